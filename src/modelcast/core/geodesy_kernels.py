"""Compiled places: between a local plane and the surface of one height, and the place that a message states.

Local east and north stand for the point at the origin's height above the ellipsoid that has them in the
origin's east-north-up frame. Far from the origin this point lies below the plane: 200 m at 50 km. So every
place within `FARTHEST_M` has one latitude and longitude, and these have one place.

A message states latitude and longitude as whole numbers of 1e-7 degree. One of latitude is 11.06 mm at the
equator and 11.17 mm at the poles. One of longitude is 11.13 mm times the cosine of the latitude, to 0.4 %:
5.6 mm at 60 degrees.

A frame is the vector that `modelcast.core.geodesy.frame_constants` makes. Sums are never regrouped, and
batches call the functions for one row, so that a row has the same bits alone and in a batch.
"""

from math import atan2, cos, hypot, pi, sin, sqrt

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntMatrix

__all__ = [
    "ALTITUDE_M",
    "CODES_PER_DEGREE",
    "COS_LATITUDE",
    "COS_LONGITUDE",
    "ECEF_X_M",
    "ECEF_Y_M",
    "ECEF_Z_M",
    "FARTHEST_M",
    "FRAME_SIZE",
    "LAST_LATITUDE_CODE",
    "NO_LATITUDE_CODE",
    "NO_LONGITUDE_CODE",
    "SIN_LATITUDE",
    "SIN_LONGITUDE",
    "earth_centred",
    "place_of",
    "places_of",
    "state_place",
    "state_places",
    "stated",
    "stated_places",
    "to_geodetic",
    "to_geodetic_rows",
    "to_local",
    "to_local_rows",
]

(
    ECEF_X_M,
    ECEF_Y_M,
    ECEF_Z_M,
    SIN_LATITUDE,
    COS_LATITUDE,
    SIN_LONGITUDE,
    COS_LONGITUDE,
    ALTITUDE_M,
) = range(8)
FRAME_SIZE = 8
"""A frame: the origin Earth-centred, sines and cosines of its latitude and longitude, its height."""

FARTHEST_M = 500_000.0
"""How far from the origin places are; what is farther has none (NaN, or the codes for unavailable)."""

CODES_PER_DEGREE = 10_000_000
HALF_TURN_CODE = 180 * CODES_PER_DEGREE
NO_LATITUDE_CODE = 900_000_001
NO_LONGITUDE_CODE = 1_800_000_001
"""Codes of SAE J2735 for unavailable."""

LAST_LATITUDE_CODE = 899_900_000
"""89.99 degrees: nearer to a pole a step of longitude comes down to the rounding of positions."""

_RADIUS_M = 6_378_137.0
_FLATTENING = 1.0 / 298.257223563
_POLAR_M = _RADIUS_M * (1.0 - _FLATTENING)
_SQUARED = _FLATTENING * (2.0 - _FLATTENING)
_SECOND_SQUARED = _SQUARED / (1.0 - _SQUARED)

_MARGIN_M = 1.0
"""How much farther than `FARTHEST_M` a position may be stated: what was stated can be stated again."""
_SETTLED_M = 1e-9
_MOST_STEPS = 8


@kernel
def earth_centred(latitude_deg: float, longitude_deg: float, altitude_m: float) -> tuple[float, float, float]:
    """Return the Earth-centred, Earth-fixed position of a place on WGS-84 [m]."""
    latitude, longitude = latitude_deg * pi / 180.0, longitude_deg * pi / 180.0
    sine, cosine = sin(latitude), cos(latitude)
    normal = _RADIUS_M / sqrt(1.0 - _SQUARED * sine * sine)
    outwards = (normal + altitude_m) * cosine
    return (
        outwards * cos(longitude),
        outwards * sin(longitude),
        (normal * (1.0 - _SQUARED) + altitude_m) * sine,
    )


@kernel
def _upwards(axial_m: float, z_m: float) -> tuple[float, float, float]:
    """Return sine and cosine of the latitude and the height [m] of a point, by Bowring's rule, twice."""
    sine, cosine = z_m * _RADIUS_M, axial_m * _POLAR_M  # of the reduced latitude
    up, out = sine, cosine
    for _ in range(2):
        size = hypot(sine, cosine)
        sine, cosine = sine / size, cosine / size
        up = z_m + _SECOND_SQUARED * _POLAR_M * sine * sine * sine
        out = axial_m - _SQUARED * _RADIUS_M * cosine * cosine * cosine
        sine, cosine = (1.0 - _FLATTENING) * up, out
    size = hypot(up, out)
    sine, cosine = up / size, out / size
    height_m = axial_m * cosine + z_m * sine - _RADIUS_M * sqrt(1.0 - _SQUARED * sine * sine)
    return sine, cosine, height_m


