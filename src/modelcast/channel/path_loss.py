"""Path loss against distance: which part of the power is lost on the way, before shadowing and fading.

| model | use it for |
|---|---|
| `WinnerB1` | highways and streets with low antennas; what the mode 4 literature uses |
| `Tr37885` | highway and urban line of sight of the newer 3GPP studies, its urban NLOS |
| `DualSlope` | fits to measured V2V channels (Abbas et al.), with or without cars in between |
| `LogDistance` | simulators' common ground, free space |
| `TwoRay` | open road: the direct wave and the one off the ground, by the heights of the antennas |
| `ManhattanNlos` | round a street corner, on top of `WinnerB1` |

Every model is a frozen value with one verb, `loss_db(distance_m)`. Distances below `NEAREST_M` count as that.
"""

import abc
from dataclasses import KW_ONLY, dataclass, field
from typing import Self

import numpy as np

from modelcast.core.arrays import FloatArray

__all__ = [
    "NEAREST_M",
    "AbstractPathLoss",
    "DualSlope",
    "LogDistance",
    "ManhattanNlos",
    "Tr37885",
    "TwoRay",
    "WinnerB1",
]

NEAREST_M = 1.0
"""No model holds nearer than this; antennas on two cars are never nearer."""

LIGHT_MPS = 299_792_458.0


def _positive(**values: float) -> None:
    for name, value in values.items():
        if not (np.isfinite(value) and value > 0):
            raise ValueError(f"{name} must be positive and finite, got {value}")


class AbstractPathLoss(abc.ABC):
    """Median loss of a link as a function of its length."""

    @abc.abstractmethod
    def loss_db(self, distance_m: FloatArray) -> FloatArray:
        """Loss, any shape [dB].

        Parameters
        ----------
        distance_m
            Length of the link in the plane, any shape [m].
        """


@dataclass(frozen=True, slots=True)
class LogDistance(AbstractPathLoss):
    """Power law: a loss at a reference distance and an exponent.

    Parameters
    ----------
    exponent
        Decay with distance; 2 is free space.
    reference_loss_db
        Loss at the reference distance; 47.86 dB is free space over 1 m at 5.9 GHz [dB].
    reference_m
        Reference distance [m].

    Examples
    --------
    >>> import numpy as np
    >>> LogDistance(2.0).loss_db(np.array([1.0, 10.0, 100.0])).round(2).tolist()
    [47.86, 67.86, 87.86]
    """

    exponent: float = 2.0
    reference_loss_db: float = 47.86
    _: KW_ONLY
    reference_m: float = 1.0

    def __post_init__(self) -> None:
        _positive(exponent=self.exponent, reference_m=self.reference_m)

    def loss_db(self, distance_m: FloatArray) -> FloatArray:
        """Loss of the power law, any shape [dB]."""
        reach = np.maximum(distance_m, NEAREST_M) / self.reference_m
        return self.reference_loss_db + 10.0 * self.exponent * np.log10(reach)


@dataclass(frozen=True, slots=True)
class DualSlope(AbstractPathLoss):
    """Two exponents, one up to a break point and one beyond.

    Parameters
    ----------
    near_exponent, far_exponent
        n1 and n2.
    reference_loss_db
        Loss at the reference distance [dB].
    reference_m, break_m
        d0 and d_b [m].
    shadowing_db
        Standard deviation found around this median, for `Shadowing` [dB].

    References
    ----------
    T. Abbas, K. Sjoberg, J. Karedal and F. Tufvesson, "A measurement based shadow fading model for
    vehicle-to-vehicle network simulations", 2015, DOI 10.1155/2015/190607. The numbers are second-hand.
    """

    near_exponent: float
    far_exponent: float
    _: KW_ONLY
    reference_loss_db: float
    reference_m: float = 10.0
    break_m: float = 104.0
    shadowing_db: float = 0.0

    def __post_init__(self) -> None:
        _positive(near_exponent=self.near_exponent, far_exponent=self.far_exponent)
        if not 0 < self.reference_m < self.break_m:
            raise ValueError(
                f"reference_m must be positive and below break_m, got {self.reference_m} and {self.break_m}"
            )

    @classmethod
    def highway_los(cls) -> Self:
        """Highway, line of sight."""
        return cls(1.66, 2.88, reference_loss_db=66.1, shadowing_db=3.95)

    @classmethod
    def urban_los(cls) -> Self:
        """Street, line of sight."""
        return cls(1.81, 2.85, reference_loss_db=63.9, shadowing_db=4.15)

    @classmethod
    def urban_obstructed(cls) -> Self:
        """Street, with a car in between."""
        return cls(1.93, 2.74, reference_loss_db=72.3, shadowing_db=6.67)

    def loss_db(self, distance_m: FloatArray) -> FloatArray:
        """Loss of two power laws that meet at the break point, any shape [dB]."""
        distance_m = np.maximum(distance_m, NEAREST_M)
        near = np.log10(np.minimum(distance_m, self.break_m) / self.reference_m)
        far = np.log10(np.maximum(distance_m, self.break_m) / self.break_m)
        return self.reference_loss_db + 10.0 * (self.near_exponent * near + self.far_exponent * far)


