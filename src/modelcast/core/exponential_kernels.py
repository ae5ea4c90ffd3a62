"""Compiled exponential that is inlined: half the time of a library's, to eleven digits."""

from math import factorial

import numpy as np

from modelcast.core.kernel import kernel

__all__ = ["LOWEST", "fast_exp"]

LOWEST = -700.0
"""Below this `fast_exp` returns 0."""

_PER_TWO = 1.0 / np.log(2.0)
_TWO_HIGH = 0.693147180369123816490  # ln 2 to 33 bits: its product with a whole number is exact
_TWO_LOW = np.log(2.0) - _TWO_HIGH
_C2, _C3, _C4, _C5, _C6, _C7, _C8, _C9 = (1.0 / factorial(n) for n in range(2, 10))


@kernel(inlined=True)
def fast_exp(x: float) -> float:
    """Return e to the power ``x``, at most 700, with a relative error below 1e-11.

    The power of two is split off; the rest, at most ln 2 / 2, goes through nine terms of the series.
    """
    if not x > LOWEST:
        return 0.0
    twos = np.floor(x * _PER_TWO + 0.5)
    r = (x - twos * _TWO_HIGH) - twos * _TWO_LOW
    series = _C2 + r * (_C3 + r * (_C4 + r * (_C5 + r * (_C6 + r * (_C7 + r * (_C8 + r * _C9))))))
    power = np.int64((np.int64(twos) + 1023) << 52).view(np.float64)
    return power * (1.0 + r * (1.0 + r * series))
