"""The catalogue of a corpus: a row a trip, with all of a `Trajectory` that is not a column of samples.

=============================================  =========================================================
Column                                         Meaning
=============================================  =========================================================
trip, vehicle                                  names; the vehicle is null where the source names none
source, format                                 file it was read from, from what the user named on; its format
partition                                      where its samples are
samples, rows                                  samples stored; rows that the source held for it
dt_s, duration_s, length_m                     median step, time observed [s], distance between samples [m]
start_unix_s, clock_s                          as in `Trajectory` [s]; null where not known
resampled                                      whether uneven steps were interpolated
gaps, longest_gap_s, jumps                     places where it was split: a gap, or a jump no vehicle makes
east_min_m, east_max_m, north_min_m, ...       bounds on the local plane [m]
origin_latitude_deg, ...                       the point the local plane touches; null where there is none
segments                                       bounds of the gapless parts, from 0 to ``samples``
skipped, repaired                              rows left out and put right, by reason
=============================================  =========================================================
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

from collections.abc import Mapping
from typing import Any

import numpy as np
import pyarrow as pa

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import Origin
from modelcast.trips.trajectory import Reading, Trajectory

__all__ = ["CATALOGUE", "SAMPLED", "catalogue_row", "trip_from"]

SAMPLED = (
    "t_s",
    "east_m",
    "north_m",
    "up_m",
    "speed_mps",
    "heading_rad",
    "acceleration_mps2",
    "yaw_rate_radps",
)
"""Columns that differ from sample to sample, as `modelcast.io.write_trips` names them."""

_COUNTS: Any = pa.list_(pa.struct([("reason", pa.string()), ("rows", pa.int64())]))

_NUMBERS = (
    "dt_s", "duration_s", "length_m", "start_unix_s", "clock_s", "longest_gap_s",
    "east_min_m", "east_max_m", "north_min_m", "north_max_m",
    "origin_latitude_deg", "origin_longitude_deg", "origin_altitude_m",
)  # fmt: skip

CATALOGUE: Any = pa.schema(
    [
        *((name, pa.string()) for name in ("trip", "vehicle", "source", "format", "partition")),
        *((name, pa.int64()) for name in ("samples", "rows", "gaps", "jumps")),
        *((name, pa.float64()) for name in _NUMBERS),
        ("resampled", pa.bool_()),
        ("segments", pa.list_(pa.int64())),
        ("skipped", _COUNTS),
        ("repaired", _COUNTS),
    ]
)
"""The catalogue's columns."""


def catalogue_row(trip: Trajectory, *, source: str) -> dict[str, Any]:
    """Return a trip's row of the catalogue; the partition is still empty.

    Parameters
    ----------
    trip
        As its reader gave it.
    source
        The file it was read from.
    """
    east_m, north_m = trip.position_m[:, 0], trip.position_m[:, 1]
    gaps_s = trip.gaps_s
    origin = trip.origin
    return {
        "trip": trip.trip_id,
        "vehicle": trip.vehicle or None,
        "source": source,
        "format": trip.source,
        "partition": "",
        "samples": len(trip),
        "rows": trip.reading.rows,
        "gaps": int(gaps_s.size),
        "jumps": int(trip.segments.size - 2 - gaps_s.size),
        "dt_s": trip.dt_s,
        "duration_s": trip.duration_s,
        "length_m": _length_m(trip),
        "start_unix_s": trip.start_unix_s,
        "clock_s": trip.clock_s,
        "longest_gap_s": float(gaps_s.max(initial=0.0)),
        "east_min_m": float(east_m.min()),
        "east_max_m": float(east_m.max()),
        "north_min_m": float(north_m.min()),
        "north_max_m": float(north_m.max()),
        "origin_latitude_deg": None if origin is None else origin.latitude_deg,
        "origin_longitude_deg": None if origin is None else origin.longitude_deg,
        "origin_altitude_m": None if origin is None else origin.altitude_m,
        "resampled": trip.resampled,
        "segments": trip.segments.tolist(),
        "skipped": _counts(trip.reading.skipped),
        "repaired": _counts(trip.reading.repaired),
    }


def trip_from(row: Mapping[str, Any], samples: Mapping[str, FloatArray]) -> Trajectory:
    """Return the trip of a row of the catalogue and its samples, as its reader gave it.

    Parameters
    ----------
    row
        As `catalogue_row` made it.
    samples
        The columns `SAMPLED`, (T,) each; one that the trip does not have is NaN throughout.

    Raises
    ------
    ValueError
        Where they are no trip.
    """
    known = {name: column for name, column in samples.items() if not np.isnan(column[:1]).all()}
    return Trajectory(
        row["trip"],
        samples["t_s"],
        np.stack([samples["east_m"], samples["north_m"]], axis=1),
        segments=np.array(row["segments"], dtype=np.int64),
        dt_s=row["dt_s"],
        speed_mps=known.get("speed_mps"),
        heading_rad=known.get("heading_rad"),
        acceleration_mps2=known.get("acceleration_mps2"),
        yaw_rate_radps=known.get("yaw_rate_radps"),
        up_m=known.get("up_m"),
        origin=_origin(row),
        start_unix_s=row["start_unix_s"],
        clock_s=row["clock_s"],
        source=row["format"],
        vehicle=row["vehicle"] or "",
        resampled=row["resampled"],
        reading=Reading(row["rows"], _by_reason(row["skipped"]), _by_reason(row["repaired"])),
    )


def _length_m(trip: Trajectory) -> float:
    """Distance between samples of the same part, added up [m]."""
    moved_m = np.hypot(*np.diff(trip.position_m, axis=0).T)
    moved_m[trip.segments[1:-1] - 1] = 0.0
    return float(moved_m.sum())


def _origin(row: Mapping[str, Any]) -> Origin | None:
    if row["origin_latitude_deg"] is None:
        return None
    return Origin(row["origin_latitude_deg"], row["origin_longitude_deg"], row["origin_altitude_m"])


def _counts(counts: Mapping[str, int]) -> list[dict[str, Any]]:
    return [{"reason": reason, "rows": rows} for reason, rows in counts.items()]


def _by_reason(counts: list[dict[str, Any]]) -> dict[str, int]:
    return {one["reason"]: one["rows"] for one in counts}
