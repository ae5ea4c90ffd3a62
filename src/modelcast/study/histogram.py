"""Weighted counts in bins that follow the bits of single precision: what pools keep of millions of errors.

A histogram merges with another one in any order to the same counts, sums included, because all of them are
whole numbers; and it never grows beyond its bins, whatever is added.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from modelcast.core.arrays import FloatArray, IntArray, SingleArray
from modelcast.study import metrics_kernels as kernels

__all__ = ["BIN_RATIO", "MILLIONTHS", "SMALLEST", "Histogram", "millionths"]

MILLIONTHS = 1_000_000
"""Sums and times are kept as whole millionths: micrometres, microseconds."""

BIN_RATIO = 2.0**-9
"""What a quantile may be off by at most, as a share of itself: the widest bin over its lower edge."""

SMALLEST = 2.0**-20
"""Sizes between zero and this share one bin, so that a quantile below it is off by as much at most."""


_OCTAVE = 512
"""Counts grow by so many bins, so that they seldom do."""


def millionths(value: float) -> int:
    """A number as whole millionths, the nearest.

    Parameters
    ----------
    value
        Finite.
    """
    return round(value * MILLIONTHS)


def _no_counts() -> IntArray:
    return np.zeros(0, dtype=np.int64)


@dataclass(slots=True)
class Histogram:
    """Weighted counts on bins that are at most 0.2 % wide.

    A quantile is read from the bin that holds it, linear inside, and never above the largest size. So it
    errs by at most `BIN_RATIO` of itself, and below `SMALLEST` by at most that. Exact zeros have a bin of
    their own, and the largest size is kept as it is.

    Parameters
    ----------
    first
        The bin that `counts` begins with.
    counts
        Weight in each bin, from the first to the last in use (in whole octaves).
    weight
        Weight of all.
    total
        Weighted sum of the sizes, in millionths: each call of `add` rounds once.
    largest
        The largest size; 0 where nothing was counted.
    """

    first: int = 0
    counts: IntArray = field(default_factory=_no_counts)
    weight: int = 0
    total: int = 0
    largest: float = 0.0

    def add(self, values: FloatArray | SingleArray, weight: int) -> None:
        """Count the sizes of values, NaN left out.

        Parameters
        ----------
        values
            Any shape, in single or double precision (then rounded to single).
        weight
            Weight of each value, a positive whole number: microseconds, or 1.
        """
        flat = np.ascontiguousarray(values, dtype=np.float32).reshape(-1)
        low, high, seen, total, largest = kernels.bins_used(flat)
        if seen == 0:
            return
        self._reach(low, high + 1)
        kernels.count(flat, weight, self.first, self.counts)
        self.weight += seen * weight
        self.total += millionths(total) * weight
        self.largest = max(self.largest, largest)

    def merge(self, other: "Histogram") -> None:
        """Add another's counts.

        Parameters
        ----------
        other
            It stays as it is.
        """
        if other.counts.size:
            self._reach(other.first, other.first + other.counts.size)
            at = other.first - self.first
            self.counts[at : at + other.counts.size] += other.counts
        self.weight += other.weight
        self.total += other.total
        self.largest = max(self.largest, other.largest)

    @classmethod
    def merged(cls, parts: Sequence["Histogram"]) -> "Histogram":
        """The histogram of all that several hold.

        Parameters
        ----------
        parts
            They stay as they are.
        """
        found = cls()
        for part in parts:
            found.merge(part)
        return found

    @property
    def mean(self) -> float:
        """Weighted mean of the sizes; NaN where nothing was counted."""
        return self.total / (self.weight * MILLIONTHS) if self.weight else float("nan")

    def quantile(self, probability: float) -> float:
        """One quantile, as `quantiles` gives it.

        Parameters
        ----------
        probability
            0..1.
        """
        return float(self.quantiles([probability])[0])

    def quantiles(self, probabilities: npt.ArrayLike) -> FloatArray:
        """The smallest size at which the weighted distribution reaches each probability.

        Parameters
        ----------
        probabilities
            Each in 0..1, (Q,).

        Returns
        -------
        FloatArray
            (Q,); NaN where nothing was counted.
        """
        wanted = np.asarray(probabilities, dtype=np.float64)
        if not self.weight:
            return np.full(wanted.size, np.nan)
        reached = np.cumsum(self.counts)
        targets = np.maximum(wanted * float(self.weight) * (1.0 - 1e-12), 0.5)
        places = np.minimum(reached.searchsorted(targets), reached.size - 1)
        low, high = kernels.bin_edges(self.first + places)
        high = np.minimum(high, self.largest)
        held = self.counts[places]
        # Where the running weight is the target, within the bin.
        return low + (high - low) * (targets - (reached[places] - held)) / held

    def _reach(self, first: int, stop: int) -> None:
        """Make `counts` hold these bins too."""
        first, stop = first // _OCTAVE * _OCTAVE, -(-stop // _OCTAVE) * _OCTAVE
        if self.counts.size:
            first, stop = min(first, self.first), max(stop, self.first + self.counts.size)
            if (first, stop) == (self.first, self.first + self.counts.size):
                return
        counts = np.zeros(stop - first, dtype=np.int64)
        if self.counts.size:
            at = self.first - first
            counts[at : at + self.counts.size] = self.counts
        self.first, self.counts = first, counts
