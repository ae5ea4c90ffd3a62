"""Trips out of one table with named columns: what the csv and parquet readers and data frames share.

Rows are gathered by vehicle (`modelcast.io.gathering`); within a vehicle time must increase.

Programs that log SUMO through TraCI write -1073741824 for what a vehicle off the road does not have. Rows
with such a position are skipped and counted; such values of other columns are missing, and counted too.
"""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import polars as pl

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin
from modelcast.io.angle_check import refuse_other_angles
from modelcast.io.base import NoUsableRow, OnSkipped, Tally
from modelcast.io.column_map import ColumnMap
from modelcast.io.gathering import AbstractKeyedRows, KeyedBlock, gathered, numbered
from modelcast.io.heading_check import heading_si
from modelcast.io.map_grid import counted_from, near_origin_m, refuse_earth_centred
from modelcast.io.packed import recording_stem
from modelcast.io.reading_limits import HELD_BYTES
from modelcast.io.rows import OPTIONAL, Rows, are_unknown_to_sumo, located, make_trip, with_missing
from modelcast.io.table_checks import check_units, checked_heading
from modelcast.io.table_notes import understood
from modelcast.io.time_column import TimeUnit, over_midnight
from modelcast.io.unit_votes import UnitVotes
from modelcast.trips.trajectory import Trajectory
from modelcast.trips.understood import Understood

__all__ = ["OFF_ROAD", "AbstractTable", "TablePart", "table_trips"]

OFF_ROAD = "off the road (SUMO's -1073741824)"
"""Why a row without a position in SUMO's traffic is skipped."""

_SORT = "Sort the file by vehicle and time and leave one row per time."
_SEVERAL = "If it holds several vehicles, say which column names them: --columns vehicle={name}."
_UNNAMED = "If it holds several vehicles, add a column that names them."

_POSITION = ("east_m", "north_m", "latitude_deg", "longitude_deg")
_NOT_KNOWN = -np.inf
"""What stands for SUMO's sentinel in columns of SI units."""

_STAND_INS = (-999.0, -9999.0, -99999.0)
"""What loggers write for an angle or a height that they do not know: none is one of a road."""
_STOOD_IN = np.inf
"""What stands for these in columns of SI units."""
_STOOD_FOR = ("latitude_deg", "longitude_deg", "altitude_m", "heading_rad")
POSITION_STOOD_FOR = "position not known (-999)"

_NEXT_DAY = "time of day taken as of the next day"

_MOST_WAITING, _MOST_WAITING_ROWS = 100, 1_000_000
"""Vehicles, and their rows, that wait while more of them object to a unit than fit it."""

_CONSTANTS = ("origin_latitude_deg", "origin_longitude_deg", "origin_altitude_m", "start_unix_s")
_ONLY = "vehicle"
"""What the vehicle of a table is called that names none."""


@dataclass(frozen=True, slots=True)
class TablePart:
    """Consecutive rows of a table.

    Parameters
    ----------
    index
        Number of the part, from 0, the same in every pass.
    rows
        The rows as the file has them: the time from `TimeUnit.start`, NaN where blank; the other columns of
        the map where they were asked for.
    labels
        The vehicle (or trip) of each row as text, where the table names it.
    partial
        Whether a last line cut short was passed over.
    """

    index: int
    rows: Rows
    labels: pl.Series | None
    partial: bool = False


class AbstractTable(ABC):
    """A table with named columns, which can be gone through again and again in parts of bounded size.

    Parameters
    ----------
    path
        What errors call it; its stem begins the identifiers.
    found
        What its columns mean.
    """

    recoded: str = ""
    """What the trips' counts say of an encoding that is not the usual one."""

    written: str = ""
    """How its text is written, in words; empty where its columns are typed."""

    counts_rows: ClassVar[bool] = False
    """Whether `rows_expected` is exact."""

    def __init__(self, path: str, found: ColumnMap) -> None:
        self.path = path
        self.found = found

    @property
    @abstractmethod
    def time(self) -> TimeUnit:
        """What the times mean; settled once a part with a time was read."""

    @property
    @abstractmethod
    def rows_expected(self) -> int | None:
        """About how many rows it has, None where only reading tells."""

    @abstractmethod
    def first_cells(self) -> Mapping[str, Sequence[str]]:
        """Return the first rows as text, by column: those read, and those not read that may be shown."""

    @abstractmethod
    def parts(self, *, whole: bool) -> Iterator[TablePart]:
        """Yield the table.

        Parameters
        ----------
        whole
            Whether the other columns of the map are wanted, beside time and vehicle.

        Raises
        ------
        DataFormatError
            Where a value is none that its column may have.
        """


