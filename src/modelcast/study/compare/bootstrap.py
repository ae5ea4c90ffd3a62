"""Paired bootstrap over trips: how far a pooled figure might move had other trips been recorded.

Every resample draws as many trips (or whole routes) as there are, with replacement. All figures of all
candidates are computed on the same resamples, so that differences are between the same trips.
"""

from collections.abc import Sequence

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray, SingleArray
from modelcast.study.metrics import quantiles

__all__ = ["Limits", "limits", "quantile_resamples", "ratio_resamples", "resample_weights"]

Limits = tuple[float | None, float | None]
"""Lower and upper end of a 95 % interval; None where there is but one thing to draw from."""

_TAIL = 0.025
_LEVELS = 1000
_SMALLEST_LEVEL_M = 1e-3


def resample_weights(clusters: IntArray, resamples: int, rng: np.random.Generator) -> FloatArray:
    """How often each resample draws each trip, (R, N).

    Parameters
    ----------
    clusters
        Trips of one number are drawn together, (N,), from 0.
    resamples
        R.
    rng
        Draws them.

    Examples
    --------
    >>> import numpy as np
    >>> drawn = resample_weights(np.array([0, 0, 1]), 1000, np.random.default_rng(0))
    >>> drawn.shape, bool((drawn[:, 0] == drawn[:, 1]).all()), bool((drawn[:, 1:].sum(axis=1) == 2).all())
    ((1000, 3), True, True)
    """
    count = int(clusters.max(initial=-1)) + 1
    drawn = rng.multinomial(count, np.full(count, 1.0 / count), size=resamples)
    return drawn[:, clusters].astype(np.float64)


def ratio_resamples(weights: FloatArray, numerator: FloatArray, denominator: FloatArray) -> FloatArray:
    """The ratio of sums in every resample, (R,).

    Parameters
    ----------
    weights
        As `resample_weights` returns them, (R, N).
    numerator, denominator
        One value a trip, (N,).
    """
    return (weights @ numerator) / (weights @ denominator)


def limits(values: FloatArray, clusters: IntArray) -> Limits:
    """The middle 95 % of resampled values; no limits where there is but one cluster to draw.

    Parameters
    ----------
    values
        One a resample, (R,).
    clusters
        As in `resample_weights`, (N,).
    """
    if np.unique(clusters).size < 2 or not np.isfinite(values).all():
        return None, None
    low, high = np.quantile(values, [_TAIL, 1.0 - _TAIL])
    return float(low), float(high)


def quantile_resamples(
    weights: FloatArray,
    by_trip_m: Sequence[Sequence[SingleArray]],
    shares_s: Sequence[float],
    probabilities: Sequence[float],
) -> FloatArray:
    """Quantiles of the tracking error pooled over the trips of every resample, (R, Q) [m].

    Parameters
    ----------
    weights
        As `resample_weights` returns them, (R, N).
    by_trip_m
        For each trip its sorted arrays of errors, one a seed [m].
    shares_s
        The time one sample of each trip stands for [s].
    probabilities
        Q of them, rising.

    Notes
    -----
    A quantile of pooled samples lies between the smallest and the largest of the same quantile of the parts.
    Distributions are counted at 1,000 levels, evenly spaced on a logarithmic scale between these, so that
    a resample costs a few sums; what is returned is at most one level too high (under 1 % as a rule).
    """
    ends = [
        quantiles(rows, [share] * len(rows), [probabilities[0], probabilities[-1]])
        for rows, share in zip(by_trip_m, shares_s, strict=True)
        if sum(row.size for row in rows)
    ]
    if not ends:
        return np.full((weights.shape[0], len(probabilities)), np.nan)
    low_m = max(min(float(end[0]) for end in ends), _SMALLEST_LEVEL_M)
    high_m = max(low_m, *(float(end[1]) for end in ends))
    levels_m = np.geomspace(low_m, high_m, _LEVELS)
    levels_m[-1] = high_m * (1.0 + 1e-6)  # single-precision errors must not lie above the last level
    reached = np.stack(
        [
            share * np.sum([np.searchsorted(row, levels_m, side="right") for row in rows], axis=0)
            for rows, share in zip(by_trip_m, shares_s, strict=True)
        ]
    )
    total = np.array(
        [share * sum(row.size for row in rows) for rows, share in zip(by_trip_m, shares_s, strict=True)]
    )
    found = [_first_reaching(weights, reached, p * (1.0 - 1e-12) * (weights @ total)) for p in probabilities]
    return levels_m[np.stack(found, axis=1)]


def _first_reaching(weights: FloatArray, reached: FloatArray, wanted: FloatArray) -> IntArray:
    """Index of the first level at which each resample's share of time reaches what is wanted, (R,).

    Found by bisection, so that only a few of the (R, levels) sums are ever made.
    """
    by_level = np.ascontiguousarray(reached.T)
    low = np.full(wanted.size, -1, dtype=np.int64)
    high = np.full(wanted.size, by_level.shape[0] - 1, dtype=np.int64)
    while (high - low).max(initial=0) > 1:
        middle = (low + high) // 2
        enough = np.einsum("rn,rn->r", weights, by_level[middle]) >= wanted
        low, high = np.where(enough, low, middle), np.where(enough, middle, high)
    return high
