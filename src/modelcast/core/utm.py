"""Positions of the Universal Transverse Mercator grid as latitude and longitude, on WGS-84."""

import numpy as np

from modelcast.core.arrays import FloatArray

__all__ = ["utm_to_geodetic", "utm_zone"]

_SEMI_MAJOR_M = 6_378_137.0
_FLATTENING = 1.0 / 298.257223563
_SCALE = 0.9996
_FALSE_EAST_M = 500_000.0
_FALSE_NORTH_M = 10_000_000.0

_N = _FLATTENING / (2.0 - _FLATTENING)
_RADIUS_M = _SEMI_MAJOR_M / (1.0 + _N) * (1.0 + _N**2 / 4.0 + _N**4 / 64.0)
_TO_SPHERE = (
    _N / 2.0 - 2.0 * _N**2 / 3.0 + 37.0 * _N**3 / 96.0,
    _N**2 / 48.0 + _N**3 / 15.0,
    17.0 * _N**3 / 480.0,
)
_TO_GEODETIC = (
    2.0 * _N - 2.0 * _N**2 / 3.0 - 2.0 * _N**3,
    7.0 * _N**2 / 3.0 - 8.0 * _N**3 / 5.0,
    56.0 * _N**3 / 15.0,
)


def utm_zone(longitude_deg: float) -> int:
    """Return the zone of a longitude; the exceptions of Norway and Svalbard are not made.

    Parameters
    ----------
    longitude_deg
        Within -180 to 180 [deg].

    Examples
    --------
    >>> utm_zone(6.1), utm_zone(-83.0)
    (32, 17)
    """
    return min(int((longitude_deg + 180.0) // 6.0) + 1, 60)


def utm_to_geodetic(
    east_m: FloatArray, north_m: FloatArray, *, zone: int, southern: bool = False
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return latitudes and longitudes, and where the grid's north points.

    Parameters
    ----------
    east_m, north_m
        Grid coordinates with their false origin, (T,) [m].
    zone
        1 to 60.
    southern
        Whether they are of the southern hemisphere.

    Returns
    -------
    tuple[FloatArray, FloatArray, FloatArray]
        Latitude, longitude, (T,) [deg], and the heading of the grid's north, clockwise from true north, (T,)
        [rad].

    Raises
    ------
    ValueError
        Where there is no such zone.

    Notes
    -----
    Krüger's series to the third order in the third flattening, within a millimetre in a zone.

    References
    ----------
    Kawase, K. (2011): A general formula for calculating meridian arc length and its application to coordinate
    conversion in the Gauss-Krüger projection. Bulletin of the Geospatial Information Authority of Japan 59.

    Examples
    --------
    >>> import numpy as np
    >>> latitude, longitude, turn = utm_to_geodetic(np.array([630084.0]), np.array([4833438.0]), zone=17)
    >>> latitude.round(4), longitude.round(4), np.degrees(turn).round(2)
    (array([43.6426]), array([-79.3871]), array([1.11]))
    """
    if not 1 <= zone <= 60:
        raise ValueError(f"zone must lie within 1..60, got {zone}")
    xi = (north_m - (_FALSE_NORTH_M if southern else 0.0)) / (_SCALE * _RADIUS_M)
    eta = (east_m - _FALSE_EAST_M) / (_SCALE * _RADIUS_M)
    sphere_xi, sphere_eta = xi, eta
    for order, factor in enumerate(_TO_SPHERE, start=1):
        sphere_xi = sphere_xi - factor * np.sin(2 * order * xi) * np.cosh(2 * order * eta)
        sphere_eta = sphere_eta - factor * np.cos(2 * order * xi) * np.sinh(2 * order * eta)
    conformal = np.arcsin(np.sin(sphere_xi) / np.cosh(sphere_eta))
    latitude = conformal
    for order, factor in enumerate(_TO_GEODETIC, start=1):
        latitude = latitude + factor * np.sin(2 * order * conformal)
    from_meridian = np.arctan2(np.sinh(sphere_eta), np.cos(sphere_xi))
    turn = np.arctan(np.tan(from_meridian) * np.sin(latitude))
    return np.degrees(latitude), np.degrees(from_meridian) + 6.0 * zone - 183.0, turn
