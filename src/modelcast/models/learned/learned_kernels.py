"""Compiled functions of the learned sub-model: its inputs, the network, and the corrected path."""

from math import hypot, log, sqrt

import numpy as np

from modelcast.core.exponential_kernels import fast_asinh
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector
from modelcast.models.context_columns import (
    LEADER_ACCELERATION,
    LEADER_ACCELERATION_BEFORE,
    LEADER_GAP,
    LEADER_KNOWN,
    LEADER_RELATIVE_SPEED,
    ROAD_HEADING,
    ROAD_KNOWN,
    ROAD_TURN,
    ROAD_TURN_HORIZONS,
)
from modelcast.models.kinematic_kernels import predict_acceleration_and_turn
from modelcast.models.learned.features import LAG_STEP_S, LEADER_INPUTS, REPORTED, ROAD_INPUTS, SHORTEST_SPAN
from modelcast.models.point_kernels import (
    ACCELERATION,
    EAST,
    NORTH,
    POSITION_NOISE,
    REPORTS,
    SPEED,
    VELOCITY_EAST,
    VELOCITY_NORTH,
    YAW_RATE,
)

__all__ = [
    "CONTEXT_AT",
    "FRAME_MPS",
    "HEADER",
    "KINEMATIC",
    "fit",
    "predict",
    "run_network",
    "window_features",
]

FRAME_MPS = 0.5
"""A slower car has no course to go by: its frame looks north."""

KINEMATIC = 4
"""Velocity, acceleration and yaw rate come first among the parameters: a core message carries them."""

HEADER = 11
"""Sampling interval, lags, rows for positions and velocities, inputs, coefficients, their time, networks;
rows for speeds, whether the context is an input, and its first column in a sample, 0 where samples hold
none."""

CONTEXT_AT = 10
"""Where in the header the context's column stands."""

_LEAST_NOISE_M, _MOST_NOISE_M = 5e-4, 0.5
_LEAST_ROUGH_MPS, _MOST_ROUGH_MPS = 1e-3, 5.0
_THIRD_DIFFERENCE_GAIN = 20.0  # of the variance of white noise: 1 + 9 + 9 + 1


@kernel
def _frame(east: float, north: float) -> tuple[float, float, float]:
    """Speed and unit course of a velocity; north where it stands."""
    speed = hypot(east, north)
    if speed < FRAME_MPS:
        return speed, 0.0, 1.0
    return speed, east / speed, north / speed


@kernel(fast=True)
def _dot(a: FloatVector, b: FloatVector) -> float:
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@kernel
def _roughness(path: FloatVector) -> float:
    """Logarithm of the noise that a velocity's third differences show (lags,)."""
    total = 0.0
    for lag in range(path.size - 3):
        third = path[lag] - 3.0 * path[lag + 1] + 3.0 * path[lag + 2] - path[lag + 3]
        total += third * third
    noise = sqrt(total / (_THIRD_DIFFERENCE_GAIN * (path.size - 3)))
    return log(min(max(noise, _LEAST_ROUGH_MPS), _MOST_ROUGH_MPS))


@kernel
def _context(sample: FloatVector, column: int, speed: float, out: FloatVector, at: int, flags: int) -> None:
    """Write the inputs of the vehicle ahead and of the road from ``at`` on, what is known from ``flags``."""
    for i in range(LEADER_INPUTS + ROAD_INPUTS):
        out[at + i] = 0.0
    out[flags] = out[flags + 1] = 0.0
    if column == 0:
        return
    if sample[column + LEADER_KNOWN] > 0.0:
        out[at] = sample[column + LEADER_GAP]
        out[at + 1] = sample[column + LEADER_RELATIVE_SPEED]
        out[at + 2] = sample[column + LEADER_ACCELERATION]
        out[at + 3] = sample[column + LEADER_ACCELERATION_BEFORE]
        out[flags] = 1.0
    if sample[column + ROAD_KNOWN] > 0.0:
        for i in range(ROAD_TURN_HORIZONS):
            out[at + LEADER_INPUTS + i] = speed * sample[column + ROAD_TURN + i] / (i + 1.0)
        out[at + LEADER_INPUTS + ROAD_TURN_HORIZONS] = speed * sample[column + ROAD_HEADING]
        out[flags + 1] = 1.0


