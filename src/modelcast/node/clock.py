"""The node's time: seconds since a minute of UTC, never back, steered by whoever knows UTC.

Everything below takes time as an argument; a node asks one of these. Messages state the milliseconds of their
minute, so the node's time must be UTC to some milliseconds, and a station wants time that only grows.
"""

import abc
import math
import time
from collections.abc import Callable
from typing import final

__all__ = ["AbstractClock", "ManualClock", "SteeredClock", "SystemClock", "read_together"]

_SLEW = 0.01
"""Most that time is made to run faster or slower while an error is taken back."""

_STEP_S = 0.25
"""An error larger than this is none of an oscillator: time steps forward at once."""

_MINUTE_S = 60.0


class AbstractClock(abc.ABC):
    """What tells the time of a node; 0 is the begin of a minute of UTC."""

    @abc.abstractmethod
    def now_s(self) -> float:
        """Now, never less than before [s]."""


@final
class ManualClock(AbstractClock):
    """A clock that stands until it is set: of tests, and of recordings replayed.

    Parameters
    ----------
    now_s
        At first [s].

    Examples
    --------
    >>> clock = ManualClock()
    >>> clock.set(2.5)
    >>> clock.now_s()
    2.5
    """

    def __init__(self, now_s: float = 0.0) -> None:
        self._now_s = now_s

    def now_s(self) -> float:
        """As it was set."""
        return self._now_s

    def set(self, now_s: float) -> None:
        """Go on to a time.

        Parameters
        ----------
        now_s
            Not before the last [s].

        Raises
        ------
        ValueError
            Where it is before the last, or no number.
        """
        if not self._now_s <= now_s < math.inf:
            raise ValueError(f"now_s must be finite and not before {self._now_s}, got {now_s}")
        self._now_s = now_s


class SteeredClock(AbstractClock):
    """Time from a counter that only grows, steered towards UTC.

    An error of up to 0.25 s is taken back by running 1 % faster or slower. Beyond that time steps forward at
    once; where it is ahead it stands still until UTC has come, since what is sent must not be dated twice.

    Parameters
    ----------
    utc_s
        UTC at the counter's 0, since 1970 without leap seconds [s].

    Raises
    ------
    ValueError
        Where it is no number.

    Examples
    --------
    >>> clock = SteeredClock(90.0)
    >>> clock.at(0.0), clock.utc_s(0.0)
    (30.0, 90.0)
    >>> clock.steer(10.0, utc_s=100.1)  # 0.1 s behind: made up for in 10 s
    >>> round(clock.at(15.0), 3), round(clock.at(30.0), 3)
    (45.05, 60.1)
    """

    def __init__(self, utc_s: float) -> None:
        if not math.isfinite(utc_s):
            raise ValueError(f"utc_s must be finite, got {utc_s}")
        self.minute_utc_s = math.floor(utc_s / _MINUTE_S) * _MINUTE_S
        """UTC at which this clock is 0 [s]."""
        self.steps = 0
        """How often it was off by more than can be taken back."""
        self._from = (0.0, utc_s - self.minute_utc_s)
        self._error_s = 0.0

    def at(self, counted_s: float) -> float:
        """Time at a reading of the counter, not before the last `steer` [s].

        Parameters
        ----------
        counted_s
            The counter [s].
        """
        began_s, time_s = self._from
        past_s = max(counted_s - began_s, 0.0)
        if self._error_s < -_STEP_S:
            return time_s + max(past_s + self._error_s, 0.0)
        gained_s = min(_SLEW * past_s, abs(self._error_s))
        return time_s + past_s + math.copysign(gained_s, self._error_s)

    def utc_s(self, counted_s: float) -> float:
        """UTC at a reading of the counter, as this clock has it [s]."""
        return self.minute_utc_s + self.at(counted_s)

    def steer(self, counted_s: float, *, utc_s: float) -> None:
        """Learn what UTC was at a reading of the counter.

        Parameters
        ----------
        counted_s
            The counter, not before the last call [s].
        utc_s
            UTC then, since 1970 [s]. Something that is no number is passed over.
        """
        if not math.isfinite(utc_s):
            return
        time_s = self.at(counted_s)
        error_s = utc_s - self.minute_utc_s - time_s
        if abs(error_s) > _STEP_S:
            self.steps += 1
        if error_s > _STEP_S:
            time_s, error_s = time_s + error_s, 0.0
        self._from, self._error_s = (counted_s, time_s), error_s

    def now_s(self) -> float:
        """Time at the machine's own counter [s]."""
        return self.at(time.monotonic())


def read_together(
    counter: Callable[[], float], utc: Callable[[], float], *, within_s: float = 1e-4, most: int = 20
) -> tuple[float, float]:
    """Read a counter and UTC at one instant; returns both [s].

    Between two readings a busy machine may run others for tens of milliseconds, and a clock set by them would
    be wrong by as much. So the counter is read before and after, again where that took long, and of all
    readings the quickest counts.

    Parameters
    ----------
    counter, utc
        What is read.
    within_s
        A reading as quick as this is good enough [s].
    most
        Readings at most.

    Examples
    --------
    >>> counted = iter([0.0, 0.5, 1.0, 1.00002])
    >>> utc_s = iter([100.4, 101.00001])
    >>> read_together(lambda: next(counted), lambda: next(utc_s))
    (1.00001, 101.00001)
    """
    took_s, found = math.inf, (math.nan, math.nan)
    for _ in range(most):
        before_s = counter()
        utc_s = utc()
        after_s = counter()
        if after_s - before_s < took_s:
            took_s, found = after_s - before_s, (before_s + (after_s - before_s) / 2.0, utc_s)
        if took_s <= within_s:
            break
    return found


@final
class SystemClock(SteeredClock):
    """The machine's clock, which its own time service keeps; its steps are met as those of any source."""

    def __init__(self) -> None:
        counted_s, utc_s = read_together(time.monotonic, time.time)
        super().__init__(utc_s - counted_s)

    def now_s(self) -> float:
        """Now, by the machine's counter steered towards its UTC [s]."""
        counted_s = time.monotonic()
        return self.at(counted_s)

    def follow_system(self) -> None:
        """Steer towards what the machine takes for UTC; to be called every few seconds."""
        counted_s, utc_s = read_together(time.monotonic, time.time)
        self.steer(counted_s, utc_s=utc_s)
