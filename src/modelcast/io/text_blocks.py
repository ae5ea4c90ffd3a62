"""Separated text in blocks of bounded size, every line checked for its number of fields.

Published trip files reach many gigabytes, so nothing here holds more than one block of a file. Lines are
checked and numbered on the raw bytes; only the wanted fields are then split off, as text, because sentinels
and padding have to be told from numbers, and a bad cell has to be named by its line.

Most files hold nothing of that kind. A block without blanks and quotes is parsed as numbers at once, and anew
as text where one cell is no number: the same numbers, three times as fast.

Lines end with LF, CRLF or CR alone, also mixed in one file. A block that is no UTF-8 is read as Windows-1252.
"""

import io
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np
import polars as pl

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.exceptions import DataFormatError
from modelcast.io.packed import open_octets
from modelcast.io.rows import are_numbers
from modelcast.io.text_head import BOM, as_utf8

__all__ = [
    "BLOCK_BYTES",
    "Block",
    "number_column",
    "read_blocks",
    "text_column",
]

BLOCK_BYTES = 16 * 2**20
"""Bytes of text parsed at a time."""

_MOST_LINE_BYTES = 2**26
"""No line of a table is longer."""

_NEWLINE = ord("\n")
_BLANK = ("", "NULL")
_HEMISPHERE = re.compile(r"[NSEWO]?\s*\d[^NSEWO]*[°'\"NSEWO].*|[NSEWO]\s*\d.*", re.DOTALL)
_AS_DEGREES = "Write degrees as a decimal number, as 48.1173, negative where they are south or west."
_BLANKS_AROUND = re.compile(rb"^[ \t]+|[ \t]+(?=\0?$)", re.MULTILINE)
_BLANKS_BETWEEN = re.compile(rb"[ \t]+")


@dataclass(frozen=True, slots=True)
class Block:
    """Consecutive lines of a file.

    Parameters
    ----------
    index
        Number of the block in the file, from 0.
    cells
        The wanted fields, one column each, named by the field's number: as text, or, where `plain`, null
        where blank, and those that are read as numbers alone as such.
    line
        One-based line numbers, (R,).
    partial
        Line number of the file's last line where that was cut short, else 0; it is not among the cells.
    plain
        Whether no cell has blanks or quotes around it, and all that are to be are numbers.
    """

    index: int
    cells: pl.DataFrame
    line: IntArray
    partial: int
    plain: bool = False


def read_blocks(
    path: str,
    *,
    counts: Collection[int],
    fields: Sequence[int],
    skip_lines: int,
    numbers: Collection[int] = (),
    width: int | None = None,
    separator: str = ",",
) -> Iterator[Block]:
    """Yield a file's lines in blocks; blank lines are passed over.

    Parameters
    ----------
    path
        The file.
    counts
        Numbers of fields a line may have.
    fields
        Numbers of the fields wanted, from 0.
    skip_lines
        Lines at the start to leave out (metadata, header).
    numbers
        Those of them that are asked for by `number_column` alone, with a point for the decimals.
    width
        Upper bound of `counts` where it is not the largest.
    separator
        What parts the fields; a blank stands for any run of blanks and tabs.

    Raises
    ------
    DataFormatError
        Where a line has another number of fields, except a last line without a line end.
    """
    wanted = sorted(set(fields))
    width = max(counts) if width is None else width
    first_line = 1
    with open_octets(path) as file:
        for index, read in enumerate(_whole_lines(path, file)):
            raw = as_utf8(read)
            ends = _line_ends(raw)
            lines = ends.size
            skip = min(max(skip_lines - (first_line - 1), 0), lines)
            text = raw if skip == 0 else raw[ends[skip - 1] + 1 :]
            if separator == " ":
                text = _BLANKS_BETWEEN.sub(b"\t", _BLANKS_AROUND.sub(b"", text))
            mark = b"\t" if separator == " " else separator.encode()
            ends = ends if text is raw else _line_ends(text)
            text, line, partial = _checked(
                path, text, ends, first_line=first_line + skip, counts=counts, separator=mark
            )
            first_line += lines
            cells = _parsed_plain(text, wanted, numbers, line, width=width, separator=mark)
            plain = cells is not None
            if cells is None:
                cells = _parsed(path, text, wanted, line, width=width, separator=mark)
            yield Block(index, cells, line, partial, plain)


