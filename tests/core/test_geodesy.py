"""Claims about the local frame, angles and velocities."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from pyproj import Transformer

from modelcast.core import geodesy_kernels as kernels
from modelcast.core.geodesy import (
    Origin,
    ecef_to_enu,
    enu_to_geodetic,
    frame_constants,
    geodetic_to_enu,
    geodetic_to_local,
    heading_to_velocity,
    local_to_geodetic,
    stated_local,
    wrap_angle_rad,
)

LIBRARY_M = 1e-3
"""What the two libraries may differ by; they agree to nanometres within kilometres."""

NEWTON_M = 1e-7
"""Rounding of Earth-centred positions, 1e-9 m, with room."""

PYMAP3D_M = 1e-6
"""Heights of pymap3d are no better."""

angles = st.floats(-1e4, 1e4)

ORIGINS = [
    Origin(0.0, 0.0),
    Origin(60.0, 10.0, 300.0),
    Origin(42.3, -83.7, 250.0),
    Origin(-33.9, 151.2, 50.0),
    Origin(52.0, 179.9999, -10.0),
    Origin(-16.8, -179.99, 4000.0),
    Origin(84.0, 25.0),
]
origins = st.builds(Origin, st.floats(-85.0, 85.0), st.floats(-180.0, 180.0), st.floats(-400.0, 4000.0))
places = st.tuples(st.floats(-3e5, 3e5), st.floats(-3e5, 3e5)).map(lambda place: np.array([place]))


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


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize("reach_m", [100.0, 50_000.0, 140_000.0])
def test_a_place_on_the_plane_is_the_one_above_or_below_at_the_origins_height(
    origin: Origin, reach_m: float
) -> None:
    local_m = np.random.default_rng(2).uniform(-reach_m, reach_m, (200, 2))
    places_deg = local_to_geodetic(local_m, origin)
    assert np.abs(geodetic_to_local(places_deg, origin) - local_m).max() < NEWTON_M
    height_m = np.full(len(local_m), origin.altitude_m)
    enu = geodetic_to_enu(*places_deg.T, height_m, origin)
    assert np.abs(enu[:, :2] - local_m).max() < PYMAP3D_M
    again = enu_to_geodetic(enu, origin)
    turned_deg = (again[:, 1] - places_deg[:, 1] + 180.0) % 360.0 - 180.0
    assert np.abs(again[:, 0] - places_deg[:, 0]).max() * 111_700.0 < PYMAP3D_M
    assert np.abs(turned_deg).max() * 111_700.0 < PYMAP3D_M
    assert np.abs(again[:, 2] - origin.altitude_m).max() < PYMAP3D_M


@given(origin=origins, place=places)
@example(Origin(10.0, 20.0), np.array([[kernels.FARTHEST_M, 0.0]]))
@example(Origin(10.0, 20.0), np.array([[0.0, -kernels.FARTHEST_M - 0.001]]))
@example(Origin(89.0, 20.0), np.array([[0.0, 110_574.0]]))
@example(Origin(89.0, 20.0), np.array([[1000.0, 112_000.0]]))
def test_what_was_stated_once_stays_when_it_is_stated_again(origin: Origin, place: np.ndarray) -> None:
    once = stated_local(place, origin)
    at_edge = np.hypot(*place[0]) > kernels.FARTHEST_M - 1.0
    assert np.isfinite(once).all() or at_edge or abs(local_to_geodetic(place, origin)[0, 0]) > 89.98
    assert stated_local(once, origin).tobytes() == once.tobytes()


@given(origin=origins, place=places)
def test_one_row_is_stated_as_in_a_batch_and_codes_are_their_degrees(
    origin: Origin, place: np.ndarray
) -> None:
    frame = frame_constants(origin)
    batch = np.concatenate([place + 7.0, place, place - 7.0])
    codes = np.zeros(batch.shape, np.int64)
    kernels.state_places(frame, batch, codes)
    assert tuple(codes[1].tolist()) == kernels.state_place(frame, *place[0].tolist())
    held = np.zeros(batch.shape)
    kernels.places_of(frame, codes, held)
    assert held.tobytes() == stated_local(batch, origin).tobytes()
    if codes[1, 0] != kernels.NO_LATITUDE_CODE:
        assert held.tobytes() == geodetic_to_local(codes / 1e7, origin).tobytes()


@given(
    latitude=st.floats(-89.9, 89.9), longitude=st.floats(-180.0, 180.0), altitude=st.floats(-400.0, 4000.0)
)
def test_stating_moves_a_place_by_half_a_code_an_axis_at_most(
    latitude: float, longitude: float, altitude: float
) -> None:
    """A code of latitude is worth 1e-7 degree of the meridian, one of longitude of the parallel."""
    origin = Origin(latitude, longitude, altitude)
    code_rad = np.radians(1e-7)
    squared, sine = 0.0066943799901413165, np.sin(np.radians(latitude))
    normal_m = 6378137.0 / np.sqrt(1.0 - squared * sine**2)
    east_m = (normal_m + altitude) * np.cos(np.radians(latitude)) * code_rad
    north_m = (normal_m * (1.0 - squared) / (1.0 - squared * sine**2) + altitude) * code_rad
    assert east_m == pytest.approx(0.01113 * np.cos(np.radians(latitude)), rel=5e-3)
    local_m = np.random.default_rng(1).uniform(-1.0, 1.0, (50, 2))
    moved_m = np.abs(stated_local(local_m, origin) - local_m).max(axis=0)
    assert moved_m[0] <= 0.501 * east_m
    assert moved_m[1] <= 0.501 * north_m


def test_longitudes_of_180_degrees_have_one_code() -> None:
    codes = np.zeros((3, 2), np.int64)
    kernels.state_places(frame_constants(Origin(10.0, 180.0)), np.array([[0.0, 0], [1.0, 0], [-1, 0]]), codes)
    assert codes[:, 1].tolist() == [1_800_000_000, -1_799_999_909, 1_799_999_909]
    frame = frame_constants(Origin(10.0, -179.999))
    assert kernels.state_place(frame, *kernels.place_of(frame, 100_000_000, -1_800_000_000)) == (
        100_000_000,
        1_800_000_000,
    )


def test_what_is_too_far_or_no_place_is_not_a_number_and_has_no_codes() -> None:
    origin = Origin(42.0, -83.0)
    frame = frame_constants(origin)
    nowhere = np.array([[kernels.FARTHEST_M + 2.0, 0.0], [0.0, np.inf], [np.nan, 0.0], [4e5, 4e5]])
    assert np.isnan(local_to_geodetic(nowhere, origin)).all()
    assert np.isnan(stated_local(nowhere, origin)).all()
    for place in nowhere.tolist():
        assert kernels.state_place(frame, *place) == (kernels.NO_LATITUDE_CODE, kernels.NO_LONGITUDE_CODE)
    antipode = np.array([[-42.0, 97.0], [42.0, 97.0], [90.0, 0.0], [np.nan, 0.0]])
    assert np.isnan(geodetic_to_local(antipode, origin)).all()
    for codes in ((kernels.NO_LATITUDE_CODE, 0), (0, kernels.NO_LONGITUDE_CODE), (-900_000_000, 0)):
        assert np.isnan(kernels.place_of(frame, *codes)).all()
    edge = np.array([[kernels.FARTHEST_M, 0.0], [0.0, -kernels.FARTHEST_M + 0.001]])
    assert np.isfinite(local_to_geodetic(edge, origin)).all()


def test_a_frame_needs_an_origin_on_earth() -> None:
    for origin in (Origin(91.0, 0.0), Origin(0.0, np.inf), Origin(np.nan, 0.0)):
        with pytest.raises(ValueError, match="an origin is a latitude and a longitude"):
            frame_constants(origin)
    with pytest.raises(ValueError, match="an origin is within"):
        frame_constants(Origin(0.0, 0.0, np.nan))


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
