"""Where the header of a table of text is, what parts its fields, and which mark its decimals have.

Before the header blank lines, lines that begin with ``#`` and Excel's ``sep=;`` are passed over. Where the
first line after them holds numbers, the last ``#`` line is the header, as NumPy writes it. Where its names
mean nothing to the caller, a line among the next `_MOST_BEFORE` whose names do is the header: loggers write
of themselves before it. A line of units behind it states the units of names that state none. Fields are
parted by commas, semicolons, tabs, vertical bars or blanks: the first of them that gives names which mean
something to the caller. Decimals have a point, or a comma where commas part no fields: one of the two in a
file.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from modelcast.core.exceptions import DataFormatError
from modelcast.io.column_meanings import MEANINGS
from modelcast.io.header_names import are_units, stated_unit
from modelcast.io.text_head import split_fields

__all__ = ["SEPARATORS", "TableLayout", "decimal_mark", "is_number", "table_layout"]

SEPARATORS = (",", ";", "\t", "|", " ")
"""What may part fields; a blank stands for any run of blanks and tabs."""

_EXCEL = re.compile(r"sep=(.)", re.IGNORECASE)
_POINT = re.compile(r"[+-]?\d*\.\d+([eE][+-]?\d+)?")
_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")
_WITH_UNIT = frozenset(name for entry in MEANINGS.values() for name in entry.names if "_" in name)
"""Names that say all there is to say."""
_SAMPLE_LINES = 200
_MOST_BEFORE = 60
"""Lines that are looked at for a header."""
_ROWS = 20
"""Rows that are looked at for a separator at their end."""


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
    plain
        The names as the header has them, where a line of units behind it states units for `names`.
    """

    names: tuple[str, ...]
    lines: int
    separator: str
    plain: tuple[str, ...] = ()


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
    TableLayout(names=('t', 'x', 'y'), lines=2, separator=';', plain=())
    """
    found = _header(lines, means)
    return None if found is None else _with_units(_with_blank_end(found, lines), lines)


def _header(lines: Sequence[str], means: Callable[[list[str]], bool]) -> TableLayout | None:
    """Return the layout as the header alone tells it."""
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
            return _first_meant(lines, at, marks, means)
    return None if comment is None else _layout(lines[comment].lstrip("# \t"), comment + 1, marks, means)


def _first_meant(
    lines: Sequence[str], at: int, marks: Sequence[str], means: Callable[[list[str]], bool]
) -> TableLayout:
    """Return the layout of the first line that means something from one on, else of that one itself.

    A line behind it may be a header where no blank parts its names, as in prose, the row below it has as many
    fields and a number, and no line before it is a row of numbers.
    """
    first = _layout(lines[at], at + 1, marks, means)
    if means(list(first.names)):
        return first
    for later in range(at, min(at + _MOST_BEFORE, len(lines) - 1)):
        fields = split_fields(lines[later], first.separator)
        if len(fields) > 1 and all(map(is_number, fields)):
            break
        mark = _meant(lines[later], [mark for mark in marks if mark != " "], means)
        if mark is None:
            continue
        names, below = (split_fields(lines[at], mark) for at in (later, later + 1))
        if len(below) in {len(names), len(names) + 1} and (any(map(is_number, below)) or are_units(below)):
            return TableLayout(tuple(names), later + 1, mark)
    return first


def _with_blank_end(found: TableLayout, lines: Sequence[str]) -> TableLayout:
    """Return the layout with a column without a name, where all rows but the header end in a separator."""
    rows = [split_fields(line, found.separator) for line in lines[found.lines :][:_ROWS] if line.strip()]
    if not rows or not all(len(row) == len(found.names) + 1 and not row[-1] for row in rows):
        return found
    return replace(found, names=(*found.names, ""))


def _with_units(found: TableLayout, lines: Sequence[str]) -> TableLayout:
    """Return the layout with the units that the line behind the header states, of names that state none."""
    behind = next((at for at in range(found.lines, len(lines)) if lines[at].strip()), None)
    units = [] if behind is None else split_fields(lines[behind], found.separator)
    if behind is None or len(units) != len(found.names) or not are_units(units):
        return found
    bare = [unit.strip("[](){} ") for unit in units]
    names = (
        name if not unit or name in _WITH_UNIT or stated_unit(name) else f"{name} [{unit}]"
        for name, unit in zip(found.names, bare, strict=True)
    )
    return replace(found, names=tuple(names), lines=behind + 1, plain=found.names)


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
