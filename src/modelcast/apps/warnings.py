"""What a safety application says: how bad it is, how long there is left, by what margin, and how sure."""

from dataclasses import dataclass
from enum import IntEnum

from modelcast.core.arrays import BoolArray, FloatArray, IntArray

__all__ = ["Level", "Warnings"]


class Level(IntEnum):
    """How bad it is."""

    NONE = 0
    """Nothing to say, or nothing known."""
    CAUTION = 1
    """To be known: the driver need not act yet."""
    WARNING = 2
    """To be acted on now."""


@dataclass(frozen=True, slots=True, eq=False)
class Warnings:
    """What an application says of N pairs of host and remote.

    Parameters
    ----------
    level
        A `Level` each, (N,).
    time_s
        Time left, as the application counts it; infinite where there is no conflict, (N,) [s].
    margin_m
        Way left until a warning, negative behind it; infinite where the remote is no concern, NaN where
        nothing is known, (N,) [m].
    certainty
        Chance that the margin is used up, given what is believed of the remote's place, (N,) in 0..1.
    """

    level: IntArray
    time_s: FloatArray
    margin_m: FloatArray
    certainty: FloatArray

    @property
    def warns(self) -> BoolArray:
        """Whether the driver is to act now, (N,)."""
        return self.level == Level.WARNING
