"""Compiled loss of the learned sub-model: how long a path holds, softened so that it has a slope."""

from math import exp, log, sqrt

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatCube, FloatMatrix, FloatVector

__all__ = ["FORGIVEN_S", "survival_slopes"]

FORGIVEN_S = 0.1
"""Added to every survival [s]: a sender looks once a sample, and no survival is shorter than that."""

_LEAST_ERROR_M = 1e-3


@kernel
def survival_slopes(
    coefficients: FloatMatrix,
    errors_m: FloatCube,
    basis: FloatMatrix,
    steps_s: FloatVector,
    thresholds_m: FloatVector,
    softness: float,
    slopes: FloatMatrix,
) -> float:
    """Mean loss of a batch, and the slopes of each row's own loss by its coefficients.

    ``coefficients`` (B, 2k) along and to the left, ``errors_m`` (B, H, 2) what they are to correct, ``basis``
    (H, k), ``steps_s`` (H,) the time each horizon stands for. The error so far, E_h, is the greatest error at
    any horizon up to h. A path holds at h with weight 1/(1 + exp((E_h - th)/(softness·th))), and its survival
    L is the sum of weights times steps. The loss of a row is the mean of -log(L + `FORGIVEN_S`) over the
    thresholds. Writes ``slopes`` (B, 2k).
    """
    rows, horizons = errors_m.shape[0], errors_m.shape[1]
    k = basis.shape[1]
    count = thresholds_m.size
    off = np.empty((horizons, 2))
    error = np.empty(horizons)
    worst = np.empty(horizons, dtype=np.int64)
    weight = np.empty((horizons, count))
    by_error = np.empty(horizons)
    total = 0.0
    for b in range(rows):
        for h in range(horizons):
            along, left = -errors_m[b, h, 0], -errors_m[b, h, 1]
            for j in range(k):
                along += coefficients[b, j] * basis[h, j]
                left += coefficients[b, k + j] * basis[h, j]
            off[h, 0], off[h, 1] = along, left
            error[h] = sqrt(along * along + left * left + _LEAST_ERROR_M * _LEAST_ERROR_M)
            worst[h] = h if h == 0 or error[h] >= error[worst[h - 1]] else worst[h - 1]
            by_error[h] = 0.0
        for i in range(count):
            scale_m = softness * thresholds_m[i]
            survival_s = FORGIVEN_S
            for h in range(horizons):
                over = min((error[worst[h]] - thresholds_m[i]) / scale_m, 60.0)
                weight[h, i] = 1.0 / (1.0 + exp(over))
                survival_s += steps_s[h] * weight[h, i]
            total -= log(survival_s) / count
            for h in range(horizons):
                one = weight[h, i]
                by_error[worst[h]] += steps_s[h] * one * (1.0 - one) / (survival_s * scale_m * count)
        for j in range(2 * k):
            slopes[b, j] = 0.0
        for h in range(horizons):
            if by_error[h] > 0.0:
                pull = by_error[h] / error[h]
                for j in range(k):
                    slopes[b, j] += pull * off[h, 0] * basis[h, j]
                    slopes[b, k + j] += pull * off[h, 1] * basis[h, j]
    return total / rows