@dataclass(frozen=True, slots=True)
class TwoRay(AbstractPathLoss):
    """The direct wave and its reflection off a flat road, which add or cancel by distance.

    Parameters
    ----------
    frequency_ghz
        Carrier [GHz].
    antenna_m
        Height of both antennas over the road [m].
    other_antenna_m
        Height of the other end's; None for the same [m].
    permittivity
        Relative permittivity of the road. 1.02 is common in vehicular simulation (from memory).

    Notes
    -----
    With d the length of the direct way, d' that of the reflected one, and t the angle at which the latter
    meets the road: 20 log(4 pi d f/c) - 20 log|1 + r (d/d') exp(-j 2 pi f (d' - d)/c)|, with
    r = (sin t - s)/(sin t + s) and s = sqrt(permittivity - cos^2 t), waves polarised along the road. Tables
    of compiled loops have an entry every half metre: narrower gaps, where waves cancel within some 10 m, are
    smoothed.

    References
    ----------
    C. Sommer, S. Joerer and F. Dressler, "On the applicability of two-ray path loss models for vehicular
    network simulation", 2012, DOI 10.1109/VNC.2012.6407446 (from memory); the formula is elementary.

    Examples
    --------
    >>> import numpy as np
    >>> TwoRay().loss_db(np.array([100.0, 1000.0, 2000.0])).round(1).tolist()
    [91.4, 113.2, 125.1]
    """

    frequency_ghz: float = 5.9
    antenna_m: float = 1.5
    other_antenna_m: float | None = None
    _: KW_ONLY
    permittivity: float = 1.02

    def __post_init__(self) -> None:
        other_m = self.antenna_m if self.other_antenna_m is None else self.other_antenna_m
        _positive(frequency_ghz=self.frequency_ghz, antenna_m=self.antenna_m, other_antenna_m=other_m)
        if not (np.isfinite(self.permittivity) and self.permittivity > 1.0):
            raise ValueError(f"permittivity must be above 1 and finite, got {self.permittivity}")

    def loss_db(self, distance_m: FloatArray) -> FloatArray:
        """Loss of both waves together, any shape [dB]."""
        ground_m = np.maximum(np.asarray(distance_m, dtype=np.float64), NEAREST_M)
        other_m = self.antenna_m if self.other_antenna_m is None else self.other_antenna_m
        direct_m = np.hypot(ground_m, self.antenna_m - other_m)
        bounced_m = np.hypot(ground_m, self.antenna_m + other_m)
        sine, cosine = (self.antenna_m + other_m) / bounced_m, ground_m / bounced_m
        root = np.sqrt(self.permittivity - cosine**2)
        reflected = (sine - root) / (sine + root) * direct_m / bounced_m
        wave_number = 2.0 * np.pi * self.frequency_ghz * 1e9 / LIGHT_MPS
        # Of equal heights the ways differ by 4 h h'/(d + d') exactly: no digits are lost far out.
        longer_m = 4.0 * self.antenna_m * other_m / (direct_m + bounced_m)
        both = np.abs(1.0 + reflected * np.exp(-1j * wave_number * longer_m))
        alone_db = 20.0 * np.log10(2.0 * wave_number * direct_m)
        return np.asarray(alone_db - 20.0 * np.log10(both), dtype=np.float64)


