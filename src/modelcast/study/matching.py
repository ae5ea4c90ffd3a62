"""The threshold at which a sender spends as much as another: what makes a comparison one of equal rate."""

from collections.abc import Callable
from math import log, sqrt

__all__ = ["matched_threshold"]

_BISECTIONS = 24
_STEPS = 7
_WIDEST_THRESHOLD_M = 64.0
_SMALLEST_THRESHOLD_M = 1e-3
_NEAR_RATIO = 0.005
_SQUARE_ROOT = -0.5
_FLATTEST, _STEEPEST = -0.2, -2.0


def matched_threshold(
    load: Callable[[float], float],
    wanted: float,
    *,
    bisections: int = _BISECTIONS,
    start_m: float | None = None,
) -> float:
    """Return the threshold whose load comes nearest to what is wanted, of those tried [m].

    Without a start the search bisects. It then begins with the same thresholds every time, so a ``load`` that
    remembers is asked little. From a start that is not far off it takes few steps: loads fall about as the
    square root of the threshold rises, where errors grow with the square of their age; from the second step
    on by the slope between the last two; and where that leads out of the thresholds that are left, it
    bisects these. It then ends within half a percent, or with the nearest of seven.

    Parameters
    ----------
    load
        Messages, bytes or airtime at a threshold [m]; falls as that rises, by and large.
    wanted
        What it should be.
    bisections
        How many thresholds are tried without a start.
    start_m
        Where to begin [m]; None to bisect.

    Examples
    --------
    >>> round(matched_threshold(lambda threshold_m: 10.0 / threshold_m, 20.0), 6)
    0.5
    >>> round(matched_threshold(lambda threshold_m: 10.0 / threshold_m, 20.0, start_m=0.3), 3)
    0.5
    """
    low, high = _SMALLEST_THRESHOLD_M, _WIDEST_THRESHOLD_M
    at = sqrt(low * high) if start_m is None else start_m
    near = 0.0 if start_m is None else _NEAR_RATIO * wanted
    best, off = at, float("inf")
    slope = _SQUARE_ROOT
    before: tuple[float, float] | None = None
    for _ in range(bisections if start_m is None else _STEPS):
        count = load(at)
        if abs(count - wanted) < off:
            best, off = at, abs(count - wanted)
        if off <= near:
            break
        low, high = (at, high) if count > wanted else (low, at)
        following = sqrt(low * high)
        if start_m is not None and count > 0.0 and wanted > 0.0:
            if before is not None:
                slope = log(count / before[1]) / log(at / before[0])
                slope = min(max(slope, _STEEPEST), _FLATTEST)
            guess = at * (wanted / count) ** (1.0 / slope)
            if low < guess < high:
                following = guess
            before = at, count
        at = following
    return best
