"""Compiled bins for streamed histograms: 32 an octave, read off the bits of a single-precision number."""

from typing import Any

import numpy as np

from modelcast.core.kernel import kernel

__all__ = ["BINS", "bin_of", "lower_edge"]

_SHIFT = 18  # leaves 5 bits of the mantissa: 32 bins an octave, 2.2 % wide
_FIRST = (127 - 14) << 5  # bin of 2**-14
BINS = (28 << 5) + 2
"""Bin 0 holds everything below 2**-14; the last bin everything from 2**14 on."""


@kernel(inlined=True)
def bin_of(value: float) -> int:
    """Bin of a number that is not negative."""
    at: Any = (np.float32(value).view(np.int32) >> _SHIFT) - _FIRST + 1
    return min(max(at, 0), BINS - 1)


def lower_edge(at: Any) -> Any:
    """Where bins begin, any shape; 0 for the first."""
    bits = (np.maximum(np.asarray(at), 1) - 1 + _FIRST) << _SHIFT
    edges = bits.astype(np.int32).view(np.float32).astype(np.float64)
    return np.where(np.asarray(at) == 0, 0.0, edges)
