"""Compiled sensing: measurements as they come into the windows that sub-models are fitted to, causally."""

from math import cos, hypot, isnan, sin, sqrt
from typing import NamedTuple

from modelcast.core.geodesy_kernels import stated
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, FloatMatrix, FloatVector, IntVector
from modelcast.messages.codes_kernels import instant_of, state_instant
from modelcast.models.point_kernels import (
    ACCELERATION,
    EAST,
    NORTH,
    POSITION_NOISE,
    REPORTS,
    REPORTS_ACCELERATION,
    REPORTS_HEADING,
    REPORTS_SPEED,
    REPORTS_YAW_RATE,
    SPEED,
    VELOCITY_EAST,
    VELOCITY_NORTH,
    YAW_RATE,
)
from modelcast.station.arrays import MEASURED, Fits, Sensed
from modelcast.station.sensing import motion_filter_kernels as motion
from modelcast.station.sensing.noise_kernels import difference_variance, settled
from modelcast.station.sensing.velocity_kernels import end_slope

__all__ = ["NoiseNumbers", "SensingNumbers", "forget_each", "sense"]

_SPEED, _HEADING, _ALONG, _TURN = range(2, MEASURED)
_NO_SPEED_MPS = 1e-9


class NoiseNumbers(NamedTuple):
    """What `noise_kernels.settled` needs, the order of the differences, and the mean at the start."""

    averaged: float
    clip: float
    share: float
    prior_count: float
    free: float
    order: int
    first_mean: float


class SensingNumbers(NamedTuple):
    """How a vehicle's measurements are read.

    ``velocity_window`` past positions whose polynomial of ``velocity_degree`` gives the velocity, 0 for the
    reported speed and heading; ``direction_only`` takes the reported speed along it. ``rates_window``
    velocities and ``rates_degree`` give acceleration and yaw rate where they are not reported
    (``has_acceleration``, ``has_yaw_rate``); both are zero below ``standing_mps``. A step longer than
    ``gap_s`` begins a new part. ``filter`` (8,) are the constants of the motion filter, empty for none; it
    holds the heading below ``hold_mps``. ``frame`` is that of the plane (`geodesy_kernels`), by which
    a message states the position; empty where receivers hold it as it was measured. At ``minute_s`` a minute
    of UTC begins.
    """

    velocity_window: int
    velocity_degree: int
    direction_only: bool
    rates_window: int
    rates_degree: int
    has_acceleration: bool
    has_yaw_rate: bool
    standing_mps: float
    gap_s: float
    hold_mps: float
    frame: FloatVector
    minute_s: float
    filter: FloatVector
    noise: NoiseNumbers


@kernel(inlined=True)
def _begins(s: Sensed, v: int, t_s: float, c: SensingNumbers) -> bool:
    """Whether a measurement is a vehicle's first, or the first after a gap."""
    return s.taken[v] == 0 or t_s - s.t_s[v, (s.taken[v] - 1) % s.stated_m.shape[1]] > c.gap_s


@kernel(inlined=True)
def _velocity(s: Sensed, v: int, at: int, history: int, c: SensingNumbers) -> tuple[float, float]:
    """Velocity east and north of the newest sample."""
    speed = s.shown[v, _SPEED]
    if c.velocity_window == 0:
        return speed * sin(s.shown[v, _HEADING]), speed * cos(s.shown[v, _HEADING])
    first = at - min(history, c.velocity_window) + 1
    east, north = end_slope(s.t_s[v], s.samples[v], first, at, EAST, c.velocity_degree)
    if c.direction_only:
        ratio = speed / max(hypot(east, north), _NO_SPEED_MPS)
        return ratio * east, ratio * north
    return east, north


@kernel(inlined=True)
def _rates(s: Sensed, v: int, at: int, history: int, c: SensingNumbers) -> tuple[float, float]:
    """Acceleration along the course and yaw rate of the newest sample, whose velocity stands already."""
    east, north = s.samples[v, at, VELOCITY_EAST], s.samples[v, at, VELOCITY_NORTH]
    speed = hypot(east, north)
    if speed < c.standing_mps:
        return 0.0, 0.0
    along, turn = s.shown[v, _ALONG], s.shown[v, _TURN]
    if not (c.has_acceleration and c.has_yaw_rate):
        # The first velocity of a part is left out: from positions it is zero for want of a second one.
        first = at - min(history - 1, c.rates_window) + 1
        change_east, change_north = end_slope(
            s.t_s[v], s.samples[v], first, at, VELOCITY_EAST, c.rates_degree
        )
        if not c.has_acceleration:
            along = (change_east * east + change_north * north) / speed
        if not c.has_yaw_rate:
            turn = (change_east * north - change_north * east) / (speed * speed)
    return along, turn


