"""Compiled timers: the next time something that repeats falls due."""

import math

from modelcast.core.kernel import kernel

__all__ = ["next_due"]

_SLACK = 1e-9
"""Sums of steps may fall short of a whole number of intervals by rounding."""


@kernel
def next_due(due_s: float, t_s: float, interval_s: float) -> float:
    """Next time after ``t_s`` on the grid of ``due_s``: what fell due in between is passed over."""
    if t_s <= due_s:
        return due_s + interval_s
    return due_s + interval_s * (math.floor((t_s - due_s) / interval_s + _SLACK) + 1.0)
