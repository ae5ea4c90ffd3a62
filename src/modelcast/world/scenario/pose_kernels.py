"""Compiled geometry: from a vehicle's motion along a road to its motion on the plane.

A road is a reference line with tangent angle phi (anticlockwise from east) and curvature kappa. A vehicle
moves along it at v with acceleration a, and is n metres to the left of it. Its lateral motion runs on a clock
tau of its own, d tau = g dt with g = v / S and S = sqrt(v² + V_REF²): at speed this is time, and a standing
vehicle does not move sideways. So the slope dn/ds = (dn/dtau) / S stays finite down to standstill.
"""

from math import atan, cos, pi, sin, sqrt

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix

__all__ = ["ACCELERATION", "EAST", "HEADING", "NORTH", "SPEED", "YAW_RATE", "lateral_clock", "place"]

EAST, NORTH, SPEED, HEADING, ACCELERATION, YAW_RATE = range(6)
"""Rows of what `place` writes."""

V_REF_MPS = 8.0
"""Below this speed sideways motion slows down in step with the speed along."""


@kernel(inlined=True)
def lateral_clock(speed_mps: float) -> float:
    """Rate of the lateral clock, g."""
    return speed_mps / sqrt(speed_mps * speed_mps + V_REF_MPS * V_REF_MPS)


@kernel
def place(
    out: FloatMatrix,
    at: int,
    east_m: float,
    north_m: float,
    tangent_rad: float,
    curvature: float,
    curvature_slope: float,
    speed: float,
    acceleration: float,
    left_m: float,
    left_rate: float,
    left_rate2: float,
) -> None:
    """Write one vehicle's column of `out`, (6, V).

    Derivatives of n are by tau; `curvature_slope` is d kappa / ds. With f = 1 - kappa n:

        slope = (dn/ds) / f,  speed = v f sqrt(1 + slope²),  course = phi + atan(slope),

    and acceleration and yaw rate are the exact derivatives of speed and course.
    """
    s2 = speed * speed + V_REF_MPS * V_REF_MPS
    s = sqrt(s2)
    raw = left_rate / s
    raw_rate = left_rate2 * speed / s2 - raw * speed * acceleration / s2
    f = 1.0 - curvature * left_m
    f_rate = -speed * (curvature_slope * left_m + curvature * raw)
    slope = raw / f
    slope_rate = (raw_rate - slope * f_rate) / f
    root = sqrt(1.0 + slope * slope)
    course = tangent_rad + atan(slope)
    heading = 0.5 * pi - course
    out[EAST, at] = east_m - left_m * sin(tangent_rad)
    out[NORTH, at] = north_m + left_m * cos(tangent_rad)
    out[SPEED, at] = speed * f * root
    out[HEADING, at] = (heading + pi) % (2.0 * pi) - pi
    out[ACCELERATION, at] = (acceleration * f + speed * f_rate) * root + speed * f * slope * slope_rate / root
    out[YAW_RATE, at] = -(speed * curvature + slope_rate / (root * root))
