"""Quantiles weighted by time, and what the percentiles of runs say of their mean."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from modelcast.core.arrays import FloatArray, SingleArray
from modelcast.study.student import student_reach

__all__ = ["LANE_M", "confidence_limits", "quantiles"]

_SAME_WEIGHT = 1e-6
"""Median steps of one recorder differ by rounding: they count as one weight, which costs a tenth as much."""

LANE_M = 1.5
"""An error beyond this may put a vehicle in another lane [m]: about half a lane's width."""


def quantiles(
    sorted_values: Sequence[FloatArray] | Sequence[SingleArray],
    weights: Sequence[float],
    probabilities: npt.ArrayLike,
) -> FloatArray:
    """Quantiles of the union of sorted arrays, each array's values weighing the same.

    The quantile at p is the smallest value whose weighted empirical distribution reaches p. Weights that
    differ by less than a millionth count as the same.

    Parameters
    ----------
    sorted_values
        Arrays sorted upwards, without NaN.
    weights
        Weight of each array's values: the time one sample stands for [s].
    probabilities
        Each in 0..1, (Q,).

    Returns
    -------
    FloatArray
        (Q,); NaN where there is no value at all.

    Examples
    --------
    >>> import numpy as np
    >>> quantiles([np.array([1.0, 2.0, 3.0, 4.0])], [0.1], [0.5, 0.9])
    array([2., 4.])
    >>> quantiles([np.array([1.0, 2.0]), np.array([10.0])], [0.1, 0.2], [0.5, 0.75])
    array([ 2., 10.])
    """
    wanted = np.asarray(probabilities, dtype=np.float64)
    kept = [(values, weight) for values, weight in zip(sorted_values, weights, strict=True) if values.size]
    if not kept:
        return np.full(wanted.size, np.nan)
    shares = [weight for _, weight in kept]
    if max(shares) - min(shares) <= _SAME_WEIGHT * max(shares):
        merged = kept[0][0] if len(kept) == 1 else np.sort(np.concatenate([values for values, _ in kept]))
        at = np.ceil(wanted * merged.size * (1.0 - 1e-12)).astype(np.int64) - 1
        return merged[np.clip(at, 0, merged.size - 1)].astype(np.float64)
    merged = np.concatenate([values for values, _ in kept])
    share = np.concatenate([np.full(values.size, weight) for values, weight in kept])
    order = np.argsort(merged, kind="stable")
    reached = np.cumsum(share[order])
    targets = wanted * float(reached[-1]) * (1.0 - 1e-12)
    at = np.array([int(reached.searchsorted(float(target))) for target in targets])
    return merged[order][np.minimum(at, merged.size - 1)].astype(np.float64)


def confidence_limits(values: FloatArray) -> tuple[float | None, float | None]:
    """95 % Student-t limits of the mean of independent values; None where there are fewer than two.

    Parameters
    ----------
    values
        One value a run, (K,).

    Examples
    --------
    >>> import numpy as np
    >>> low, high = confidence_limits(np.array([1.0, 2.0, 3.0]))
    >>> round(low, 3), round(high, 3)
    (-0.484, 4.484)
    """
    values = values[np.isfinite(values)]
    if values.size < 2:
        return None, None
    reach = float(student_reach(values.size - 1) * values.std(ddof=1) / np.sqrt(values.size))
    centre = float(values.mean())
    return centre - reach, centre + reach
