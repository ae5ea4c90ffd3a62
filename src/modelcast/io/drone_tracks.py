"""Tracks that drones recorded, what highD and the inD family share: tables, frames, road users by name.

A road user is a trip, ``<stem of the tracks>/<id>``; bicycles are ``<stem>/bicycle-<id>``. Pedestrians are no
vehicles: each is reported, with its rows counted. All trips of a recording share a clock that counts from
frame 0; the hour and the weekday that the metadata name are no absolute time.

Rows are gathered in bounded memory and in any order (`modelcast.io.gathering`). Skipped and counted:
"duplicate time", "partial last line", "of a pedestrian". Repaired: "out of time order". A road user that the
metadata do not name, and cells that are blank or no numbers, are errors.
"""

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import polars as pl

from modelcast.core.arrays import IntArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin
from modelcast.io.base import OnSkipped, Tally, ignore_skipped
from modelcast.io.drone_files import DroneFiles, DroneTables, header_of, number_of, small_table
from modelcast.io.gathering import AbstractKeyedRows, Gathered, KeyedBlock, gathered
from modelcast.io.holding import AbstractHoldingReader
from modelcast.io.packed import recording_stem
from modelcast.io.rows import Rows, make_trip, ordered
from modelcast.io.text_blocks import number_column, read_blocks, text_column
from modelcast.io.text_head import first_lines, rows_expected, split_fields
from modelcast.trips.trajectory import Trajectory

__all__ = ["AbstractDroneReader", "Recorded", "RoadUser"]

_MOST_FRAMES_PER_S = 1000.0
_PEDESTRIAN, _BICYCLE = "pedestrian", "bicycle"


@dataclass(frozen=True, slots=True)
class RoadUser:
    """A row of the table of road users: its class in lower case, its cells, and their line."""

    kind: str
    cells: Mapping[str, str | None]
    line: int


@dataclass(frozen=True, slots=True)
class Recorded:
    """What the metadata say of a recording: its files, its only row and that row's line, road users by id."""

    files: DroneFiles
    row: Mapping[str, str | None]
    line: int
    users: Mapping[str, RoadUser]

    def number(self, name: str) -> float:
        """Return a number of the recording."""
        return number_of(str(self.files.path("recordingMeta")), self.row, name, self.line)


class AbstractDroneReader(AbstractHoldingReader):
    """Reads recordings of one layout."""

    @property
    @abstractmethod
    def tables(self) -> DroneTables:
        """The columns it needs; the first of the tracks' and of the road users' is the id."""

    @property
    @abstractmethod
    def optional(self) -> tuple[str, ...]:
        """Columns of the recording's metadata that are used where they are there."""

    @abstractmethod
    def placed(
        self, rows: Rows, user: RoadUser, recorded: Recorded, tally: Tally
    ) -> tuple[Rows, Origin | None]:
        """Return a road user's rows in SI units on the local plane, and where that is on Earth.

        Parameters
        ----------
        rows
            With ``t_s`` and the columns of the tracks, without the id.
        user, recorded
            What the metadata say.
        tally
            For what is put right.
        """

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether the first line is the header of one of the tables."""
        lines = first_lines(head)
        table = self.tables.table_of(split_fields(lines[0])) if lines else None
        return table is not None and path.stem.endswith(f"_{table}")

    def stands_for(self, path: Path) -> Path:
        """Return the tracks."""
        files = DroneFiles.beside(self.tables, path)
        return path if files is None else files.path("tracks")

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip a road user."""
        files = DroneFiles.opened(self.tables, path)
        recorded = self._recorded(files)
        rate_hz = recorded.number("frameRate")
        if not 0.0 < rate_hz <= _MOST_FRAMES_PER_S:
            raise DataFormatError(
                str(files.path("recordingMeta")), f"frameRate is {rate_hz:g}", row=recorded.line,
                remedy="It is in frames a second, 25 as published.",
            )  # fmt: skip
        tracks = _Tracks(str(files.path("tracks")), self.tables.tracks, recorded)
        for found in gathered(tracks, self.held_bytes):
            trip = self._trip(tracks, found, rate_hz, on_skipped)
            if trip is not None:
                yield trip

    def _recorded(self, files: DroneFiles) -> Recorded:
        path = str(files.path("recordingMeta"))
        recording, at = small_table(path, self.tables.recording_meta, self.optional)
        if len(at) > 1:
            raise DataFormatError(
                path, "more than one recording", row=at[1], remedy="Give the recording's own file."
            )
        table, lines = small_table(str(files.path("tracksMeta")), self.tables.tracks_meta)
        name = self.tables.tracks_meta[0]
        users = {
            str(cells[name]): RoadUser(str(cells["class"] or "").lower(), cells, line)
            for cells, line in zip(table.iter_rows(named=True), lines, strict=True)
        }
        return Recorded(files, recording.row(0, named=True), at[0], users)

    def _trip(
        self, tracks: "_Tracks", found: Gathered[str], rate_hz: float, on_skipped: OnSkipped
    ) -> Trajectory | None:
        tally = Tally()
        tally.skip("partial last line", int(found.partial))
        count = len(found.rows) + int(found.partial)
        trip_id = tracks.called(found.key)
        user = tracks.recorded.users[found.key]
        rows = found.rows.without(
            np.full(len(found.rows), user.kind == _PEDESTRIAN), f"of a {_PEDESTRIAN}", tally
        )
        trip = None
        if len(rows):
            rows = ordered(rows.having(t_s=rows.columns["frame"] / rate_hz), tally)
            rows, origin = self.placed(rows, user, tracks.recorded, tally)
            trip = make_trip(
                tracks.path, trip_id, rows, tally,
                count=count, source=self.name, origin=origin, clock_offset_s=0.0,
            )  # fmt: skip
        if trip is None:
            on_skipped(trip_id, tally.why_empty())
        return trip


