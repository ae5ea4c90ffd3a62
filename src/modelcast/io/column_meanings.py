"""What a column of a table may mean, in which unit, and the names it is found under without a map.

======================  ==========================  ==================================================
Meaning                 Unit                        Names found without a map
======================  ==========================  ==================================================
t                       s, or told by the values    t_s, time_s (seconds for certain), t, time
t_ms, t_us, t_ns        ms, µs, ns                  t_ms, time_ms; t_us, time_us; t_ns, time_ns
t_days                  days, as spreadsheets count
t_dmy, t_mdy            dates, day or month first
east, north, up         m                           east_m, east, x; north_m, north, y; up_m, up, z
east_ft, north_ft,      ft                          east_ft; north_ft; up_ft
up_ft
lat, lon, alt           deg, deg, m                 latitude_deg, latitude, lat; longitude_deg,
                                                    longitude, lon; altitude_m, altitude, alt
lat_e7, lon_e7          1e-7 deg                    latitude_e7, lat_e7; longitude_e7, lon_e7
lat_rad, lon_rad        rad                         latitude_rad, lat_rad; longitude_rad, lon_rad
alt_ft                  ft                          altitude_ft, alt_ft
speed, speed_kmh        m/s, km/h                   speed_mps, speed; speed_kmh
speed_mph, speed_kn,    mile/h, knot, ft/s          speed_mph; speed_kn, speed_knots; speed_ftps
speed_ftps
heading_rad, _deg       from north, clockwise       heading_rad; heading_deg
yaw_rad, _deg           from east, anticlockwise
yaw_rate_radps,         rad/s, deg/s, clockwise     yaw_rate_radps; yaw_rate_degps
yaw_rate_degps
yaw_rate_left_radps,    rad/s, deg/s, anticlockwise
yaw_rate_left_degps
acceleration            m/s²                        acceleration_mps2
acceleration_ftps2, _g  ft/s², 9.80665 m/s²         acceleration_ftps2; acceleration_g
vehicle                 name of the vehicle         vehicle, vehicle_id
trip                    complete identifier         trip
origin_lat, _lon,       deg, deg, m; constant in a  origin_latitude_deg, origin_longitude_deg,
_alt                    trip, with east and north   origin_altitude_m
start_unix              s, Unix time of t = 0;      start_unix_s
                        constant in a trip
======================  ==========================  ==================================================

These names are case-sensitive. What they leave open, names that others use tell (``GPS Time``,
``Speed (km/h)``: `modelcast.io.header_names`). Angles have no default unit: a plain ``heading`` has to be
mapped. `modelcast.io.time_column` says how the values of a time column tell their unit.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from types import MappingProxyType

__all__ = ["GEODETIC", "LABELS", "LOCAL", "MEANINGS", "PLACED", "Meaning", "filled"]

_DEG = 0.017453292519943295
_FOOT_M = 0.3048
"""The international foot; that of the United States' surveys is 2 millionths longer."""
_MILE_M = 5280 * _FOOT_M
_NAUTICAL_MILE_M = 1852.0
_GRAVITY_MPS2 = 9.80665
"""Standard gravity (ISO 80000-3)."""
_DAY_S = 86400.0


@dataclass(frozen=True, slots=True)
class Meaning:
    """What a column holds.

    Parameters
    ----------
    fills
        The SI column it fills.
    factor
        The factor to SI; a negative one turns the other way round, and a heading with it counts from east.
    names
        The names it is found under.
    """

    fills: str
    factor: float
    names: tuple[str, ...] = ()


