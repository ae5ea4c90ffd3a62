"""Quantiles weighted by time, and a mergeable histogram for the secondary figures."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy import special

from modelcast.core.arrays import FloatArray, SingleArray
from modelcast.study import metrics_kernels as kernels

__all__ = ["LANE_M", "Histogram", "confidence_limits", "quantiles"]

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
    reach = float(special.stdtrit(values.size - 1, 0.975) * values.std(ddof=1) / np.sqrt(values.size))
    centre = float(values.mean())
    return centre - reach, centre + reach


class Histogram:
    """Weighted counts on bins that are about 0.2 % wide, so that it merges and never grows.

    Quantiles read from it err by at most 0.1 %. Values below 0.06 mm (or 0.06 ms) count as zero,
    values from 16 384 on as that.
    """

    def __init__(self) -> None:
        self.counts = np.zeros(kernels.BINS)
        self.weight = 0.0
        self.total = 0.0

    def add(self, values: FloatArray | SingleArray, weight: float) -> None:
        """Count the sizes of values, NaN left out.

        Parameters
        ----------
        values
            Any shape, in single or double precision.
        weight
            Weight of each value.
        """
        weighed, total = kernels.count(
            np.ascontiguousarray(values, dtype=np.float32).reshape(-1), weight, self.counts
        )
        self.weight += weighed
        self.total += total

    def merge(self, other: "Histogram") -> None:
        """Add another's counts."""
        self.counts += other.counts
        self.weight += other.weight
        self.total += other.total

    @property
    def mean(self) -> float:
        """Weighted mean of the sizes; NaN where nothing was counted."""
        return self.total / self.weight if self.weight > 0 else float("nan")

    def quantile(self, probability: float) -> float:
        """Middle of the bin that holds the quantile; NaN where nothing was counted."""
        if self.weight <= 0:
            return float("nan")
        at = kernels.bin_of(self.counts, probability * float(self.counts.sum()) * (1.0 - 1e-12))
        return kernels.bin_middle(at)