class _Tracks(AbstractKeyedRows[str]):
    """The rows of the tracks."""

    def __init__(self, path: str, names: tuple[str, ...], recorded: Recorded) -> None:
        self.path, self.recorded = path, recorded
        header = header_of(path)
        missing = [name for name in names if name not in header]
        if missing:
            raise DataFormatError(
                path, f"no column {missing[0]} among {', '.join(header)[:200]}", row=1,
                remedy=f"Needed are {', '.join(names)}.",
            )  # fmt: skip
        self._width = len(header)
        self._key, *self._numbers = [(name, header.index(name)) for name in names]

    @property
    def columns(self) -> int:
        """Those that are needed, and the time."""
        return len(self._numbers) + 1

    @property
    def rows_expected(self) -> int | None:
        """By the size of the file."""
        return rows_expected(self.path)

    def called(self, key: str) -> str:
        """``<stem>/<id>``, with what it is where that is no car."""
        kind = self.recorded.users[key].kind if key in self.recorded.users else ""
        prefix = f"{kind}-" if kind in {_PEDESTRIAN, _BICYCLE} else ""
        return f"{recording_stem(self.path)}/{prefix}{key}"

    def blocks(self, *, rows: bool) -> Iterator[KeyedBlock[str]]:
        """Yield blocks of text."""
        at = self._key[1]
        fields = [at, *(field for _, field in self._numbers)] if rows else [at]
        for block in read_blocks(self.path, counts=[self._width], fields=fields, skip_lines=1):
            text = text_column(block, at).fill_null("")
            unique = text.unique(maintain_order=True)
            keys: list[str] = unique.to_list()
            number = text.replace_strict(unique, range(len(keys)), return_dtype=pl.Int64).to_numpy()
            self._require_known(keys, number, block.line)
            columns = {
                called: number_column(self.path, block, field, called)
                for called, field in (self._numbers if rows else [])
            }
            for called, column in columns.items():
                if np.isnan(column).any():
                    line = int(block.line[int(np.argmax(np.isnan(column)))])
                    raise DataFormatError(
                        self.path, f"{called} is blank", row=line, remedy="Leave the row out."
                    )
            yield KeyedBlock(
                block.index, keys, number, Rows(block.line, columns) if rows else None,
                partial=block.partial > 0,
            )  # fmt: skip

    def _require_known(self, keys: list[str], number: IntArray, line: IntArray) -> None:
        for at, key in enumerate(keys):
            if key not in self.recorded.users:
                raise DataFormatError(
                    self.path,
                    f"{self._key[0]} {key!r} is not in {self.recorded.files.path('tracksMeta').name}",
                    row=int(line[int(np.argmax(number == at))]),
                    remedy="Give the three files of one recording.",
                )