MEANINGS: Mapping[str, Meaning] = MappingProxyType(
    {
        "t": Meaning("t_s", 1.0, ("t_s", "time_s", "t", "time")),
        "t_ms": Meaning("t_s", 1e-3, ("t_ms", "time_ms")),
        "t_us": Meaning("t_s", 1e-6, ("t_us", "time_us")),
        "t_ns": Meaning("t_s", 1e-9, ("t_ns", "time_ns")),
        "t_days": Meaning("t_s", _DAY_S),
        "t_dmy": Meaning("t_s", 1.0),
        "t_mdy": Meaning("t_s", 1.0),
        "east": Meaning("east_m", 1.0, ("east_m", "east", "x")),
        "north": Meaning("north_m", 1.0, ("north_m", "north", "y")),
        "up": Meaning("up_m", 1.0, ("up_m", "up", "z")),
        "east_ft": Meaning("east_m", _FOOT_M, ("east_ft",)),
        "north_ft": Meaning("north_m", _FOOT_M, ("north_ft",)),
        "up_ft": Meaning("up_m", _FOOT_M, ("up_ft",)),
        "lat": Meaning("latitude_deg", 1.0, ("latitude_deg", "latitude", "lat")),
        "lon": Meaning("longitude_deg", 1.0, ("longitude_deg", "longitude", "lon")),
        "lat_e7": Meaning("latitude_deg", 1e-7, ("latitude_e7", "lat_e7")),
        "lon_e7": Meaning("longitude_deg", 1e-7, ("longitude_e7", "lon_e7")),
        "lat_rad": Meaning("latitude_deg", 1 / _DEG, ("latitude_rad", "lat_rad")),
        "lon_rad": Meaning("longitude_deg", 1 / _DEG, ("longitude_rad", "lon_rad")),
        "alt": Meaning("altitude_m", 1.0, ("altitude_m", "altitude", "alt")),
        "alt_ft": Meaning("altitude_m", _FOOT_M, ("altitude_ft", "alt_ft")),
        "speed": Meaning("speed_mps", 1.0, ("speed_mps", "speed")),
        "speed_kmh": Meaning("speed_mps", 1.0 / 3.6, ("speed_kmh",)),
        "speed_mph": Meaning("speed_mps", _MILE_M / 3600.0, ("speed_mph",)),
        "speed_kn": Meaning("speed_mps", _NAUTICAL_MILE_M / 3600.0, ("speed_kn", "speed_knots")),
        "speed_ftps": Meaning("speed_mps", _FOOT_M, ("speed_ftps",)),
        "heading_rad": Meaning("heading_rad", 1.0, ("heading_rad",)),
        "heading_deg": Meaning("heading_rad", _DEG, ("heading_deg",)),
        "yaw_rad": Meaning("heading_rad", -1.0),
        "yaw_deg": Meaning("heading_rad", -_DEG),
        "yaw_rate_radps": Meaning("yaw_rate_radps", 1.0, ("yaw_rate_radps",)),
        "yaw_rate_degps": Meaning("yaw_rate_radps", _DEG, ("yaw_rate_degps",)),
        "yaw_rate_left_radps": Meaning("yaw_rate_radps", -1.0),
        "yaw_rate_left_degps": Meaning("yaw_rate_radps", -_DEG),
        "acceleration": Meaning("acceleration_mps2", 1.0, ("acceleration_mps2",)),
        "acceleration_ftps2": Meaning("acceleration_mps2", _FOOT_M, ("acceleration_ftps2",)),
        "acceleration_g": Meaning("acceleration_mps2", _GRAVITY_MPS2, ("acceleration_g",)),
        "origin_lat": Meaning("origin_latitude_deg", 1.0, ("origin_latitude_deg",)),
        "origin_lon": Meaning("origin_longitude_deg", 1.0, ("origin_longitude_deg",)),
        "origin_alt": Meaning("origin_altitude_m", 1.0, ("origin_altitude_m",)),
        "start_unix": Meaning("start_unix_s", 1.0, ("start_unix_s",)),
        "vehicle": Meaning("vehicle", 1.0, ("vehicle", "vehicle_id")),
        "trip": Meaning("trip", 1.0, ("trip",)),
    }
)
"""The meanings, by the words of a column map; of two that fill the same the first goes before."""

LABELS = ("trip", "vehicle")
"""Meanings that are no numbers."""

LOCAL = ("east_m", "north_m")
GEODETIC = ("latitude_deg", "longitude_deg")
PLACED = frozenset({"t_s", *LOCAL, *GEODETIC})
"""What a table needs: a time, and one of the two positions."""


def filled(meanings: Collection[str]) -> set[str]:
    """Return the SI columns that meanings fill.

    Examples
    --------
    >>> sorted(filled(["t_ms", "lat"]))
    ['latitude_deg', 't_s']
    """
    return {MEANINGS[meaning].fills for meaning in meanings}
