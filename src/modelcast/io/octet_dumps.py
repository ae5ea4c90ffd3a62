"""Octets printed by other programs: dumps with offsets (xxd, hexdump, od, Wireshark), arrays of C and such.

A dump is known by its offsets: each is the first plus the octets before it, in hexadecimal, octal or decimal.
A row ``*`` stands for copies of the row above. Rows of 16-bit words (``od -x``, plain ``hexdump``, ``od``)
have the octets of each word swapped, as the machines do that print them.
"""

import re
from collections.abc import Sequence
from typing import NamedTuple

__all__ = ["Block", "array_at", "dump_at"]

_ROW = re.compile(r"\s*([0-9A-Fa-f]{4,16})(:?)(?:\s+(\S.*))?\s*")
_DIGITS = re.compile(r"[0-9A-Fa-f]+")
_BASES = (16, 8, 10)
_MOST_OCTETS = 1 << 24
_OPENING = re.compile(r"[{\[]")
_ARRAY = re.compile(r"[^{\[]*[{\[]([^{}\[\]]*)[}\]]\s*;?\s*")
_ELEMENT = re.compile(r"0[xX]([0-9A-Fa-f]{1,2})")
_DECIMAL = re.compile(r"[0-9]{1,3}")
_LEAST_DECIMALS = 8
_MORE = re.compile(r"[\s,0-9A-Fa-fxX]*")
_LENGTH = re.compile(r"\s*(?:static\s+)?(?:const\s+)?(?:unsigned\s+int|size_t)\s+\w+\s*=\s*(\d+)\s*;\s*")


class Block(NamedTuple):
    """Lines that print octets.

    Parameters
    ----------
    octets
        What they print.
    stop
        Line behind the last, counted from 0.
    """

    octets: bytes
    stop: int


def dump_at(lines: Sequence[str], at: int) -> Block | None:
    r"""Return the dump that begins at a line; None where none does.

    Parameters
    ----------
    lines
        All lines.
    at
        Where, counted from 0.

    Examples
    --------
    >>> dump_at(["00000000: 0014 2501  ..%.", "00000004: 68         h"], 0)
    Block(octets=b'\x00\x14%\x01h', stop=2)
    """
    first = _ROW.fullmatch(lines[at])
    if first is None or first[3] is None or (int(first[1], 16) and not first[2]):
        return None
    octets, row = bytearray(), b""
    bases = list(_BASES)
    squeezed = False
    stop = at
    for line in lines[at:]:
        if line.strip() == "*" and row:
            squeezed, stop = True, stop + 1
            continue
        found = _ROW.fullmatch(line)
        if found is None or found[2] != first[2]:
            break
        fitting = [
            base for base in bases if _fits(found[1], first[1], base, octets, row if squeezed else b"")
        ]
        if not fitting:
            break
        if squeezed:
            octets += row * (
                (_offset(found[1], fitting[0]) - _offset(first[1], fitting[0]) - len(octets)) // len(row)
            )
            squeezed = False
        bases, stop = fitting, stop + 1
        if found[3] is None:
            del octets[_offset(found[1], bases[0]) - _offset(first[1], bases[0]) :]
            break
        row = _row_octets(found[3], colon=bool(found[2]))
        if not row:
            return None
        octets += row
    return Block(bytes(octets), stop)


def _offset(digits: str, base: int) -> int:
    try:
        return int(digits, base)
    except ValueError:
        return -1


def _fits(digits: str, first: str, base: int, octets: bytearray, repeated: bytes) -> bool:
    """Whether an offset is the one that follows; a last word may have been filled up with an octet."""
    begin, here = _offset(first, base), _offset(digits, base)
    if begin < 0 or here < 0:
        return False
    more = here - begin - len(octets)
    if repeated:
        return 0 < more <= _MOST_OCTETS and more % len(repeated) == 0
    return more in (0, -1)


def _row_octets(body: str, *, colon: bool) -> bytes:
    """Octets of a row, its column of characters left out; empty where it is no row."""
    if colon:
        tokens = re.split(r"\s{2,}", body.strip(), maxsplit=1)[0].split()
    else:
        tokens = list[str]()
        for token in map(str, re.split(r"(\s+)", body.partition("|")[0].strip())):
            if token.isspace() and len(token) <= 2:
                continue
            if not _DIGITS.fullmatch(token) or (tokens and len(token) != len(tokens[0])):
                break
            tokens.append(token)
    if not tokens or not all(_DIGITS.fullmatch(token) for token in tokens):
        return b""
    return _tokens_octets(tokens, colon=colon)


def _tokens_octets(tokens: Sequence[str], *, colon: bool) -> bytes:
    width = len(tokens[0])
    joined = "".join(tokens)
    try:
        if width == 8 and colon and not joined.strip("01"):
            return bytes(int(token, 2) for token in tokens)
        if width == 3 and not colon:
            return bytes(int(token, 8) for token in tokens)
        if width == 6 and not colon:
            return b"".join(int(token, 8).to_bytes(2, "little") for token in tokens)
        if width == 4 and not colon:
            return b"".join(int(token, 16).to_bytes(2, "little") for token in tokens)
        return bytes.fromhex(joined) if colon or width == 2 else b""
    except (ValueError, OverflowError):
        return b""


def array_at(lines: Sequence[str], at: int) -> Block | None:
    """Return the array of octets ``{0x00, 0x14, ...}`` that begins at a line; None where none does.

    Elements are all in hexadecimal with ``0x``, or eight and more and all in decimal. A line behind it that
    tells its length, as ``xxd -i`` writes, belongs to it.

    Parameters
    ----------
    lines
        All lines.
    at
        Where, counted from 0.
    """
    if not _OPENING.search(lines[at]):
        return None
    text, stop = lines[at], at + 1
    while not re.search(r"[}\]]\s*;?\s*$", text) and stop < len(lines) and len(text) < _MOST_OCTETS:
        if stop > at + 1 and not _MORE.fullmatch(lines[stop - 1]):
            return None
        text, stop = f"{text}\n{lines[stop]}", stop + 1
    found = _ARRAY.fullmatch(re.sub(r"\[\d*\]|\(byte\)", " ", text))
    if found is None:
        return None
    octets = _elements_octets([element.strip() for element in str(found[1]).split(",") if element.strip()])
    if octets is None:
        return None
    if stop < len(lines) and (told := _LENGTH.fullmatch(lines[stop])) and int(told[1]) == len(octets):
        stop += 1
    return Block(octets, stop)


def _elements_octets(elements: Sequence[str]) -> bytes | None:
    """Octets of an array's elements, all in hexadecimal or, where there are some, all in decimal."""
    values = [int(match[1], 16) for element in elements if (match := _ELEMENT.fullmatch(element))]
    if not values and len(elements) >= _LEAST_DECIMALS:
        values = [int(element) for element in elements if _DECIMAL.fullmatch(element) and int(element) < 256]
    return bytes(values) if values and len(values) == len(elements) else None
