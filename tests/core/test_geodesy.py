"""Claims about the local frame, angles and velocities."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyproj import Transformer

from modelcast.core.geodesy import Origin, ecef_to_enu, geodetic_to_enu, heading_to_velocity, wrap_angle_rad

LIBRARY_M = 1e-3
"""What the two libraries may differ by; they agree to nanometres within kilometres."""

angles = st.floats(-1e4, 1e4)


def pyproj_enu(origin: Origin) -> Transformer:
    """Geodetic to east, north, up by PROJ's own topocentric pipeline."""
    return Transformer.from_pipeline(
        "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=cart +ellps=WGS84 "
        f"+step +proj=topocentric +ellps=WGS84 +lon_0={origin.longitude_deg!r} "
        f"+lat_0={origin.latitude_deg!r} +h_0={origin.altitude_m!r}"
    )


@given(
    latitude=st.floats(-85.0, 85.0),
    longitude=st.floats(-180.0, 180.0),
    altitude=st.floats(-400.0, 4000.0),
    seed=st.integers(0, 10_000),
)
def test_enu_agrees_with_pyproj_to_a_millimetre_within_a_hundred_kilometres(
    latitude: float, longitude: float, altitude: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    origin = Origin(latitude, longitude, altitude)
    lat, lon = latitude + rng.uniform(-0.5, 0.5, 20), longitude + rng.uniform(-0.5, 0.5, 20)
    up = altitude + rng.uniform(-200.0, 200.0, 20)
    expected = np.stack(pyproj_enu(origin).transform(lon, lat, up), axis=1)
    assert np.abs(geodetic_to_enu(lat, lon, up, origin) - expected).max() < LIBRARY_M


@given(latitude=st.floats(-85.0, 85.0), longitude=st.floats(-180.0, 180.0), seed=st.integers(0, 10_000))
def test_earth_centred_positions_give_the_same_local_ones(
    latitude: float, longitude: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    lat, lon = latitude + rng.uniform(-0.05, 0.05, 20), longitude + rng.uniform(-0.05, 0.05, 20)
    up = rng.uniform(0.0, 500.0, 20)
    to_ecef = Transformer.from_crs("EPSG:4979", "EPSG:4978")
    ecef = np.stack(to_ecef.transform(lat, lon, up), axis=1)
    local, origin = ecef_to_enu(ecef)
    assert np.abs(local[0]).max() < LIBRARY_M
    assert (origin.latitude_deg, origin.altitude_m) == pytest.approx((lat[0], up[0]), abs=1e-6)
    assert np.abs(local - geodetic_to_enu(lat, lon, up, origin)).max() < LIBRARY_M
    given_origin = Origin(latitude, longitude)
    assert ecef_to_enu(ecef, given_origin)[1] is given_origin


@given(angle=angles)
def test_a_wrapped_angle_lies_in_half_open_bounds_and_points_the_same_way(angle: float) -> None:
    wrapped = wrap_angle_rad(np.array([angle]))[0]
    assert -np.pi <= wrapped < np.pi
    assert np.cos(wrapped) == pytest.approx(np.cos(angle), abs=1e-9)
    assert np.sin(wrapped) == pytest.approx(np.sin(angle), abs=1e-9)


@given(angle=st.floats(-3.14, 3.14), turns=st.integers(-50, 50))
def test_whole_turns_change_nothing(angle: float, turns: int) -> None:
    assert wrap_angle_rad(np.array([angle + 2 * np.pi * turns]))[0] == pytest.approx(angle, abs=1e-9)


@pytest.mark.parametrize(
    "angle", [np.nextafter(-np.pi, -4), -np.pi, np.pi, np.nextafter(np.pi, 0), 3 * np.pi]
)
def test_the_bounds_themselves_stay_inside(angle: float) -> None:
    wrapped = wrap_angle_rad(np.array([angle]))[0]
    assert -np.pi <= wrapped < np.pi


@given(speed=st.floats(0.0, 80.0), heading=angles)
def test_velocity_has_the_speed_and_points_along_the_heading(speed: float, heading: float) -> None:
    east, north = heading_to_velocity(np.array([speed]), np.array([heading]))[0]
    assert np.hypot(east, north) == pytest.approx(speed)
    assert (east, north) == pytest.approx((speed * np.sin(heading), speed * np.cos(heading)))
