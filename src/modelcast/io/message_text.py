r"""Octets in text: digits one message a line, wrapped, dumped, as an array, in Base64, or behind labels.

==========================  ==================================================================================
lines                       read as
==========================  ==================================================================================
digits only                 octets; blanks, ``: - , ;``, ``0x`` and ``\x`` between them are allowed
digits that go on           one run, where a line's own head announces more octets than it holds (``xxd -p``)
offsets in front            one run (`octet_dumps`)
``{0x00, 0x14, ...}``       one run (`octet_dumps`)
Base64                      one run, over lines that go on (`base64_text`); beside other text too
digits among other text     each run that begins as a message does; a single run in any case
blank, or ``#`` in front    nothing
anything else               a fault that names the first character that is no digit
==========================  ==================================================================================
"""

import ast
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from modelcast.io.base64_text import encoded_lines, encoded_run
from modelcast.io.octet_dumps import array_at, dump_at
from modelcast.messages.sequence import announced_octets, begins_a_message, is_message

__all__ = ["Piece", "pieces_of_text"]

_LINE_ENDS = re.compile(r"\r\n|\r|\n")
_BETWEEN = re.compile(r"[\s:,;\-]+|\\[xX]")
_RUN = re.compile(r"(?<![0-9A-Za-z_])(?:0[xX])?([0-9A-Fa-f]{16,})(?![0-9A-Za-z_])")
_SPACED_RUN = re.compile(
    r"(?<![0-9A-Za-z_])(?:0[xX])?[0-9A-Fa-f]{2}(?:[ ,:\-]{1,2}(?:0[xX])?[0-9A-Fa-f]{2}){7,}(?![0-9A-Za-z_])"
)
_BEGINNING = re.compile(r"0?|00|00[12f]|(?:0014|0020|00f0)[0-9a-f]{0,3}|0[23][0-9a-f]{0,20}", re.IGNORECASE)
"""Digits that may begin a message and are too few to tell."""

_BYTES = re.compile(
    r"(?<![0-9A-Za-z_])b(?:'(?:[^'\\]|\\[\\'\"nrt]|\\x[0-9a-f]{2})+'|\"(?:[^\"\\]|\\[\\'\"nrt]|\\x[0-9a-f]{2})+\")"
)
"""Octets as Python prints them."""

_HEX = frozenset("0123456789abcdefABCDEF")


@dataclass(frozen=True, slots=True)
class Piece:
    """What stands in one place of a text.

    Parameters
    ----------
    place
        ``line 3``, ``lines 1 to 5``.
    octets
        Empty where there is a fault.
    fault
        Why there are no octets; empty where there are.
    announced
        How many octets its head announces, where that is more than there are; otherwise 0.
    """

    place: str
    octets: bytes = b""
    fault: str = ""
    announced: int = 0


def pieces_of_text(text: str) -> Iterator[Piece]:
    r"""Yield each run of octets, and each line that holds none, in order.

    Parameters
    ----------
    text
        All of it.

    Examples
    --------
    >>> [(piece.place, piece.octets.hex()) for piece in pieces_of_text("00142501\n# none\n00 14")]
    [('line 1', '00142501'), ('line 3', '0014')]
    """
    lines = _LINE_ENDS.split(text)
    at = 0
    while at < len(lines):
        if not lines[at].strip() or lines[at].lstrip().startswith("#"):
            at += 1
            continue
        block = dump_at(lines, at) or array_at(lines, at)
        if block is not None:
            yield _piece(_place(at, block.stop), block.octets.hex())
            at = block.stop
        elif (digits := _digits(lines[at])) is not None:
            joined, stop = _wrapped(lines, at, digits)
            yield _piece(_place(at, stop), joined)
            at = stop
        elif (encoded := encoded_lines(lines, at)) is not None:
            octets, stop = encoded
            yield _piece(_place(at, stop), octets.hex())
            at = stop
        else:
            yield from _labelled(lines[at], _place(at, at + 1))
            at += 1


def _place(at: int, stop: int) -> str:
    return f"line {at + 1}" if stop == at + 1 else f"lines {at + 1} to {stop}"


def _piece(place: str, digits: str) -> Piece:
    if len(digits) % 2:
        return Piece(place, fault=f"an odd number of hexadecimal digits: {len(digits)}")
    octets = bytes.fromhex(digits)
    announced = announced_octets(octets) or 0
    return Piece(place, octets, announced=announced if announced > len(octets) else 0)


