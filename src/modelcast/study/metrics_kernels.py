"""Compiled counting into bins that follow the bits of a single-precision number."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import Float32Vector, FloatVector

__all__ = ["BINS", "bin_middle", "bin_of", "count"]

_SHIFT = 14  # leaves 9 bits of the mantissa: 512 bins an octave
_FIRST = (127 - 14) << 9  # bin of 2**-14
BINS = (28 << 9) + 2
"""Bin 0 holds everything below 2**-14; the last bin everything from 2**14 on."""


@kernel
def count(values: Float32Vector, weight: float, counts: FloatVector) -> tuple[float, float]:
    """Add the sizes of values to ``counts`` (BINS,); returns their weight and weighted sum."""
    total = 0.0
    seen = 0
    for value in values:
        if np.isnan(value):
            continue
        size = np.float32(abs(value))
        at = (size.view(np.int32) >> _SHIFT) - _FIRST + 1
        counts[min(max(at, 0), BINS - 1)] += weight
        total += float(size)
        seen += 1
    return seen * weight, total * weight


@kernel
def bin_of(counts: FloatVector, target: float) -> int:
    """First bin at which the running sum of ``counts`` reaches the target."""
    reached = 0.0
    for at in range(counts.size):
        reached += counts[at]
        if reached >= target:
            return at
    return counts.size - 1


def bin_middle(at: int) -> float:
    """Middle of a bin."""
    if at == 0:
        return 0.0
    edges = np.array([(at - 1 + _FIRST) << _SHIFT, (at + _FIRST) << _SHIFT], dtype=np.int32)
    low, high = edges.view(np.float32).astype(np.float64)
    return float(0.5 * (low + high))