_Made = tuple[str, "Trajectory | NoUsableRow"]
"""The name of a vehicle's trip, and the trip or why there is none."""


def table_trips(
    table: AbstractTable, source: str, on_skipped: OnSkipped, *, held_bytes: int = HELD_BYTES
) -> Iterator[Trajectory]:
    """Yield a table's trips.

    Parameters
    ----------
    table
        The table.
    source, on_skipped
        As for readers.
    held_bytes
        Octets of numbers that may be gathered at a time.

    Notes
    -----
    While at least half of the vehicles that could be told object to a unit, trips wait; if they still do at
    the end, or when `_MOST_WAITING` of them wait, the first objection is raised.
    """
    rows = _TableRows(table)
    taken: Understood | None = None
    votes, waiting = UnitVotes(), deque[_Made]()
    waiting_rows = 0
    for found in gathered(rows, held_bytes):
        tally = Tally()
        taken = taken or understood(
            table.found, table.first_cells() if table.found.unused else {}, table.time,
            written=table.written, far_m=rows.far_m,
        )  # fmt: skip
        tally.understand(taken)
        tally.skip("partial last line", int(found.partial))
        if table.recoded:
            tally.repair(table.recoded, len(found.rows))
        trip_id = rows.called(found.key)
        try:
            trip = _trip(
                table.path, source, trip_id, found.rows, tally,
                count=len(found.rows) + int(found.partial), time=table.time,
                shared_origin=rows.origin, far_m=rows.far_m, one_clock=rows.one_clock,
                vehicle=rows.vehicle(found.key), found=table.found, votes=votes,
                unsorted=_unsorted(table.found, taken),
            )  # fmt: skip
        except DataFormatError as error:
            objection = votes.objection
            if objection is None:
                raise
            raise objection from error
        waiting.append((trip_id, tally.why_empty() if trip is None else trip))
        waiting_rows += len(found.rows)
        if votes.objection is None:
            yield from _let_go(waiting, on_skipped)
            waiting_rows = 0
        elif len(waiting) >= _MOST_WAITING or waiting_rows >= _MOST_WAITING_ROWS:
            break
    if votes.objection is not None:
        raise votes.objection


def _let_go(waiting: deque[_Made], on_skipped: OnSkipped) -> Iterator[Trajectory]:
    """Yield the trips that wait, and say which vehicles gave none."""
    while waiting:
        trip_id, made = waiting.popleft()
        if isinstance(made, Trajectory):
            yield made
        else:
            on_skipped(trip_id, made)


def _unsorted(found: ColumnMap, taken: Understood) -> str:
    """Return what to do where time does not increase."""
    if found.label:
        return _SORT
    if not found.unused:
        return f"{_SORT} {_UNNAMED}"
    return f"{_SORT} {_SEVERAL.format(name=taken.suggested.get('vehicle', 'NAME'))}"


