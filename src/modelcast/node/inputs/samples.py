"""What sources give: fixes and bus values, each with when it was measured and when it arrived."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

__all__ = ["AHEAD_S", "PLAUSIBLE", "SAME_S", "BusValue", "GnssFix", "Sample", "measured_at"]

AHEAD_S = 0.1
"""How far a fix may be dated after its arrival: clocks differ. It is then taken as of its arrival."""

SAME_S = 1e-6
"""Instants closer than this are one, as a tick and a recorded time that were computed in two ways."""

PLAUSIBLE: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "speed_mps": (-30.0, 100.0),
        "yaw_rate_radps": (-2.5, 2.5),
        "acceleration_mps2": (-20.0, 20.0),
        "steering_rad": (-25.0, 25.0),
        "brake": (0.0, 1.0),
    }
)
"""Quantities of a bus and the least and greatest value that a road vehicle shows.

Speed is negative backwards, yaw rate clockwise, acceleration along the vehicle, steering the wheel's angle
clockwise, brake 1 where the pedal is pressed. 2.5 rad/s is a turn of 4 m at 36 km/h; four turns of the
wheel are 25 rad.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class GnssFix:
    """A place at an instant, as a receiver of satellites states it; NaN where it does not.

    Parameters
    ----------
    received_s, measured_s
        When it arrived and when it was measured, not later, on the node's clock [s].
    latitude_deg, longitude_deg
        WGS-84 [deg].
    utc_s
        When it was measured by the receiver, since 1970 without leap seconds [s].
    altitude_m
        Above the ellipsoid [m].
    speed_mps, heading_rad
        Over ground; heading is the course, clockwise from true north.
    semi_major_m, semi_minor_m, ellipse_orientation_rad
        Error ellipse of one standard deviation, as in SAE J2735's PositionalAccuracy; orientation of the
        longer axis, clockwise from north. NaN is J2735's "unavailable".
    position_m
        East and north on the node's plane, where the source knows them better than by the angles [m].

    Raises
    ------
    ValueError
        Where it is no place on Earth, or measured after it arrived.
    """

    received_s: float
    measured_s: float
    latitude_deg: float
    longitude_deg: float
    utc_s: float = math.nan
    altitude_m: float = math.nan
    speed_mps: float = math.nan
    heading_rad: float = math.nan
    semi_major_m: float = math.nan
    semi_minor_m: float = math.nan
    ellipse_orientation_rad: float = math.nan
    position_m: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if not (abs(self.latitude_deg) <= 90.0 and abs(self.longitude_deg) <= 180.0):
            raise ValueError(
                f"a place is a latitude and a longitude, got {self.latitude_deg}, {self.longitude_deg}"
            )
        if not -math.inf < self.measured_s <= self.received_s < math.inf:
            raise ValueError(
                "a fix arrives after it was measured, "
                f"got {self.measured_s} s measured, {self.received_s} s received"
            )

    @property
    def has_ellipse(self) -> bool:
        """Whether its error is stated."""
        return math.isfinite(self.semi_major_m + self.semi_minor_m + self.ellipse_orientation_rad)


@dataclass(frozen=True, slots=True)
class BusValue:
    """One value off the vehicle's bus.

    Parameters
    ----------
    quantity
        A key of `PLAUSIBLE`.
    value
        In the quantity's unit.
    received_s
        When it arrived [s].
    measured_s
        When it was measured, not later [s]; a bus frame says nothing, so sources take its arrival.

    Raises
    ------
    ValueError
        Where the quantity is unknown, the value outside `PLAUSIBLE` or measured after it arrived.
    """

    quantity: str
    value: float
    received_s: float
    measured_s: float

    def __post_init__(self) -> None:
        if self.quantity not in PLAUSIBLE:
            raise ValueError(f"quantity must be one of {', '.join(PLAUSIBLE)}, got {self.quantity!r}")
        low, high = PLAUSIBLE[self.quantity]
        if not low <= self.value <= high:
            raise ValueError(f"{self.quantity} must be between {low} and {high}, got {self.value}")
        if not -math.inf < self.measured_s <= self.received_s < math.inf:
            raise ValueError(
                f"a value arrives after it was measured, got {self.measured_s} s and {self.received_s} s"
            )


Sample = GnssFix | BusValue
"""What `take` gives."""


def measured_at(received_s: float, utc_s: float, utc_at_zero_s: float) -> float:
    """When a fix was measured, on the node's clock [s].

    Parameters
    ----------
    received_s
        When it arrived [s].
    utc_s
        What it says, NaN where nothing: then it was measured when it arrived [s].
    utc_at_zero_s
        UTC at the node's 0 [s].

    Raises
    ------
    ValueError
        Where it is more than `AHEAD_S` ahead of its arrival: one of the two clocks is wrong.

    Examples
    --------
    >>> [measured_at(10.0, utc_s, 1000.0) for utc_s in (1009.5, 1010.05, math.nan)]
    [9.5, 10.0, 10.0]
    """
    if not math.isfinite(utc_s):
        return received_s
    measured_s = utc_s - utc_at_zero_s
    if measured_s > received_s + AHEAD_S:
        raise ValueError(f"a fix is dated {measured_s - received_s:.3f} s after it arrived")
    return min(measured_s, received_s)
