"""Compiled clairvoyant reference: the longest stretches of a track that one polynomial an axis holds."""

from typing import Any

import numba
import numpy as np

__all__ = ["FAILS", "HOLDS", "MOST_DEGREE", "MOST_ITERATIONS", "UNDECIDED", "decide", "greedy"]

FAILS, UNDECIDED, HOLDS = range(-1, 2)
"""What `decide` finds of a stretch."""

MOST_DEGREE = 3
MOST_ITERATIONS = 60

_TERMS = MOST_DEGREE + 1
_ROUNDING = 1e-9
"""A bound must pass the threshold by this share, so that rounding proves nothing."""
_FEW = 12
_CENTRING = 0.15
_TO_EDGE = 0.95
_SHORTEST_STEP = 1e-9


@numba.njit(cache=True, nogil=True)
def _basis(u: float, terms: int, out: Any) -> None:
    """Legendre polynomials at ``u``, scaled time in -1..1."""
    out[0] = 1.0
    if terms > 1:
        out[1] = u
    if terms > 2:
        out[2] = 1.5 * u * u - 0.5
    if terms > 3:
        out[3] = (2.5 * u * u - 1.5) * u


@numba.njit(cache=True, nogil=True)
def _factor(matrix: Any, size: int) -> bool:
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


@numba.njit(cache=True, nogil=True)
def _solve(factor: Any, size: int, right: Any) -> None:
    """Solve with the Cholesky factor, in place."""
    for i in range(size):
        for k in range(i):
            right[i] -= factor[i, k] * right[k]
        right[i] /= factor[i, i]
    for i in range(size - 1, -1, -1):
        for k in range(i + 1, size):
            right[i] -= factor[k, i] * right[k]
        right[i] /= factor[i, i]


@numba.njit(cache=True, nogil=True)
def _least_squares(phi: Any, data: Any, weight: Any, count: int, terms: int, fit: Any) -> tuple[float, float]:
    """Weighted fit ``fit`` (2, terms) of ``data`` (count, 2): weighted mean and maximum of the squared error.

    The weights sum to one. Both are infinite or NaN-free bounds only where the normal matrix is definite;
    otherwise the result is (0, inf), which proves nothing.
    """
    normal = np.zeros((_TERMS, _TERMS))
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


@numba.njit(cache=True, nogil=True)
def _newton(
    phi: Any, error: Any, slack: Any, weight: Any, mu: float, count: int, terms: int, step: Any
) -> bool:
    """Primal-dual Newton step towards ``weight * slack = mu``: both axes' coefficients, then the bound.

    ``error`` (count, 2) is data less polynomial, ``slack`` (count,) the bound less its square.
    """
    last = 2 * terms
    matrix = np.zeros((2 * _TERMS + 1, 2 * _TERMS + 1))
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


