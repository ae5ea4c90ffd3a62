"""Values of one quantity by the time they were measured, whatever order they came in."""

import bisect
import math
from collections.abc import Iterator
from itertools import pairwise
from statistics import median

__all__ = ["Series", "stale_after_s"]

_PERIODS = 3.0
_GAPS = 5
_LEAST_S = 0.3
"""Three periods of 10 Hz: of a source that has not shown its own period yet, and of a faster one."""


class Series:
    """Values in order of time; of two of one time the one that arrived later counts.

    Parameters
    ----------
    most
        Values kept, the newest ones.

    Examples
    --------
    >>> series = Series(100)
    >>> for at, value in ((2.0, 20.0), (1.0, 10.0), (3.0, 30.0)):
    ...     series.add(at, at, value)
    >>> series.at(1.5), series.at(9.0), list(series.knots(1.0, 3.0))
    (15.0, 30.0, [2.0])
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._rows: list[tuple[float, float, float]] = []

    def __len__(self) -> int:
        return len(self._rows)

    def add(self, measured_s: float, received_s: float, value: float) -> None:
        """Add a value [s], [s]."""
        bisect.insort(self._rows, (measured_s, received_s, value))
        del self._rows[: -self._most]

    def forget_before(self, t_s: float) -> None:
        """Drop what was measured before a time [s]."""
        del self._rows[: bisect.bisect_left(self._rows, (t_s, -math.inf, -math.inf))]

    def clear(self) -> None:
        """Drop all."""
        self._rows.clear()

    @property
    def newest_s(self) -> float:
        """When the newest was measured, minus infinity where there is none [s]."""
        return self._rows[-1][0] if self._rows else -math.inf

    def since(self, t_s: float) -> tuple[list[float], list[float]]:
        """Times and values from a time on [s]."""
        rows = self._rows[bisect.bisect_left(self._rows, (t_s, -math.inf, -math.inf)) :]
        return [row[0] for row in rows], [row[2] for row in rows]

    def at(self, t_s: float) -> float:
        """The value at a time, on the line between its neighbours; beyond an end that end's, NaN of none."""
        rows = self._rows
        if not rows:
            return math.nan
        after = bisect.bisect_right(rows, (t_s, math.inf, math.inf))
        if after == 0 or after == len(rows):
            return rows[max(after - 1, 0)][2]
        (from_s, _, low), (to_s, _, high) = rows[after - 1], rows[after]
        return low + (high - low) * (t_s - from_s) / (to_s - from_s)

    def knots(self, from_s: float, to_s: float) -> Iterator[float]:
        """Times of values between two times, neither included [s]."""
        first = bisect.bisect_right(self._rows, (from_s, math.inf, math.inf))
        for row in self._rows[first:]:
            if row[0] >= to_s:
                return
            yield row[0]

    def count(self, from_s: float, to_s: float) -> int:
        """How many values lie between two times, both included [s]."""
        first = bisect.bisect_left(self._rows, (from_s, -math.inf, -math.inf))
        return bisect.bisect_right(self._rows, (to_s, math.inf, math.inf)) - first

    def same_since(self) -> tuple[float, int]:
        """Since when the newest value stands, and how many it is; infinity and 0 of none."""
        begin_s, count = math.inf, 0
        for measured_s, _, value in reversed(self._rows):
            if value != self._rows[-1][2]:
                break
            begin_s, count = measured_s, count + 1
        return begin_s, count

    def stale_after_s(self, cap_s: float) -> float:
        """Age from which its newest value is old [s]."""
        return stale_after_s([row[0] for row in self._rows[-_GAPS - 1 :]], cap_s)


def stale_after_s(times_s: list[float], cap_s: float) -> float:
    """Age from which a source's newest sample is old: three of its own periods, within bounds [s].

    Parameters
    ----------
    times_s
        When its newest samples were measured, rising [s].
    cap_s
        The most it may be [s].

    Examples
    --------
    >>> stale_after_s([0.0, 0.2, 0.4], 1.0), stale_after_s([0.0, 0.01], 1.0), stale_after_s([0.0, 1.0], 1.0)
    (0.6000000000000001, 0.3, 1.0)
    """
    gaps = [later - sooner for sooner, later in pairwise(times_s)]
    period_s = median(gaps) if gaps else 0.0
    return min(max(_PERIODS * period_s, _LEAST_S), cap_s)
