"""What a safety application says: how urgent, how long, how far from the decision, and how sure."""

from dataclasses import KW_ONLY, dataclass
from enum import IntEnum

import numpy as np

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
        Where shapes differ, a level is none of `Level`, or a certainty is not within 0..1.
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
        if len(self) and not (self.level.min() >= Level.NONE and self.level.max() <= Level.WARNING):
            raise ValueError(f"level must be of Level, got {self.level.min()}..{self.level.max()}")
        if not ((self.certainty >= 0.0) & (self.certainty <= 1.0)).all():
            raise ValueError("certainty must be within 0..1")

    @classmethod
    def by_margin(
        cls, margin_m: FloatArray, *, time_s: FloatArray | None = None, cautions: BoolArray | None = None
    ) -> "Warnings":
        """Warn where the margin is not positive, with certainty.

        Parameters
        ----------
        margin_m
            Way left until the warning, (N,) [m]; infinite for no threat, NaN where it is not known.
        time_s
            Until host and remote touch, (N,) [s]; None where that is not told.
        cautions
            Of which pairs that do not warn is cautioned, (N,); None for none.

        Examples
        --------
        >>> import numpy as np
        >>> Warnings.by_margin(np.array([-1.0, 3.0, np.inf]), cautions=np.array([True, True, False])).level
        array([2, 1, 0])
        """
        warned = margin_m <= 0.0
        cautioned = np.zeros_like(warned) if cautions is None else cautions
        return cls(
            np.where(warned, int(Level.WARNING), np.where(cautioned, int(Level.CAUTION), int(Level.NONE))),
            time_s=np.full(margin_m.shape, np.inf) if time_s is None else time_s,
            margin_m=margin_m,
            certainty=warned.astype(np.float64),
        )

    def __len__(self) -> int:
        return int(self.level.shape[0])

    @property
    def warned(self) -> BoolArray:
        """Where the level is `Level.WARNING`, (N,)."""
        return self.level == Level.WARNING
