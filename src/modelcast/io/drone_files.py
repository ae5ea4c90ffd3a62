"""The three tables of a drone's recording, as highD and the inD family publish them, found by their headers.

``<recording>_tracks.csv`` has a row a road user and frame, ``<recording>_tracksMeta.csv`` a row a road user
and ``<recording>_recordingMeta.csv`` one row. Any of them stands for the recording.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import polars as pl

from modelcast.core.exceptions import DataFormatError
from modelcast.io.rows import LARGEST
from modelcast.io.text_blocks import read_blocks, text_column
from modelcast.io.text_head import file_head, first_lines, split_fields

__all__ = ["DroneFiles", "DroneTables", "header_of", "number_of", "small_table"]

Table = Literal["tracks", "tracksMeta", "recordingMeta"]
_TABLES: tuple[Table, ...] = ("tracks", "tracksMeta", "recordingMeta")
_MOST_ROWS = 1_000_000


@dataclass(frozen=True, slots=True)
class DroneTables:
    """The columns that a format needs, and is known by, by table."""

    tracks: tuple[str, ...]
    tracks_meta: tuple[str, ...]
    recording_meta: tuple[str, ...]

    def of(self, table: Table) -> tuple[str, ...]:
        """Return the columns of one table."""
        return {
            "tracks": self.tracks,
            "tracksMeta": self.tracks_meta,
            "recordingMeta": self.recording_meta,
        }[table]

    def table_of(self, names: Sequence[str]) -> Table | None:
        """Return which of the tables has these columns, None where they are of another format."""
        return next((table for table in _TABLES if set(self.of(table)) <= set(names)), None)


@dataclass(frozen=True, slots=True)
class DroneFiles:
    """Where the tables of one recording are.

    Parameters
    ----------
    tables
        What the format needs.
    folder, recording
        The files' folder, and what their names begin with.
    """

    tables: DroneTables
    folder: Path
    recording: str

    def path(self, table: Table) -> Path:
        """Return the file of one table."""
        return self.folder / f"{self.recording}_{table}.csv"

    @classmethod
    def beside(cls, tables: DroneTables, path: Path) -> "DroneFiles | None":
        """Return the recording that a file belongs to, None where its name is that of no table."""
        recording, mark, table = path.stem.rpartition("_")
        return cls(tables, path.parent, recording) if mark and table in _TABLES else None

    @classmethod
    def opened(cls, tables: DroneTables, path: str) -> "DroneFiles":
        """Return the recording that a file belongs to.

        Raises
        ------
        DataFormatError
            Where the file is empty, or called otherwise than the tables are, or one of them is missing.
        """
        header_of(path)
        found = cls.beside(tables, Path(path))
        if found is None:
            raise DataFormatError(
                path, "is called otherwise than <recording>_tracks.csv, ..._tracksMeta.csv or "
                "..._recordingMeta.csv", remedy="Give the three files their own names.",
            )  # fmt: skip
        for table in _TABLES:
            if not found.path(table).is_file():
                raise DataFormatError(
                    path, f"{found.path(table).name} is not beside it",
                    remedy="A recording is three files: put them into one folder.",
                )  # fmt: skip
        return found


def header_of(path: str) -> list[str]:
    """Return the names in a table's first line.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    DataFormatError
        Where it is empty.
    """
    lines = first_lines(file_head(path))
    if not lines or not any(line.strip() for line in lines):
        raise DataFormatError(path, "the file is empty", remedy="Check that it is complete.")
    return split_fields(lines[0])


def small_table(
    path: str, needed: Sequence[str], optional: Sequence[str] = ()
) -> tuple[pl.DataFrame, list[int]]:
    """Return columns of a table of metadata as text, and its rows' line numbers.

    Parameters
    ----------
    path
        The file.
    needed, optional
        Names of the columns; an optional one that is missing is not among those returned.

    Raises
    ------
    DataFormatError
        Where a column or all rows are missing, a line is not whole, or there are over a million rows.
    """
    names = header_of(path)
    absent = [name for name in needed if name not in names]
    if absent:
        raise DataFormatError(
            path, f"no column {absent[0]} among {', '.join(names)[:200]}", row=1,
            remedy="Give the recording's own file.",
        )  # fmt: skip
    wanted = [name for name in (*needed, *optional) if name in names]
    parts: list[pl.DataFrame] = []
    lines: list[int] = []
    for block in read_blocks(
        path, counts=[len(names)], fields=[names.index(n) for n in wanted], skip_lines=1
    ):
        parts.append(pl.DataFrame([text_column(block, names.index(name)).alias(name) for name in wanted]))
        lines += block.line.tolist()
        if block.partial or len(lines) > _MOST_ROWS:
            what = "the last line is cut short" if block.partial else f"over {_MOST_ROWS} rows of metadata"
            raise DataFormatError(
                path, what, row=block.partial or _MOST_ROWS, remedy="Check that it is complete."
            )
    if not lines:
        raise DataFormatError(path, "no rows after the header", remedy="Check that it is complete.")
    return pl.concat(parts), lines


def number_of(path: str, row: Mapping[str, str | None], name: str, line: int) -> float:
    """Return a cell of metadata as a number.

    Parameters
    ----------
    path, line
        Where it is.
    row, name
        The row's cells by column, and the column.

    Raises
    ------
    DataFormatError
        Where it is no finite number.
    """
    text = row[name]
    value = None if text is None else pl.Series([text]).cast(pl.Float64, strict=False)[0]
    if value is None or not abs(value) <= LARGEST:
        raise DataFormatError(
            path, f"{name} is {text!r}, not a finite number", row=line, remedy="Correct the value."
        )
    return float(value)
