"""Compiled parts that several applications share: a remote in the host's path, and how sure a margin is."""

from math import atan2, copysign, cos, erfc, hypot, sin, sqrt

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector

__all__ = [
    "ACCELERATION",
    "EAST",
    "HEADING",
    "LENGTH",
    "NORTH",
    "SPEED",
    "WIDTH",
    "YAW_RATE",
    "along_path",
    "chance_below_zero",
    "heading_apart",
]

EAST, NORTH, SPEED, HEADING, ACCELERATION, YAW_RATE, LENGTH, WIDTH = range(8)
"""Columns of a row of motion."""

_STRAIGHT_M = 5000.0
"""A wider turn is a straight line [m]."""

_SHARPEST_M = 8.0
"""No vehicle on a road turns within less [m]: below, a yaw rate is noise at a crawl."""


@kernel(inlined=True)
def heading_apart(first: float, second: float) -> float:
    """How far two courses are apart, 0 to pi [rad]."""
    return abs(atan2(sin(first - second), cos(first - second)))


@kernel(inlined=True)
def along_path(host: FloatVector, remote: FloatVector) -> tuple[float, float]:
    """How far a remote is along the host's path of constant curvature, and how far beside it [m].

    The first is negative behind the host, the second on its left.
    """
    east, north = remote[EAST] - host[EAST], remote[NORTH] - host[NORTH]
    course = host[HEADING]
    ahead = east * sin(course) + north * cos(course)
    right = east * cos(course) - north * sin(course)
    speed, turn = host[SPEED], host[YAW_RATE]
    if abs(turn) * _STRAIGHT_M <= speed or abs(turn) * _SHARPEST_M > speed:
        return ahead, right
    radius = speed / turn  # positive to the right
    across = radius - right
    beside = radius - copysign(hypot(ahead, across), radius)
    angle = atan2(ahead, copysign(1.0, radius) * across)
    return abs(radius) * angle, beside


@kernel(inlined=True)
def chance_below_zero(margin_m: float, variance_m2: float) -> float:
    """Chance that a normal variable of this mean and variance is not positive."""
    if variance_m2 <= 0.0:
        return 1.0 if margin_m <= 0.0 else 0.0
    return 0.5 * erfc(margin_m / sqrt(2.0 * variance_m2))