@kernel
def window_features(window: FloatMatrix, constants: FloatVector, out: FloatVector) -> bool:
    """Write the inputs (I,) of a window (n, 9); False where it does not reach back far enough."""
    dt_s, lags = constants[0], int(constants[1])
    position_rows, velocity_rows = int(constants[2]), int(constants[3])
    last = window.shape[0] - 1
    if last * dt_s < lags * LAG_STEP_S * SHORTEST_SPAN:
        return False
    east, north = window[last, VELOCITY_EAST], window[last, VELOCITY_NORTH]
    speed, ahead_east, ahead_north = _frame(east, north)
    speed_rows = int(constants[8])
    path = np.zeros((5, lags + 1))
    path[4, 0] = window[last, SPEED] - hypot(east, north)
    for lag in range(1, lags + 1):
        back = min(lag * LAG_STEP_S / dt_s, float(last))
        j = last - int(back)
        share = back - int(back)
        k = max(j - 1, 0)
        moved_east = window[j, EAST] + share * (window[k, EAST] - window[j, EAST]) - window[last, EAST]
        moved_north = window[j, NORTH] + share * (window[k, NORTH] - window[j, NORTH]) - window[last, NORTH]
        gained_east = window[j, VELOCITY_EAST] - east
        gained_east += share * (window[k, VELOCITY_EAST] - window[j, VELOCITY_EAST])
        gained_north = window[j, VELOCITY_NORTH] - north
        gained_north += share * (window[k, VELOCITY_NORTH] - window[j, VELOCITY_NORTH])
        path[0, lag] = moved_east * ahead_east + moved_north * ahead_north + speed * lag * LAG_STEP_S
        path[1, lag] = moved_north * ahead_east - moved_east * ahead_north
        path[2, lag] = gained_east * ahead_east + gained_north * ahead_north
        path[3, lag] = gained_north * ahead_east - gained_east * ahead_north
        path[4, lag] = window[j, SPEED] + share * (window[k, SPEED] - window[j, SPEED]) - hypot(east, north)
    if speed < FRAME_MPS:
        # A car that stands is at rest along its frame; its slow velocity is in the lags.
        for lag in range(1, lags + 1):
            path[0, lag] -= speed * lag * LAG_STEP_S
    out[0] = speed
    out[1] = window[last, ACCELERATION]
    out[2] = speed * window[last, YAW_RATE]
    at = 3
    begin = HEADER
    for _ in range(position_rows):
        row = constants[begin : begin + lags + 1]
        out[at], out[at + 1] = _dot(row, path[0]), _dot(row, path[1])
        at += 2
        begin += lags + 1
    for _ in range(velocity_rows):
        row = constants[begin : begin + lags + 1]
        out[at], out[at + 1] = _dot(row, path[2]), _dot(row, path[3])
        at += 2
        begin += lags + 1
    for _ in range(speed_rows):
        out[at] = _dot(constants[begin : begin + lags + 1], path[4])
        at += 1
        begin += lags + 1
    if speed_rows > 0:
        out[at] = path[4, 0]
        at += 1
    if constants[9] > 0.0:
        flags = at + LEADER_INPUTS + ROAD_INPUTS
        _context(window[last], int(constants[CONTEXT_AT]), speed, out, at, flags)
        at = flags + 2
    if speed_rows > 0:
        reports = int(window[last, REPORTS])
        for value in range(REPORTED):
            out[at] = float((reports >> value) & 1)
            at += 1
        out[at] = _roughness(path[4])
        at += 1
    out[at], out[at + 1] = _roughness(path[2]), _roughness(path[3])
    out[at + 2] = log(min(max(window[last, POSITION_NOISE], _LEAST_NOISE_M), _MOST_NOISE_M))
    return True


@kernel(fast=True)
def run_network(
    network: FloatVector, first: int, second: int, inputs: FloatVector, outputs: FloatVector
) -> None:
    """Run one packed network over raw inputs; ``inputs`` (I,) is overwritten."""
    count = inputs.size
    for i in range(count):
        inputs[i] = fast_asinh((inputs[i] - network[i]) * network[count + i])
    hidden_1, hidden_2 = np.empty(first), np.empty(second)
    at = 2 * count
    bias = at + first * count
    for j in range(first):
        hidden_1[j] = max(network[bias + j] + _dot(network[at : at + count], inputs), 0.0)
        at += count
    at += first
    bias = at + second * first
    for j in range(second):
        hidden_2[j] = max(network[bias + j] + _dot(network[at : at + first], hidden_1), 0.0)
        at += first
    at += second
    bias = at + outputs.size * second
    for j in range(outputs.size):
        outputs[j] = network[bias + j] + _dot(network[at : at + second], hidden_2)
        at += second


@kernel
def fit(window: FloatMatrix, constants: FloatVector, out: FloatVector) -> None:
    """Keep the newest motion, and let the network for the window's noise give the correction."""
    newest = window[-1]
    out[0], out[1] = newest[VELOCITY_EAST], newest[VELOCITY_NORTH]
    out[2], out[3] = newest[ACCELERATION], newest[YAW_RATE]
    out[KINEMATIC:] = 0.0
    lags, inputs, networks = int(constants[1]), int(constants[4]), int(constants[7])
    features = np.empty(inputs)
    if not window_features(window, constants, features):
        return
    outputs = out.size - KINEMATIC
    at = HEADER + (int(constants[2]) + int(constants[3]) + int(constants[8])) * (lags + 1)
    for one in range(networks):
        first, second = int(constants[at + 1]), int(constants[at + 2])
        size = 2 * inputs + first * (inputs + 1) + second * (first + 1) + outputs * (second + 1)
        if newest[POSITION_NOISE] <= constants[at] or one == networks - 1:
            run_network(constants[at + 3 : at + 3 + size], first, second, features, out[KINEMATIC:])
            return
        at += 3 + size


@kernel
def predict(parameters: FloatVector, horizon_s: float, constants: FloatVector, out: FloatVector) -> None:
    """Turn and accelerate, and add the correction along and across the first course."""
    predict_acceleration_and_turn(parameters, horizon_s, constants, out)
    coefficients = int(constants[5])
    share = horizon_s / constants[6]
    along, left = 0.0, 0.0
    for power in range(coefficients - 1, -1, -1):
        along = along * share + parameters[KINEMATIC + power]
        left = left * share + parameters[KINEMATIC + coefficients + power]
    _, ahead_east, ahead_north = _frame(parameters[0], parameters[1])
    out[0] += along * ahead_east - left * ahead_north
    out[1] += along * ahead_north + left * ahead_east
