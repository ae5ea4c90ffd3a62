"""Trips out of one table with named columns: what the csv and parquet readers share.

Rows are grouped by vehicle, in order of first appearance; within a vehicle time must increase. All mapped
columns are held in memory, 8 bytes a value.

Programs that log SUMO through TraCI write -1073741824 for what a vehicle off the road does not have. Rows
with such a position are skipped and counted; such values of other columns are missing, and counted too.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import polars as pl

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin, wrap_angle_rad
from modelcast.io.base import OnSkipped, Tally
from modelcast.io.column_map import ColumnMap
from modelcast.io.rows import OPTIONAL, Rows, are_unknown_to_sumo, located, make_trip, with_missing
from modelcast.io.time_column import TimeUnit
from modelcast.io.unit_check import refuse_other_unit
from modelcast.trips.trajectory import Trajectory

__all__ = ["OFF_ROAD", "table_trips"]

OFF_ROAD = "off the road (SUMO's -1073741824)"
"""Why a row without a position in SUMO's traffic is skipped."""

_POSITION = ("east_m", "north_m", "latitude_deg", "longitude_deg")
_OFF = "off_road"

_CONSTANTS = ("origin_latitude_deg", "origin_longitude_deg", "origin_altitude_m", "start_unix_s")


def table_trips(
    path: str, source: str, found: ColumnMap, rows: Rows, labels: pl.Series | None, *, time: TimeUnit,
    partial: bool, on_skipped: OnSkipped,
) -> Iterator[Trajectory]:  # fmt: skip
    """Yield a table's trips.

    Parameters
    ----------
    path, source, on_skipped
        As for readers.
    found
        The table's columns.
    rows
        All rows as the file has them, the time from `TimeUnit.start`, NaN where blank.
    labels
        The vehicle (or trip) of each row as text, where the table names it.
    time
        What the times mean.
    partial
        Whether a cut last line was passed over; it is counted with the last row's vehicle.
    """
    rows = _in_si(found, _without_positions_off_road(rows))
    _check_range(path, rows)
    stem = Path(path).stem
    origin = _first_origin(rows) if found.geodetic else None
    groups = list(_groups(path, rows, labels))
    one_clock = _one_clock(groups, rows, time)
    for label, which in groups:
        trip_id = label if found.whole_id and labels is not None else f"{stem}/{label}"
        tally = Tally()
        own = rows.taken(which) if labels is not None else rows
        cut = partial and len(rows) - 1 in which[-1:]
        tally.skip("partial last line", int(cut))
        count = len(own) + int(cut)
        trip = _trip(
            path, source, trip_id, own, tally,
            count=count, time=time, shared_origin=origin, one_clock=one_clock,
        )  # fmt: skip
        if trip is None:
            on_skipped(trip_id, tally.why_empty())
        else:
            yield trip


def _trip(
    path: str, source: str, trip_id: str, rows: Rows, tally: Tally, *, count: int, time: TimeUnit,
    shared_origin: Origin | None, one_clock: bool,
) -> Trajectory | None:  # fmt: skip
    """Return one vehicle's trip, or None where no row is usable."""
    columns = rows.columns
    geodetic = "latitude_deg" in columns
    if _OFF in columns:
        rows = rows.without(columns[_OFF] > 0, OFF_ROAD, tally)
    rows = rows.without(np.isnan(rows.columns["t_s"]), "time blank", tally)
    x, y = ("latitude_deg", "longitude_deg") if geodetic else ("east_m", "north_m")
    rows = rows.without(np.isnan(rows.columns[x] + rows.columns[y]), "position blank", tally)
    if not len(rows):
        return None
    constant = {name: float(columns[name][0]) for name in _CONSTANTS if name in columns}
    rows = _known_to_sumo(rows, tally)
    if time.told:
        tally.repair(time.told, len(rows))
    if "heading_rad" in columns:
        rows = rows.having(heading_rad=_wrapped(rows.columns["heading_rad"]))
    if geodetic and shared_origin is not None:
        origin: Origin | None = shared_origin
        rows = located(rows, shared_origin)
    else:
        origin = _own_origin(constant)
    unix = 0.0 if time.unix else constant.get("start_unix_s", np.nan)
    raw_t = rows.columns["t_s"]
    # Small units are often Unix times, which as seconds in float64 lose their last digits.
    start = float(raw_t[0]) if time.unit_s != 1.0 else 0.0
    rows = rows.having(t_s=(raw_t - start) * time.unit_s)
    if time.assumed:
        refuse_other_unit(path, rows, time.assumed)
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
    )


