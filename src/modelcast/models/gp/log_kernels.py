"""A natural logarithm that vectorises: exponent by its bits, mantissa by a polynomial."""

import numpy as np

from modelcast.core.kernel import kernel

__all__ = ["rough_log"]

_LOG_TWO = float(np.log(2.0))
_DEGREE = 7


def _log_polynomial() -> tuple[float, ...]:
    nodes = 0.5 + 0.5 * np.cos(np.pi * (np.arange(64) + 0.5) / 64)
    # log(1 + m) - m·log 2 vanishes at both ends, so that the approximation is continuous.
    base = (np.log1p(nodes) - nodes * _LOG_TWO) / (nodes * (1.0 - nodes))
    fit = np.polynomial.chebyshev.Chebyshev.fit(nodes, base, _DEGREE - 2, domain=[0, 1])
    return tuple(float(c) for c in fit.convert(kind=np.polynomial.Polynomial).coef)


_C0, _C1, _C2, _C3, _C4, _C5 = _log_polynomial()


@kernel(fast=True)
def rough_log(x: float) -> float:
    """Natural logarithm to 1e-6, continuous, of a positive normal number."""
    bits = np.float64(x).view(np.int64)
    exponent = float((bits >> 52) - 1023)
    m = np.int64((bits & 0x000FFFFFFFFFFFFF) | 0x3FF0000000000000).view(np.float64) - 1.0
    bend = _C0 + m * (_C1 + m * (_C2 + m * (_C3 + m * (_C4 + m * _C5))))
    return (exponent + m) * _LOG_TWO + m * (1.0 - m) * bend
