"""Compiled Kalman filter of one vehicle's motion; `modelcast.station.sensing.motion_filter` describes it.

State (6,): position, velocity, acceleration, each east and north. A measurement (6,) is what `FleetFrame` and
a sample row hold of a vehicle: east, north, speed, heading, acceleration along the course, yaw rate.
Constants ``c`` (8,): standard deviations of position, speed, heading, acceleration and yaw rate; density of
the jerk along the course and across it; standard deviations beyond which a position has jumped.
"""

from math import atan2, cos, hypot, sin, sqrt

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector

__all__ = ["STATES", "advance", "correct", "follow", "shown", "start"]

STATES = 6

_LEAST_ACROSS_MPS = 0.01
"""Of the velocity across the measured course: a car slips a little."""

_FIRST_ACCELERATION_MPS2 = 1.0
"""Of a vehicle's acceleration before it was measured twice: the column may be missing."""


@kernel
def _observe(
    state: FloatVector, spread: FloatMatrix, first: int, east: float, north: float, seen: float, std: float
) -> None:
    """Take in one measured number, ``east`` and ``north`` times the two numbers from ``first`` on."""
    gain = np.empty(STATES)
    total = std * std
    for i in range(STATES):
        gain[i] = spread[i, first] * east + spread[i, first + 1] * north
    total += gain[first] * east + gain[first + 1] * north
    off = seen - state[first] * east - state[first + 1] * north
    for i in range(STATES):
        state[i] += gain[i] * off / total
        for j in range(STATES):
            spread[i, j] -= gain[i] * gain[j] / total


@kernel
def _across_std(speed: float, noise: float, least: float) -> float:
    return sqrt(speed * speed * noise * noise + least * least)


@kernel
def start(seen: FloatVector, c: FloatVector, state: FloatVector, spread: FloatMatrix) -> None:
    """Take a vehicle's first measurement for its state (6,), with its errors for the covariance (6, 6)."""
    ahead_east, ahead_north = sin(seen[3]), cos(seen[3])
    state[0], state[1] = seen[0], seen[1]
    state[2], state[3] = seen[2] * ahead_east, seen[2] * ahead_north
    across = seen[2] * seen[5]
    state[4] = seen[4] * ahead_east + across * ahead_north
    state[5] = seen[4] * ahead_north - across * ahead_east
    spread[:, :] = 0.0
    velocity = c[1] + _across_std(seen[2], c[2], _LEAST_ACROSS_MPS)
    for axis in range(2):
        spread[axis, axis] = c[0] * c[0]
        spread[2 + axis, 2 + axis] = velocity * velocity
        spread[4 + axis, 4 + axis] = _FIRST_ACCELERATION_MPS2 * _FIRST_ACCELERATION_MPS2


@kernel
def advance(dt_s: float, heading_rad: float, c: FloatVector, state: FloatVector, spread: FloatMatrix) -> None:
    """Go on by a time at constant acceleration; the jerk is white, along and across a course."""
    half = 0.5 * dt_s * dt_s
    for axis in range(2):
        state[axis] += dt_s * state[2 + axis] + half * state[4 + axis]
        state[2 + axis] += dt_s * state[4 + axis]
    # F P Fᵀ: the same combination of rows, then of columns.
    for j in range(STATES):
        for axis in range(2):
            spread[axis, j] += dt_s * spread[2 + axis, j] + half * spread[4 + axis, j]
            spread[2 + axis, j] += dt_s * spread[4 + axis, j]
    for i in range(STATES):
        for axis in range(2):
            spread[i, axis] += dt_s * spread[i, 2 + axis] + half * spread[i, 4 + axis]
            spread[i, 2 + axis] += dt_s * spread[i, 4 + axis]
    ahead_east, ahead_north = sin(heading_rad), cos(heading_rad)
    along, across = c[5] * c[5], c[6] * c[6]
    jerk = np.empty((2, 2))
    jerk[0, 0] = along * ahead_east * ahead_east + across * ahead_north * ahead_north
    jerk[1, 1] = along * ahead_north * ahead_north + across * ahead_east * ahead_east
    jerk[0, 1] = jerk[1, 0] = (along - across) * ahead_east * ahead_north
    # Integrals of white jerk over the time: t⁵/20, t⁴/8, t³/6; t³/3, t²/2; t.
    moments = np.empty((3, 3))
    moments[0, 0] = dt_s**5 / 20.0
    moments[0, 1] = moments[1, 0] = dt_s**4 / 8.0
    moments[0, 2] = moments[2, 0] = dt_s**3 / 6.0
    moments[1, 1] = dt_s**3 / 3.0
    moments[1, 2] = moments[2, 1] = dt_s**2 / 2.0
    moments[2, 2] = dt_s
    for i in range(STATES):
        for j in range(STATES):
            spread[i, j] += moments[i // 2, j // 2] * jerk[i % 2, j % 2]


@kernel
def correct(seen: FloatVector, c: FloatVector, state: FloatVector, spread: FloatMatrix) -> None:
    """Take in a measurement (6,); speed and rates count along the measured course and across it."""
    ahead_east, ahead_north = sin(seen[3]), cos(seen[3])
    speed = seen[2]
    off_east, off_north = seen[0] - state[0], seen[1] - state[1]
    square = off_east * off_east + off_north * off_north
    if square > c[7] * c[7] * (0.5 * (spread[0, 0] + spread[1, 1]) + c[0] * c[0]):
        # The receiver jumped: the place is new, speed and course are not.
        spread[0, 0] += square
        spread[1, 1] += square
    _observe(state, spread, 0, 1.0, 0.0, seen[0], c[0])
    _observe(state, spread, 0, 0.0, 1.0, seen[1], c[0])
    _observe(state, spread, 2, ahead_east, ahead_north, speed, c[1])
    across_std = _across_std(speed, c[2], _LEAST_ACROSS_MPS)
    _observe(state, spread, 2, ahead_north, -ahead_east, 0.0, across_std)
    _observe(state, spread, 4, ahead_east, ahead_north, seen[4], c[3])
    across_std = _across_std(speed, c[4], c[3])
    _observe(state, spread, 4, ahead_north, -ahead_east, speed * seen[5], across_std)


@kernel
def shown(seen: FloatVector, slowest_mps: float, state: FloatVector, out: FloatVector) -> None:
    """Write the state as a measurement (6,); a car slower than ``slowest_mps`` keeps its measured course."""
    east, north = state[2], state[3]
    speed = hypot(east, north)
    out[0], out[1], out[2] = state[0], state[1], speed
    if speed < slowest_mps:
        out[3], out[4], out[5] = seen[3], seen[4], seen[5]
        return
    out[3] = atan2(east, north)
    out[4] = (state[4] * east + state[5] * north) / speed
    out[5] = (state[4] * north - state[5] * east) / (speed * speed)


@kernel
def follow(
    elapsed_s: float,
    seen: FloatVector,
    fresh: bool,
    slowest_mps: float,
    c: FloatVector,
    state: FloatVector,
    spread: FloatMatrix,
    out: FloatVector,
) -> None:
    """Take in what a vehicle sees, (6,), and write what it takes for its motion into ``out`` (6,)."""
    if fresh:
        start(seen, c, state, spread)
    else:
        advance(elapsed_s, seen[3], c, state, spread)
        correct(seen, c, state, spread)
    shown(seen, slowest_mps, state, out)
