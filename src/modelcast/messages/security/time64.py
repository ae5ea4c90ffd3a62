"""Time on the wire: whole microseconds in 64 bits, Time64 of IEEE 1609.2.

Sender and receiver have to count from the same instant; 1609.2 counts from 2004-01-01 00:00 UTC, and leap
seconds count.
"""

import math

__all__ = ["LAST_US", "LEAP_SECONDS", "SECONDS", "microseconds", "since_2004_s"]

LAST_US = 2**64 - 1
"""585,000 years."""

SECONDS = 1_000_000
"""Microseconds in a second."""

LEAP_SECONDS = 5
"""Leap seconds from 2004 to this day, the last at the end of 2016; none is announced (IERS Bulletin C)."""

_BEGIN_UTC_S = 1_072_915_200
"""2004-01-01 00:00 UTC, since 1970 without leap seconds [s]."""


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


def since_2004_s(utc_s: float) -> float:
    """Time as IEEE 1609.2 counts it.

    Parameters
    ----------
    utc_s
        UTC since 1970, leap seconds left out, as computers count it, after 2016 [s].

    Examples
    --------
    >>> since_2004_s(1_483_228_800.0)  # 2017-01-01: 4749 days, and five leap seconds
    410313605.0
    """
    return utc_s - _BEGIN_UTC_S + LEAP_SECONDS