class _TableRows(AbstractKeyedRows[str]):
    """The rows of a table in SI units, but for the time.

    `origin` is the first full position of a table of latitudes and longitudes, once it was read; `far_m` the
    point that others are counted from where they lie far off (`modelcast.io.map_grid`); `one_clock` whether
    all trips tell the time by one clock, as they do where some begins at another time than 0.
    """

    def __init__(self, table: AbstractTable) -> None:
        self.path = table.path
        self.origin: Origin | None = None
        self.far_m: FloatArray | None = None
        self._placed = False
        self.one_clock = False
        self._table = table
        self._begun: set[str] = set()

    @property
    def columns(self) -> int:
        """Those of the map."""
        return len(self._table.found.numbers)

    @property
    def rows_expected(self) -> int | None:
        """As the table says."""
        return self._table.rows_expected

    @property
    def only(self) -> str | None:
        """The one trip of a table that names none and counts its rows."""
        return _ONLY if self._table.counts_rows and self._table.found.label is None else None

    def called(self, key: str) -> str:
        """The label where it is a complete identifier, else ``<stem>/<label>``."""
        found = self._table.found
        return key if found.whole_id and found.label is not None else f"{recording_stem(self.path)}/{key}"

    def vehicle(self, key: str) -> str:
        """The label where it names a vehicle, whose trips may be in several files; else nothing."""
        found = self._table.found
        return "" if found.whole_id or found.label is None else key

    def blocks(self, *, rows: bool) -> Iterator[KeyedBlock[str]]:
        """Yield the table's parts."""
        for part in self._table.parts(whole=rows):
            keys, number = self._keys(part)
            self._note_clock(part.rows.columns["t_s"], keys, number)
            found = self._in_si(part.rows) if rows else None
            yield KeyedBlock(part.index, keys, number, found, part.partial)

    def _keys(self, part: TablePart) -> tuple[list[str], IntArray]:
        count, labels = len(part.rows), part.labels
        if labels is None:
            return [_ONLY] * (count > 0), np.zeros(count, dtype=np.int64)
        if labels.null_count():
            at = int(labels.is_null().arg_true()[0])
            raise DataFormatError(
                self.path, f"the vehicle ({labels.name}) is blank", row=int(part.rows.line[at]),
                remedy="Name it.",
            )  # fmt: skip
        keys, number = numbered([labels])
        return [key for (key,) in keys], number

    def _note_clock(self, t_s: FloatArray, keys: list[str], number: IntArray) -> None:
        """Look whether a trip that begins here does so at another time than 0."""
        if self.one_clock or self._begun.issuperset(keys):
            return
        _, first = np.unique(number, return_index=True)
        for key, start in zip(keys, t_s[first].tolist(), strict=True):
            if key not in self._begun and np.isfinite(start) and start + self._table.time.start != 0.0:
                self.one_clock = True
                self._begun.clear()
                return
        self._begun.update(keys)

    def _in_si(self, raw: Rows) -> Rows:
        """Return the rows with SUMO's sentinel as -inf, in all columns of a position where it is in one."""
        columns = dict(raw.columns)
        for fills, (_, factor) in self._table.found.numbers.items():
            if fills == "t_s":
                continue
            column = columns[fills]
            if fills == "heading_rad":
                column = heading_si(column, factor)
            elif factor != 1.0:
                column = column * factor
            unknown = are_unknown_to_sumo(columns[fills])
            column = np.where(unknown, _NOT_KNOWN, column) if unknown.any() else column
            stood_in = np.isin(columns[fills], _STAND_INS) if fills in _STOOD_FOR else unknown[:0]
            columns[fills] = np.where(stood_in, _STOOD_IN, column) if stood_in.any() else column
        places = [name for name in _POSITION if name in columns]
        off = np.any([np.isneginf(columns[name]) for name in places], axis=0)
        if off.any():
            columns |= {name: np.where(off, _NOT_KNOWN, columns[name]) for name in places}
        rows = Rows(raw.line, columns)
        refuse_other_angles(self.path, rows, self._table.found)
        if self._table.found.geodetic and self.origin is None:
            self.origin = _first_origin(rows)
        if not self._placed and "east_m" in columns and "origin_latitude_deg" not in columns:
            self._placed = bool(np.isfinite(columns["east_m"] + columns["north_m"]).any())
            self.far_m = near_origin_m(rows)
        return rows


def _without_blank_columns(rows: Rows) -> Rows:
    """Return the rows without optional columns that hold nothing, as if the table did not have them."""
    blank = {name for name in OPTIONAL if name in rows.columns and np.isnan(rows.columns[name]).all()}
    return Rows(rows.line, {name: column for name, column in rows.columns.items() if name not in blank})


