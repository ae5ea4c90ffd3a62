"""Trips out of one table with named columns: what the csv and parquet readers share.

Rows are grouped by vehicle, in order of first appearance; within a vehicle time must increase. All mapped
columns are held in memory, 8 bytes a value.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import polars as pl

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin, wrap_angle_rad
from modelcast.core.trajectory import Trajectory
from modelcast.io.base import OnSkipped, Tally
from modelcast.io.column_map import ColumnMap
from modelcast.io.rows import Rows, located, make_trip

__all__ = ["table_trips"]

_CONSTANTS = ("origin_latitude_deg", "origin_longitude_deg", "origin_altitude_m", "start_unix_s")


def table_trips(
    path: str, source: str, found: ColumnMap, rows: Rows, labels: pl.Series | None, *, partial: bool,
    on_skipped: OnSkipped,
) -> Iterator[Trajectory]:  # fmt: skip
    """Yield a table's trips.

    Parameters
    ----------
    path, source, on_skipped
        As for readers.
    found
        The table's columns.
    rows
        All rows, in SI units except for the time, NaN where blank.
    labels
        The vehicle (or trip) of each row as text, where the table names it.
    partial
        Whether a cut last line was passed over; it is counted with the last row's vehicle.
    """
    _check_range(path, rows)
    stem = Path(path).stem
    origin = _first_origin(rows) if found.geodetic else None
    for label, which in _groups(path, rows, labels):
        trip_id = label if found.whole_id and labels is not None else f"{stem}/{label}"
        tally = Tally()
        own = rows.taken(which) if labels is not None else rows
        cut = partial and len(rows) - 1 in which[-1:]
        tally.skip("partial last line", int(cut))
        count = len(own) + int(cut)
        unit_s = found.numbers["t_s"][1]
        trip = _trip(
            path, source, trip_id, own, tally, count=count, unit_s=unit_s, shared_origin=origin
        )  # fmt: skip
        if trip is None:
            on_skipped(trip_id, tally.why_empty())
        else:
            yield trip


def _trip(
    path: str, source: str, trip_id: str, rows: Rows, tally: Tally, *, count: int, unit_s: float,
    shared_origin: Origin | None,
) -> Trajectory | None:  # fmt: skip
    """Return one vehicle's trip, or None where no row is usable."""
    columns = rows.columns
    geodetic = "latitude_deg" in columns
    rows = rows.without(np.isnan(columns["t_s"]), "time blank", tally)
    x, y = ("latitude_deg", "longitude_deg") if geodetic else ("east_m", "north_m")
    rows = rows.without(np.isnan(rows.columns[x] + rows.columns[y]), "position blank", tally)
    if not len(rows):
        return None
    constant = {name: float(columns[name][0]) for name in _CONSTANTS if name in columns}
    if "heading_rad" in columns:
        rows = rows.having(heading_rad=_wrapped(rows.columns["heading_rad"]))
    if geodetic and shared_origin is not None:
        origin: Origin | None = shared_origin
        rows = located(rows, shared_origin)
    else:
        origin = _own_origin(constant)
    unix = constant.get("start_unix_s", np.nan)
    raw_t = rows.columns["t_s"]
    # Milli- and microseconds are often Unix times, which as seconds in float64 lose their last digits.
    start = float(raw_t[0]) if unit_s != 1.0 else 0.0
    rows = rows.having(t_s=(raw_t - start) * unit_s)
    return make_trip(
        path,
        trip_id,
        rows,
        tally,
        count=count,
        source=source,
        origin=origin,
        unix_offset_s=unix + start * unit_s if np.isfinite(unix) else None,
    )


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
