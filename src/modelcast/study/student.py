"""Student's t, as far as the interval of a mean needs it."""

from functools import cache
from math import atan, cos, exp, lgamma, pi, sin, sqrt, tan

import numpy as np

__all__ = ["student_reach"]

_ENOUGH = 1e-14
_MOST_STEPS = 100


@cache
def student_reach(degrees: int, within: float = 0.95) -> float:
    """Return how far a t variable strays from 0, to either side, with a given probability.

    Right to 1e-12 up to 10,000 degrees of freedom.

    Parameters
    ----------
    degrees
        Degrees of freedom, at least 1.
    within
        The probability, over 0 and under 1.

    Raises
    ------
    ValueError
        Where one of them is out of its range.

    Notes
    -----
    With a = atan(t/√n) the probability is a finite sum of powers of cos a, all positive. Its slope in a
    falls as a power of cos a, so that Newton's steps from 0 never pass the root.

    References
    ----------
    M. Abramowitz, I. A. Stegun, "Handbook of Mathematical Functions", 26.7.3 and 26.7.4.

    Examples
    --------
    >>> round(student_reach(1), 4), round(student_reach(4), 4)
    (12.7062, 2.7764)
    """
    if degrees < 1 or not 0.0 < within < 1.0:
        raise ValueError(f"degrees must be at least 1 and within in 0..1, got {degrees} and {within}")
    odd = degrees % 2
    power = np.arange(1, (degrees - 2 - odd) // 2 + 1, dtype=np.float64)
    factor = np.cumprod(2.0 * power / (2.0 * power + 1.0) if odd else (2.0 * power - 1.0) / (2.0 * power))

    def probability(angle: float) -> float:
        total = sin(angle) * (1.0 + float(factor @ cos(angle) ** (2.0 * power)))
        if not odd:
            return total
        return 2.0 / pi * (angle + (cos(angle) * total if degrees > 1 else 0.0))

    steepest = 2.0 * exp(lgamma((degrees + 1) / 2) - lgamma(degrees / 2)) / sqrt(pi)
    angle = 0.0
    for _ in range(_MOST_STEPS):
        step = (within - probability(angle)) / (steepest * cos(angle) ** (degrees - 1))
        angle += step
        if abs(step) < _ENOUGH * max(angle, atan(1.0 / sqrt(degrees))):
            break
    return sqrt(degrees) * tan(angle)
