"""Compiled point functions of the Gaussian-process model."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatCube, FloatMatrix, FloatVector
from modelcast.models.gp.layout import (
    AT_DT,
    AT_FLAT,
    AT_NOISE_LOW,
    AT_SAMPLES,
    OUT_CONSTANT,
    OUT_FLOORED,
    OUT_LENGTHSCALE,
    OUT_LINEAR_RATIO,
    OUT_NOISE_RATIO,
    OUT_SLOPE,
    OUT_VARIANCE,
    OUT_WEIGHTS,
)
from modelcast.models.gp.search_kernels import scratch_size, search
from modelcast.models.point_kernels import POSITION_NOISE

__all__ = [
    "fit_adaptive",
    "fit_anchored",
    "fit_axes",
    "fit_fixed",
    "fit_intercept",
    "predict_anchored",
    "predict_fixed",
    "predict_intercept",
]

_SKIP_EXPONENT = 90.0
"""Beyond this exponent every RBF term is below 1e-39 of its weight."""
_ROOT_HALF = float(np.sqrt(0.5))


@kernel(fast=True)
def fit_columns(
    window: FloatMatrix, first: int, D: int, constants: FloatVector, scratch: FloatVector, out: FloatVector
) -> None:
    """Fit columns ``first`` to ``first + D`` of a window (n, .), less their last sample, into ``out``."""
    n = int(constants[AT_SAMPLES])
    dt = constants[AT_DT]
    flat = constants[AT_FLAT] > 0.0
    he = (n + 1) // 2
    half = n // 2
    folded = scratch[0 : 2 * n]
    gamma = scratch[2 * n : 2 * n + 2]
    mean = scratch[2 * n + 2 : 2 * n + 4]
    centre = -0.5 * (n - 1) * dt
    shift = centre if flat else 0.0
    gamma[0] = 0.0
    gamma[1] = 0.0
    for d in range(D):
        last = window[n - 1, first + d]
        total = 0.0
        cross = 0.0
        square = 0.0
        for j in range(n):
            t = (j - n + 1) * dt - shift
            y = window[j, first + d] - last
            total += y
            cross += t * y
            square += t * t
        g = cross / square
        a = total / n if flat else 0.0
        gamma[d] = g
        mean[d] = a
        for j in range(half):
            t = (half - j - n) * dt - shift
            early = window[half - 1 - j, first + d] - last - a - g * t
            t = (j + 1 - half) * dt - shift
            late = window[n - half + j, first + d] - last - a - g * t
            folded[d * n + n % 2 + j] = (late + early) * _ROOT_HALF
            folded[d * n + he + j] = (late - early) * _ROOT_HALF
        if n % 2:
            folded[d * n] = window[half, first + d] - last - a - g * ((half - n + 1) * dt - shift)
    search(folded, gamma, D, constants, scratch[2 * n + 4 :], out)
    over = 0.5 * dt * dt / (out[OUT_LENGTHSCALE] * out[OUT_LENGTHSCALE])
    for d in range(D):
        out[OUT_CONSTANT + d] += mean[d] - out[OUT_SLOPE + d] * shift
    for j in range(n):
        age = n - 1 - j
        decay = np.exp(-over * (age * age))
        for d in range(D):
            out[OUT_WEIGHTS + d * n + j] *= decay


@kernel(fast=True)
def fit_axes(displacements: FloatCube, constants: FloatVector, out: FloatMatrix) -> None:
    """Fit one axis of B windows, (B, n, 1), into (B, .) in the layout of `search`."""
    n = displacements.shape[1]
    scratch = np.empty(2 * n + 4 + scratch_size(n))
    for row in range(displacements.shape[0]):
        fit_columns(displacements[row], 0, 1, constants, scratch, out[row])


@kernel(fast=True)
def fit_anchored(window: FloatMatrix, constants: FloatVector, out: FloatVector) -> None:
    """Fit each axis on its own; see `GaussianProcess.parameter_names` for the layout."""
    n = int(constants[AT_SAMPLES])
    scratch = np.empty(4 * n + 4 + scratch_size(n) + OUT_WEIGHTS)
    found = scratch[2 * n + 4 + scratch_size(n) :]
    tail = 4 + 2 * n
    for d in range(2):
        fit_columns(window, d, 1, constants, scratch, found)
        out[d] = found[OUT_SLOPE]
        out[2 + d] = found[OUT_LENGTHSCALE]
        for j in range(n):
            out[4 + d * n + j] = found[OUT_WEIGHTS + j]
        out[tail + d] = found[OUT_VARIANCE]
        out[tail + 2 + d] = found[OUT_NOISE_RATIO]
        out[tail + 4 + d] = found[OUT_LINEAR_RATIO]
        out[tail + 6 + d] = found[OUT_FLOORED]


@kernel(fast=True)
def fit_intercept(window: FloatMatrix, constants: FloatVector, out: FloatVector) -> None:
    """Fit both axes with common hyper-parameters."""
    n = int(constants[AT_SAMPLES])
    scratch = np.empty(4 * n + 4 + scratch_size(n) + OUT_WEIGHTS)
    found = scratch[2 * n + 4 + scratch_size(n) :]
    fit_columns(window, 0, 2, constants, scratch, found)
    for d in range(2):
        out[d] = found[OUT_CONSTANT + d]
        out[2 + d] = found[OUT_SLOPE + d]
    out[4] = found[OUT_LENGTHSCALE]
    for j in range(2 * n):
        out[5 + j] = found[OUT_WEIGHTS + j]
    tail = 5 + 2 * n
    out[tail] = found[OUT_VARIANCE]
    out[tail + 1] = found[OUT_NOISE_RATIO]
    out[tail + 2] = found[OUT_LINEAR_RATIO]
    out[tail + 3] = found[OUT_FLOORED]


@kernel(fast=True)
def fit_adaptive(window: FloatMatrix, constants: FloatVector, out: FloatVector) -> None:
    """Fit both axes with common hyper-parameters and no less noise than the window says it has.

    Raising the floor by a factor is the same as shrinking the positions by it, which leaves all tables as
    they are; the other bounds are stretched by as much.
    """
    n = int(constants[AT_SAMPLES])
    floor = np.sqrt(constants[AT_NOISE_LOW])
    scale = max(window[n - 1, POSITION_NOISE] / floor, 1.0)
    shrunk = np.empty((n, 2))
    for j in range(n):
        for d in range(2):
            shrunk[j, d] = (window[j, d] - window[n - 1, d]) / scale
    fit_intercept(shrunk, constants, out)
    for i in range(4):
        out[i] *= scale
    for j in range(2 * n):
        out[5 + j] *= scale
    out[5 + 2 * n] *= scale * scale


@kernel(fast=True)
def horner(parameters: FloatVector, first: int, n: int, power: float) -> float:
    """Polynomial whose coefficients are the weights, newest sample first."""
    total = 0.0
    for j in range(n):
        total = total * power + parameters[first + j]
    return total


@kernel(fast=True)
def predict_anchored(
    parameters: FloatVector, horizon_s: float, constants: FloatVector, out: FloatVector
) -> None:
    """Line through the last sample plus the RBF part, each axis with its own lengthscale."""
    n = int(constants[AT_SAMPLES])
    for d in range(2):
        out[d] = parameters[d] * horizon_s
        scaled = horizon_s / parameters[2 + d]
        exponent = 0.5 * scaled * scaled
        if exponent < _SKIP_EXPONENT:
            power = np.exp(-scaled * constants[AT_DT] / parameters[2 + d])
            out[d] += np.exp(-exponent) * horner(parameters, 4 + d * n, n, power)


@kernel(fast=True)
def predict_intercept(
    parameters: FloatVector, horizon_s: float, constants: FloatVector, out: FloatVector
) -> None:
    """Line plus the RBF part with the common lengthscale."""
    n = int(constants[AT_SAMPLES])
    out[0] = parameters[0] + parameters[2] * horizon_s
    out[1] = parameters[1] + parameters[3] * horizon_s
    scaled = horizon_s / parameters[4]
    exponent = 0.5 * scaled * scaled
    if exponent < _SKIP_EXPONENT:
        decay = np.exp(-exponent)
        power = np.exp(-scaled * constants[AT_DT] / parameters[4])
        east = 0.0
        north = 0.0
        for j in range(n):
            east = east * power + parameters[5 + j]
            north = north * power + parameters[5 + n + j]
        out[0] += decay * east
        out[1] += decay * north


# The constants of fixed hyper-parameters: n, dt, lengthscale, whether there is an intercept, and then the
# matrices of `modelcast.models.gp.covariance.projection`.
_FIXED_LENGTHSCALE, _FIXED_FLAT, FIXED_HEADER = 2, 3, 4


@kernel(fast=True)
def fit_fixed(window: FloatMatrix, constants: FloatVector, out: FloatVector) -> None:
    """Multiply both axes by the constant matrices: [intercepts,] slopes, weights."""
    n = int(constants[0])
    lines = 2 if constants[_FIXED_FLAT] > 0.0 else 1
    moved = np.empty((2, n))
    dual = np.empty((2, n))
    for j in range(n):
        moved[0, j] = window[j, 0] - window[n - 1, 0]
        moved[1, j] = window[j, 1] - window[n - 1, 1]
    at = FIXED_HEADER
    for r in range(lines + n):
        east = 0.0
        north = 0.0
        for j in range(n):
            east += constants[at + j] * moved[0, j]
            north += constants[at + j] * moved[1, j]
        if r < lines:
            out[2 * r] = east
            out[2 * r + 1] = north
        else:
            dual[0, r - lines] = east
            dual[1, r - lines] = north
        at += n
    for r in range(n):
        east = 0.0
        north = 0.0
        for k in range(n):
            east += constants[at + k] * dual[0, k]
            north += constants[at + k] * dual[1, k]
        out[2 * lines + r] = east
        out[2 * lines + n + r] = north
        at += n


@kernel(fast=True)
def predict_fixed(
    parameters: FloatVector, horizon_s: float, constants: FloatVector, out: FloatVector
) -> None:
    """Line plus the RBF part, lengthscale among the constants."""
    n = int(constants[0])
    at = 0
    out[0] = 0.0
    out[1] = 0.0
    if constants[_FIXED_FLAT] > 0.0:
        out[0] = parameters[0]
        out[1] = parameters[1]
        at = 2
    out[0] += parameters[at] * horizon_s
    out[1] += parameters[at + 1] * horizon_s
    scaled = horizon_s / constants[_FIXED_LENGTHSCALE]
    exponent = 0.5 * scaled * scaled
    if exponent < _SKIP_EXPONENT:
        decay = np.exp(-exponent)
        power = np.exp(-scaled * constants[1] / constants[_FIXED_LENGTHSCALE])
        east = 0.0
        north = 0.0
        for j in range(n):
            east = east * power + parameters[at + 2 + j]
            north = north * power + parameters[at + 2 + n + j]
        out[0] += decay * east
        out[1] += decay * north
