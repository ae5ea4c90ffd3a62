"""Where the header of a table of text is, what parts its fields, and which mark its decimals have.

Before the header blank lines, lines that begin with ``#`` and Excel's ``sep=;`` are passed over. Where the
first line after them holds numbers, the last ``#`` line is the header, as NumPy writes it. Fields are parted
by commas, semicolons, tabs, vertical bars or blanks: the first of them that gives names which mean something
to the caller. Decimals have a point, or a comma where commas part no fields: one of the two in a file.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from modelcast.core.exceptions import DataFormatError
from modelcast.io.text_head import split_fields

__all__ = ["SEPARATORS", "TableLayout", "decimal_mark", "is_number", "table_layout"]

SEPARATORS = (",", ";", "\t", "|", " ")
"""What may part fields; a blank stands for any run of blanks and tabs."""

_EXCEL = re.compile(r"sep=(.)", re.IGNORECASE)
_POINT = re.compile(r"[+-]?\d*\.\d+([eE][+-]?\d+)?")
_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")
_SAMPLE_LINES = 200


@dataclass(frozen=True, slots=True)
class TableLayout:
    """How a table of text is written.

    Parameters
    ----------
    names
        Its columns, in order.
    lines
        Lines up to and with the header.
    separator
        One of `SEPARATORS`.
    """

    names: tuple[str, ...]
    lines: int
    separator: str


def table_layout(lines: Sequence[str], means: Callable[[list[str]], bool]) -> TableLayout | None:
    """Return the layout of a table, or None where it has no line but blank ones and comments.

    Parameters
    ----------
    lines
        The first lines of the file.
    means
        Whether names of columns mean something to the caller.

    Examples
    --------
    >>> table_layout(["# made up", "t;x;y", "0;1,5;2,5"], lambda names: "t" in names)
    TableLayout(names=('t', 'x', 'y'), lines=2, separator=';')
    """
    marks = SEPARATORS
    comment: int | None = None
    for at, line in enumerate(lines):
        excel = _EXCEL.fullmatch(line.strip().strip('"'))
        if excel is not None:
            marks = (excel[1],)
        elif line.lstrip().startswith("#") and not _meant(line, marks, means):
            comment = at
        elif line.strip():
            if comment is not None and _holds_numbers(line, marks):
                return _layout(lines[comment].lstrip("# \t"), comment + 1, marks, means)
            return _layout(line, at + 1, marks, means)
    return None if comment is None else _layout(lines[comment].lstrip("# \t"), comment + 1, marks, means)


def decimal_mark(lines: Sequence[str], layout: TableLayout, fields: Sequence[int], path: str) -> str:
    """Return the mark of decimals of some columns, by their first rows.

    Raises
    ------
    DataFormatError
        Where these rows have both marks: a comma may then part thousands.
    """
    found: dict[str, str] = {}
    for line in lines[layout.lines :][:_SAMPLE_LINES]:
        cells = split_fields(line, layout.separator)
        for cell in (cells[field] for field in fields if field < len(cells)):
            for mark, pattern in ((".", _POINT), (",", _COMMA)):
                if mark not in found and pattern.fullmatch(cell):
                    found[mark] = cell
    if len(found) > 1:
        raise DataFormatError(
            path,
            f"has decimal points and decimal commas: {found['.']!r} and {found[',']!r}",
            remedy="Write all numbers with one mark of decimals and none of thousands.",
        )
    return next(iter(found), ".")


def _layout(line: str, number: int, marks: Sequence[str], means: Callable[[list[str]], bool]) -> TableLayout:
    mark = _meant(line, marks, means) or max(marks, key=lambda mark: len(split_fields(line, mark)))
    return TableLayout(tuple(split_fields(line, mark)), number, mark)


def _meant(line: str, marks: Sequence[str], means: Callable[[list[str]], bool]) -> str | None:
    """Return the first separator that gives names which mean something."""
    return next((mark for mark in marks if means(split_fields(line, mark))), None)


def _holds_numbers(line: str, marks: Sequence[str]) -> bool:
    return any(is_number(field) for mark in marks for field in split_fields(line, mark))


def is_number(text: str) -> bool:
    """Return whether a cell is a number with a decimal point."""
    try:
        float(text)
    except ValueError:
        return False
    return True
