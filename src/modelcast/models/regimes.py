"""A finite bank of kernels: driving regimes, and the sub-model that was trained in each.

A regime is what the sender knows of a window at its last sample: speed, how hard the vehicle brakes or speeds
up, how hard it turns. The turn is told by the acceleration across the course, not by the yaw rate: that of a
car which barely moves is mostly noise, and would make a regime of its own. The regimes are found, and their
sub-models trained, by `modelcast.study.training.regimes`.
"""

from dataclasses import KW_ONLY, dataclass
from typing import Annotated

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.rules import Each, FieldError, Fixed, Number, One, check_fields
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.point_kernels import ACCELERATION, VELOCITY_EAST, VELOCITY_NORTH, YAW_RATE

__all__ = ["REGIME_BANK", "Regimes", "nearest_centre", "regime_features"]

REGIME_BANK = "regimes"
"""Name of the bank of all regimes' sub-models."""

_FEATURES = 3
_CENTRE = Number(-1000.0, 1000.0)
_SCALE = Number(1e-6, 1000.0)


@dataclass(frozen=True, slots=True)
class Regimes:
    """Driving regimes, each with its trained sub-model; the most frequent first.

    Parameters
    ----------
    members
        The sub-models, R of them with distinct names.
    centres
        Mean features of each regime, R times (speed, size of the acceleration along the course, size of the
        one across it) [m/s, m/s², m/s²].
    scales
        Standard deviation of each feature over all windows.
    shares
        Share of the training windows in each regime, R of them, 0..1.

    Raises
    ------
    ValueError
        Where there are under two regimes, the lengths differ, two members share a name, or a number is out of
        its range.

    Examples
    --------
    >>> from modelcast.models.gp import VehicleProcess
    >>> members = (VehicleProcess("gp-regime-1"), VehicleProcess("gp-regime-2"))
    >>> centres = ((20.0, 0.1, 0.1), (5.0, 1.5, 1.5))
    >>> regimes = Regimes(members, centres, scales=(6.0, 0.7, 0.9), shares=(0.8, 0.2))
    >>> slow_turn = np.array([[[0.0, 0.0, 4.0, 0.0, -1.0, 0.2, 0.01]]])
    >>> int(regimes.of(slow_turn)[0]), regimes.bank.name
    (1, 'regimes')
    """

    members: Annotated[tuple[AbstractSubModel, ...], Each(One((AbstractSubModel,), "a sub-model"), 2, 16)]
    centres: Annotated[tuple[tuple[float, ...], ...], Each(Fixed((_CENTRE,) * _FEATURES), 2, 16)]
    _: KW_ONLY
    scales: Annotated[tuple[float, ...], Fixed((_SCALE,) * _FEATURES)]
    shares: Annotated[tuple[float, ...], Each(Number(0.0, 1.0), 2, 16)]

    def __post_init__(self) -> None:
        check_fields(self)
        count = len(self.members)
        if len(self.centres) != count or len(self.shares) != count:
            raise ValueError(
                f"regimes need two or more members with a centre and a share each, got {count} members, "
                f"{len(self.centres)} centres and {len(self.shares)} shares"
            )
        if not abs(sum(self.shares) - 1.0) < 1e-6:
            raise FieldError("shares", self.shares, "shares that sum to one")
        Bank(self.members)  # refuses what is no sub-model's name twice

    @property
    def bank(self) -> Bank:
        """All members, the most frequent regime's first."""
        return Bank(self.members, REGIME_BANK)

    def of(self, samples: FloatArray) -> IntArray:
        """Return the regime of each window, the one with the nearest centre, (B,).

        Parameters
        ----------
        samples
            Windows, (B, n, 9).
        """
        scales = np.array(self.scales)
        return nearest_centre(regime_features(samples) / scales, np.array(self.centres) / scales)


def regime_features(samples: FloatArray) -> FloatArray:
    """Speed, and sizes of the acceleration along the course and across it, at the last sample, (B, 3).

    Parameters
    ----------
    samples
        Windows, (B, n, 9).
    """
    last = samples[:, -1]
    speed = np.hypot(last[:, VELOCITY_EAST], last[:, VELOCITY_NORTH])
    return np.stack([speed, np.abs(last[:, ACCELERATION]), np.abs(speed * last[:, YAW_RATE])], axis=1)


def nearest_centre(features: FloatArray, centres: FloatArray) -> IntArray:
    """Return the index of the centre nearest to each row, (B,).

    Parameters
    ----------
    features
        Features over their scales, (B, 3).
    centres
        Centres over the same scales, (R, 3).
    """
    return ((features[:, None] - centres) ** 2).sum(axis=2).argmin(axis=1)
