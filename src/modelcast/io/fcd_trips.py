"""Floating-car data of SUMO as trips: XML, CSV and Parquet as SUMO 1.28 writes them, also packed.

A vehicle is a trip, ``<stem>/<vehicle>``, a bicycle (by its type's name) ``<stem>/bicycle-<vehicle>``.
`modelcast.io.fcd_columns` has the table of columns and names; tables with names of one's own are read by the
formats csv and parquet. What a scenario of these files does (`modelcast.io.fcd`) is done here too:

- x and y are the middle of the front bumper. Positions are moved back by half a length, along the heading.
  SUMO writes no length: that of `modelcast.core.kinds` is taken where the file has none, counted "length not
  known, usual one taken"; the middle is then off by half of what the length is. Without a heading positions
  stay where they are, counted "heading not known, front bumper kept".
- Longitude and latitude (``--fcd-output.geo``) are found by how vehicles move, laid out in metres, and
  headings turned to true north (`modelcast.io.fcd_survey`).
- Persons, containers, vehicles off the road, and time steps without vehicles are no trips. They are reported
  together, as ``<stem>/others``, with their numbers.

Times are the simulation's, one clock for all vehicles; there is no absolute time. A vehicle that is missing
for a while has a gap; where one is teleported a part begins. Time that runs back, a vehicle twice at one
time, and positions that do not move as the speeds say are errors with file, row and value.

What positions are is told by the first `HEAD_TIMES` times, or by all where these do not tell. The file is
then read once, and more often where its vehicles do not fit into memory together (`modelcast.io.gathering`).
A row is an element, a line or a record.

References
----------
SUMO 1.28, Simulation/Output/FCDOutput (x, y: front bumper; angle: degrees clockwise from north).
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import ClassVar

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import heading_to_velocity, wrap_angle_rad
from modelcast.core.kinds import SIZES_M, Kind
from modelcast.io.base import OnSkipped, Tally, ignore_skipped
from modelcast.io.fcd_columns import FcdRow, fcd_columns
from modelcast.io.fcd_rows import csv_names, read_columns
from modelcast.io.fcd_survey import FcdSurvey, survey
from modelcast.io.fcd_times import by_time, in_metres
from modelcast.io.fleet_slots import RAW_COLUMNS
from modelcast.io.gathering import AbstractKeyedRows, Gathered, KeyedBlock, gathered
from modelcast.io.holding import AbstractHoldingReader
from modelcast.io.packed import recording_stem
from modelcast.io.rows import Rows, make_trip
from modelcast.io.text_head import first_lines
from modelcast.trips.trajectory import Trajectory
from modelcast.trips.understood import Understood

__all__ = ["HEAD_TIMES", "FcdReader"]

_Key = tuple[str, Kind]
"""A vehicle's name and what it is."""

HEAD_TIMES = 500
"""Times at the start of a file that tell whether positions are metres or degrees."""

_BLOCK_ROWS = 2**16
_OPTIONAL = ("speed_mps", "heading_rad", "acceleration_mps2", "yaw_rate_radps")


class FcdReader(AbstractHoldingReader):
    """Reads SUMO's floating-car data; the module's docstring has the choices."""

    name: ClassVar[str] = "sumo-fcd"
    streams: ClassVar[bool] = True

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether this is XML with SUMO's root, or a table with SUMO's names."""
        start = head.removeprefix(b"\xef\xbb\xbf").lstrip()
        if start.startswith(b"<"):
            return b"<fcd-export" in start
        try:
            if start.startswith(b"PAR1"):
                columns = read_columns(str(path))
            else:
                columns = fcd_columns(str(path), csv_names("".join(first_lines(head)[:1]))[0])
        except DataFormatError:
            return False
        return columns is not None and columns.is_sumo

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip a vehicle."""
        rows = _FcdTrips(_surveyed(path))
        for found in gathered(rows, self.held_bytes):
            trip = _trip(rows, found, on_skipped)
            if trip is not None:
                yield trip
        if rows.others.left_out:
            on_skipped(f"{rows.stem}/others", rows.others.why_empty())


def _surveyed(path: str) -> FcdSurvey:
    """Return what the positions of a file are."""
    try:
        return survey(path, times=HEAD_TIMES)
    except DataFormatError:
        return survey(path)


