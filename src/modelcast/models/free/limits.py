"""How far the values that a sender states may lie from its estimates."""

from dataclasses import dataclass
from math import pi
from typing import Annotated

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.rules import Number, check_fields

__all__ = ["Limits"]

_DEGREE = pi / 180.0


@dataclass(frozen=True, slots=True)
class Limits:
    """Greatest differences between what Part I states and what the sender estimates.

    Parameters
    ----------
    speed_mps, heading_rad, acceleration_mps2, yaw_rate_radps
        Of each value; 0 for none. The defaults are the accuracy that SAE J2945/1 is said to ask of a sender:
        1 km/h, 2°, 0.3 m/s², 0.5 °/s (second-hand; the standard's text was not at hand).

    Raises
    ------
    ValueError
        Where one is out of its range.

    Examples
    --------
    >>> Limits().values.round(4).tolist()
    [0.28, 0.0349, 0.3, 0.0087]
    """

    speed_mps: Annotated[float, Number(0.0, 100.0)] = 0.28
    heading_rad: Annotated[float, Number(0.0, pi)] = 2.0 * _DEGREE
    acceleration_mps2: Annotated[float, Number(0.0, 100.0)] = 0.3
    yaw_rate_radps: Annotated[float, Number(0.0, 10.0)] = 0.5 * _DEGREE

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def values(self) -> FloatArray:
        """All four, in the order of the networks' outputs, (4,)."""
        return np.array([self.speed_mps, self.heading_rad, self.acceleration_mps2, self.yaw_rate_radps])
