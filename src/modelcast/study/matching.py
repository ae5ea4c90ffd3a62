"""The threshold at which a sender spends as much as another: what makes a comparison one of equal rate."""

from collections.abc import Callable

import numpy as np

__all__ = ["matched_threshold"]

_BISECTIONS = 24
_WIDEST_THRESHOLD_M = 64.0
_SMALLEST_THRESHOLD_M = 1e-3


def matched_threshold(
    load: Callable[[float], float], wanted: float, *, bisections: int = _BISECTIONS
) -> float:
    """Return the threshold whose load comes nearest to what is wanted, found by bisection [m].

    Every search begins with the same thresholds, so a ``load`` that remembers is asked little.

    Parameters
    ----------
    load
        Messages, bytes or airtime at a threshold [m]; falls as that rises, by and large.
    wanted
        What it should be.
    bisections
        How many thresholds are tried.

    Examples
    --------
    >>> round(matched_threshold(lambda threshold_m: 10.0 / threshold_m, 20.0), 6)
    0.5
    """
    low, high = _SMALLEST_THRESHOLD_M, _WIDEST_THRESHOLD_M
    best, found = low, -1.0
    for _ in range(bisections):
        middle = float(np.sqrt(low * high))
        count = load(middle)
        if found < 0.0 or abs(count - wanted) < abs(found - wanted):
            best, found = middle, count
        if count == wanted:
            break
        low, high = (middle, high) if count > wanted else (low, middle)
    return best