def _trip(
    path: str, source: str, trip_id: str, rows: Rows, tally: Tally, *, count: int, time: TimeUnit,
    shared_origin: Origin | None, far_m: FloatArray | None, one_clock: bool, vehicle: str, found: ColumnMap,
    votes: UnitVotes, unsorted: str,
) -> Trajectory | None:  # fmt: skip
    """Return one vehicle's trip, or None where no row is usable."""
    rows = _without_blank_columns(rows)
    columns = rows.columns
    geodetic = "latitude_deg" in columns
    x, y = ("latitude_deg", "longitude_deg") if geodetic else ("east_m", "north_m")
    rows = rows.without(np.isposinf(columns[x]) | np.isposinf(columns[y]), POSITION_STOOD_FOR, tally)
    rows = rows.without(np.isneginf(rows.columns[x]), OFF_ROAD, tally)
    rows = rows.without(np.isnan(rows.columns["t_s"]), "time blank", tally)
    rows = rows.without(np.isnan(rows.columns[x] + rows.columns[y]), "position blank", tally)
    if not len(rows):
        return None
    columns = rows.columns
    constant = {name: float(columns[name][0]) for name in _CONSTANTS if name in columns}
    rows = _known(rows, tally)
    if time.told:
        tally.repair(time.told, len(rows))
    if geodetic and shared_origin is not None:
        origin: Origin | None = shared_origin
        rows = located(rows, shared_origin)
    else:
        origin = _own_origin(constant)
        if far_m is not None:
            placed, east = rows, found.numbers["east_m"][0]
            votes.ask("centre", lambda: refuse_earth_centred(path, placed, east))
            rows = counted_from(rows, far_m, tally)
    if "heading_rad" in columns:
        rows = checked_heading(path, rows, found, votes)
    unix = 0.0 if time.unix else constant.get("start_unix_s", np.nan)
    raw_t = over_midnight(rows.columns["t_s"], time)
    tally.repair(_NEXT_DAY, int((raw_t != rows.columns["t_s"]).sum()))
    # Small units are often Unix times, which as seconds in float64 lose their last digits.
    start = float(raw_t[0]) if time.unit_s != 1.0 else 0.0
    rows = rows.having(t_s=(raw_t - start) * time.unit_s)
    check_units(path, rows, time, found, votes)
    return make_trip(
        path,
        trip_id,
        rows,
        tally,
        count=count,
        source=source,
        origin=origin,
        unix_offset_s=unix + (start + time.start) * time.unit_s if np.isfinite(unix) else None,
        clock_offset_s=(start + time.start) * time.unit_s if one_clock else None,
        vehicle=vehicle,
        unsorted=unsorted,
    )


def _known(rows: Rows, tally: Tally) -> Rows:
    """Return the rows with optional values blank for which something stood, counted as repaired."""
    for name, word in (*OPTIONAL.items(), ("altitude_m", "altitude")):
        column = rows.columns.get(name, np.zeros(0))
        for unknown, said in ((np.isneginf(column), "SUMO's -1073741824"), (np.isposinf(column), "-999")):
            if unknown.any():
                tally.repair(f"{word} not known ({said})", int(unknown.sum()))
                rows = rows.having(**{name: with_missing(rows.columns[name], unknown)})
    return rows


def _first_origin(rows: Rows) -> Origin | None:
    columns = rows.columns
    placed = np.isfinite(columns["latitude_deg"] + columns["longitude_deg"] + columns["t_s"])
    if not placed.any():
        return None
    at = int(np.argmax(placed))
    altitude = float(columns["altitude_m"][at]) if "altitude_m" in columns else 0.0
    return Origin(
        float(columns["latitude_deg"][at]),
        float(columns["longitude_deg"][at]),
        altitude if np.isfinite(altitude) else 0.0,
    )


def _own_origin(constant: dict[str, float]) -> Origin | None:
    """Return the origin that a converted trip carries along."""
    latitude = constant.get("origin_latitude_deg", np.nan)
    longitude = constant.get("origin_longitude_deg", np.nan)
    altitude = constant.get("origin_altitude_m", 0.0)
    return (
        Origin(latitude, longitude, altitude) if np.isfinite([latitude, longitude, altitude]).all() else None
    )
