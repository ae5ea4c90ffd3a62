"""What a trip is worth as ground truth, as columns of the catalogue: what ``modelcast trips`` tells of it."""

import math
from collections.abc import Sequence
from typing import Any

import pyarrow as pa

from modelcast.trips.inspection import inspect
from modelcast.trips.judgement import judge
from modelcast.trips.trajectory import Trajectory

__all__ = ["QUALITY", "quality_row"]

_NUMBERS = (
    "moving_s", "position_rate_hz", "grid_m", "held_s", "coasted_ratio", "fix_period_s", "noise_p50_m",
    "noise_p95_m", "speed_ratio",
)  # fmt: skip

QUALITY: list[Any] = [
    *((name, pa.float64()) for name in _NUMBERS),
    ("recommended_protocol", pa.string()),
    ("warnings", pa.list_(pa.string())),
]
"""The columns, null where a trip was not inspected, or a figure does not exist."""


def quality_row(trip: Trajectory, thresholds_m: Sequence[float]) -> dict[str, Any]:
    """Return a trip's quality, as `modelcast.trips.inspection.TripInspection` says; warnings by their kinds.

    Parameters
    ----------
    trip
        As its reader gave it.
    thresholds_m
        Tracking-error thresholds that noise is judged by [m].
    """
    found = inspect(trip)
    protocol = found.recommended_protocol
    numbers: dict[str, float] = {name: getattr(found, name) for name in _NUMBERS}
    warnings = judge(found, thresholds_m, smoothed=protocol == "sensor")
    return {
        **{name: value if math.isfinite(value) else None for name, value in numbers.items()},
        "recommended_protocol": protocol,
        "warnings": list(warnings),
    }