def _line_ends(text: bytes) -> IntArray:
    return np.flatnonzero(np.frombuffer(text, np.uint8) == _NEWLINE)


def _whole_lines(path: str, file: BinaryIO) -> Iterator[bytes]:
    """Yield the file cut at line ends, all made LF, without byte order mark; NUL marks a missing last one."""
    rest = b""
    first = True
    held = b""
    while chunk := held + file.read(BLOCK_BYTES):
        if first:
            chunk, first = chunk.removeprefix(BOM), False
        # A CR at the end of a chunk may be half of a CRLF.
        held = b"\r" if chunk.endswith(b"\r") and len(chunk) > 1 else b""
        chunk = chunk.removesuffix(held)
        if b"\r" in chunk:
            chunk = chunk.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        cut = chunk.rfind(b"\n") + 1
        if cut == 0:
            rest += chunk
            if len(rest) > _MOST_LINE_BYTES:
                raise DataFormatError(
                    path, f"has a line of over {_MOST_LINE_BYTES:,} octets", remedy="It is no table of text."
                )
            continue
        yield rest + chunk[:cut]
        rest = chunk[cut:]
    if rest:
        # A newline lets the last line be counted like the others; NUL marks that it was not there.
        yield rest + b"\0\n"


def _checked(
    path: str, text: bytes, ends: IntArray, *, first_line: int, counts: Collection[int], separator: bytes
) -> tuple[bytes, IntArray, int]:
    """Return the non-blank lines of a block, their numbers, and the number of a cut last line."""
    starts = np.concatenate([[0], ends[:-1] + 1]) if ends.size else ends
    found = _separators(text, starts, separator) + 1
    blank = ends == starts
    wrong = ~blank
    for count in counts:
        wrong &= found != count
    line = first_line + np.arange(ends.size, dtype=np.int64)
    partial = 0
    unended = text.endswith(b"\0\n")
    if unended and wrong[-1] and found[-1] < max(counts):
        partial = int(line[-1])
        wrong[-1], blank[-1] = False, True
    if wrong.any():
        at = int(np.argmax(wrong))
        expected = " or ".join(str(count) for count in sorted(counts))
        raise DataFormatError(
            path,
            f"{found[at]} fields where the format has {expected}",
            row=int(line[at]),
            remedy="Check that the line is whole and that the file holds one format only.",
        )
    if blank.any():
        kept = np.flatnonzero(~blank)
        text = b"".join(text[starts[k] : ends[k] + 1] for k in kept)
        line = line[kept]
    return text[:-2] + b"\n" if text.endswith(b"\0\n") else text, line, partial


def _separators(text: bytes, starts: IntArray, separator: bytes) -> IntArray:
    """Return how many separators each line has."""
    if not starts.size:
        return starts
    marks = np.frombuffer(text, np.uint8) == ord(separator)
    # One octet a line is ten times as fast as eight; where a line has more than 255 the sum tells.
    found = np.add.reduceat(marks.view(np.uint8), starts, dtype=np.uint8).astype(np.int64)
    if int(found.sum()) != int(np.count_nonzero(marks)):
        found = np.add.reduceat(marks.view(np.uint8), starts, dtype=np.int64)
    return found


