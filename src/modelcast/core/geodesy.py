"""One Earth model, one distance, one way to wrap an angle.

Local positions are east-north-up on the WGS-84 ellipsoid about an origin, by pymap3d. Headings are
clockwise from true north, as in SAE J2735; yaw angles are anticlockwise from east.

Where positions have no height, as in a message or on a plane, `local_to_geodetic` and `geodetic_to_local` are
each other's inverse: they go by the surface of the origin's height (`geodesy_kernels`).
"""

import math
from dataclasses import dataclass
from typing import cast

import numpy as np
import pymap3d  # its results are untyped: this is the one module that imports it

from modelcast.core import geodesy_kernels as kernels
from modelcast.core.arrays import FloatArray, owned

__all__ = [
    "Origin",
    "ecef_to_enu",
    "enu_to_geodetic",
    "enu_to_surface",
    "frame_constants",
    "geodetic_to_enu",
    "geodetic_to_local",
    "heading_to_velocity",
    "local_to_geodetic",
    "stated_local",
    "wrap_angle_rad",
]

_HIGHEST_M = 100_000.0


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


def frame_constants(origin: Origin) -> FloatArray:
    """What compiled code needs of a local frame, (`geodesy_kernels.FRAME_SIZE`,).

    Parameters
    ----------
    origin
        Where the local frame touches the ellipsoid.

    Raises
    ------
    ValueError
        Where it is no place on Earth.
    """
    latitude_deg, longitude_deg, altitude_m = origin.latitude_deg, origin.longitude_deg, origin.altitude_m
    if not (abs(latitude_deg) <= 90.0 and np.isfinite(longitude_deg)):
        raise ValueError(f"an origin is a latitude and a longitude, got {latitude_deg}, {longitude_deg} deg")
    if not abs(altitude_m) <= _HIGHEST_M:
        raise ValueError(f"an origin is within {_HIGHEST_M} m of the ellipsoid, got {altitude_m} m")
    frame = np.zeros(kernels.FRAME_SIZE)
    frame[: kernels.SIN_LATITUDE] = kernels.earth_centred(latitude_deg, longitude_deg, altitude_m)
    latitude, longitude = math.radians(latitude_deg), math.radians(longitude_deg)
    frame[kernels.SIN_LATITUDE], frame[kernels.COS_LATITUDE] = math.sin(latitude), math.cos(latitude)
    frame[kernels.SIN_LONGITUDE], frame[kernels.COS_LONGITUDE] = math.sin(longitude), math.cos(longitude)
    frame[kernels.ALTITUDE_M] = altitude_m
    return frame


def local_to_geodetic(local_m: FloatArray, origin: Origin) -> FloatArray:
    """Latitude and longitude of positions on a local plane, (T, 2) [deg].

    Parameters
    ----------
    local_m
        East and north, (T, 2) [m], of points at the origin's height.
    origin
        Of the local frame.

    Returns
    -------
    FloatArray
        NaN where a position is not known, or farther than `geodesy_kernels.FARTHEST_M` (and a metre).

    Examples
    --------
    >>> import numpy as np
    >>> at, place = Origin(42.0, -83.0), np.array([[30_000.0, -40_000.0]])
    >>> bool(np.abs(geodetic_to_local(local_to_geodetic(place, at), at) - place).max() < 1e-7)
    True
    """
    out_deg = np.empty((len(local_m), 2))
    kernels.to_geodetic_rows(frame_constants(origin), owned(local_m, np.float64), out_deg)
    return out_deg


def geodetic_to_local(places_deg: FloatArray, origin: Origin) -> FloatArray:
    """East and north of places at the origin's height, (T, 2) [m].

    Parameters
    ----------
    places_deg
        Latitude and longitude, (T, 2) [deg].
    origin
        Of the local frame.

    Returns
    -------
    FloatArray
        NaN where a place is not known, or farther than `geodesy_kernels.FARTHEST_M`.
    """
    out_m = np.empty((len(places_deg), 2))
    kernels.to_local_rows(frame_constants(origin), owned(places_deg, np.float64), out_m)
    return out_m


def stated_local(local_m: FloatArray, origin: Origin) -> FloatArray:
    """East and north as the receivers of a message have them, (T, 2) [m].

    Parameters
    ----------
    local_m
        East and north, (T, 2) [m].
    origin
        Of the local frame.

    Returns
    -------
    FloatArray
        NaN where a position has no codes, or they stand for one that is too far.
    """
    out_m = np.empty((len(local_m), 2))
    kernels.stated_places(frame_constants(origin), owned(local_m, np.float64), out_m)
    return out_m


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
