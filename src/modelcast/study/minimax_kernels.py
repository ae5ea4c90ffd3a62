"""Compiled search for the polynomial with the smallest greatest error over some samples of a track.

One polynomial an axis, in Legendre's basis; a primal-dual interior-point method, which gives weights that
prove a bound beside the polynomial.
"""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, StridedFloatMatrix, StridedFloatVector

__all__ = [
    "FAILS",
    "HOLDS",
    "MOST_DEGREE",
    "MOST_ITERATIONS",
    "ROUNDING",
    "TERMS",
    "UNDECIDED",
    "basis",
    "least_squares",
    "minimax",
]

FAILS, UNDECIDED, HOLDS = range(-1, 2)
"""What is found of a stretch."""

MOST_DEGREE = 3
MOST_ITERATIONS = 60

TERMS = MOST_DEGREE + 1
"""Coefficients of the longest polynomial."""
ROUNDING = 1e-9
"""A bound must pass the threshold by this share, so that rounding proves nothing."""
_CENTRING = 0.15
_TO_EDGE = 0.95
_SHORTEST_STEP = 1e-9


@kernel
def basis(u: float, terms: int, out: StridedFloatVector) -> None:
    """Legendre polynomials at ``u``, scaled time in -1..1."""
    out[0] = 1.0
    if terms > 1:
        out[1] = u
    if terms > 2:
        out[2] = 1.5 * u * u - 0.5
    if terms > 3:
        out[3] = (2.5 * u * u - 1.5) * u


@kernel
def _factor(matrix: FloatMatrix, size: int) -> bool:
    """Cholesky factor of the lower triangle in place; False where it is not positive definite."""
    for j in range(size):
        for k in range(j):
            matrix[j, j] -= matrix[j, k] * matrix[j, k]
        if not matrix[j, j] > 0.0:
            return False
        matrix[j, j] = np.sqrt(matrix[j, j])
        for i in range(j + 1, size):
            for k in range(j):
                matrix[i, j] -= matrix[i, k] * matrix[j, k]
            matrix[i, j] /= matrix[j, j]
    return True


@kernel
def _solve(factor: FloatMatrix, size: int, right: FloatVector) -> None:
    """Solve with the Cholesky factor, in place."""
    for i in range(size):
        for k in range(i):
            right[i] -= factor[i, k] * right[k]
        right[i] /= factor[i, i]
    for i in range(size - 1, -1, -1):
        for k in range(i + 1, size):
            right[i] -= factor[k, i] * right[k]
        right[i] /= factor[i, i]


@kernel
def least_squares(
    phi: StridedFloatMatrix,
    data: StridedFloatMatrix,
    weight: StridedFloatVector,
    count: int,
    terms: int,
    fit: FloatMatrix,
) -> tuple[float, float]:
    """Weighted fit ``fit`` (2, terms) of ``data`` (count, 2): weighted mean and maximum of the squared error.

    The weights sum to one. Both are infinite or NaN-free bounds only where the normal matrix is definite;
    otherwise the result is (0, inf), which proves nothing.
    """
    normal = np.zeros((TERMS, TERMS))
    fit[:] = 0.0
    for k in range(count):
        for a in range(terms):
            scaled = weight[k] * phi[k, a]
            fit[0, a] += scaled * data[k, 0]
            fit[1, a] += scaled * data[k, 1]
            for b in range(a + 1):
                normal[a, b] += scaled * phi[k, b]
    if not _factor(normal, terms):
        fit[:] = 0.0
        return 0.0, np.inf
    _solve(normal, terms, fit[0])
    _solve(normal, terms, fit[1])
    mean = worst = 0.0
    for k in range(count):
        east, north = data[k, 0], data[k, 1]
        for a in range(terms):
            east -= phi[k, a] * fit[0, a]
            north -= phi[k, a] * fit[1, a]
        squared = east * east + north * north
        mean += weight[k] * squared
        worst = max(worst, squared)
    return mean, worst


@kernel
def _newton(
    phi: StridedFloatMatrix,
    error: StridedFloatMatrix,
    slack: StridedFloatVector,
    weight: StridedFloatVector,
    mu: float,
    count: int,
    terms: int,
    step: FloatVector,
) -> bool:
    """Primal-dual Newton step towards ``weight * slack = mu``: both axes' coefficients, then the bound.

    ``error`` (count, 2) is data less polynomial, ``slack`` (count,) the bound less its square.
    """
    last = 2 * terms
    matrix = np.zeros((2 * TERMS + 1, 2 * TERMS + 1))
    step[:] = 0.0
    step[last] = -1.0
    for k in range(count):
        centred = mu / slack[k]
        stiff = weight[k] / slack[k]
        east, north = 2.0 * error[k, 0], 2.0 * error[k, 1]
        step[last] += centred
        matrix[last, last] += stiff
        for a in range(terms):
            one = phi[k, a]
            step[a] += centred * east * one
            step[terms + a] += centred * north * one
            matrix[last, a] += stiff * east * one
            matrix[last, terms + a] += stiff * north * one
            both = (2.0 * weight[k] + stiff * east * east) * one
            across = stiff * east * north * one
            other = (2.0 * weight[k] + stiff * north * north) * one
            for b in range(a + 1):
                matrix[a, b] += both * phi[k, b]
                matrix[terms + a, terms + b] += other * phi[k, b]
            for b in range(terms):
                matrix[terms + a, b] += across * phi[k, b]
    if not _factor(matrix, last + 1):
        return False
    _solve(matrix, last + 1, step)
    return True