@numba.njit(cache=True, nogil=True)
def _advance(
    phi: Any,
    data: Any,
    fit: Any,
    bound: float,
    step: Any,
    mu: float,
    count: int,
    terms: int,
    error: Any,
    slack: Any,
    weight: Any,
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


@numba.njit(cache=True, nogil=True)
def _minimax(
    phi: Any,
    data: Any,
    count: int,
    terms: int,
    error: Any,
    weight: Any,
    slack: Any,
    fit: Any,
) -> int:
    """Whether some polynomial stays below an error of one at these samples; ``fit`` takes it where so."""
    step = np.zeros(2 * _TERMS + 1)
    current = np.zeros((2, _TERMS))
    weight[:count] = 1.0 / count
    lower, worst = _least_squares(phi, data, weight, count, terms, fit)
    if worst < 1.0:
        return HOLDS
    if lower >= 1.0 + _ROUNDING:
        return FAILS
    current[:] = fit
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
            fit[:] = current
            return HOLDS
        lower, worst = _least_squares(phi, data, weight, count, terms, fit)
        if worst < 1.0:
            return HOLDS
        if lower >= 1.0 + _ROUNDING:
            return FAILS
        if bound - lower < 0.1 * _ROUNDING:
            break
    return UNDECIDED


@numba.njit(cache=True, nogil=True)
def _squared_errors(phi: Any, data: Any, count: int, terms: int, fit: Any, squared: Any) -> float:
    """Squared error at every sample, and the greatest."""
    worst = 0.0
    for k in range(count):
        east, north = data[k, 0], data[k, 1]
        for a in range(terms):
            east -= phi[k, a] * fit[0, a]
            north -= phi[k, a] * fit[1, a]
        squared[k] = east * east + north * north
        worst = max(worst, squared[k])
    return worst


@numba.njit(cache=True, nogil=True)
def decide(
    t_s: Any,
    position_m: Any,
    first: int,
    end: int,
    degree: int,
    threshold_m: float,
    work: Any,
    polynomial: Any,
) -> int:
    """Whether one polynomial an axis stays closer than the threshold to all samples ``first`` to ``end - 1``.

    ``polynomial`` (2, 4) takes the coefficients found, over the threshold and about the first sample.
    ``work`` (N, 18) is scratch.

    Notes
    -----
    For weights w >= 0 that sum to one, the weighted least-squares optimum has sqrt(sum w e²) <= the smallest
    greatest error. Where that reaches the threshold no polynomial holds, also not over more samples; its own
    greatest error, or any other polynomial's, proves the contrary. The weights come from a primal-dual
    interior-point method: minimise the bound t of all squared errors, w_k (t - e_k²) = mu -> 0. It runs on
    few samples, which are joined by those that its polynomial misses.
    """
    count = end - first
    terms = min(degree + 1, count)
    phi, data, squared, chosen = work[:count, 0:4], work[:count, 4:6], work[:count, 6], work[:count, 7]
    some_phi, some_data = work[:count, 8:12], work[:count, 12:14]
    error, weight, slack = work[:count, 14:16], work[:count, 16], work[:count, 17]
    middle_s = 0.5 * (t_s[first] + t_s[end - 1])
    half_s = max(0.5 * (t_s[end - 1] - t_s[first]), 1e-12)
    for k in range(count):
        _basis((t_s[first + k] - middle_s) / half_s, terms, phi[k])
        data[k, 0] = (position_m[first + k, 0] - position_m[first, 0]) / threshold_m
        data[k, 1] = (position_m[first + k, 1] - position_m[first, 1]) / threshold_m
        weight[k] = 1.0 / count
    polynomial[:] = 0.0
    lower, worst = _least_squares(phi, data, weight, count, terms, polynomial)
    if worst < 1.0 or count <= degree + 1:
        return HOLDS
    if lower >= 1.0 + _ROUNDING:
        return FAILS
    plain = polynomial.copy()
    _squared_errors(phi, data, count, terms, plain, squared)
    # From here on the data are what plain least squares leaves over: of the size of the threshold.
    stride = 1 if count <= 2 * _FEW else count // _FEW
    for k in range(count):
        for a in range(terms):
            data[k, 0] -= phi[k, a] * plain[0, a]
            data[k, 1] -= phi[k, a] * plain[1, a]
        chosen[k] = 1.0 if k % stride == 0 or k == count - 1 or _peak(squared, k, count) else 0.0
    fit = np.zeros((2, _TERMS))
    while True:
        few = 0
        for k in range(count):
            if chosen[k] > 0.0:
                some_phi[few] = phi[k]
                some_data[few] = data[k]
                few += 1
        found = _minimax(some_phi, some_data, few, terms, error, weight, slack, fit)
        if found != HOLDS:
            return found
        polynomial[:] = plain + fit
        if _squared_errors(phi, data, count, terms, fit, squared) < 1.0:
            return HOLDS
        joined = False
        for k in range(count):
            if chosen[k] == 0.0 and squared[k] >= 1.0 and _peak(squared, k, count):
                chosen[k] = 1.0
                joined = True
        if not joined:
            return UNDECIDED


@numba.njit(cache=True, nogil=True)
def _peak(squared: Any, k: int, count: int) -> bool:
    """Whether no neighbour errs more."""
    return (k == 0 or squared[k] >= squared[k - 1]) and (k == count - 1 or squared[k] >= squared[k + 1])


@numba.njit(cache=True, nogil=True)
def _held_until(
    t_s: Any, position_m: Any, first: int, end: int, stop: int, threshold_m: float, polynomial: Any
) -> int:
    """First sample from ``end`` on, at most ``stop``, that the polynomial found for the stretch misses."""
    middle_s = 0.5 * (t_s[first] + t_s[end - 1])
    half_s = max(0.5 * (t_s[end - 1] - t_s[first]), 1e-12)
    phi = np.zeros(_TERMS)
    for i in range(end, stop):
        _basis((t_s[i] - middle_s) / half_s, _TERMS, phi)
        east = (position_m[i, 0] - position_m[first, 0]) / threshold_m
        north = (position_m[i, 1] - position_m[first, 1]) / threshold_m
        for a in range(_TERMS):
            east -= phi[a] * polynomial[0, a]
            north -= phi[a] * polynomial[1, a]
        if not east * east + north * north < 1.0:
            return i
    return stop


@numba.njit(cache=True, nogil=True)
def greedy(
    t_s: Any,
    position_m: Any,
    segments: Any,
    degree: int,
    threshold_m: float,
    hopeful: bool,
    starts: Any,
) -> tuple[int, int]:
    """Cover the gapless parts with the longest stretches that hold: how many, and tests left undecided.

    ``hopeful`` takes an undecided stretch as one that holds. Writes the first sample of each into ``starts``
    (T,). A stretch grows by doubling, then its end is bisected between the longest proved and the shortest
    refused; a polynomial found for a part often holds beyond it, which saves tests.
    """
    longest = 0
    for part in range(segments.size - 1):
        longest = max(longest, segments[part + 1] - segments[part])
    work = np.empty((longest, 18))
    polynomial = np.zeros((2, _TERMS))
    found = undecided = 0
    for part in range(segments.size - 1):
        first, stop = segments[part], segments[part + 1]
        while first < stop:
            starts[found] = first
            found += 1
            # `held` is a proved end; `failed` the smallest refused one.
            held, failed = min(first + degree + 1, stop), stop + 1
            while held < failed - 1:
                reached = held - first
                trial = min(first + 2 * reached, stop) if failed > stop else (held + failed) // 2
                found_out = decide(t_s, position_m, first, trial, degree, threshold_m, work, polynomial)
                if found_out == UNDECIDED:
                    undecided += 1
                if found_out == HOLDS:
                    ahead = min(failed - 1, stop)
                    held = _held_until(t_s, position_m, first, trial, ahead, threshold_m, polynomial)
                elif found_out == UNDECIDED and hopeful:
                    held = trial
                else:
                    failed = trial
            first = held
    return found, undecided
