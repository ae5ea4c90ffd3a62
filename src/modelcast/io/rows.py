"""One vehicle's rows on their way to a trip: put in order, completed, placed on the local plane.

Readers fill `Rows` with plain numbers, NaN where a value is missing, and take out what their format calls
unusable. The rules that all formats share are here, each of them counted.

Missing optional values (speed, heading, ...)
    A column missing in more than `MOSTLY_THERE` of the rows is left out, and counted. Otherwise the last
    value is held, as a live sender would have to, and counted; rows before the first value are skipped.

Values that no vehicle has (`LARGEST_MOTION`) are missing too, and counted.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin, geodetic_to_enu
from modelcast.io.base import Tally
from modelcast.trips.judgement import IMPLAUSIBLE
from modelcast.trips.jumps import MAX_SPEED_MPS
from modelcast.trips.trajectory import Trajectory, build_trajectory

__all__ = [
    "LARGEST",
    "MOSTLY_THERE",
    "NOT_KNOWN_TO_SUMO",
    "OPTIONAL",
    "Rows",
    "are_numbers",
    "are_unknown_to_sumo",
    "joined",
    "located",
    "make_trip",
    "ordered",
    "with_missing",
]

MOSTLY_THERE = 0.1
"""A column missing in more than this share of the rows is left out instead of being held."""

OPTIONAL = {
    "speed_mps": "speed",
    "heading_rad": "heading",
    "acceleration_mps2": "acceleration",
    "yaw_rate_radps": "yaw rate",
    "up_m": "height",
}
"""Optional columns of a trip, with their names in counts."""

LARGEST_MOTION = {
    "speed_mps": MAX_SPEED_MPS,
    "acceleration_mps2": 200.0,
    "yaw_rate_radps": float(np.radians(327.67)),
}
"""Larger sizes no vehicle has. Yaw rate: the range of SAE J2735. Acceleration: ours, 20 g, as in a crash."""

NOT_KNOWN_TO_SUMO = -(2.0**30)
"""What SUMO and its TraCI say for a position, speed or angle that there is none of: -1073741824."""

_ROUNDED = 5000.0
"""How far a sentinel may have been rounded: six digits, as many programs print, leave 1,824."""

LARGEST = 1e18
"""No quantity of any format is larger; what is, is damage, and could overflow later."""


@dataclass(frozen=True, slots=True)
class Rows:
    """Rows of one vehicle.

    Parameters
    ----------
    line
        One-based line or record numbers, (R,).
    columns
        Numbers by name, (R,) each, NaN where missing: ``t_s``, then ``east_m`` and ``north_m`` or
        ``latitude_deg`` and ``longitude_deg``, any of `OPTIONAL`, and ``piece`` where the log parts a trip.
    """

    line: IntArray
    columns: Mapping[str, FloatArray]

    def __len__(self) -> int:
        return int(self.line.size)

    def taken(self, which: BoolArray | IntArray) -> "Rows":
        """Return the rows that a mask or an index picks."""
        return Rows(self.line[which], {name: column[which] for name, column in self.columns.items()})

    def without(self, bad: BoolArray, reason: str, tally: Tally) -> "Rows":
        """Return the rows that are not bad, the bad ones counted as skipped."""
        tally.skip(reason, int(bad.sum()))
        return self.taken(~bad) if bad.any() else self

    def having(self, **columns: FloatArray) -> "Rows":
        """Return the rows with columns added or replaced."""
        return replace(self, columns={**self.columns, **columns})


def are_numbers(values: FloatArray, largest: float = LARGEST) -> BoolArray:
    """Return which values are finite and of a size that quantities have.

    Examples
    --------
    >>> import numpy as np
    >>> are_numbers(np.array([1.0, np.nan, -np.inf, 1e300]))
    array([ True, False, False, False])
    """
    return np.abs(values) <= largest


def are_unknown_to_sumo(values: FloatArray) -> BoolArray:
    """Return which values are `NOT_KNOWN_TO_SUMO`, rounded to six digits or better.

    Examples
    --------
    >>> import numpy as np
    >>> are_unknown_to_sumo(np.array([-1073741824.0, -1.07374e9, -1e9, np.nan]))
    array([ True,  True, False, False])
    """
    return np.abs(values - NOT_KNOWN_TO_SUMO) <= _ROUNDED


def joined(parts: list[Rows]) -> Rows:
    """Return rows gathered in several parts as one."""
    if len(parts) == 1:
        return parts[0]
    names = parts[0].columns
    return Rows(
        np.concatenate([part.line for part in parts]),
        {name: np.concatenate([part.columns[name] for part in parts]) for name in names},
    )


def with_missing(column: FloatArray, unavailable: BoolArray) -> FloatArray:
    """Return a column with NaN where the format says that the value is unavailable."""
    return np.where(unavailable, np.nan, column)


def ordered(rows: Rows, tally: Tally, *, duplicate: str = "duplicate time") -> Rows:
    """Return the rows by increasing time, the first of each time; late ones counted as repaired."""
    t_s = rows.columns["t_s"]
    if (np.diff(t_s) > 0).all():
        return rows
    late = t_s < np.maximum.accumulate(t_s)
    tally.repair("out of time order", int(late.sum()))
    rows = rows.taken(np.argsort(t_s, kind="stable"))
    again = np.concatenate([[False], np.diff(rows.columns["t_s"]) <= 0])
    return rows.without(again, duplicate, tally)


def located(rows: Rows, origin: Origin) -> Rows:
    """Return geodetic rows with ``east_m``, ``north_m``, and ``up_m`` where there is an altitude."""
    columns = rows.columns
    altitude = columns.get("altitude_m", np.zeros(len(rows)))
    unknown = ~np.isfinite(altitude)
    enu = geodetic_to_enu(
        columns["latitude_deg"],
        columns["longitude_deg"],
        np.where(unknown, origin.altitude_m, altitude),
        origin,
    )
    rows = rows.having(east_m=enu[:, 0], north_m=enu[:, 1])
    return rows.having(up_m=with_missing(enu[:, 2], unknown)) if "altitude_m" in columns else rows


def make_trip(
    path: str,
    trip_id: str,
    rows: Rows,
    tally: Tally,
    *,
    count: int,
    source: str,
    origin: Origin | None = None,
    unix_offset_s: float | None = None,
    clock_offset_s: float | None = None,
    vehicle: str = "",
    unsorted: str = "Sort the file by vehicle and time and leave one row per time.",
) -> Trajectory | None:
    """Return the trip of rows in time order, or None where no row is left.

    Parameters
    ----------
    path, trip_id, source, origin, vehicle
        Where the rows come from, and as in `Trajectory`.
    rows
        With ``t_s``, ``east_m``, ``north_m`` complete, and optional columns.
    tally
        Counts so far; completed here.
    count
        Rows the file held for this vehicle.
    unix_offset_s
        What turns ``t_s`` into Unix time, where that is known [s].
    clock_offset_s
        What turns it into the time of the clock that the file's trips share, where they share one [s].
    unsorted
        What to do where time does not increase.

    Raises
    ------
    DataFormatError
        Where time does not increase or a value is not finite.
    """
    rows = _completed(rows, tally)
    if not len(rows):
        return None
    reading = tally.reading(count, samples=len(rows))
    columns = rows.columns
    t_s = columns["t_s"]
    steps = np.diff(t_s)
    if (steps <= 0).any():
        at = int(np.argmax(steps <= 0)) + 1
        raise DataFormatError(
            path,
            f"time of {trip_id} does not increase: {t_s[at]} after {t_s[at - 1]}",
            row=int(rows.line[at]),
            remedy=unsorted,
        )
    try:
        return build_trajectory(
            trip_id,
            t_s,
            np.stack([columns["east_m"], columns["north_m"]], axis=1),
            **{name: columns[name] for name in OPTIONAL if name in columns},
            origin=origin,
            start_unix_s=None if unix_offset_s is None else float(t_s[0]) + unix_offset_s,
            clock_s=None if clock_offset_s is None else float(t_s[0]) + clock_offset_s,
            source=source,
            vehicle=vehicle,
            reading=reading,
            piece=columns.get("piece"),
        )
    except (ValueError, FloatingPointError) as error:
        raise DataFormatError(path, str(error), row=int(rows.line[0])) from error


def _possible(columns: Mapping[str, FloatArray], tally: Tally) -> dict[str, FloatArray]:
    """Return the columns with values that no vehicle has as missing, each counted."""
    found = dict(columns)
    for name, largest in LARGEST_MOTION.items():
        if name in found:
            impossible = np.abs(found[name]) > largest
            tally.repair(OPTIONAL[name] + IMPLAUSIBLE, int(impossible.sum()))
            found[name] = with_missing(found[name], impossible)
    return found


def _completed(rows: Rows, tally: Tally) -> Rows:
    """Return the rows with every optional column either complete or left out."""
    if not len(rows):
        return rows
    columns = _possible(rows.columns, tally)
    first = 0
    for name, word in OPTIONAL.items():
        missing = np.isnan(columns[name]) if name in columns else np.zeros(len(rows), np.bool_)
        if missing.mean() > MOSTLY_THERE:
            tally.repair(f"{word} left out, too often missing", int(missing.sum()))
            del columns[name]
        if name not in columns or not missing.any():
            continue
        given = np.where(missing, 0, np.arange(len(rows)))
        first = max(first, int(np.argmin(missing)))
        columns[name] = columns[name][np.maximum.accumulate(given)]
        tally.repair(f"{word} missing, last value held", int(missing[int(np.argmin(missing)) :].sum()))
    early = np.arange(len(rows)) < first
    return Rows(rows.line, columns).without(early, "no first value yet", tally)