@kernel
def _advance(
    phi: StridedFloatMatrix,
    data: StridedFloatMatrix,
    fit: FloatMatrix,
    bound: float,
    step: FloatVector,
    mu: float,
    count: int,
    terms: int,
    error: StridedFloatMatrix,
    slack: StridedFloatVector,
    weight: StridedFloatVector,
) -> tuple[float, float]:
    """Take the step in weights, and in polynomial and bound, each shortened to stay off the edge.

    Writes the new fit, errors, slacks and weights; returns the bound and the greatest squared error.
    """
    longest = 1.0
    for k in range(count):
        change = step[2 * terms]
        for a in range(terms):
            change += 2.0 * phi[k, a] * (error[k, 0] * step[a] + error[k, 1] * step[terms + a])
        change = (mu - weight[k] * change) / slack[k] - weight[k]
        error[k, 0] = change
        if change < 0.0:
            longest = min(longest, -_TO_EDGE * weight[k] / change)
    total = 0.0
    for k in range(count):
        weight[k] += longest * error[k, 0]
        total += weight[k]
    size = 1.0
    while True:
        new = bound + size * step[2 * terms]
        worst = 0.0
        inside = True
        for k in range(count):
            east, north = data[k, 0], data[k, 1]
            for a in range(terms):
                east -= phi[k, a] * (fit[0, a] + size * step[a])
                north -= phi[k, a] * (fit[1, a] + size * step[terms + a])
            error[k, 0], error[k, 1] = east, north
            squared = east * east + north * north
            inside = inside and new - squared >= (1.0 - _TO_EDGE) * slack[k]
            worst = max(worst, squared)
        if inside or size == 0.0:
            break
        size = 0.0 if size < _SHORTEST_STEP else 0.6 * size
    for k in range(count):
        weight[k] /= total
        slack[k] = new - error[k, 0] ** 2 - error[k, 1] ** 2
    for a in range(terms):
        fit[0, a] += size * step[a]
        fit[1, a] += size * step[terms + a]
    return new, worst


@kernel(inlined=True)
def _copy(one: FloatMatrix, other: FloatMatrix) -> None:
    """Put a polynomial, (2, `TERMS`), in the place of another."""
    for a in range(TERMS):
        other[0, a], other[1, a] = one[0, a], one[1, a]


@kernel
def minimax(
    phi: StridedFloatMatrix,
    data: StridedFloatMatrix,
    count: int,
    terms: int,
    error: StridedFloatMatrix,
    weight: StridedFloatVector,
    slack: StridedFloatVector,
    fit: FloatMatrix,
) -> int:
    """Whether some polynomial stays below an error of one at these samples; ``fit`` takes it where so."""
    step = np.zeros(2 * TERMS + 1)
    current = np.zeros((2, TERMS))
    weight[:count] = 1.0 / count
    lower, worst = least_squares(phi, data, weight, count, terms, fit)
    if worst < 1.0:
        return HOLDS
    if lower >= 1.0 + ROUNDING:
        return FAILS
    _copy(fit, current)
    bound = 1.1 * worst
    for k in range(count):
        east, north = data[k, 0], data[k, 1]
        for a in range(terms):
            east -= phi[k, a] * fit[0, a]
            north -= phi[k, a] * fit[1, a]
        error[k, 0], error[k, 1] = east, north
        slack[k] = bound - east * east - north * north
    for iteration in range(MOST_ITERATIONS):
        gap = 0.0
        for k in range(count):
            gap += weight[k] * slack[k]
        # Now and then a step that only centres: steps that keep running into the edge would stall.
        mu = (1.0 if iteration % 4 == 3 else _CENTRING) * gap / count
        if not _newton(phi, error, slack, weight, mu, count, terms, step):
            break
        bound, worst = _advance(phi, data, current, bound, step, mu, count, terms, error, slack, weight)
        if worst < 1.0:
            _copy(current, fit)
            return HOLDS
        lower, worst = least_squares(phi, data, weight, count, terms, fit)
        if worst < 1.0:
            return HOLDS
        if lower >= 1.0 + ROUNDING:
            return FAILS
        if bound - lower < 0.1 * ROUNDING:
            break
    return UNDECIDED
