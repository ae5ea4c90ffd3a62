"""Octets in text as Base64: by RFC 4648 with either alphabet, with or without padding, wrapped or not.

A run is taken for Base64 where it is not hexadecimal digits with a slip of the pen (one letter in five at
least is no hexadecimal digit; three in four are none in Base64) and begins as a message does, or is all that
stands in its line, 40 letters at least. A message that is read here is no hexadecimal digits in Base64: it
begins with ``ABQ``, ``APA``, ``A4EAQ`` or ``A4A`` and one of the former. A personal safety message begins
with ``ACA``; it is told by one letter in five that is no digit, as in nearly all.
"""

import base64
import binascii
import re
from collections.abc import Sequence
from typing import NamedTuple

from modelcast.messages.sequence import announced_octets, begins_a_message

__all__ = ["EncodedRun", "encoded_lines", "encoded_run"]

_RUN = re.compile(r"(?<![0-9A-Za-z+/_\-])[0-9A-Za-z+/_\-]{12,}={0,2}(?![0-9A-Za-z+/=])")
_LINE = re.compile(r"[0-9A-Za-z+/_\-]+={0,2}")
_HEX = frozenset("0123456789abcdefABCDEF")
_LEAST_FOREIGN = 0.2
_LEAST_ALONE = 40
_HEAD_LETTERS = 3200
"""Letters that hold all octets of a frame: from them its head tells its length."""


class EncodedRun(NamedTuple):
    """A run of Base64.

    Parameters
    ----------
    column
        Where it begins, counted from 0.
    octets
        What it holds.
    """

    column: int
    octets: bytes


def encoded_run(line: str) -> EncodedRun | None:
    r"""The first run of Base64 in a line; None where there is none.

    Parameters
    ----------
    line
        Any.

    Examples
    --------
    >>> encoded_run('"payload": "ABQlAWhhbGxvLCB0aGVyZSE="')
    EncodedRun(column=12, octets=b'\x00\x14%\x01hallo, there!')
    """
    for found in _RUN.finditer(line):
        run = found[0]
        foreign = sum(letter not in _HEX for letter in run.rstrip("="))
        if foreign < _LEAST_FOREIGN * len(run):
            continue
        octets = _decoded(run)
        if octets and (begins_a_message(octets) or (run == line.strip() and len(run) >= _LEAST_ALONE)):
            return EncodedRun(found.start(), octets)
    return None


def encoded_lines(lines: Sequence[str], at: int) -> tuple[bytes, int] | None:
    """The octets that begin in a line of nothing but Base64, and the line behind them; else None.

    Lines go on as long as they are full, until the message is whole that the first begins with.

    Parameters
    ----------
    lines
        All lines.
    at
        Where, counted from 0.
    """
    first = lines[at].strip()
    if not _LINE.fullmatch(first) or encoded_run(first) is None:
        return None
    text, stop = first, at + 1
    while stop < len(lines) and len(lines[stop - 1].strip()) == len(first) and not text.endswith("="):
        more = lines[stop].strip()
        if not _LINE.fullmatch(more) or len(more.rstrip("=")) > len(first) or _is_whole(text):
            break
        if _decoded(text + more) is None:
            break
        text, stop = text + more, stop + 1
    octets = _decoded(text)
    return None if octets is None else (octets, stop)


def _is_whole(text: str) -> bool:
    """Whether Base64 holds the whole of the message that it begins with."""
    octets = _decoded(text[:_HEAD_LETTERS])
    announced = announced_octets(octets) if octets else None
    return bool(announced) and 3 * len(text) >= 4 * (announced or 0)


def _decoded(run: str) -> bytes | None:
    plain = run.rstrip("=").replace("-", "+").replace("_", "/")
    try:
        return base64.b64decode(plain + "=" * (-len(plain) % 4), validate=True)
    except (binascii.Error, ValueError):
        return None
