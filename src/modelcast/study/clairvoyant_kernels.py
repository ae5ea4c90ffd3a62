"""Compiled clairvoyant reference: the longest stretches of a track that one polynomial an axis holds."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    FloatMatrix,
    FloatVector,
    IntVector,
    StridedFloatMatrix,
    StridedFloatVector,
)
from modelcast.study.minimax_kernels import (
    FAILS,
    HOLDS,
    ROUNDING,
    TERMS,
    UNDECIDED,
    basis,
    least_squares,
    minimax,
)

__all__ = ["decide", "greedy"]

_FEW = 12


@kernel
def _squared_errors(
    phi: StridedFloatMatrix,
    data: StridedFloatMatrix,
    count: int,
    terms: int,
    fit: FloatMatrix,
    squared: StridedFloatVector,
) -> float:
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


@kernel
def decide(
    t_s: FloatVector,
    position_m: FloatMatrix,
    first: int,
    end: int,
    degree: int,
    threshold_m: float,
    work: FloatMatrix,
    polynomial: FloatMatrix,
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
        basis((t_s[first + k] - middle_s) / half_s, terms, phi[k])
        data[k, 0] = (position_m[first + k, 0] - position_m[first, 0]) / threshold_m
        data[k, 1] = (position_m[first + k, 1] - position_m[first, 1]) / threshold_m
        weight[k] = 1.0 / count
    polynomial[:] = 0.0
    lower, worst = least_squares(phi, data, weight, count, terms, polynomial)
    if worst < 1.0 or count <= degree + 1:
        return HOLDS
    if lower >= 1.0 + ROUNDING:
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
    fit = np.zeros((2, TERMS))
    while True:
        few = 0
        for k in range(count):
            if chosen[k] > 0.0:
                for a in range(terms):
                    some_phi[few, a] = phi[k, a]
                some_data[few, 0], some_data[few, 1] = data[k, 0], data[k, 1]
                few += 1
        found = minimax(some_phi, some_data, few, terms, error, weight, slack, fit)
        if found != HOLDS:
            return found
        for a in range(TERMS):
            polynomial[0, a], polynomial[1, a] = plain[0, a] + fit[0, a], plain[1, a] + fit[1, a]
        if _squared_errors(phi, data, count, terms, fit, squared) < 1.0:
            return HOLDS
        joined = False
        for k in range(count):
            if chosen[k] == 0.0 and squared[k] >= 1.0 and _peak(squared, k, count):
                chosen[k] = 1.0
                joined = True
        if not joined:
            return UNDECIDED


@kernel
def _peak(squared: StridedFloatVector, k: int, count: int) -> bool:
    """Whether no neighbour errs more."""
    return (k == 0 or squared[k] >= squared[k - 1]) and (k == count - 1 or squared[k] >= squared[k + 1])


@kernel
def _held_until(
    t_s: FloatVector,
    position_m: FloatMatrix,
    first: int,
    end: int,
    stop: int,
    threshold_m: float,
    polynomial: FloatMatrix,
) -> int:
    """First sample from ``end`` on, at most ``stop``, that the polynomial found for the stretch misses."""
    middle_s = 0.5 * (t_s[first] + t_s[end - 1])
    half_s = max(0.5 * (t_s[end - 1] - t_s[first]), 1e-12)
    phi = np.zeros(TERMS)
    for i in range(end, stop):
        basis((t_s[i] - middle_s) / half_s, TERMS, phi)
        east = (position_m[i, 0] - position_m[first, 0]) / threshold_m
        north = (position_m[i, 1] - position_m[first, 1]) / threshold_m
        for a in range(TERMS):
            east -= phi[a] * polynomial[0, a]
            north -= phi[a] * polynomial[1, a]
        if not east * east + north * north < 1.0:
            return i
    return stop


@kernel
def greedy(
    t_s: FloatVector,
    position_m: FloatMatrix,
    segments: IntVector,
    degree: int,
    threshold_m: float,
    hopeful: bool,
    starts: IntVector,
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
    polynomial = np.zeros((2, TERMS))
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
