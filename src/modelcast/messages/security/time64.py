"""Time on the wire: whole microseconds in 64 bits, Time64 of IEEE 1609.2.

Sender and receiver have to count from the same instant; 1609.2 counts from 2004-01-01 00:00 TAI.
"""

import math

__all__ = ["LAST_US", "SECONDS", "microseconds"]

LAST_US = 2**64 - 1
"""585,000 years."""

SECONDS = 1_000_000
"""Microseconds in a second."""


def microseconds(t_s: float) -> int:
    """Nearest whole microsecond.

    Parameters
    ----------
    t_s
        Time since the common instant [s].

    Raises
    ------
    ValueError
        Where it is before that instant, not finite, or beyond 64 bits.
    """
    if not (math.isfinite(t_s) and 0 <= t_s * SECONDS < LAST_US):
        raise ValueError(f"t_s must be from 0 to {LAST_US // SECONDS} s after the common instant, got {t_s}")
    return round(t_s * SECONDS)