def _digits(line: str) -> str | None:
    """Digits of a line that holds nothing else; None for any other."""
    tokens = [token for token in _BETWEEN.split(line.strip()) if token]
    bare = [token[2:].zfill(2) if token[:2] in ("0x", "0X") else token for token in tokens]
    if not bare or not all(_HEX.issuperset(token) for token in bare):
        return None
    widths = {len(token) for token in bare[:-1]}
    mixed = len(widths) > 1 or (bool(widths) and len(bare[-1]) > max(widths))
    if mixed and any(_begins(run) for run in _RUN.findall(line)):
        return None  # a column of digits beside others
    return "".join(bare)


def _begins(digits: str) -> bool:
    return begins_a_message(bytes.fromhex(digits[: len(digits) // 2 * 2]))


@dataclass(slots=True)
class _Gathered:
    """Digits of a line and of those that go on with it.

    Parameters
    ----------
    lines
        Digits, by line.
    open
        Those behind the last whole message; the first of them where their head tells no length.
    untold
        Whether `open` begins with no message.
    """

    lines: list[str]
    open: str
    untold: bool = False

    def settle(self) -> None:
        """Take whole messages off what is open."""
        while self.open and not self.untold:
            count = announced_octets(bytes.fromhex(self.open[: len(self.open) // 2 * 2]))
            if not count:
                self.untold = not _BEGINNING.fullmatch(self.open)
            if not count or 2 * count > len(self.open):
                return
            self.open = self.open[2 * count :]

    def take(self, digits: str) -> None:
        """Append a line."""
        self.lines.append(digits)
        if not self.untold:
            self.open += digits
            self.settle()

    def goes_on(self, digits: str) -> bool:
        """Whether a line goes on with them: a message lacks octets, or all lines were full."""
        if self.open and not self.untold:
            return not _whole(digits)
        if len(digits) > 2 and not digits.strip("0"):
            return True  # a padded buffer goes on
        full = len(self.lines[-1]) == len(self.lines[0])
        begun = len(self.lines) > 1 or (self.untold and self.open == self.lines[0])
        return full and begun and not _begins(digits)


def _wrapped(lines: Sequence[str], at: int, digits: str) -> tuple[str, int]:
    """Digits of a line and of those that go on with it, and the line behind them."""
    gathered = _Gathered([digits], digits)
    gathered.settle()
    stop = at + 1
    for ahead in range(at + 1, len(lines)):
        if not lines[ahead].strip():
            continue
        more = _digits(lines[ahead])
        if more is None or not gathered.goes_on(more):
            break
        gathered.take(more)
        stop = ahead + 1
    return "".join(gathered.lines), stop


def _whole(digits: str) -> bool:
    """Whether digits begin with a whole message."""
    if len(digits) % 2:
        return False
    octets = bytes.fromhex(digits)
    count = announced_octets(octets)
    return bool(count) and count <= len(octets) and is_message(octets[:count])


def _labelled(line: str, place: str) -> Iterator[Piece]:
    """Yield the runs of digits in a line with other text, or what is wrong with it."""
    runs = [(found.start(1), found[1]) for found in _RUN.finditer(line)]
    if not runs:
        runs = [(found.start(), _digits(found[0]) or "") for found in _SPACED_RUN.finditer(line)]
    chosen = [run for run in runs if _begins(run[1])] or runs
    written = _BYTES.search(line)
    encoded = None if any(_begins(run) for _, run in runs) else encoded_run(line)
    if written is not None:
        yield _piece(f"{place}, column {written.start() + 1}", ast.literal_eval(written[0]).hex())
    elif encoded is not None:
        yield _piece(f"{place}, column {encoded.column + 1}", encoded.octets.hex())
    elif not chosen:
        yield Piece(place, fault=_no_digit(line))
    elif len(chosen) > 1 and not _begins(chosen[0][1]):
        columns = ", ".join(str(column + 1) for column, _ in chosen)
        yield Piece(place, fault=f"several runs of digits (columns {columns}), and none begins as a message")
    else:
        for column, digits in chosen:
            yield _piece(f"{place}, column {column + 1}", digits)


def _no_digit(line: str) -> str:
    """Tell the first character that is no hexadecimal digit."""
    rest = _BETWEEN.sub(lambda between: " " * len(between[0]), line)
    for column, letter in enumerate(rest, start=1):
        if letter not in _HEX and not letter.isspace():
            return f"column {column}: '{letter}' is not a hexadecimal digit"
    return "not an even number of hexadecimal digits"
