"""Compiled point functions of the Gaussian process in the vehicle's frame."""

from math import hypot, log

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector
from modelcast.models.point_kernels import (
    EAST,
    NORTH,
    POSITION_NOISE,
    VELOCITY_EAST,
    VELOCITY_NORTH,
)

__all__ = [
    "AT_COEFFICIENTS",
    "AT_LEVELS",
    "AT_LOG_FINEST",
    "AT_LOG_STEP",
    "AT_MEASUREMENTS",
    "AT_SAMPLES",
    "AT_STRAIGHT_AFTER",
    "AT_UNKNOWN",
    "HEADER",
    "fit",
    "predict",
]

AT_SAMPLES, AT_MEASUREMENTS, AT_COEFFICIENTS, AT_LEVELS = range(4)
AT_STRAIGHT_AFTER, AT_LOG_FINEST, AT_LOG_STEP, AT_UNKNOWN = range(4, 8)
HEADER = 8
"""The constants: window length n; measurements m, n or 2n; coefficients k an axis; noise levels; where the
polynomial ends [s]; logarithm of the finest level, step between levels; level where the noise is not known.
Then for each level the matrices (k, m) of the axis along the course and of that across it."""

_STOP_STEPS = 24
"""Instants of the polynomial at which the speed along the course is looked at."""


@kernel
def _level(noise_m: float, constants: FloatVector) -> int:
    """Nearest noise level on the ladder."""
    if noise_m <= 0.0:
        return int(constants[AT_UNKNOWN])
    nearest = int((log(noise_m) - constants[AT_LOG_FINEST]) / constants[AT_LOG_STEP] + 0.5)
    return max(0, min(nearest, int(constants[AT_LEVELS]) - 1))


@kernel
def _stop(coefficients: FloatVector, count: int) -> float:
    """Share of the polynomial's span at which the speed along the course has fallen to zero; 1 if never."""
    before = coefficients[1]
    if before <= 0.0:
        return 0.0
    for step in range(1, _STOP_STEPS + 1):
        share = step / _STOP_STEPS
        speed = 0.0
        for i in range(count - 1, 0, -1):
            speed = speed * share + i * coefficients[i]
        if speed <= 0.0:
            return (step + speed / (before - speed)) / _STOP_STEPS
        before = speed
    return 1.0


@kernel
def fit(window: FloatMatrix, constants: FloatVector, out: FloatVector) -> None:
    """Polynomial coefficients east, then north; the end of the motion; the noise level."""
    n = int(constants[AT_SAMPLES])
    m = int(constants[AT_MEASUREMENTS])
    k = int(constants[AT_COEFFICIENTS])
    level = _level(window[n - 1, POSITION_NOISE], constants)
    east, north = window[n - 1, VELOCITY_EAST], window[n - 1, VELOCITY_NORTH]
    speed = hypot(east, north)
    ahead_east, ahead_north = (east / speed, north / speed) if speed > 0.0 else (1.0, 0.0)
    turned = np.empty((2, m))
    for j in range(n):
        for first, at in ((EAST, j), (VELOCITY_EAST, n + j)):
            if at < m:
                one = window[j, first] - (window[n - 1, EAST] if first == EAST else 0.0)
                other = window[j, first + 1] - (window[n - 1, NORTH] if first == EAST else 0.0)
                turned[0, at] = ahead_east * one + ahead_north * other
                turned[1, at] = ahead_east * other - ahead_north * one
    found = np.empty((2, k))
    at = HEADER + level * 2 * k * m
    for axis in range(2):
        for i in range(k):
            total = 0.0
            for j in range(m):
                total += constants[at + j] * turned[axis, j]
            found[axis, i] = total
            at += m
    for i in range(k):
        out[i] = ahead_east * found[0, i] - ahead_north * found[1, i]
        out[k + i] = ahead_north * found[0, i] + ahead_east * found[1, i]
    out[2 * k] = constants[AT_STRAIGHT_AFTER] * _stop(found[0], k)
    out[2 * k + 1] = level


@kernel
def predict(parameters: FloatVector, horizon_s: float, constants: FloatVector, out: FloatVector) -> None:
    """Follow the polynomial to its end, then go straight on, or stay where the vehicle stopped."""
    k = int(constants[AT_COEFFICIENTS])
    span = constants[AT_STRAIGHT_AFTER]
    end = parameters[2 * k]
    share = min(horizon_s, end) / span
    beyond = horizon_s / span - 1.0 if end >= span and horizon_s > span else 0.0
    for axis in range(2):
        value = 0.0
        slope = 0.0
        for i in range(k - 1, -1, -1):
            slope = slope * share + value
            value = value * share + parameters[axis * k + i]
        out[axis] = value + slope * beyond
