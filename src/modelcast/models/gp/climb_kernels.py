"""Compiled search for the likelihood's maximum: the best of many starts, then quasi-Newton steps in bounds.

The starts do not depend on the data: of each the inverse covariance, its determinant and the likelihood's
expected curvature (Fisher information) are tabled, at a white noise of 1 m². The scale that a window likes
best is found in closed form, so that a start costs one quadratic form. From the best few go some BFGS steps
in the logarithms, begun with the expected curvature, and the rest from the best of these. Hyper-parameters
that press against a bound rest there. Where rounding leaves a start without a Cholesky factor its white noise
is raised until there is one.
"""

import numpy as np

from modelcast.core.exponential_kernels import fast_exp, fast_log
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector
from modelcast.models.gp.expression_layout import (
    AT_BOUNDS,
    AT_CURVATURES,
    AT_DETERMINANTS,
    AT_INVERSES,
    AT_POINTS,
    AT_STARTS,
)
from modelcast.models.gp.lag_kernels import Work
from modelcast.models.gp.likelihood_kernels import cost_at, slopes_at

__all__ = ["search", "settle"]

_MOST_CLIMBED = 3
"""Starts from which steps are taken, at most; one less than there are hyper-parameters."""
_FIRST_STEPS = 3
_MOST_STEPS = 60
_MOST_HALVINGS = 12
_LONGEST = 3.0
"""Longest step of a hyper-parameter's logarithm."""
_DECREASE = 5e-5
"""The search ends where a step is expected to lower the cost by less."""
_NOISE_STEP = 2.3
"""Of the white noise's logarithm, about a factor of ten, where there is no Cholesky factor."""
_LEAST_SCALE_M2 = 1e-300
_RIDGE = 1e-2
"""Added to the expected curvature, which may be flat in some direction."""


@kernel(fast=True)
def rank(y: FloatVector, constants: FloatVector, starts: FloatMatrix) -> None:
    """Write the best starts, best first: cost, index and the logarithm of the best scale (S, 3)."""
    n = y.size
    size = n * (n + 1) // 2
    pairs = np.empty(size)
    at = 0
    for i in range(n):
        for j in range(i + 1):
            pairs[at] = y[i] * y[j]
            at += 1
    bounds = int(constants[AT_BOUNDS])
    count = (int(constants[AT_INVERSES]) - bounds) // 3
    low = constants[bounds + count - 1]
    high = constants[bounds + 2 * count - 1]
    inverses = int(constants[AT_INVERSES])
    determinants = int(constants[AT_DETERMINANTS])
    last = starts.shape[0] - 1
    for k in range(last + 1):
        starts[k, 0] = np.inf
        starts[k, 1] = 0.0
        starts[k, 2] = low
    for g in range(int(constants[AT_STARTS])):
        square = 0.0
        row = constants[inverses + g * size : inverses + (g + 1) * size]
        for k in range(size):
            square += row[k] * pairs[k]
        # A quadratic form that is not positive is rounding: a window without any motion.
        scale = min(max(fast_log(max(square / n, _LEAST_SCALE_M2)), low), high)
        cost = constants[determinants + g] + n * scale + square * fast_exp(-scale)
        if cost < starts[last, 0]:
            k = last
            while k > 0 and cost < starts[k - 1, 0]:
                for column in range(3):
                    starts[k, column] = starts[k - 1, column]
                k -= 1
            starts[k, 0] = cost
            starts[k, 1] = g
            starts[k, 2] = scale


@kernel(fast=True)
def free_step(x: FloatVector, low: FloatVector, high: FloatVector, work: Work) -> float:
    """Write the quasi-Newton step of the free hyper-parameters; returns the decrease it promises.

    Solves by a Cholesky factor of the curvature; a pivot that is not positive is taken as the ridge.
    """
    count = x.size
    slopes = work.slopes[0]
    step = work.points[1]
    curvature = work.curvature[0]
    factor = work.curvature[1]
    for i in range(count):
        held = (x[i] <= low[i] and slopes[i] > 0.0) or (x[i] >= high[i] and slopes[i] < 0.0)
        step[i] = 0.0 if held else -slopes[i]
        for j in range(i):
            other = factor[j, j] == 0.0
            rest = 0.0 if held or other else curvature[i, j]
            if not (held or other):
                for k in range(j):
                    rest -= factor[i, k] * factor[j, k]
                rest /= factor[j, j]
            factor[i, j] = rest
        pivot = curvature[i, i]
        for k in range(i):
            pivot -= factor[i, k] * factor[i, k]
            step[i] -= factor[i, k] * step[k]
        factor[i, i] = 0.0 if held else np.sqrt(max(pivot, _RIDGE))
        step[i] = 0.0 if held else step[i] / factor[i, i]
    for i in range(count - 1, -1, -1):
        if factor[i, i] > 0.0:
            for k in range(i + 1, count):
                step[i] -= factor[k, i] * step[k]
            step[i] /= factor[i, i]
    longest = _LONGEST
    for i in range(count):
        longest = max(longest, abs(step[i]))
    promised = 0.0
    for i in range(count):
        step[i] *= _LONGEST / longest
        promised -= slopes[i] * step[i]
    return promised


