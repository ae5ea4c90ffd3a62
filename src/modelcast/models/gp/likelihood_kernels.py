"""Compiled likelihood of a kernel expression on one axis, and its derivatives.

The cost is ``log|K| + yᵀK⁻¹y``: -2 times the log-likelihood, less the constant n·log(2·pi). By a
hyper-parameter's logarithm its derivative is the sum over i, j of ``G_ij·dK_ij`` with
``G = K⁻¹ - alpha·alphaᵀ`` and ``alpha = K⁻¹·y`` (Rasmussen and Williams 2006, equation 5.9); along a diagonal
dK is a function of the lag times a power of the times, so that n sums of G serve all hyper-parameters.
"""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector
from modelcast.models.gp.expression_layout import (
    AT_LEAF_ROWS,
    AT_TERM_ROWS,
    LEAF_CODE,
    LEAF_ROW,
    LEAF_SHAPE,
    LEAF_VARIANCE,
    TERM_COUNT,
    TERM_DEGREE,
    TERM_FIRST,
    TERM_ROW,
)
from modelcast.models.gp.kernel_codes import LINEAR, PERIODIC, RATIONAL_QUADRATIC
from modelcast.models.gp.lag_kernels import Work, lag_terms

__all__ = ["cost_at", "slopes_at"]


@kernel(fast=True)
def covariance_at(x: FloatVector, constants: FloatVector, work: Work) -> None:
    """Write the lower triangle of the covariance, noise on the diagonal."""
    n = work.lower.shape[0]
    lag_terms(x, constants, work)
    lags = work.lags
    for q in range(lags.shape[0]):
        for lag in range(n):
            lags[q, lag] = 0.0
    at = int(constants[AT_TERM_ROWS])
    for term in range(work.terms.shape[0]):
        q = int(constants[at + TERM_DEGREE])
        # Longest lag first: along a row of the lower triangle lags fall.
        for lag in range(n):
            lags[q, n - 1 - lag] += work.terms[term, lag]
        at += TERM_ROW
    lags[0, n - 1] += np.exp(x[x.size - 1])
    for i in range(n):
        first = n - 1 - i
        for j in range(i + 1):
            work.lower[i, j] = lags[0, first + j]
    for q in range(1, lags.shape[0]):
        for i in range(n):
            left = work.powers[q, i]
            first = n - 1 - i
            for j in range(i + 1):
                work.lower[i, j] += left * work.powers[q, j] * lags[q, first + j]


@kernel(fast=True)
def cost_at(x: FloatVector, y: FloatVector, constants: FloatVector, work: Work) -> float:
    """Cost at the logarithms of the hyper-parameters; infinite where K is not positive to rounding.

    Leaves the Cholesky factor in ``work.lower`` and the whitened displacements.
    """
    covariance_at(x, constants, work)
    n = y.size
    lower = work.lower
    column = work.column
    z = work.whitened
    cost = 0.0
    determinant = 1.0
    for i in range(n):
        z[i] = y[i]
    for j in range(n):
        pivot = lower[j, j]
        if not pivot > 0.0:
            return np.inf
        over = 1.0 / np.sqrt(pivot)
        work.overs[j] = over
        for i in range(j + 1, n):
            column[i] = lower[i, j] * over
            lower[i, j] = column[i]
        z[j] *= over
        cost += z[j] * z[j]
        for i in range(j + 1, n):
            left = column[i]
            z[i] -= left * z[j]
            for k in range(j + 1, i + 1):
                lower[i, k] -= left * column[k]
        determinant *= pivot
        if j % 8 == 7:
            cost += np.log(determinant)
            determinant = 1.0
    return cost + np.log(determinant)


@kernel(fast=True)
def weigh(work: Work) -> None:
    """Write the factor's inverse and the dual coefficients, from what `cost_at` left."""
    n = work.dual.size
    lower = work.lower
    inverse = work.inverse
    for i in range(n):
        over = work.overs[i]
        for j in range(i):
            inverse[i, j] = 0.0
        for k in range(i):
            left = lower[i, k] * over
            for j in range(k + 1):
                inverse[i, j] -= left * inverse[k, j]
        inverse[i, i] = over
    for j in range(n):
        work.dual[j] = 0.0
    for i in range(n):
        for j in range(i + 1):
            work.dual[j] += work.whitened[i] * inverse[i, j]


@kernel(fast=True)
def sum_lags(work: Work) -> None:
    """Write sums of G along its diagonals, weighted by the powers of the times; both triangles count."""
    n = work.dual.size
    lags = work.lags
    row = work.column
    for q in range(lags.shape[0]):
        for lag in range(n):
            lags[q, lag] = 0.0
    for j in range(n):
        for lag in range(n - j):
            row[lag] = -work.dual[j + lag] * work.dual[j]
        for k in range(j, n):
            left = work.inverse[k, j]
            for lag in range(k - j + 1):
                row[lag] += left * work.inverse[k, j + lag]
        for q in range(lags.shape[0]):
            right = work.powers[q, j]
            for lag in range(n - j):
                lags[q, lag] += row[lag] * right * work.powers[q, j + lag]
    for q in range(lags.shape[0]):
        for lag in range(1, n):
            lags[q, lag] *= 2.0


@kernel(fast=True)
def slopes_at(x: FloatVector, constants: FloatVector, work: Work, out: FloatVector) -> None:
    """Derivatives of the cost where `cost_at` has just been, into ``out`` (P,)."""
    weigh(work)
    sum_lags(work)
    last = x.size - 1
    for p in range(last):
        out[p] = 0.0
    out[last] = np.exp(x[last]) * work.lags[0, 0]
    rows = int(constants[AT_LEAF_ROWS])
    at = int(constants[AT_TERM_ROWS])
    for term in range(work.terms.shape[0]):
        q = int(constants[at + TERM_DEGREE])
        total = 0.0
        for lag in range(work.dual.size):
            total += work.lags[q, lag] * work.terms[term, lag]
        for k in range(int(constants[at + TERM_COUNT])):
            leaf = int(constants[at + TERM_FIRST + k])
            row = rows + leaf * LEAF_ROW
            variance = int(constants[row + LEAF_VARIANCE])
            if variance >= 0:
                out[variance] += total
            code = int(constants[row + LEAF_CODE])
            if code == LINEAR:
                continue
            shape = int(constants[row + LEAF_SHAPE])
            for side in range(2 if code in (RATIONAL_QUADRATIC, PERIODIC) else 1):
                slope = 0.0
                for lag in range(work.dual.size):
                    slope += work.lags[q, lag] * work.terms[term, lag] * work.leaves[1 + side, leaf, lag]
                out[shape + side] += slope
        at += TERM_ROW
