"""What a safety application says: how urgent, how long, how far from the decision, and how sure."""

from dataclasses import KW_ONLY, dataclass
from enum import IntEnum

from modelcast.apps import pair_kernels
from modelcast.core.arrays import BoolArray, FloatArray, IntArray

__all__ = ["Level", "Warnings"]


class Level(IntEnum):
    """How urgent."""

    NONE = pair_kernels.NONE
    CAUTION = pair_kernels.CAUTION
    WARNING = pair_kernels.WARNING


@dataclass(frozen=True, slots=True, eq=False)
class Warnings:
    """What an application says of N pairs of host and remote.

    Parameters
    ----------
    level
        Values of `Level`, (N,).
    time_s
        Until host and remote touch if both go on as they do, (N,) [s]; infinite where they do not.
    margin_m
        Way left until the application warns, (N,) [m]: a warning where it is not positive. Infinite where the
        remote is no threat of the application's kind, NaN where it is not known.
    certainty
        Probability that the margin is not positive, (N,): 0 or 1 without covariances, 0 for no threat.

    Raises
    ------
    ValueError
        Where shapes differ.
    """

    level: IntArray
    _: KW_ONLY
    time_s: FloatArray
    margin_m: FloatArray
    certainty: FloatArray

    def __post_init__(self) -> None:
        for name in ("time_s", "margin_m", "certainty"):
            shape = getattr(self, name).shape
            if shape != self.level.shape:
                raise ValueError(f"{name} must have shape {self.level.shape}, got {shape}")

    def __len__(self) -> int:
        return int(self.level.shape[0])

    @property
    def warned(self) -> BoolArray:
        """Where the level is `Level.WARNING`, (N,)."""
        return self.level == Level.WARNING
