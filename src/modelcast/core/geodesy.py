"""One Earth model, one distance, one way to wrap an angle.

Local positions are east-north-up on the WGS-84 ellipsoid about an origin, by pymap3d. Headings are
clockwise from true north, as in SAE J2735; yaw angles are anticlockwise from east.
"""

from dataclasses import dataclass
from typing import cast

import numpy as np
import pymap3d  # its results are untyped: this is the one module that imports it

from modelcast.core.arrays import FloatArray

__all__ = [
    "Origin",
    "ecef_to_enu",
    "enu_to_geodetic",
    "enu_to_surface",
    "geodetic_to_enu",
    "heading_to_velocity",
    "wrap_angle_rad",
]


@dataclass(frozen=True, slots=True)
class Origin:
    """The point of the WGS-84 ellipsoid that a local east-north-up frame touches.

    Parameters
    ----------
    latitude_deg, longitude_deg
        Geodetic position [deg].
    altitude_m
        Height above the ellipsoid [m].
    """

    latitude_deg: float
    longitude_deg: float
    altitude_m: float = 0.0


def geodetic_to_enu(
    latitude_deg: FloatArray, longitude_deg: FloatArray, altitude_m: FloatArray, origin: Origin
) -> FloatArray:
    """Local east, north and up of WGS-84 positions.

    Parameters
    ----------
    latitude_deg, longitude_deg
        Geodetic positions, (T,) [deg].
    altitude_m
        Heights above the ellipsoid, (T,) [m].
    origin
        Where the local frame touches the ellipsoid.

    Returns
    -------
    FloatArray
        East, north, up, (T, 3) [m].

    Examples
    --------
    >>> import numpy as np
    >>> at = Origin(42.0, -83.0)
    >>> geodetic_to_enu(np.array([42.0]), np.array([-83.0]), np.array([0.0]), at).round(6) + 0.0
    array([[0., 0., 0.]])
    """
    enu = cast(
        "object",
        pymap3d.geodetic2enu(
            latitude_deg,
            longitude_deg,
            altitude_m,
            origin.latitude_deg,
            origin.longitude_deg,
            origin.altitude_m,
        ),
    )
    return _stacked(enu)


def ecef_to_enu(ecef_m: FloatArray, origin: Origin | None = None) -> tuple[FloatArray, Origin]:
    """Local east, north and up of Earth-centred positions, about their first where no origin is given.

    Parameters
    ----------
    ecef_m
        Earth-centred, Earth-fixed positions, (T, 3) [m].
    origin
        Where the local frame touches the ellipsoid.

    Returns
    -------
    tuple[FloatArray, Origin]
        East, north, up, (T, 3) [m], and the origin used.
    """
    if origin is None:
        latitude, longitude, altitude = cast(
            "tuple[float, float, float]", pymap3d.ecef2geodetic(ecef_m[0, 0], ecef_m[0, 1], ecef_m[0, 2])
        )
        origin = Origin(float(latitude), float(longitude), float(altitude))
    enu = cast(
        "object",
        pymap3d.ecef2enu(
            ecef_m[:, 0],
            ecef_m[:, 1],
            ecef_m[:, 2],
            origin.latitude_deg,
            origin.longitude_deg,
            origin.altitude_m,
        ),
    )
    return _stacked(enu), origin


def enu_to_geodetic(enu_m: FloatArray, origin: Origin) -> FloatArray:
    """Latitude and longitude [deg] and height above the ellipsoid [m] of local positions, (T, 3).

    Parameters
    ----------
    enu_m
        East, north, up, (T, 3) [m].
    origin
        Where the local frame touches the ellipsoid.

    Examples
    --------
    >>> import numpy as np
    >>> enu_to_geodetic(np.zeros((1, 3)), Origin(42.0, -83.0)).round(6) + 0.0
    array([[ 42., -83.,   0.]])
    """
    geodetic = cast(
        "object",
        pymap3d.enu2geodetic(
            enu_m[:, 0],
            enu_m[:, 1],
            enu_m[:, 2],
            origin.latitude_deg,
            origin.longitude_deg,
            origin.altitude_m,
        ),
    )
    return _stacked(geodetic)


def enu_to_surface(enu_m: FloatArray, origin: Origin) -> FloatArray:
    """Points of the ellipsoid under local positions, Earth-centred: one frame for places anywhere on Earth.

    Heights are dropped, since receivers do not agree on what they are measured from.

    Parameters
    ----------
    enu_m
        East, north, up, (T, 3) [m].
    origin
        Where the local frame touches the ellipsoid.

    Returns
    -------
    FloatArray
        Earth-centred, Earth-fixed positions at height 0, (T, 3) [m].

    Examples
    --------
    Two frames give the same place the same point:

    >>> import numpy as np
    >>> at, beside = Origin(42.0, -83.0), Origin(42.01, -83.0, 250.0)
    >>> place = np.array([42.005]), np.array([-83.0]), np.array([100.0])
    >>> one, other = (enu_to_surface(geodetic_to_enu(*place, frame), frame) for frame in (at, beside))
    >>> bool(np.abs(one - other).max() < 1e-6)
    True
    """
    latitude_deg, longitude_deg, _ = enu_to_geodetic(enu_m, origin).T
    return _stacked(cast("object", pymap3d.geodetic2ecef(latitude_deg, longitude_deg, 0.0 * latitude_deg)))


def _stacked(enu: object) -> FloatArray:
    """Return pymap3d's three axes as one (T, 3) array."""
    axes = cast("tuple[FloatArray, FloatArray, FloatArray]", enu)
    return np.stack([np.asarray(axis, dtype=np.float64) for axis in axes], axis=-1)


def wrap_angle_rad(angle_rad: FloatArray) -> FloatArray:
    """Angles brought into [-pi, pi).

    Examples
    --------
    >>> import numpy as np
    >>> wrap_angle_rad(np.array([0.0, 3.5, -3.5])).round(3)
    array([ 0.   , -2.783,  2.783])
    """
    wrapped = (angle_rad + np.pi) % (2.0 * np.pi) - np.pi
    return np.where(wrapped >= np.pi, -np.pi, wrapped)  # the remainder may round up to a whole turn


def heading_to_velocity(speed_mps: FloatArray, heading_rad: FloatArray) -> FloatArray:
    """East and north velocity of a speed along a heading, (..., 2) [m/s].

    Parameters
    ----------
    speed_mps
        Speeds, (...) [m/s].
    heading_rad
        Headings clockwise from true north, (...) [rad].

    Examples
    --------
    >>> import numpy as np
    >>> heading_to_velocity(np.array([10.0]), np.array([np.pi / 2])).round(6)
    array([[10.,  0.]])
    """
    return np.stack([speed_mps * np.sin(heading_rad), speed_mps * np.cos(heading_rad)], axis=-1)
