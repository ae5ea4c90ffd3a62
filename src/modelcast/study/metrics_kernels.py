"""Compiled counting into bins that follow the bits of a single-precision number.

Bin 0 holds exact zeros, bin 1 what lies between zero and ``2**-20`` (a millionth), bin 2 and those after it
512 bins an octave from there to ``2**17``, and the last bin everything from there on.
"""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import Float32Vector, FloatVector, IntVector

__all__ = ["BINS", "bin_edges", "bins_used", "count"]

_SHIFT = 14  # leaves 9 bits of the mantissa: 512 bins an octave
_LOWEST, _HIGHEST = -20, 17  # powers of two
_BEFORE = ((127 + _LOWEST) << 9) - 2  # what turns the bits of 2**-20 into bin 2
BINS = ((_HIGHEST - _LOWEST) << 9) + 3
"""How many bins there are."""


@kernel(inlined=True)
def _bin(bits: int) -> int:
    """The bin of a size whose bits these are."""
    return 0 if bits == 0 else min(max((bits >> _SHIFT) - _BEFORE, 1), BINS - 1)


@kernel
def bins_used(values: Float32Vector) -> tuple[int, int, int, float, float]:
    """Find the lowest and highest bin of the values' sizes, how many they are, their sum and the largest.

    NaN is left out; without any value the lowest bin is above the highest.
    """
    low, high, seen = BINS, -1, 0
    total, largest = 0.0, 0.0
    for value in values:
        if np.isnan(value):
            continue
        size = np.float32(abs(value))
        at = _bin(int(size.view(np.int32)))
        low, high = min(low, at), max(high, at)
        largest = max(largest, float(size))
        total += float(size)
        seen += 1
    return low, high, seen, total, largest


@kernel
def count(values: Float32Vector, weight: int, first: int, counts: IntVector) -> None:
    """Add ``weight`` for each size to ``counts``, whose first bin is ``first``; NaN is left out."""
    for value in values:
        if not np.isnan(value):
            counts[_bin(int(np.float32(abs(value)).view(np.int32))) - first] += weight


def bin_edges(at: IntVector) -> tuple[FloatVector, FloatVector]:
    """Between which sizes each bin lies, (Q,) both; the last one has no upper edge."""
    low, high = (
        np.ascontiguousarray((at + step + _BEFORE) << _SHIFT, dtype=np.int32)
        .view(np.float32)
        .astype(np.float64)
        for step in (0, 1)
    )
    low[at <= 1] = 0.0
    high[at == 0] = 0.0
    high[at == BINS - 1] = np.inf
    return low, high
