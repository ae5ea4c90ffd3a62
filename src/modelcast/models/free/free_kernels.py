"""Compiled estimates of Part I, and the network that moves them within limits."""

from math import atan2, cos, hypot, sin, tanh

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector
from modelcast.models.learned.learned_kernels import FRAME_MPS, HEADER, run_network, window_features
from modelcast.models.point_kernels import (
    ACCELERATION,
    POSITION_NOISE,
    REPORTS,
    VELOCITY_EAST,
    VELOCITY_NORTH,
    YAW_RATE,
)

__all__ = ["LEVEL", "VALUES", "estimates_each", "estimates_of", "fit"]

VALUES = 4
"""Speed, angle of the course to the left of the newest velocity, acceleration, yaw rate to the left."""

LEVEL = 2 + VALUES
"""Numbers of one set of estimates: up to which noise, what must be reported, and the place of each estimate
among the inputs."""

_PLACES = 2

_SLOWEST_MPS = 0.1


@kernel
def _level_of(noise: float, reports: float, levels: FloatVector) -> int:
    """Return where the first set begins that serves a noise and what is reported; else the last."""
    count, reported = levels.size // LEVEL, int(reports)
    for level in range(count):
        at = level * LEVEL
        needed = int(levels[at + 1])
        if noise <= levels[at] and (needed & reported) == needed:
            return at
    return (count - 1) * LEVEL


@kernel
def estimates_of(
    noise: float, reports: float, inputs: FloatVector, levels: FloatVector, out: FloatVector
) -> None:
    """Write the four values (`VALUES`,) that a moving vehicle's inputs give.

    ``levels`` (L x `LEVEL`,) are all sets of estimates; -1 stands for the newest sample's own value.
    """
    first = _level_of(noise, reports, levels) + _PLACES
    places = levels[first : first + VALUES]
    along, left = inputs[0], 0.0
    if places[0] >= 0.0:
        along += inputs[int(places[0])]
    if places[1] >= 0.0:
        left = inputs[int(places[1])]
    along = max(along, _SLOWEST_MPS)
    out[0] = hypot(along, left)
    out[1] = atan2(left, along)
    out[2] = inputs[int(places[2])] if places[2] >= 0.0 else inputs[1]
    toward = inputs[int(places[3])] if places[3] >= 0.0 else -inputs[2]
    out[3] = toward / out[0]


@kernel
def estimates_each(
    noise: FloatVector, reports: FloatVector, inputs: FloatMatrix, levels: FloatVector, out: FloatMatrix
) -> None:
    """Write `estimates_of` of many windows, (B,), (B,) and inputs (B, I), into (B, `VALUES`)."""
    for row in range(inputs.shape[0]):
        estimates_of(noise[row], reports[row], inputs[row], levels, out[row])


@kernel
def _moved(
    noise: float,
    inputs: FloatVector,
    limits: FloatVector,
    packed: FloatVector,
    networks: int,
    out: FloatVector,
) -> None:
    """Let the network for a noise move the values (`VALUES`,) within their limits; ``inputs`` are lost."""
    at, count = 0, inputs.size
    moves = np.empty(VALUES)
    for one in range(networks):
        first, second = int(packed[at + 1]), int(packed[at + 2])
        size = 2 * count + first * (count + 1) + second * (first + 1) + VALUES * (second + 1)
        if noise <= packed[at] or one == networks - 1:
            run_network(packed[at + 3 : at + 3 + size], first, second, inputs, moves)
            for i in range(VALUES):
                out[i] += limits[i] * tanh(moves[i])
            out[0] = max(out[0], 0.0)
            return
        at += 3 + size


@kernel
def fit(window: FloatMatrix, constants: FloatVector, out: FloatVector) -> None:
    """Write velocity east and north, acceleration and clockwise yaw rate, as a message states them.

    A standing vehicle states its newest sample, and so does one whose window does not reach back far enough.
    """
    newest = window[-1]
    out[0], out[1] = newest[VELOCITY_EAST], newest[VELOCITY_NORTH]
    out[2], out[3] = newest[ACCELERATION], newest[YAW_RATE]
    lags, networks = int(constants[1]), int(constants[7])
    inputs = np.empty(int(constants[4]))
    if not window_features(window, constants, inputs) or inputs[0] < FRAME_MPS:
        return
    ahead_east, ahead_north = out[0] / inputs[0], out[1] / inputs[0]
    at = HEADER + (int(constants[2]) + int(constants[3]) + int(constants[8])) * (lags + 1)
    levels = int(constants[at])
    at += 1
    noise = newest[POSITION_NOISE]
    values = np.empty(VALUES)
    estimates_of(noise, newest[REPORTS], inputs, constants[at : at + levels * LEVEL], values)
    at += levels * LEVEL
    if networks > 0:
        _moved(noise, inputs, constants[at : at + VALUES], constants[at + VALUES :], networks, values)
    along, left = values[0] * cos(values[1]), values[0] * sin(values[1])
    out[0] = along * ahead_east - left * ahead_north
    out[1] = along * ahead_north + left * ahead_east
    out[2], out[3] = values[2], -values[3]
