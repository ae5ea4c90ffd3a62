"""Compiled forward collision warning: brake-onset ranges of one family, and the rule for one pair."""

from math import inf, nan

import numpy as np

from modelcast.apps.conflict_kernels import (
    ACCELERATION,
    EAST,
    HEADING,
    LENGTH,
    NORTH,
    SPEED,
    along_path,
    chance_below_zero,
    heading_apart,
)
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntVector

__all__ = ["CAUTION_DELAY", "G_MPS2", "SETTINGS", "assess_each", "range_each", "warning_range"]

(
    DELAY,
    CONSTANT,
    BY_LEADER,
    BY_MOVING,
    BY_CLOSING,
    HALF_LANE,
    FARTHEST,
    WIDEST_TURN,
    CAUTION_DELAY,
) = range(9)
"""Settings: delay of driver and brakes [s]; of the deceleration that the driver is taken to choose, its
constant [m/s²], and what is added by leader's acceleration, where it moves, and by closing speed [1/s]; half
of a lane, longest range [m], largest difference of courses [rad]; how much earlier caution is given [s]."""

SETTINGS = 9
G_MPS2 = 9.80665

_LEAST_BRAKING_MPS2 = 0.1
"""A driver that is taken to brake less would never stop [m/s²]."""


@kernel
def warning_range(
    speed: float, acceleration: float, leader_speed: float, leader_acceleration: float, x: FloatVector,
    delay_s: float,
) -> float:  # fmt: skip
    """Range at which a driver must be warned to end behind the leader [m]."""
    own_then = max(speed + acceleration * delay_s, 0.0)
    leader_then = max(leader_speed + leader_acceleration * delay_s, 0.0)
    moving = 1.0 if leader_then > 0.0 else 0.0
    braking = (
        x[CONSTANT] + x[BY_LEADER] * leader_acceleration + x[BY_MOVING] * moving
        + x[BY_CLOSING] * (own_then - leader_then)
    )  # fmt: skip
    braking = min(braking, -_LEAST_BRAKING_MPS2)
    meanwhile = (speed - leader_speed) * delay_s
    meanwhile += 0.5 * (acceleration - leader_acceleration) * delay_s * delay_s
    own_way = own_then * own_then / (-2.0 * braking)
    if moving == 0.0:
        return max(own_way + meanwhile, 0.0)
    closing, relative = own_then - leader_then, leader_acceleration - braking
    stops_s = leader_then / -leader_acceleration if leader_acceleration < 0.0 else inf
    if relative > 0.0 and closing / relative <= stops_s:
        onset = closing * closing / (2.0 * relative) if closing > 0.0 else 0.0
    elif leader_acceleration < 0.0:
        onset = own_way - leader_then * leader_then / (-2.0 * leader_acceleration)
    else:
        onset = 0.0
    return max(max(onset, 0.0) + meanwhile, 0.0)


@kernel
def range_each(
    speed: FloatVector, acceleration: FloatVector, leader_speed: FloatVector,
    leader_acceleration: FloatVector, x: FloatVector, out: FloatVector,
) -> None:  # fmt: skip
    """Warning ranges of N pairs, into ``out`` (N,)."""
    for k in range(out.size):
        out[k] = warning_range(
            speed[k], acceleration[k], leader_speed[k], leader_acceleration[k], x, x[DELAY]
        )


@kernel
def assess_each(
    host: FloatMatrix, remote: FloatMatrix, spread: FloatMatrix, x: FloatVector, level: IntVector,
    out: FloatMatrix,
) -> None:  # fmt: skip
    """Assess N pairs, rows of motion (N, 8): levels (N,), and time, margin, certainty into ``out`` (N, 3).

    ``spread`` (N, 3) is the covariance of the remote's place.
    """
    for k in range(level.size):
        level[k] = 0
        out[k, 0], out[k, 1], out[k, 2] = inf, inf, 0.0
        known = 0.0
        for i in range(6):
            known += host[k, i] + remote[k, i]
        if np.isnan(known):
            out[k, 1] = nan
            continue
        ahead, beside = along_path(host[k], remote[k])
        if ahead <= 0.0 or ahead > x[FARTHEST] or abs(beside) > x[HALF_LANE]:
            continue
        if heading_apart(host[k, HEADING], remote[k, HEADING]) > x[WIDEST_TURN]:
            continue
        gap = ahead - 0.5 * (host[k, LENGTH] + remote[k, LENGTH])
        speed, leader_speed = host[k, SPEED], remote[k, SPEED]
        motion = (speed, host[k, ACCELERATION], leader_speed, remote[k, ACCELERATION])
        reach = warning_range(*motion, x, x[DELAY])
        margin = gap - reach
        if speed > leader_speed:
            out[k, 0] = max(gap, 0.0) / (speed - leader_speed)
        out[k, 1] = margin
        east, north = remote[k, EAST] - host[k, EAST], remote[k, NORTH] - host[k, NORTH]
        square = max(east * east + north * north, 1e-9)
        variance = (
            spread[k, 0] * east * east + 2.0 * spread[k, 1] * east * north + spread[k, 2] * north * north
        )
        out[k, 2] = chance_below_zero(margin, variance / square)
        # A range of zero asks for nothing, however close they are: nobody closes in.
        if reach > 0.0 and margin <= 0.0:
            level[k] = 2
        elif x[CAUTION_DELAY] > 0.0 and gap <= warning_range(*motion, x, x[DELAY] + x[CAUTION_DELAY]):
            level[k] = 1
