"""Tables of text with a header row, by the names of their columns.

`modelcast.io.column_map` has the table of columns, the names found without a map, and the units;
`modelcast.io.table_layout` says which separators, marks of decimals and lines before the header are read, and
`modelcast.io.time_column` which times. A column ``vehicle`` makes one trip a vehicle, ``<stem>/<vehicle>``
(``<stem>/vehicle`` without that column); a column ``trip`` gives identifiers as they are. Other columns are
not read.

A byte order mark, line ends of any kind, blank padding, quotes around a field (without a separator inside)
and E notation are read; a number or time that is blank, ``NULL``, ``NA``, ``NaN``, ``None`` or ``-`` is
missing. Text that is no UTF-8 is read as Windows-1252, and counted; UTF-16 is an error.

Skipped and counted: rows whose time or position is blank, rows off the road (`modelcast.io.table_trips`), a
cut last line. Repaired and counted: single missing values of optional columns (the last value is held), Unix
times whose unit only their size tells. Anything else is an error with its line.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import ClassVar

import numpy as np
import polars as pl

from modelcast.core.exceptions import DataFormatError
from modelcast.io.base import OnSkipped, ignore_skipped
from modelcast.io.column_map import ColumnMap, detected_map, known_map, names_its_own
from modelcast.io.holding import AbstractHoldingReader
from modelcast.io.rows import Rows
from modelcast.io.table_layout import TableLayout, decimal_mark, is_number, table_layout
from modelcast.io.table_notes import FIRST_ROWS
from modelcast.io.table_trips import AbstractTable, TablePart, table_trips
from modelcast.io.text_blocks import number_column, read_blocks, text_column
from modelcast.io.text_head import (
    complete_lines,
    file_head,
    first_lines,
    is_utf8,
    rows_expected,
    split_fields,
)
from modelcast.io.time_column import TimeColumn, TimeUnit
from modelcast.io.unit_check import LONGEST_STEP_S
from modelcast.trips.trajectory import Trajectory

__all__ = ["CsvReader"]

_RECODED = "read as Windows-1252"
_MISSING = frozenset({"na", "n/a", "nan", "null", "none", "-", "--"})
"""What programs write for a number that there is none of, in lower case; pandas, R and MATLAB among them."""
_LONGEST_MISSING = max(map(len, _MISSING))
_SEPARATED = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "vertical bars", " ": "blanks"}
"""What parts fields, in words."""
_FIRST = 20
"""Rows that are looked at to tell a table."""


@dataclass(frozen=True, slots=True)
class CsvReader(AbstractHoldingReader):
    """Reads comma-separated tables.

    Parameters
    ----------
    columns
        Column names by meaning; names are detected where it is None.
    """

    columns: Mapping[str, str] | None = None
    name: ClassVar[str] = "csv"
    streams: ClassVar[bool] = True

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether the header row names time and position, and names every field of the rows below.

        Names in words of others say so only where their times may be seconds: logs of other things have such
        columns too.
        """
        del path
        lines = first_lines(head)
        layout = table_layout(lines, _has_known_names)
        if layout is None:
            return False
        below = _rows(lines, layout)[:_FIRST]
        if below and min(map(len, below)) > len(layout.names):
            return False
        found = _map_of(layout.names)
        return found is not None and (
            names_its_own(layout.names)
            or found.time_stated
            or not _are_far_apart(below, layout.names.index(found.numbers["t_s"][0]))
        )

    def with_columns(self, columns: Mapping[str, str]) -> "CsvReader":
        """Return the reader with the user's column names."""
        return replace(self, columns=dict(columns))

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip per vehicle, as `modelcast.io.gathering` gathers them."""
        head = file_head(path)
        lines = first_lines(head)
        layout = self._layout(path, lines)
        found = known_map(path, self.columns, layout.names, row=layout.lines)
        table = _TextTable(path, found, layout, lines)
        table.recoded = "" if is_utf8(complete_lines(head)) else _RECODED
        table.written = "; ".join([table.written, *([table.recoded] if table.recoded else [])])
        yield from table_trips(table, self.name, on_skipped, held_bytes=self.held_bytes)

    def _layout(self, path: str, lines: list[str]) -> TableLayout:
        """Return how the table is written."""
        mapped = set(self.columns.values()) if self.columns else None
        layout = table_layout(lines, _has_known_names if mapped is None else mapped.issubset)
        if layout is not None and mapped and layout.plain:
            both = zip(layout.names, layout.plain, strict=True)
            layout = replace(layout, names=tuple(plain if plain in mapped else name for name, plain in both))
        if layout is None or not any(layout.names):
            raise DataFormatError(path, "the file is empty", remedy="The first line names the columns.")
        if mapped is None and all(map(is_number, layout.names)):
            raise DataFormatError(
                path, "has numbers where the header row should be", row=layout.lines,
                remedy="Add a first line that names the columns, for example t,x,y,speed.",
            )  # fmt: skip
        return layout


class _TextTable(AbstractTable):
    """A table of text; its parts are blocks of lines."""

    def __init__(self, path: str, found: ColumnMap, layout: TableLayout, lines: list[str]) -> None:
        super().__init__(path, found)
        self._layout = layout
        self._field = {name: at for at, name in enumerate(layout.names)}
        numbers = [self._field[name] for name, _ in found.numbers.values()]
        self._decimal = decimal_mark(lines, layout, numbers, path)
        name, unit_s = found.numbers["t_s"]
        self._times = TimeColumn(
            path, name, unit_s, stated=found.time_stated, decimal=self._decimal, day_first=found.day_first
        )
        self._lines = lines
        marks = [_SEPARATED[layout.separator]] if layout.separator in _SEPARATED else [layout.separator]
        marks += ["decimal commas"] * (self._decimal == ",")
        marks += [f"header in line {layout.lines - bool(layout.plain)}"] * (
            layout.lines > 1 + bool(layout.plain)
        )
        marks += [f"units in line {layout.lines}"] * bool(layout.plain)
        self.written = ", ".join(marks)

    @property
    def time(self) -> TimeUnit:
        """As the first known value tells."""
        return self._times.unit

    @property
    def rows_expected(self) -> int | None:
        """By the size of the file."""
        return rows_expected(self.path)

    def first_cells(self) -> Mapping[str, Sequence[str]]:
        """Return the first rows of all columns."""
        rows = _rows(self._lines[:FIRST_ROWS], self._layout)
        whole = [row for row in rows if len(row) == len(self._layout.names)]
        return (
            {name: [row[at] for row in whole] for at, name in enumerate(self._layout.names)} if whole else {}
        )

    def parts(self, *, whole: bool) -> Iterator[TablePart]:
        """Yield blocks of lines."""
        numbers = {fills: name for fills, (name, _) in self.found.numbers.items() if whole or fills == "t_s"}
        label = self.found.label
        wanted = [self._field[name] for name in numbers.values()]
        for block in read_blocks(
            self.path, counts=[len(self._layout.names)], skip_lines=self._layout.lines,
            fields=wanted if label is None else [*wanted, self._field[label]],
            separator=self._layout.separator,
        ):  # fmt: skip
            columns = {
                fills: number_column(
                    self.path, block, self._field[name], name, decimal=self._decimal, missing=_MISSING
                )
                for fills, name in numbers.items()
                if fills != "t_s"
            }
            time = _without_missing(text_column(block, self._field[numbers["t_s"]]))
            columns["t_s"] = self._times.read(time, block.line)
            labels = None if label is None else text_column(block, self._field[label]).alias(label)
            yield TablePart(block.index, Rows(block.line, columns), labels, block.partial > 0)


def _without_missing(time: pl.Series) -> pl.Series:
    """Return cells of a time column, null where a word for a missing one stands."""
    if time.dtype != pl.String:
        return time
    words = time.filter(time.str.len_bytes() <= _LONGEST_MISSING).str.to_lowercase()
    if not words.is_in(list(_MISSING)).any():
        return time
    return time.set(time.str.to_lowercase().is_in(list(_MISSING)), None)


def _rows(lines: list[str], layout: TableLayout) -> list[list[str]]:
    """Return the fields of the rows below the header."""
    return [split_fields(line, layout.separator) for line in lines[layout.lines :] if line.strip()]


def _are_far_apart(rows: list[list[str]], field: int) -> bool:
    """Whether the times of some rows grow by more than seconds do; of what is no number nothing is said."""
    texts = [row[field] for row in rows if field < len(row)]
    if len(texts) < 2 or not all(map(is_number, texts)):
        return False
    steps = np.diff([float(text.replace(",", ".")) for text in texts])
    return bool(np.median(steps) >= LONGEST_STEP_S)


@lru_cache(maxsize=64)
def _map_of(names: tuple[str, ...]) -> ColumnMap | None:
    """The map that names tell: asked again and again while a header is looked for."""
    return detected_map(names)


def _has_known_names(names: list[str]) -> bool:
    return _map_of(tuple(names)) is not None