def _parsed_plain(
    text: bytes, fields: list[int], numbers: Collection[int], line: IntArray, *, width: int, separator: bytes
) -> pl.DataFrame | None:
    """Return the wanted fields, null where blank, numbers as such; None where they have to be looked at."""
    around = b' "' if separator == b"\t" else b' \t"'
    if line.size == 0 or any(mark in text for mark in map(bytes, zip(around, strict=True))):
        return None
    kinds = {str(field): pl.Float64 if field in numbers else pl.String for field in fields}
    try:
        cells = _read_csv(text, kinds, width=width, separator=separator, null="NULL")
    except pl.exceptions.PolarsError:
        return None
    if cells.height != line.size:
        return None
    for field in numbers:
        column = cells[str(field)]
        if not (are_numbers(column.to_numpy()) | column.is_null().to_numpy()).all():
            return None
    return cells


def _read_csv(
    text: bytes, kinds: Mapping[str, type[pl.DataType]], *, width: int, separator: bytes, null: str | None
) -> pl.DataFrame:
    # A header of our own tells the parser the full width: lines may be shorter.
    header = separator.join(str(field).encode() for field in range(width)) + b"\n"
    return pl.read_csv(
        io.BytesIO(header + text),
        separator=separator.decode(),
        quote_char=None,
        infer_schema=False,
        columns=list(kinds),
        schema_overrides=kinds,
        null_values=null,
        encoding="utf8-lossy",
        truncate_ragged_lines=True,
    )


def _parsed(
    path: str, text: bytes, fields: list[int], line: IntArray, *, width: int, separator: bytes
) -> pl.DataFrame:
    """Return the wanted fields of the lines as text."""
    if line.size == 0:
        return pl.DataFrame({str(field): [] for field in fields}, schema={str(f): pl.String for f in fields})
    kinds = {str(field): pl.String for field in fields}
    try:
        cells = _read_csv(text, kinds, width=width, separator=separator, null=None)
    except pl.exceptions.PolarsError as error:
        raise DataFormatError(path, f"cannot be split into fields: {error}", row=int(line[0])) from error
    if cells.height != line.size:
        raise DataFormatError(
            path,
            f"{cells.height} records in {line.size} lines",
            row=int(line[0]),
            remedy="Remove the control characters in these lines.",
        )
    return cells


def text_column(block: Block, field: int) -> pl.Series:
    """Return a field as text, stripped of blanks and quotes; null where it is blank or ``NULL``."""
    text = block.cells[str(field)]
    if block.plain:
        return text
    text = text.str.strip_chars(' \t\r"')
    return text.set(text.is_in(_BLANK), None)


def number_column(
    path: str,
    block: Block,
    field: int,
    name: str,
    *,
    decimal: str = ".",
    missing: Collection[str] = (),
) -> FloatArray:
    """Return a field as numbers, NaN where it is blank, (R,).

    Parameters
    ----------
    path, block, field, name
        The column, and its name in errors.
    decimal
        The one mark of decimals: a number with the other one is an error.
    missing
        Words in lower case that are as blank.

    Raises
    ------
    DataFormatError
        Where a cell is not a finite number.
    """
    text = text_column(block, field)
    if text.dtype == pl.Float64:
        return np.array(text.fill_null(np.nan).to_numpy(), dtype=np.float64)
    plain = text
    if decimal != ".":
        plain = text.str.replace_all(".", "?", literal=True).str.replace(decimal, ".", literal=True)
    values = plain.cast(pl.Float64, strict=False)
    numbers = values.fill_null(np.nan).to_numpy()
    bad = ~are_numbers(numbers) & text.is_not_null().to_numpy()
    if missing and bad.any():
        blank = text.str.to_lowercase().is_in(list(missing)).fill_null(value=False).to_numpy()
        numbers, bad = np.where(blank, np.nan, numbers), bad & ~blank
    if bad.any():
        at = int(np.argmax(bad))
        raise DataFormatError(
            path,
            f"{name} is {text[at]!r}, not a finite number",
            row=int(block.line[at]),
            remedy=_AS_DEGREES
            if _HEMISPHERE.fullmatch(str(text[at]))
            else "Correct the value, or leave the cell blank where it is not known.",
        )
    return np.array(numbers, dtype=np.float64)
