"""When a claim that something is smaller holds: ratios with their intervals in, one word out."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Literal

__all__ = ["Estimate", "Verdict", "verdict_of"]

Verdict = Literal["holds", "in part", "not shown", "fails", "not run"]


@dataclass(frozen=True, slots=True)
class Estimate:
    """A ratio that a claim says to be below 1.

    Parameters
    ----------
    value
        The ratio.
    low, high
        Its 95 % interval; None where there is none.
    """

    value: float
    low: float | None = None
    high: float | None = None

    @property
    def is_below(self) -> bool:
        """Whether all of it lies below 1."""
        return (self.value if self.high is None else self.high) < 1.0

    @property
    def is_above(self) -> bool:
        """Whether all of it lies above 1."""
        return (self.value if self.low is None else self.low) > 1.0


def verdict_of(estimates: Sequence[Estimate]) -> Verdict:
    """Whether all of several ratios lie below 1.

    Parameters
    ----------
    estimates
        One a threshold, say.

    Returns
    -------
    Verdict
        ``holds`` where every interval lies below 1, ``fails`` where every one lies above, ``not shown`` where
        none lies to one side, ``in part`` for anything between, ``not run`` without estimates that are
        numbers. A ratio that has no interval is taken as it is.

    Examples
    --------
    >>> verdict_of([Estimate(0.9, 0.8, 0.95), Estimate(0.8)]), verdict_of([Estimate(0.9, 0.8, 1.1)])
    ('holds', 'not shown')
    >>> verdict_of([Estimate(0.9), Estimate(1.1)]), verdict_of([Estimate(1.1)]), verdict_of([])
    ('in part', 'fails', 'not run')
    """
    estimates = [one for one in estimates if isfinite(one.value)]
    if not estimates:
        return "not run"
    below = sum(one.is_below for one in estimates)
    above = sum(one.is_above for one in estimates)
    if below == len(estimates):
        return "holds"
    if above == len(estimates):
        return "fails"
    return "in part" if below or above else "not shown"
