"""What a node knows of its own motion at an instant, and what gives it."""

import abc
from dataclasses import KW_ONLY, dataclass
from enum import StrEnum

__all__ = ["AbstractMotionSource", "Motion", "Source"]


class Source(StrEnum):
    """What a motion was made of."""

    BOTH = "gnss and can"
    GNSS = "gnss alone"
    CAN = "reckoned from can"
    RECORDED = "recorded"


@dataclass(frozen=True, slots=True)
class Motion:
    """How the vehicle moves at one instant, as its sensors have it.

    Parameters
    ----------
    t_s
        The instant, by the node's clock [s].
    place_deg
        Latitude and longitude [deg].
    speed_mps, heading_rad, acceleration_mps2, yaw_rate_radps
        Heading and yaw rate clockwise; None where nothing says it.
    sigma_m
        Standard deviation of the place along its worse axis, not a number where unknown [m].
    source
        What it was made of.
    begins
        Whether it does not connect with the one before, as after a jump of the receiver.
    """

    t_s: float
    place_deg: tuple[float, float]
    _: KW_ONLY
    speed_mps: float | None = None
    heading_rad: float | None = None
    acceleration_mps2: float | None = None
    yaw_rate_radps: float | None = None
    sigma_m: float = float("nan")
    source: Source = Source.GNSS
    begins: bool = False


class AbstractMotionSource(abc.ABC):
    """Gives the motion of the vehicle at the node's instants, from what has arrived by then."""

    @abc.abstractmethod
    def at(self, now_s: float) -> Motion | None:
        """Return the motion at an instant; None where nothing fresh enough tells it.

        Parameters
        ----------
        now_s
            The instant, later than the last call's [s].
        """