def _one_clock(groups: list[tuple[str, np.ndarray]], rows: Rows, time: TimeUnit) -> bool:
    """Whether all trips tell the time by one clock: some begins at another time than 0."""
    starts_s = (rows.columns["t_s"][which[:1]] for _, which in groups)
    return any(bool(np.isfinite(start).all() and (start + time.start != 0.0).all()) for start in starts_s)


def _without_positions_off_road(rows: Rows) -> Rows:
    """Return the rows with positions that are SUMO's sentinel blank, marked in a column of their own."""
    places = {name: column for name, column in rows.columns.items() if name in _POSITION}
    off = np.any([are_unknown_to_sumo(column) for column in places.values()], axis=0)
    if not off.any():
        return rows
    blanked = {name: with_missing(column, off) for name, column in places.items()}
    return rows.having(**blanked, **{_OFF: off.astype(np.float64)})


def _known_to_sumo(rows: Rows, tally: Tally) -> Rows:
    """Return the rows with optional values that were SUMO's sentinel blank, counted as repaired."""
    for name, word in (*OPTIONAL.items(), ("altitude_m", "altitude")):
        unknown = np.isneginf(rows.columns.get(name, np.zeros(0)))
        if unknown.any():
            tally.repair(f"{word} not known (SUMO's -1073741824)", int(unknown.sum()))
            rows = rows.having(**{name: with_missing(rows.columns[name], unknown)})
    return rows


def _in_si(found: ColumnMap, rows: Rows) -> Rows:
    """Return the rows in SI units but for the time, optional values that are SUMO's sentinel as -inf."""
    columns = dict(rows.columns)
    for fills, (_, factor) in found.numbers.items():
        if fills == "t_s":
            continue
        column = columns[fills] * factor if factor != 1.0 else columns[fills]
        unknown = are_unknown_to_sumo(columns[fills])
        columns[fills] = np.where(unknown, -np.inf, column) if unknown.any() else column
    return Rows(rows.line, columns)


def _wrapped(heading_rad: FloatArray) -> FloatArray:
    """Return headings in [-pi, pi), those already there to the bit."""
    inside = (heading_rad >= -np.pi) & (heading_rad < np.pi)
    return np.where(inside, heading_rad, wrap_angle_rad(heading_rad))


def _groups(path: str, rows: Rows, labels: pl.Series | None) -> Iterator[tuple[str, np.ndarray]]:
    """Yield every label with the indices of its rows, in order of first appearance."""
    if labels is None:
        yield "vehicle", np.arange(len(rows))
        return
    if labels.null_count():
        at = int(labels.is_null().arg_true()[0])
        raise DataFormatError(
            path, f"the vehicle ({labels.name}) is blank", row=int(rows.line[at]), remedy="Name it."
        )
    frame = pl.DataFrame({"label": labels}).with_row_index("row")
    for label, rows_of in frame.group_by("label", maintain_order=True).agg("row").iter_rows():
        yield str(label), np.asarray(rows_of, dtype=np.int64)


def _check_range(path: str, rows: Rows) -> None:
    for name, bound in (("latitude_deg", 90.0), ("longitude_deg", 360.0)):
        column = rows.columns.get(name, np.zeros(0))
        bad = np.abs(column) > bound
        if bad.any():
            at = int(np.argmax(bad))
            raise DataFormatError(
                path,
                f"{name} is {column[at]}, beyond {bound:.0f}",
                row=int(rows.line[at]),
                remedy="Correct the value or the column map.",
            )


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