class _FcdTrips(AbstractKeyedRows[_Key]):
    """The rows of a file that are vehicles; `others` are the rest, once the file was read to its end."""

    def __init__(self, found: FcdSurvey) -> None:
        self.found, self.path, self.others = found, found.path, Tally()
        self.stem = recording_stem(found.path)
        degrees = (
            "x and y are longitude and latitude, told by how vehicles move; headings turned to true north"
        )
        place = "front bumpers, moved back by half a length" if found.front_bumper else "middles"
        told = "x and y are metres, told by how vehicles move" if found.origin is None else degrees
        self.understood = Understood(notes={"position": f"{told}; {place}"})

    @property
    def columns(self) -> int:
        """The time and the numbers."""
        return len(RAW_COLUMNS) + 1

    @property
    def rows_expected(self) -> int | None:
        """Not known."""
        return None

    def called(self, key: _Key) -> str:
        """``<stem>/<vehicle>``, for bicycles ``<stem>/bicycle-<vehicle>``."""
        vehicle, kind = key
        return f"{self.stem}/{'bicycle-' if kind == Kind.CYCLIST else ''}{vehicle}"

    def blocks(self, *, rows: bool) -> Iterator[KeyedBlock[_Key]]:
        """Yield blocks of vehicles' rows."""
        batch: list[FcdRow] = []
        others = Tally()
        index = 0
        for at_one_time in by_time(self.path):
            for row in at_one_time:
                if row.skipped:
                    others.skip(row.skipped, 1)
                else:
                    batch.append(row)
            if len(batch) >= _BLOCK_ROWS:
                yield _block(index, batch, rows=rows)
                batch, index = [], index + 1
        self.others = others
        if batch:
            yield _block(index, batch, rows=rows)


def _block(index: int, batch: Sequence[FcdRow], *, rows: bool) -> KeyedBlock[_Key]:
    places: dict[_Key, int] = {}
    number = np.array([places.setdefault((row.vehicle, row.kind), len(places)) for row in batch], np.int64)
    if not rows:
        return KeyedBlock(index, list(places), number, None)
    numbers = np.array([row.numbers for row in batch])
    columns = {name: numbers[:, at] for at, name in enumerate(RAW_COLUMNS)}
    line = np.array([row.row for row in batch], np.int64)
    t_s = np.array([row.t_s for row in batch])
    return KeyedBlock(index, list(places), number, Rows(line, {"t_s": t_s, **columns}))


def _trip(file: _FcdTrips, found: Gathered[_Key], on_skipped: OnSkipped) -> Trajectory | None:
    """Return one vehicle's trip, its middle in metres."""
    tally = Tally()
    tally.understand(file.understood)
    trip_id = file.called(found.key)
    trip = make_trip(
        file.path, trip_id, _placed(file.found, found.rows, found.key[1], tally), tally,
        count=len(found.rows), source=FcdReader.name, origin=file.found.origin, clock_offset_s=0.0,
    )  # fmt: skip
    if trip is None:
        on_skipped(trip_id, tally.why_empty())
    return trip


def _placed(found: FcdSurvey, rows: Rows, kind: Kind, tally: Tally) -> Rows:
    """Return rows with their middles, headings from true north, and the columns that are there."""
    columns = rows.columns
    table = np.stack([columns[name] for name in RAW_COLUMNS], axis=1)
    place_m = in_metres(table, found.origin)
    heading_rad = wrap_angle_rad(columns["heading_rad"] + found.turn_rad)
    if found.front_bumper:
        place_m = place_m - _half_lengths(rows, heading_rad, kind, tally)
    own = {name: columns[name] for name in _OPTIONAL if not np.isnan(columns[name]).all()}
    if "heading_rad" in own:
        own["heading_rad"] = heading_rad
    return Rows(rows.line, {"t_s": columns["t_s"], "east_m": place_m[:, 0], "north_m": place_m[:, 1], **own})


def _half_lengths(rows: Rows, heading_rad: FloatArray, kind: Kind, tally: Tally) -> FloatArray:
    """Return the way from a vehicle's middle to its front bumper, (R, 2) [m]; nothing without a heading."""
    length_m = rows.columns["length_m"]
    headless = np.isnan(heading_rad)
    tally.repair("heading not known, front bumper kept", int(headless.sum()))
    tally.repair("length not known, usual one taken", int((np.isnan(length_m) & ~headless).sum()))
    half_m = 0.5 * np.where(np.isnan(length_m), SIZES_M[kind][0], length_m)
    return heading_to_velocity(np.where(headless, 0.0, half_m), np.where(headless, 0.0, heading_rad))