@kernel(inlined=True)
def _take(s: Sensed, v: int, t_s: float, fresh: bool, c: SensingNumbers) -> None:
    """Take what a vehicle shows into its window; ``fresh`` begins a new part."""
    ring = s.stated_m.shape[1]
    number = s.taken[v]
    place = number % ring
    at = place + ring
    history = 1 if fresh else s.history[v, (number - 1) % ring] + 1
    if number == 0:
        s.noise[v, 0], s.noise[v, 1] = c.noise.first_mean, 0.0
    s.t_s[v, place] = s.t_s[v, at] = t_s
    s.history[v, place] = history
    s.samples[v, at, EAST], s.samples[v, at, NORTH] = s.shown[v, 0], s.shown[v, 1]
    s.samples[v, at, VELOCITY_EAST], s.samples[v, at, VELOCITY_NORTH] = _velocity(s, v, at, history, c)
    s.samples[v, at, ACCELERATION], s.samples[v, at, YAW_RATE] = _rates(s, v, at, history, c)
    n = c.noise
    if history > n.order:
        square = difference_variance(s.t_s[v], s.samples[v], at, n.order)
        s.noise[v, 0], s.noise[v, 1] = settled(
            square, s.noise[v, 0], s.noise[v, 1], n.averaged, n.clip, n.share, n.prior_count, n.free
        )
    s.samples[v, at, POSITION_NOISE] = sqrt(s.noise[v, 0] / n.share)
    speed = s.shown[v, _SPEED]
    reports = REPORTS_HEADING if c.velocity_window == 0 else 0.0
    if isnan(speed):
        speed = hypot(s.samples[v, at, VELOCITY_EAST], s.samples[v, at, VELOCITY_NORTH])
    else:
        reports += REPORTS_SPEED
    if c.has_acceleration:
        reports += REPORTS_ACCELERATION
    if c.has_yaw_rate:
        reports += REPORTS_YAW_RATE
    s.samples[v, at, SPEED], s.samples[v, at, REPORTS] = speed, reports
    for column in range(s.samples.shape[2]):
        s.samples[v, place, column] = s.samples[v, at, column]
    east, north, instant_s = s.samples[v, at, EAST], s.samples[v, at, NORTH], t_s
    if c.frame.size > 0:
        east, north = stated(c.frame, east, north)
        instant_s = instant_of(state_instant(t_s, c.minute_s), t_s, c.minute_s)
    s.stated_s[v, place] = instant_s
    s.stated_m[v, place, 0], s.stated_m[v, place, 1] = east, north
    s.taken[v] = number + 1


@kernel
def sense(
    s: Sensed, vehicle: IntVector, t_s: FloatVector, seen: FloatMatrix, begins: BoolVector, c: SensingNumbers
) -> None:
    """Take in K measurements in turn: whose (K,), when (K,), ``seen`` (K, 6), whether a part begins (K,)."""
    for k in range(vehicle.size):
        v = vehicle[k]
        fresh = begins[k] or _begins(s, v, t_s[k], c)
        if c.filter.size == 0:
            for column in range(seen.shape[1]):
                s.shown[v, column] = seen[k, column]
        else:
            elapsed_s = t_s[k] - s.t_s[v, (s.taken[v] - 1) % s.stated_m.shape[1]]
            motion.follow(
                elapsed_s, seen[k], fresh, c.hold_mps, c.filter, s.states[v], s.spreads[v], s.shown[v]
            )
        _take(s, v, t_s[k], fresh, c)


@kernel
def forget_each(s: Sensed, fits: Fits, whose: BoolVector) -> None:
    """Let some vehicles hold nothing, (V,): others have taken their places."""
    for v in range(whose.size):
        if whose[v]:
            s.taken[v] = 0
            for place in range(fits.number.shape[1]):
                for m in range(fits.number.shape[2]):
                    fits.number[v, place, m] = -1
