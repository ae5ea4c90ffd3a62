"""Compiled parts of a kernel expression as functions of the lag between two samples.

On equally spaced times a stationary kernel takes n values, one a lag. Multiplied out, an expression is a sum
of products, each ``(t_i·t_j)^q`` times a function of the lag ``|i - j|``; the same holds of its derivatives.
"""

from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatCube, FloatMatrix, FloatVector
from modelcast.models.gp.expression_layout import (
    AT_DEGREES,
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
    TERM_FIRST,
    TERM_ROW,
)
from modelcast.models.gp.kernel_codes import (
    LINEAR,
    MATERN12,
    MATERN32,
    MATERN52,
    RATIONAL_QUADRATIC,
    RBF,
)

__all__ = ["Work", "lag_terms", "leaf_at", "work_for"]


class Work(NamedTuple):
    """Arrays that a search writes into.

    Parameters
    ----------
    leaves
        Correlation of each leaf at each lag, and its logarithm's derivatives by the logarithms of its two
        shape hyper-parameters, (3, L, n).
    terms
        Each product at each lag, time's powers left out [m²], (T, n).
    powers
        Powers of the times, (Q, n).
    lower
        Covariance, then its Cholesky factor below the diagonal, (n, n).
    inverse
        Inverse of that factor, (n, n).
    lags
        Sums of the cost's derivatives by the covariance along each diagonal, (Q, n).
    whitened, overs, column, dual
        Displacements whitened, one over the factor's diagonal, one column or row, and the dual coefficients,
        (n,).
    slopes
        The cost's derivatives, old and new, (2, P).
    points
        Hyper-parameters, a step, a trial and the best, (4, P).
    curvature
        The cost's second derivatives, approximately; the factor of those of the free ones; and those where
        the cost is least so far, (3, P, P).
    costs
        What the search ended with, (1,).
    """

    leaves: FloatCube
    terms: FloatMatrix
    powers: FloatMatrix
    lower: FloatMatrix
    inverse: FloatMatrix
    lags: FloatMatrix
    whitened: FloatVector
    overs: FloatVector
    column: FloatVector
    dual: FloatVector
    slopes: FloatMatrix
    points: FloatMatrix
    curvature: FloatCube
    costs: FloatVector


@kernel(fast=True)
def work_for(constants: FloatVector) -> Work:
    """Make the arrays, with the powers of the times in place."""
    n = int(constants[AT_SAMPLES])
    count = int(constants[AT_PARAMETERS])
    degrees = int(constants[AT_DEGREES])
    powers = np.empty((degrees, n))
    for j in range(n):
        power = 1.0
        for q in range(degrees):
            powers[q, j] = power
            power *= (j - n + 1) * constants[AT_DT]
    return Work(
        np.empty((3, int(constants[AT_LEAVES]), n)),
        np.empty((int(constants[AT_TERMS]), n)),
        powers,
        np.empty((n, n)),
        np.empty((n, n)),
        np.empty((degrees, n)),
        np.empty(n),
        np.empty(n),
        np.empty(n),
        np.empty(n),
        np.empty((2, count)),
        np.empty((4, count)),
        np.empty((3, count, count)),
        np.empty(1),
    )


@kernel(fast=True, inlined=True)
def leaf_at(code: int, gap_s: float, first: float, second: float) -> tuple[float, float, float]:
    """Correlation at a gap, and its logarithm's derivatives by the logarithms of the shape; 1 if linear."""
    if code == LINEAR:
        return 1.0, 0.0, 0.0
    r = gap_s / first
    if code == RBF:
        return np.exp(-0.5 * r * r), r * r, 0.0
    if code == MATERN12:
        return np.exp(-r), r, 0.0
    if code == MATERN32:
        q = np.sqrt(3.0) * r
        return (1.0 + q) * np.exp(-q), q * q / (1.0 + q), 0.0
    if code == MATERN52:
        q = np.sqrt(5.0) * r
        polynomial = 1.0 + q + q * q / 3.0
        return polynomial * np.exp(-q), q * q / 3.0 * (1.0 + q) / polynomial, 0.0
    if code == RATIONAL_QUADRATIC:
        u = 0.5 * r * r / second
        logarithm = np.log1p(u)
        share = u / (1.0 + u)
        return np.exp(-second * logarithm), 2.0 * second * share, second * (share - logarithm)
    angle = np.pi * r
    sine = np.sin(angle) / second
    return np.exp(-2.0 * sine * sine), 4.0 * sine * angle * np.cos(angle) / second, 4.0 * sine * sine


@kernel(fast=True)
def lag_terms(x: FloatVector, constants: FloatVector, work: Work) -> None:
    """Write leaves and products at every lag for the logarithms of the hyper-parameters."""
    n = int(constants[AT_SAMPLES])
    dt = constants[AT_DT]
    at = int(constants[AT_LEAF_ROWS])
    for leaf in range(int(constants[AT_LEAVES])):
        code = int(constants[at + LEAF_CODE])
        shape = int(constants[at + LEAF_SHAPE])
        last = x.size - 1
        first = np.exp(x[min(shape, last)])
        second = np.exp(x[min(shape + 1, last)])
        at += LEAF_ROW
        for lag in range(n):
            value, by_first, by_second = leaf_at(code, lag * dt, first, second)
            work.leaves[0, leaf, lag] = value
            work.leaves[1, leaf, lag] = by_first
            work.leaves[2, leaf, lag] = by_second
    leaf_rows = int(constants[AT_LEAF_ROWS])
    at = int(constants[AT_TERM_ROWS])
    for term in range(int(constants[AT_TERMS])):
        logarithm = 0.0
        for lag in range(n):
            work.terms[term, lag] = 1.0
        for k in range(int(constants[at + TERM_COUNT])):
            leaf = int(constants[at + TERM_FIRST + k])
            variance = int(constants[leaf_rows + leaf * LEAF_ROW + LEAF_VARIANCE])
            if variance >= 0:
                logarithm += x[variance]
            for lag in range(n):
                work.terms[term, lag] *= work.leaves[0, leaf, lag]
        weight = np.exp(logarithm)
        for lag in range(n):
            work.terms[term, lag] *= weight
        at += TERM_ROW