@kernel
def to_geodetic(frame: FloatVector, east_m: float, north_m: float) -> tuple[float, float]:
    """Return latitude and longitude [deg] of a place; NaN where it is too far or not known.

    Newton's rule finds the point at the origin's height straight above or below the one of the plane.
    """
    distance_m = hypot(east_m, north_m)
    if not distance_m <= FARTHEST_M + _MARGIN_M:
        return np.nan, np.nan
    sine, cosine = frame[SIN_LATITUDE], frame[COS_LATITUDE]
    sine_east, cosine_east = frame[SIN_LONGITUDE], frame[COS_LONGITUDE]
    up_m = -0.5 * distance_m * distance_m / _RADIUS_M
    x, y, z, axial_m, sine_there, cosine_there = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for _ in range(_MOST_STEPS):
        outwards = cosine * up_m - sine * north_m
        x = frame[ECEF_X_M] + (cosine_east * outwards - sine_east * east_m)
        y = frame[ECEF_Y_M] + (sine_east * outwards + cosine_east * east_m)
        z = frame[ECEF_Z_M] + (sine * up_m + cosine * north_m)
        axial_m = hypot(x, y)
        sine_there, cosine_there, height_m = _upwards(axial_m, z)
        slope = sine_there * sine
        if axial_m > 0.0:
            slope += cosine_there * cosine * (x * cosine_east + y * sine_east) / axial_m
        step_m = (height_m - frame[ALTITUDE_M]) / slope
        if abs(step_m) <= _SETTLED_M:
            break
        up_m -= step_m
    return atan2(sine_there, cosine_there) * 180.0 / pi, atan2(y, x) * 180.0 / pi


@kernel
def to_local(frame: FloatVector, latitude_deg: float, longitude_deg: float) -> tuple[float, float]:
    """Return east and north [m] of a place; NaN where it is too far or not known."""
    x, y, z = earth_centred(latitude_deg, longitude_deg, frame[ALTITUDE_M])
    x, y, z = x - frame[ECEF_X_M], y - frame[ECEF_Y_M], z - frame[ECEF_Z_M]
    outwards = frame[COS_LONGITUDE] * x + frame[SIN_LONGITUDE] * y
    east_m = frame[COS_LONGITUDE] * y - frame[SIN_LONGITUDE] * x
    north_m = frame[COS_LATITUDE] * z - frame[SIN_LATITUDE] * outwards
    up_m = frame[COS_LATITUDE] * outwards + frame[SIN_LATITUDE] * z
    # The far side of the Earth has small easts and norths too, and is far below.
    if not (hypot(east_m, north_m) <= FARTHEST_M and up_m > -FARTHEST_M):
        return np.nan, np.nan
    return east_m, north_m


@kernel
def state_place(frame: FloatVector, east_m: float, north_m: float) -> tuple[int, int]:
    """Return the nearest codes of latitude and longitude, those for unavailable where there are none."""
    latitude_deg, longitude_deg = to_geodetic(frame, east_m, north_m)
    if not abs(latitude_deg) * CODES_PER_DEGREE < LAST_LATITUDE_CODE + 0.5:
        return NO_LATITUDE_CODE, NO_LONGITUDE_CODE
    latitude = int(np.rint(latitude_deg * CODES_PER_DEGREE))
    longitude = int(np.rint(longitude_deg * CODES_PER_DEGREE))
    if longitude <= -HALF_TURN_CODE:
        longitude += 2 * HALF_TURN_CODE
    return latitude, longitude


@kernel
def place_of(frame: FloatVector, latitude_code: int, longitude_code: int) -> tuple[float, float]:
    """Return east and north [m] of what a message states; NaN where too far, too near a pole, or no place."""
    if abs(latitude_code) > LAST_LATITUDE_CODE or abs(longitude_code) > HALF_TURN_CODE:
        return np.nan, np.nan
    return to_local(frame, latitude_code / CODES_PER_DEGREE, longitude_code / CODES_PER_DEGREE)


@kernel
def stated(frame: FloatVector, east_m: float, north_m: float) -> tuple[float, float]:
    """Return east and north [m] as the receiver of a message has them; stated once more, they stay."""
    latitude_code, longitude_code = state_place(frame, east_m, north_m)
    return place_of(frame, latitude_code, longitude_code)


@kernel
def to_geodetic_rows(frame: FloatVector, local_m: FloatMatrix, out_deg: FloatMatrix) -> None:
    """Latitudes and longitudes [deg] of places, (N, 2) both."""
    for i in range(local_m.shape[0]):
        out_deg[i, 0], out_deg[i, 1] = to_geodetic(frame, local_m[i, 0], local_m[i, 1])


@kernel
def to_local_rows(frame: FloatVector, places_deg: FloatMatrix, out_m: FloatMatrix) -> None:
    """Easts and norths [m] of places, (N, 2) both."""
    for i in range(places_deg.shape[0]):
        out_m[i, 0], out_m[i, 1] = to_local(frame, places_deg[i, 0], places_deg[i, 1])


@kernel
def state_places(frame: FloatVector, local_m: FloatMatrix, out_codes: IntMatrix) -> None:
    """Codes of places, (N, 2) both."""
    for i in range(local_m.shape[0]):
        out_codes[i, 0], out_codes[i, 1] = state_place(frame, local_m[i, 0], local_m[i, 1])


@kernel
def places_of(frame: FloatVector, codes: IntMatrix, out_m: FloatMatrix) -> None:
    """Easts and norths [m] of codes, (N, 2) both."""
    for i in range(codes.shape[0]):
        out_m[i, 0], out_m[i, 1] = place_of(frame, codes[i, 0], codes[i, 1])


@kernel
def stated_places(frame: FloatVector, local_m: FloatMatrix, out_m: FloatMatrix) -> None:
    """Easts and norths [m] as receivers have them, (N, 2) both."""
    for i in range(local_m.shape[0]):
        out_m[i, 0], out_m[i, 1] = stated(frame, local_m[i, 0], local_m[i, 1])
