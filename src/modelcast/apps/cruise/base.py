"""What a follower knows, and what a cruise control law makes of it."""

import abc
from dataclasses import KW_ONLY, dataclass, fields
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from modelcast.apps.motions import Motions
from modelcast.core.arrays import BoolArray, FloatArray

__all__ = ["AbstractCruiseLaw", "ComplexArray", "Following", "Ranging", "following"]

ComplexArray = npt.NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class Ranging:
    """What an on-board ranging sensor shows of the vehicle ahead.

    Parameters
    ----------
    gap_m
        From its rear bumper to the own front bumper, (N,) [m].
    closing_mps
        Own speed less its speed, (N,) [m/s].
    """

    gap_m: FloatArray
    closing_mps: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Following:
    """N followers at one instant; what is not known is NaN.

    Parameters
    ----------
    speed_mps, acceleration_mps2
        Own, along the course, (N,) [m/s], [m/s²].
    commanded_mps2
        The acceleration asked for last, (N,) [m/s²].
    gap_m
        From the rear bumper of the vehicle ahead to the own front bumper, (N,) [m].
    ahead_speed_mps, ahead_acceleration_mps2
        Of the vehicle ahead, (N,) [m/s], [m/s²].
    leader_speed_mps, leader_acceleration_mps2
        Of the platoon's leader, (N,) [m/s], [m/s²].

    Raises
    ------
    ValueError
        Where shapes differ.
    """

    speed_mps: FloatArray
    acceleration_mps2: FloatArray
    _: KW_ONLY
    commanded_mps2: FloatArray
    gap_m: FloatArray
    ahead_speed_mps: FloatArray
    ahead_acceleration_mps2: FloatArray
    leader_speed_mps: FloatArray
    leader_acceleration_mps2: FloatArray

    def __post_init__(self) -> None:
        shape = self.speed_mps.shape
        for one in fields(self):
            found = getattr(self, one.name).shape
            if found != shape or len(shape) != 1:
                raise ValueError(f"all columns must have one shape (N,), got {one.name} {found} for {shape}")

    def __len__(self) -> int:
        return int(self.speed_mps.size)


class AbstractCruiseLaw(abc.ABC):
    """A law of longitudinal control: a function of what is known, row by row."""

    name: ClassVar[str]
    """Short name, as in tables."""

    needs: ClassVar[tuple[str, ...]]
    """Columns of `Following` without which the law says nothing."""

    @abc.abstractmethod
    def acceleration(self, known: Following, dt_s: float) -> FloatArray:
        """Return the acceleration asked for, (N,) [m/s²]; NaN where something it needs is.

        Parameters
        ----------
        known
            What each follower knows.
        dt_s
            Time since it was asked last [s].
        """

    @abc.abstractmethod
    def gap_m(self, speed_mps: FloatArray) -> FloatArray:
        """Gap at which the law is content at a steady speed, of the same shape [m].

        Parameters
        ----------
        speed_mps
            Own speed [m/s].
        """

    @abc.abstractmethod
    def response(
        self, s: ComplexArray, ahead: ComplexArray, leader: ComplexArray, lag_s: float
    ) -> ComplexArray:
        """Position of a follower in the Laplace domain, where it knows all at once and meets no limit.

        Parameters
        ----------
        s
            Frequencies, j omega for a steady swing, any shape [rad/s].
        ahead, leader
            Positions of the vehicle ahead and of the leader there, of the same shape.
        lag_s
            First-order lag of the drive [s].
        """

    def knows_enough(self, known: Following) -> BoolArray:
        """Where all that the law needs is known, (N,).

        Parameters
        ----------
        known
            What each follower knows.
        """
        enough: BoolArray = np.ones(len(known), dtype=np.bool_)
        for name in self.needs:
            enough &= ~np.isnan(getattr(known, name))
        return enough


def following(
    own: Motions,
    ahead: Motions,
    leader: Motions,
    *,
    commanded_mps2: FloatArray,
    ranging: Ranging | None = None,
) -> Following:
    """What followers know: all from what they believe, or the vehicle ahead's place and speed from a sensor.

    Parameters
    ----------
    own
        N followers.
    ahead, leader
        What each believes of the vehicle ahead and of the platoon's leader; NaN where it believes nothing.
    commanded_mps2
        The acceleration asked for last, (N,) [m/s²].
    ranging
        What a ranging sensor shows; None where there is none, and the gap is that between believed places,
        along the own course.

    Raises
    ------
    ValueError
        Where the numbers of rows differ.

    Examples
    --------
    >>> own = Motions.of([[0.0, 0.0]], speed_mps=[20.0], heading_rad=[0.0], length_m=4.0)
    >>> ahead = Motions.of([[0.0, 9.0]], speed_mps=[21.0], heading_rad=[0.0], length_m=4.0)
    >>> following(own, ahead, ahead, commanded_mps2=np.zeros(1)).gap_m.tolist()
    [5.0]
    """
    if ranging is None:
        away_m = ahead.position_m - own.position_m
        along_m = away_m[:, 0] * np.sin(own.heading_rad) + away_m[:, 1] * np.cos(own.heading_rad)
        gap_m = along_m - 0.5 * (own.length_m + ahead.length_m)
        ahead_speed_mps = ahead.speed_mps
    else:
        gap_m, ahead_speed_mps = ranging.gap_m, own.speed_mps - ranging.closing_mps
    return Following(
        own.speed_mps,
        own.acceleration_mps2,
        commanded_mps2=commanded_mps2,
        gap_m=gap_m,
        ahead_speed_mps=ahead_speed_mps,
        ahead_acceleration_mps2=ahead.acceleration_mps2,
        leader_speed_mps=leader.speed_mps,
        leader_acceleration_mps2=leader.acceleration_mps2,
    )
