"""Compiled exponential and logarithm that are inlined: half the time of a library's, or less.

A loop of them runs several at a time, which a call of a library's prevents.
"""

from math import factorial

import numpy as np

from modelcast.core.kernel import kernel

__all__ = ["LOWEST", "fast_asinh", "fast_exp", "fast_log"]

LOWEST = -700.0
"""Below this `fast_exp` returns 0."""

_PER_TWO = 1.0 / np.log(2.0)
_TWO_HIGH = 0.693147180369123816490  # ln 2 to 33 bits: its product with a whole number is exact
_TWO_LOW = np.log(2.0) - _TWO_HIGH
_C2, _C3, _C4, _C5, _C6, _C7, _C8, _C9 = (1.0 / factorial(n) for n in range(2, 10))
_ROOT_HALF_BITS = int(np.float64(0.5**0.5).view(np.int64))
_L1, _L2, _L3, _L4, _L5, _L6, _L7, _L8, _L9 = (2.0 / (2 * n + 1) for n in range(1, 10))


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


@kernel(inlined=True)
def fast_log(x: float) -> float:
    """Return the natural logarithm of a positive number, with an error below 1e-15 of it or of 1.

    The power of two is split off; the rest m, between the root of a half and the root of two, is
    2 artanh((m - 1) / (m + 1)), of which ten terms are summed. Below 1e-307 the logarithm comes out too low.
    """
    bits = np.float64(x).view(np.int64)
    twos = (bits - _ROOT_HALF_BITS) >> 52
    m = np.int64(bits - (twos << 52)).view(np.float64)
    z = (m - 1.0) / (m + 1.0)
    s = z * z
    series = _L1 + s * (_L2 + s * (_L3 + s * (_L4 + s * (_L5 + s * (_L6 + s * (_L7 + s * (_L8 + s * _L9)))))))
    return twos * _TWO_HIGH + (twos * _TWO_LOW + z * (2.0 + s * series))


@kernel(inlined=True)
def fast_asinh(x: float) -> float:
    """Return the inverse hyperbolic sine of a number below 1e150, with an error below 1e-15 of it or of 1."""
    size = abs(x)
    return np.copysign(fast_log(size + np.sqrt(size * size + 1.0)), x)