@kernel(fast=True)
def bend(moved: FloatVector, x: FloatVector, curvature: FloatMatrix, slopes: FloatMatrix) -> None:
    """Update the curvature by BFGS for the move from ``x`` to ``moved``, damped (Powell 1978)."""
    count = x.size
    s = np.empty(count)
    b = np.empty(count)
    along = 0.0
    bent = 0.0
    for i in range(count):
        s[i] = moved[i] - x[i]
    for i in range(count):
        total = 0.0
        for j in range(count):
            total += curvature[i, j] * s[j]
        b[i] = total
        bent += s[i] * total
        along += s[i] * (slopes[1, i] - slopes[0, i])
    if not bent > 0.0:
        return
    share = 1.0 if along >= 0.2 * bent else 0.8 * bent / (bent - along)
    along = share * along + (1.0 - share) * bent
    for i in range(count):
        left = share * (slopes[1, i] - slopes[0, i]) + (1.0 - share) * b[i]
        for j in range(count):
            right = share * (slopes[1, j] - slopes[0, j]) + (1.0 - share) * b[j]
            curvature[i, j] += left * right / along - b[i] * b[j] / bent


@kernel(fast=True)
def settle(x: FloatVector, y: FloatVector, constants: FloatVector, work: Work) -> float:
    """Move ``x`` to where the covariance has a Cholesky factor, if it is not there; returns the cost.

    The white noise rises, at most to its bound: there the tables of `pack_expression` have every start sound.
    """
    count = x.size
    bounds = int(constants[AT_BOUNDS])
    high = constants[bounds + 2 * count - 1]
    cost = cost_at(x, y, constants, work)
    while cost == np.inf and x[count - 1] < high:
        x[count - 1] = min(x[count - 1] + _NOISE_STEP, high)
        cost = cost_at(x, y, constants, work)
    return cost


@kernel(fast=True)
def climb(x: FloatVector, y: FloatVector, constants: FloatVector, work: Work, most: int) -> float:
    """Move ``x`` to a maximum of the likelihood by the curvature in ``work``; returns the cost there."""
    count = x.size
    bounds = int(constants[AT_BOUNDS])
    low = constants[bounds : bounds + count]
    high = constants[bounds + count : bounds + 2 * count]
    step = work.points[1]
    trial = work.points[2]
    cost = settle(x, y, constants, work)
    slopes_at(x, constants, work, work.slopes[0])
    for _ in range(most):
        if free_step(x, low, high, work) < _DECREASE:
            break
        share = 1.0
        new = np.inf
        lower = False
        for _ in range(_MOST_HALVINGS):
            promised = 0.0
            for i in range(count):
                trial[i] = min(max(x[i] + share * step[i], low[i]), high[i])
                promised += work.slopes[0, i] * (trial[i] - x[i])
            new = cost_at(trial, y, constants, work)
            if new <= cost + 1e-4 * promised:
                lower = True
                break
            share *= 0.3
        if not lower:
            break
        slopes_at(trial, constants, work, work.slopes[1])
        bend(trial, x, work.curvature[0], work.slopes)
        cost = new
        for i in range(count):
            x[i] = trial[i]
            work.slopes[0, i] = work.slopes[1, i]
    return cost


@kernel(fast=True)
def search(y: FloatVector, constants: FloatVector, work: Work) -> None:
    """Find the best hyper-parameters of one axis, into ``work.points[3]``, and their cost."""
    count = work.points.shape[1]
    bounds = int(constants[AT_BOUNDS])
    x = work.points[0]
    best = work.points[3]
    least = np.inf
    starts = np.empty((min(count - 1, _MOST_CLIMBED), 3))
    rank(y, constants, starts)
    for k in range(starts.shape[0]):
        taken = int(starts[k, 1])
        logarithm = starts[k, 2]
        point = int(constants[AT_POINTS]) + taken * count
        curvature = int(constants[AT_CURVATURES]) + taken * count * count
        for i in range(count):
            moved = constants[point + i] + logarithm * constants[bounds + 2 * count + i]
            x[i] = min(max(moved, constants[bounds + i]), constants[bounds + count + i])
            for j in range(count):
                work.curvature[0, i, j] = constants[curvature + i * count + j]
            work.curvature[0, i, i] += _RIDGE
        cost = climb(x, y, constants, work, _FIRST_STEPS)
        if cost < least or k == 0:
            least = cost
            for i in range(count):
                best[i] = x[i]
                for j in range(count):
                    work.curvature[2, i, j] = work.curvature[0, i, j]
    for i in range(count):
        for j in range(count):
            work.curvature[0, i, j] = work.curvature[2, i, j]
    work.costs[0] = climb(best, y, constants, work, _MOST_STEPS)
