"""Tables of text with a header row, by the names of their columns.

`modelcast.io.column_map` has the table of columns, the names found without a map, and the units;
`modelcast.io.table_layout` says which separators, marks of decimals and lines before the header are read, and
`modelcast.io.time_column` which times. A column ``vehicle`` makes one trip a vehicle, ``<stem>/<vehicle>``
(``<stem>/vehicle`` without that column); a column ``trip`` gives identifiers as they are. Other columns are
not read.

A byte order mark, line ends of any kind, blank padding, quotes around a field (without a separator inside)
and E notation are read; blank or ``NULL`` is missing. UTF-16 is an error.

Skipped and counted: rows whose time or position is blank, rows off the road (`modelcast.io.table_trips`), a
cut last line. Repaired and counted: single missing values of optional columns (the last value is held), Unix
times whose unit only their size tells. Anything else is an error with its line.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

import polars as pl

from modelcast.core.exceptions import DataFormatError
from modelcast.io.base import AbstractTripReader, OnSkipped, ignore_skipped
from modelcast.io.column_map import detected_map, known_map
from modelcast.io.rows import Rows, joined
from modelcast.io.table_layout import TableLayout, decimal_mark, is_number, table_layout
from modelcast.io.table_trips import table_trips
from modelcast.io.text_blocks import number_column, read_blocks, text_column
from modelcast.io.text_head import file_head, first_lines
from modelcast.io.time_column import TimeColumn
from modelcast.trips.trajectory import Trajectory

__all__ = ["CsvReader"]


@dataclass(frozen=True, slots=True)
class CsvReader(AbstractTripReader):
    """Reads comma-separated tables.

    Parameters
    ----------
    columns
        Column names by meaning; names are detected where it is None.
    """

    columns: Mapping[str, str] | None = None
    name: ClassVar[str] = "csv"

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether the header row has default names of time and position."""
        del path
        layout = table_layout(first_lines(head), _has_known_names)
        return layout is not None and _has_known_names(list(layout.names))

    def with_columns(self, columns: Mapping[str, str]) -> "CsvReader":
        """Return the reader with the user's column names."""
        return replace(self, columns=dict(columns))

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip per vehicle; the mapped columns are held in memory."""
        lines = first_lines(file_head(path))
        layout = self._layout(path, lines)
        found = known_map(path, self.columns, layout.names, row=layout.lines)
        field = {name: at for at, name in enumerate(layout.names)}
        numbers = [field[name] for name, _ in found.numbers.values()]
        wanted = numbers + ([field[found.label]] if found.label is not None else [])
        decimal = decimal_mark(lines, layout, numbers, path)
        time, unit_s = found.numbers["t_s"]
        times = TimeColumn(path, time, unit_s, stated=found.time_stated, decimal=decimal)
        parts: list[Rows] = []
        labels: list[pl.Series] = []
        partial = False
        for block in read_blocks(
            path, counts=[len(layout.names)], fields=wanted, skip_lines=layout.lines,
            separator=layout.separator,
        ):  # fmt: skip
            partial = partial or block.partial > 0
            columns = {
                fills: number_column(path, block, field[name], name, decimal=decimal)
                for fills, (name, _) in found.numbers.items()
                if fills != "t_s"
            }
            columns["t_s"] = times.read(text_column(block, field[time]), block.line)
            parts.append(Rows(block.line, columns))
            if found.label is not None:
                labels.append(text_column(block, field[found.label]).alias(found.label))
        if not any(len(part) for part in parts):
            raise DataFormatError(path, "no rows after the header", remedy="The file is empty.")
        yield from table_trips(
            path, self.name, found, joined(parts), pl.concat(labels) if labels else None,
            time=times.unit, partial=partial, on_skipped=on_skipped,
        )  # fmt: skip

    def _layout(self, path: str, lines: list[str]) -> TableLayout:
        """Return how the table is written."""
        mapped = set(self.columns.values()) if self.columns else None
        layout = table_layout(lines, _has_known_names if mapped is None else mapped.issubset)
        if layout is None or not any(layout.names):
            raise DataFormatError(path, "the file is empty", remedy="The first line names the columns.")
        if mapped is None and all(map(is_number, layout.names)):
            raise DataFormatError(
                path, "has numbers where the header row should be", row=layout.lines,
                remedy="Add a first line that names the columns, for example t,x,y,speed.",
            )  # fmt: skip
        return layout


def _has_known_names(names: list[str]) -> bool:
    return detected_map(names) is not None
