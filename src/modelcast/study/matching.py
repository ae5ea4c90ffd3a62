"""The threshold at which a sender spends as much as another: what makes a comparison one of equal rate."""

from collections.abc import Callable
from math import log

import numpy as np

__all__ = ["matched_threshold", "threshold_near"]

_BISECTIONS = 24
_WIDEST_THRESHOLD_M = 64.0
_SMALLEST_THRESHOLD_M = 1e-3
_STEPS = 6
_NEAR_RATIO = 0.005
_SQUARE_ROOT = -0.5
_FLATTEST, _STEEPEST = -0.2, -2.0


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


def threshold_near(load: Callable[[float], float], wanted: float, start_m: float) -> float:
    """Return a threshold whose load comes near to what is wanted, by few steps from one not far off [m].

    Loads fall about as the square root of the threshold rises, where errors grow with the square of their
    age; from the second step on by the slope between the last two. It ends within half a percent, or after
    six steps with the nearest.

    Parameters
    ----------
    load
        Messages at a threshold [m], 1 or more; falls as that rises, by and large.
    wanted
        What it should be, 1 or more.
    start_m
        Where to begin [m].

    Examples
    --------
    >>> round(threshold_near(lambda threshold_m: 10.0 / threshold_m, 20.0, 0.3), 3)
    0.5
    """
    at, count = start_m, load(start_m)
    best, found, slope = at, count, _SQUARE_ROOT
    for _ in range(_STEPS):
        if abs(found - wanted) <= _NEAR_RATIO * wanted:
            break
        moved = at * (wanted / count) ** (1.0 / slope)
        moved = min(max(moved, _SMALLEST_THRESHOLD_M), _WIDEST_THRESHOLD_M)
        if moved == at:
            break
        reached = load(moved)
        if abs(reached - wanted) < abs(found - wanted):
            best, found = moved, reached
        slope = min(max(log(reached / count) / log(moved / at), _STEEPEST), _FLATTEST)
        at, count = moved, reached
    return best
