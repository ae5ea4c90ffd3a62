"""How a vehicle moves as fixes alone show it: for a node without a bus, or one that has lost it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import Origin, geodetic_to_local
from modelcast.node.inputs.samples import PLAUSIBLE, GnssFix
from modelcast.station.sensing.rates import NO_RATES_BELOW_MPS, RATES_FROM_VELOCITY
from modelcast.station.sensing.velocity_kernels import end_slope

__all__ = ["Course", "OwnMotion", "course_of", "courses_of", "end_slope_of", "motion_of", "origin_of"]

_COURSE_M = 1.0
"""Places at least so far apart tell a course where fixes do not."""


@dataclass(frozen=True, slots=True)
class OwnMotion:
    """Motion as fixes alone show it.

    Parameters
    ----------
    speed_mps, acceleration_mps2, yaw_rate_radps
        At the last fix; the yaw rate clockwise.
    stated_mps
        The speed that fix states, NaN where it states none [m/s].
    """

    speed_mps: float
    acceleration_mps2: float
    yaw_rate_radps: float
    stated_mps: float


def motion_of(fixes: Sequence[GnssFix]) -> OwnMotion:
    """Speed, acceleration and yaw rate at the last of some fixes.

    Parameters
    ----------
    fixes
        In order of time, at least one.
    """
    recent = [fix for fix in fixes if fix.measured_s >= fixes[-1].measured_s - RATES_FROM_VELOCITY.span_s]
    spoken = [fix for fix in recent if math.isfinite(fix.speed_mps)]
    stated_mps = fixes[-1].speed_mps
    speed_mps = stated_mps if math.isfinite(stated_mps) else _speed_by_places(recent)
    acceleration_mps2 = end_slope_of([fix.measured_s for fix in spoken], [fix.speed_mps for fix in spoken])
    turning = [fix for fix in recent if math.isfinite(fix.heading_rad)]
    yaw_rate_radps = 0.0
    if speed_mps >= NO_RATES_BELOW_MPS and turning:
        courses = np.unwrap([fix.heading_rad for fix in turning]).tolist()
        yaw_rate_radps = end_slope_of([fix.measured_s for fix in turning], courses)
    low, high = PLAUSIBLE["yaw_rate_radps"]
    return OwnMotion(speed_mps, acceleration_mps2, min(max(yaw_rate_radps, low), high), stated_mps)


def _speed_by_places(fixes: Sequence[GnssFix]) -> float:
    """Speed between the two newest places, 0 of one [m/s]."""
    if len(fixes) < 2:
        return 0.0
    before, fix = fixes[-2:]
    return math.hypot(*_between_m(before, fix)) / (fix.measured_s - before.measured_s)


def end_slope_of(times_s: Sequence[float], values: Sequence[float]) -> float:
    """Slope at the newest value of the quadratic that the station's own rates use; 0 of fewer than four.

    Parameters
    ----------
    times_s, values
        In order of time, (N,) [s] and (N,); the slope is kept within what is plausible of an acceleration.
    """
    if len(times_s) < RATES_FROM_VELOCITY.degree + 2:
        return 0.0
    rows: FloatArray = np.zeros((len(values), 2))
    rows[:, 0] = values
    slope, _ = end_slope(
        np.array(times_s, dtype=np.float64), rows, 0, len(values) - 1, 0, RATES_FROM_VELOCITY.degree
    )
    low, high = PLAUSIBLE["acceleration_mps2"]
    return min(max(slope, low), high) if math.isfinite(slope) else 0.0


def course_of(fixes: Sequence[GnssFix], *, within_s: float, otherwise_rad: float) -> float:
    """Heading at the last of some fixes: what it states, else from its place and an earlier one [rad].

    Parameters
    ----------
    fixes
        In order of time.
    within_s
        How much earlier the other one may be [s].
    otherwise_rad
        What holds where neither tells [rad].
    """
    fix = fixes[-1]
    if math.isfinite(fix.heading_rad):
        return fix.heading_rad
    for earlier in reversed(fixes[:-1]):
        if fix.measured_s - earlier.measured_s > within_s:
            break
        east_m, north_m = _between_m(earlier, fix)
        if math.hypot(east_m, north_m) >= _COURSE_M:
            return math.atan2(east_m, north_m) % math.tau
    return otherwise_rad


@dataclass(frozen=True, slots=True)
class Course:
    """Which way, and how fast, at an instant [s], [rad], [m/s]."""

    t_s: float
    heading_rad: float
    speed_mps: float


def courses_of(fixes: Sequence[GnssFix]) -> list[Course]:
    """Courses that fixes state, and those between two places where neither states one.

    Parameters
    ----------
    fixes
        In order of time.
    """
    found: list[Course] = []
    before: GnssFix | None = None
    for fix in fixes:
        if math.isfinite(fix.heading_rad + fix.speed_mps):
            found.append(Course(fix.measured_s, fix.heading_rad, fix.speed_mps))
        elif before is not None and not math.isfinite(before.heading_rad):
            east_m, north_m = _between_m(before, fix)
            step_s = fix.measured_s - before.measured_s
            middle_s = (fix.measured_s + before.measured_s) / 2.0
            found.append(Course(middle_s, math.atan2(east_m, north_m), math.hypot(east_m, north_m) / step_s))
        before = fix
    return found


def origin_of(fix: GnssFix) -> Origin:
    """A plane that touches the ellipsoid under a fix.

    Parameters
    ----------
    fix
        Any.
    """
    return Origin(fix.latitude_deg, fix.longitude_deg)


def _between_m(before: GnssFix, fix: GnssFix) -> tuple[float, float]:
    """East and north from one fix to another [m]."""
    place_deg = np.array([[fix.latitude_deg, fix.longitude_deg]])
    east_m, north_m = geodetic_to_local(place_deg, origin_of(before))[0].tolist()
    return east_m, north_m
