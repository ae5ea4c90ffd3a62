"""Comma-separated tables with a header row, by the names of their columns.

`modelcast.io.column_map` has the table of columns, the names found without a map, and the units. A column
``vehicle`` makes one trip a vehicle, ``<stem>/<vehicle>`` (``<stem>/vehicle`` without that column); a column
``trip`` gives identifiers as they are. Other columns are not read.

A byte order mark, CRLF, blank padding, quotes around a field (without a comma inside) and E notation are
read; blank or ``NULL`` is missing.

Skipped and counted: rows whose time or position is blank, a cut last line. Repaired and counted: single
missing values of optional columns (the last value is held). Anything else is an error with its line.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

import polars as pl

from modelcast.core.exceptions import DataFormatError
from modelcast.core.trajectory import Trajectory
from modelcast.io.base import AbstractTripReader, OnSkipped, ignore_skipped
from modelcast.io.column_map import ColumnMap, detected_map, user_map
from modelcast.io.rows import Rows, joined
from modelcast.io.table_trips import table_trips
from modelcast.io.text_blocks import first_lines, number_column, read_blocks, split_fields, text_column

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
        lines = first_lines(head)
        return bool(lines) and detected_map(split_fields(lines[0])) is not None

    def with_columns(self, columns: Mapping[str, str]) -> "CsvReader":
        """Return the reader with the user's column names."""
        return replace(self, columns=dict(columns))

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip per vehicle; the mapped columns are held in memory."""
        header, found = self._layout(path)
        field = {name: at for at, name in enumerate(header)}
        wanted = [field[name] for name, _ in found.numbers.values()]
        wanted += [field[found.label]] if found.label is not None else []
        parts: list[Rows] = []
        labels: list[pl.Series] = []
        partial = False
        for block in read_blocks(path, counts=[len(header)], fields=wanted, skip_lines=1):
            partial = partial or block.partial > 0
            columns = {
                fills: number_column(path, block, field[name], name) * (factor if fills != "t_s" else 1.0)
                for fills, (name, factor) in found.numbers.items()
            }
            parts.append(Rows(block.line, columns))
            if found.label is not None:
                labels.append(text_column(block, field[found.label]).alias(found.label))
        if not any(len(part) for part in parts):
            raise DataFormatError(path, "no rows after the header", remedy="The file is empty.")
        yield from table_trips(
            path, self.name, found, joined(parts), pl.concat(labels) if labels else None,
            partial=partial, on_skipped=on_skipped,
        )  # fmt: skip

    def _layout(self, path: str) -> tuple[list[str], ColumnMap]:
        """Return the header's names and which of them mean what."""
        with Path(path).open("rb") as file:
            lines = first_lines(file.read(65536))
        header = split_fields(lines[0]) if lines else []
        if not any(header):
            raise DataFormatError(path, "the file is empty", remedy="The first line names the columns.")
        found = user_map(path, self.columns, header) if self.columns else detected_map(header)
        if found is None:
            raise DataFormatError(
                path,
                f"no known names of time and position among the columns {', '.join(header)}",
                row=1,
                remedy="Give a column map, for example t=time,east=x,north=y,speed=v.",
            )
        names = [name for name, _ in found.numbers.values()] + ([found.label] if found.label else [])
        twice = [name for name in names if header.count(name) > 1]
        if twice:
            raise DataFormatError(path, f"column {twice[0]!r} occurs more than once", row=1)
        return header, found
