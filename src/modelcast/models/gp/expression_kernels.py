"""Compiled point functions of the sub-model of a kernel expression."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector
from modelcast.models.gp.climb_kernels import search, settle
from modelcast.models.gp.expression_layout import (
    AT_DT,
    AT_LEAF_ROWS,
    AT_LEAVES,
    AT_PARAMETERS,
    AT_SAMPLES,
    AT_TERM_ROWS,
    AT_TERMS,
    LEAF_CODE,
    LEAF_ROW,
    LEAF_SHAPE,
    LEAF_VARIANCE,
    TERM_COUNT,
    TERM_DEGREE,
    TERM_FIRST,
    TERM_ROW,
)
from modelcast.models.gp.lag_kernels import Work, leaf_at, work_for
from modelcast.models.gp.likelihood_kernels import cost_at, slopes_at, weigh

__all__ = ["costs_and_slopes", "fit", "fit_axes", "predict"]


@kernel(fast=True)
def conclude(y: FloatVector, constants: FloatVector, work: Work, out: FloatVector) -> None:
    """Write the best hyper-parameters that a search left, then their dual coefficients."""
    best = work.points[3]
    work.costs[0] = settle(best, y, constants, work)
    weigh(work)
    for i in range(best.size):
        out[i] = np.exp(best[i])
    for j in range(y.size):
        out[best.size + j] = work.dual[j]


@kernel(fast=True)
def fit(window: FloatMatrix, constants: FloatVector, out: FloatVector) -> None:
    """Fit each axis on its own, relative to the last sample."""
    n = int(constants[AT_SAMPLES])
    work = work_for(constants)
    y = np.empty(n)
    size = int(constants[AT_PARAMETERS]) + n
    for d in range(2):
        for j in range(n):
            y[j] = window[j, d] - window[n - 1, d]
        search(y, constants, work)
        conclude(y, constants, work, out[d * size : (d + 1) * size])


@kernel(fast=True)
def fit_axes(displacements: FloatMatrix, constants: FloatVector, out: FloatMatrix) -> None:
    """Fit one axis of B windows, (B, n), into (B, P + n + 1): as `conclude`, then the cost."""
    work = work_for(constants)
    n = displacements.shape[1]
    y = np.empty(n)
    size = int(constants[AT_PARAMETERS]) + n
    for row in range(displacements.shape[0]):
        for j in range(n):
            y[j] = displacements[row, j] - displacements[row, n - 1]
        search(y, constants, work)
        conclude(y, constants, work, out[row, :size])
        out[row, size] = work.costs[0]


@kernel(fast=True)
def costs_and_slopes(
    displacements: FloatMatrix, logarithms: FloatMatrix, constants: FloatVector, out: FloatMatrix
) -> None:
    """Cost of B windows (B, n) at given hyper-parameters (B, P), and its derivatives, into (B, 1 + P)."""
    work = work_for(constants)
    for row in range(displacements.shape[0]):
        out[row, 0] = cost_at(logarithms[row], displacements[row], constants, work)
        slopes_at(logarithms[row], constants, work, out[row, 1:])


@kernel(fast=True)
def covariance_with(
    hyper: FloatVector, horizon_s: float, j: int, constants: FloatVector, correlations: FloatVector
) -> float:
    """Covariance of the position at a horizon with that of sample j, noise-free."""
    t = (j - constants[AT_SAMPLES] + 1.0) * constants[AT_DT]
    rows = int(constants[AT_LEAF_ROWS])
    for leaf in range(int(constants[AT_LEAVES])):
        row = rows + leaf * LEAF_ROW
        shape = int(constants[row + LEAF_SHAPE])
        last = int(constants[AT_PARAMETERS]) - 1
        code = int(constants[row + LEAF_CODE])
        value, _, _ = leaf_at(code, abs(horizon_s - t), hyper[min(shape, last)], hyper[min(shape + 1, last)])
        correlations[leaf] = value
    at = int(constants[AT_TERM_ROWS])
    total = 0.0
    for _ in range(int(constants[AT_TERMS])):
        product = 1.0
        for k in range(int(constants[at + TERM_COUNT])):
            leaf = int(constants[at + TERM_FIRST + k])
            variance = int(constants[rows + leaf * LEAF_ROW + LEAF_VARIANCE])
            product *= correlations[leaf]
            if variance >= 0:
                product *= hyper[variance]
        for _ in range(int(constants[at + TERM_DEGREE])):
            product *= t * horizon_s
        total += product
        at += TERM_ROW
    return total


@kernel(fast=True)
def predict(parameters: FloatVector, horizon_s: float, constants: FloatVector, out: FloatVector) -> None:
    """Sum over the samples of covariance times dual coefficient."""
    n = int(constants[AT_SAMPLES])
    count = int(constants[AT_PARAMETERS])
    size = count + n
    correlations = np.empty(int(constants[AT_LEAVES]))
    for d in range(2):
        own = parameters[d * size : (d + 1) * size]
        total = 0.0
        for j in range(n):
            total += own[count + j] * covariance_with(own, horizon_s, j, constants, correlations)
        out[d] = total
