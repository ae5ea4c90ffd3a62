"""A trip driven at a time of UTC: the truth that players tell of and that maps are held against."""

from dataclasses import dataclass
from typing import final

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import local_to_geodetic
from modelcast.station.sensing.sensing import NOWHERE
from modelcast.trips.trajectory import Trajectory

__all__ = ["Drive", "Driven"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Driven:
    """A vehicle at an instant.

    Parameters
    ----------
    latitude_deg, longitude_deg
        WGS-84 [deg].
    speed_mps, heading_rad, acceleration_mps2, yaw_rate_radps
        Heading and yaw rate clockwise.
    """

    latitude_deg: float
    longitude_deg: float
    speed_mps: float
    heading_rad: float
    acceleration_mps2: float
    yaw_rate_radps: float


@final
class Drive:
    """A trip that begins at a time; before it the vehicle is where it begins, after it where it ends.

    Parameters
    ----------
    trip
        With speed, heading, acceleration and yaw rate; without an origin it is laid at
        `modelcast.station.sensing.sensing.NOWHERE`.
    begin_utc_s
        UTC of its first sample, since 1970 [s].

    Raises
    ------
    ValueError
        Where the trip lacks a column.

    Examples
    --------
    >>> from modelcast.node.demo import demo_trips
    >>> drive = Drive(demo_trips()["leader"], begin_utc_s=1_764_000_000.0)
    >>> round(drive.at(1_764_000_005.0).speed_mps, 1)
    14.0
    """

    def __init__(self, trip: Trajectory, *, begin_utc_s: float) -> None:
        columns = (trip.speed_mps, trip.heading_rad, trip.acceleration_mps2, trip.yaw_rate_radps)
        found: list[FloatArray] = [one for one in columns if one is not None]
        if len(found) < len(columns):
            raise ValueError(f"trip {trip.trip_id} must have speed, heading, acceleration and yaw rate")
        speed, heading, acceleration, yaw_rate = found
        self._t_s: FloatArray = trip.t_s + begin_utc_s - float(trip.t_s[0])
        self._origin = trip.origin or NOWHERE
        east, north = trip.position_m.T
        self._columns = (east, north, speed, np.unwrap(heading), acceleration, yaw_rate)

    def at(self, utc_s: float) -> Driven:
        """The vehicle at a time.

        Parameters
        ----------
        utc_s
            Since 1970 [s].
        """
        east, north, speed, heading, acceleration, yaw_rate = (
            float(np.interp(utc_s, self._t_s, column)) for column in self._columns
        )
        latitude, longitude = local_to_geodetic(np.array([[east, north]]), self._origin)[0].tolist()
        return Driven(
            latitude_deg=latitude,
            longitude_deg=longitude,
            speed_mps=speed,
            heading_rad=heading % (2.0 * np.pi),
            acceleration_mps2=acceleration,
            yaw_rate_radps=yaw_rate,
        )
