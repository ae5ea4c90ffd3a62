"""How a node moves at a tick, by what it knows that, and what changed."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.node.inputs.reckoning import ellipse_of

__all__ = ["Change", "Health", "Mode", "Motion"]

Mode = Literal["gnss+can", "gnss", "can", "silent"]
"""What a motion is made of: fixes and the bus; fixes alone; the bus alone, by dead reckoning; nothing."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Motion:
    """A vehicle's motion at a tick, as `modelcast.station.station.Station.sense` takes it.

    Parameters
    ----------
    t_s
        The tick [s].
    mode
        What it is made of; never "silent".
    place_deg
        Latitude and longitude [deg].
    position_m
        East and north on the node's plane; NaN where that is too far [m].
    speed_mps, heading_rad, acceleration_mps2, yaw_rate_radps
        Along the vehicle; heading and yaw rate clockwise.
    derived
        Which of the four no source measures at this time: they follow from earlier fixes or bus values.
    covariance_m2
        Of the place, east and north, (2, 2) [m²].
    ellipse_known
        Whether the fix stated its error; where not, a message must say "unavailable" and the covariance
        begins with `modelcast.node.inputs.reckoning.DEFAULT_AXIS_M`.
    age_s
        Of the fix behind it [s].
    begins
        Whether it does not connect with the last one: after silence, or where the place jumped.
    altitude_m
        Of that fix, NaN where unknown [m].
    steering_rad, brake
        Off the bus, NaN and None where it does not say.
    """

    t_s: float
    mode: Mode
    place_deg: tuple[float, float]
    position_m: tuple[float, float]
    speed_mps: float
    heading_rad: float
    acceleration_mps2: float
    yaw_rate_radps: float
    derived: frozenset[str]
    covariance_m2: FloatArray
    ellipse_known: bool
    age_s: float
    begins: bool
    altitude_m: float = np.nan
    steering_rad: float = np.nan
    brake: bool | None = None

    @property
    def ellipse(self) -> tuple[float, float, float]:
        """Longer and shorter axis of one standard deviation [m], and the longer one's direction [rad]."""
        return ellipse_of(self.covariance_m2)


@dataclass(frozen=True, slots=True)
class Change:
    """Something that changed, for the log and the page.

    Parameters
    ----------
    t_s
        When it was noticed [s].
    what
        ``mode``, or ``frozen``.
    before, after
        Its values.
    why
        In words.
    """

    t_s: float
    what: Literal["mode", "frozen"]
    before: str
    after: str
    why: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Health:
    """How the inputs are.

    Parameters
    ----------
    mode, why
        What the last motion was made of, and why.
    fix_age_s, fix_stale_s
        Of the newest fix, infinite where there is none, and the age from which it is old [s].
    bus_ages_s
        Of the newest value of each quantity [s].
    frozen
        Quantities of the bus, and ``place``, that stand still and should not.
    counts
        Samples taken in, and left out by reason: "late", "overrun", "clock went back".
    """

    mode: Mode
    why: str
    fix_age_s: float
    fix_stale_s: float
    bus_ages_s: Mapping[str, float]
    frozen: frozenset[str]
    counts: Mapping[str, int]
