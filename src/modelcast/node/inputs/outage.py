"""What a vehicle learns of its own bus while it has fixes, for the time when it has none.

Over the last 10 s of driving before a fix, courses of fixes less the turn by the bus's yaw rate are a
line in time: its end is the course, free of a single fix's noise, its slope the bias of the yaw rate.
Speeds of fixes over those of the bus give the scale of the latter.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from modelcast.node.inputs.fix_motion import Course, courses_of
from modelcast.node.inputs.reckoning import Growth, way
from modelcast.node.inputs.samples import GnssFix
from modelcast.node.inputs.series import Series
from modelcast.station.sensing.motion_filter import HEADING_HOLD_MPS

__all__ = ["LEARNT_S", "BusErrors", "bus_errors"]

LEARNT_S = 10.0
_LEAST_FIXES = 5
_LEAST_LINE_S = 3.0
_ABOVE_MPS = 3.0
_MOST_BIAS_RADPS = math.radians(1.5)
_MOST_SCALE = 0.1
_NO_COURSE_RAD = math.pi / 2.0
"""Of the course of a car that has stood for as long as is remembered: none."""
_TURN_S = 2.5
"""In such a time a course goes as far off its line as it is spread about it: a quarter of the window."""


@dataclass(frozen=True, slots=True)
class BusErrors:
    """What a bus is off by.

    Parameters
    ----------
    heading_rad
        The course at the fix, NaN where nothing was learnt [rad].
    yaw_rate_radps
        What its yaw rate is too large by [rad/s].
    speed_scale
        What its speed must be multiplied by.
    course_rad
        Standard deviation of courses about that line: what the yaw rate does not show [rad].
    turn_radps
        Of the turn that it does not show [rad/s].
    """

    heading_rad: float = math.nan
    yaw_rate_radps: float = 0.0
    speed_scale: float = 1.0
    course_rad: float = 0.0
    turn_radps: float = 0.0

    def widened(self, growth: Growth) -> Growth:
        """How the error grows by a bus that was off so.

        Parameters
        ----------
        growth
            How it grows by a good one, which is the least.
        """
        return replace(
            growth,
            course_rad=max(growth.course_rad, self.course_rad),
            yaw_rate_radps=max(growth.yaw_rate_radps, self.turn_radps),
        )


def bus_errors(fixes: Sequence[GnssFix], speed: Series, yaw_rate: Series) -> BusErrors:
    """What the bus is off by, seen from the last of some fixes.

    Parameters
    ----------
    fixes
        In order of time.
    speed, yaw_rate
        Of the bus.
    """
    last_s = fixes[-1].measured_s
    used = [course for course in courses_of(fixes) if course.speed_mps > _ABOVE_MPS]
    used = [course for course in used if course.t_s >= used[-1].t_s - LEARNT_S]
    if len(used) < _LEAST_FIXES:
        return BusErrors(course_rad=0.0 if fixes[-1].speed_mps > HEADING_HOLD_MPS else _NO_COURSE_RAD)
    by_fixes = sum(course.speed_mps * speed.at(course.t_s) for course in used)
    by_bus = sum(speed.at(course.t_s) ** 2 for course in used)
    scale = by_fixes / by_bus if by_bus > 0.0 else 1.0
    line = _course_line(used, last_s, yaw_rate)
    bias_radps = min(max(-line.slope_radps, -_MOST_BIAS_RADPS), _MOST_BIAS_RADPS)
    return BusErrors(
        line.end_rad,
        bias_radps,
        min(max(scale, 1.0 - _MOST_SCALE), 1.0 + _MOST_SCALE),
        line.spread_rad,
        max(abs(line.slope_radps + bias_radps), line.spread_rad / _TURN_S),
    )


@dataclass(frozen=True, slots=True)
class _Line:
    """Course at the end, slope, and standard deviation about it."""

    end_rad: float
    slope_radps: float
    spread_rad: float


def _course_line(courses: Sequence[Course], last_s: float, yaw_rate: Series) -> _Line:
    """The line through courses less the turn since the first, at a time."""
    turned_rad, at_s = 0.0, courses[0].t_s
    rows: list[tuple[float, float]] = []
    for course in courses:
        turned_rad += _turn_rad(yaw_rate, at_s, course.t_s)
        at_s = course.t_s
        off_rad = math.remainder(course.heading_rad - courses[0].heading_rad - turned_rad, math.tau)
        rows.append((at_s - last_s, off_rad))
    turned_rad += _turn_rad(yaw_rate, at_s, last_s)
    count = len(rows)
    mean_s, mean_rad = sum(row[0] for row in rows) / count, sum(row[1] for row in rows) / count
    slope_radps = 0.0
    if rows[-1][0] - rows[0][0] >= _LEAST_LINE_S:
        spread = sum((since_s - mean_s) ** 2 for since_s, _ in rows)
        slope_radps = sum((since_s - mean_s) * off_rad for since_s, off_rad in rows) / spread
    about = [off_rad - mean_rad - slope_radps * (since_s - mean_s) for since_s, off_rad in rows]
    spread_rad = math.sqrt(sum(one**2 for one in about) / count)
    end_rad = courses[0].heading_rad + turned_rad + mean_rad - slope_radps * mean_s
    return _Line(end_rad, slope_radps, spread_rad)


def _turn_rad(yaw_rate: Series, from_s: float, to_s: float) -> float:
    """Integral of a yaw rate between two times [rad]."""
    knots_s = yaw_rate.knots(from_s, to_s)
    return way(lambda _: 0.0, yaw_rate.at, knots_s, from_s=from_s, to_s=to_s, heading_rad=0.0).heading_rad