@dataclass(frozen=True, slots=True)
class WinnerB1(AbstractPathLoss):
    """WINNER+ B1, line of sight: a street, antennas at car height.

    Parameters
    ----------
    frequency_ghz
        Carrier [GHz].
    antenna_m
        Height of both antennas over the road; a metre of it is lost to traffic [m].
    other_antenna_m
        Height of the other end's, as of a roadside unit; None for the same [m].

    Notes
    -----
    22.7 log d + 27 + 20 log f up to the break point 4 h h' f/c, and 40 log d + 7.56 - 17.3 log h
    - 17.3 log h' + 2.7 log f beyond, with the effective heights h = antenna_m - 1 and h' of the other end.
    At 1.5 m and 5.9 GHz the break point is 19.7 m and
    the two parts miss each other there by 0.1 dB.

    References
    ----------
    WINNER+ D5.3, "Final channel models", 2010, table 4-1, as used in 3GPP TR 36.885, A.1.4.
    """

    frequency_ghz: float = 5.9
    antenna_m: float = 1.5
    other_antenna_m: float | None = None

    def __post_init__(self) -> None:
        heights_m = [height - 1.0 for height in (self.antenna_m, self.other_antenna_m) if height is not None]
        _positive(frequency_ghz=self.frequency_ghz, effective_height_m=min(heights_m))

    def loss_db(self, distance_m: FloatArray) -> FloatArray:
        """Loss on a line of sight, any shape [dB]."""
        distance_m = np.maximum(distance_m, NEAREST_M)
        height_m, log_f = self.antenna_m - 1.0, np.log10(self.frequency_ghz)
        other_m = height_m if self.other_antenna_m is None else self.other_antenna_m - 1.0
        lift_db = 17.3 * (np.log10(height_m) + np.log10(other_m))
        break_m = 4.0 * height_m * other_m * self.frequency_ghz * 1e9 / LIGHT_MPS
        near = 22.7 * np.log10(distance_m) + 27.0 + 20.0 * log_f
        far = 40.0 * np.log10(distance_m) + 7.56 - lift_db + 2.7 * log_f
        return np.asarray(np.where(distance_m <= break_m, near, far), dtype=np.float64)

    def height_gain_db(self, height_m: float) -> float:
        """What another height of one antenna adds to a link beyond both break points [dB].

        Parameters
        ----------
        height_m
            Height over the road in place of `antenna_m`, above 1 m [m].

        Raises
        ------
        ValueError
            Where the height is not above 1 m.

        Examples
        --------
        >>> round(WinnerB1().height_gain_db(1.2), 1)
        -6.9
        """
        _positive(effective_height_m=height_m - 1.0)
        return float(17.3 * np.log10((height_m - 1.0) / (self.antenna_m - 1.0)))


@dataclass(frozen=True, slots=True)
class Tr37885(AbstractPathLoss):
    """3GPP TR 37.885: intercept + slope log d + frequency slope log f.

    Parameters
    ----------
    intercept_db, slope_db, frequency_slope_db
        The three numbers of table 6.2.1-1.
    frequency_ghz
        Carrier [GHz].

    References
    ----------
    3GPP TR 37.885, table 6.2.1-1. The numbers are second-hand.
    """

    intercept_db: float
    slope_db: float
    _: KW_ONLY
    frequency_slope_db: float
    frequency_ghz: float = 5.9

    def __post_init__(self) -> None:
        _positive(slope_db=self.slope_db, frequency_ghz=self.frequency_ghz)

    @classmethod
    def highway(cls) -> Self:
        """Highway, line of sight or cars in between."""
        return cls(32.4, 20.0, frequency_slope_db=20.0)

    @classmethod
    def urban(cls) -> Self:
        """Street, line of sight or cars in between."""
        return cls(38.77, 16.7, frequency_slope_db=18.2)

    @classmethod
    def nlos(cls) -> Self:
        """Building in between."""
        return cls(36.85, 30.0, frequency_slope_db=18.9)

    def loss_db(self, distance_m: FloatArray) -> FloatArray:
        """Loss of the formula, any shape [dB]."""
        log_d = np.log10(np.maximum(distance_m, NEAREST_M))
        return (
            self.intercept_db + self.slope_db * log_d + self.frequency_slope_db * np.log10(self.frequency_ghz)
        )


@dataclass(frozen=True, slots=True)
class ManhattanNlos:
    """Round one corner of a street grid, WINNER+ B1.

    Parameters
    ----------
    los
        Loss along the first street.
    corner_db
        Constant of the corner; 17.3 here, 17.9 and 20 are in circulation too [dB].
    frequency_slope_db
        Times log f, with f in GHz; 3 here. The variant with 20 uses log(f/5) [dB].

    References
    ----------
    WINNER+ D5.3, table 4-1, as used in 3GPP TR 36.885, A.1.4. The constants are disputed.
    """

    los: AbstractPathLoss = field(default_factory=WinnerB1)
    corner_db: float = 17.3
    _: KW_ONLY
    frequency_slope_db: float = 3.0
    frequency_ghz: float = 5.9

    def __post_init__(self) -> None:
        _positive(frequency_ghz=self.frequency_ghz)

    @property
    def constant_db(self) -> float:
        """What does not depend on distance [dB]."""
        return self.corner_db + self.frequency_slope_db * float(np.log10(self.frequency_ghz))

    def loss_db(self, first_m: FloatArray, second_m: FloatArray) -> FloatArray:
        """Loss of a link along two streets, the smaller of both orders, any shape [dB].

        Parameters
        ----------
        first_m, second_m
            Ways along the two streets, any common shape [m].
        """
        first_m, second_m = np.maximum(first_m, NEAREST_M), np.maximum(second_m, NEAREST_M)
        return np.minimum(self._one_way_db(first_m, second_m), self._one_way_db(second_m, first_m))

    def _one_way_db(self, first_m: FloatArray, second_m: FloatArray) -> FloatArray:
        exponent = np.maximum(2.8 - 0.0024 * first_m, 1.84)
        turned = 10.0 * exponent * np.log10(second_m) - 12.5 * exponent
        return np.asarray(self.los.loss_db(first_m) + self.constant_db + turned, dtype=np.float64)
