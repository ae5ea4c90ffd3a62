"""The grid against what defines it: the meridian's length on its middle, and angles kept everywhere."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.geodesy import Origin, geodetic_to_enu
from modelcast.core.utm import utm_to_geodetic, utm_zone

SEMI_MAJOR_M, SQUARED = 6378137.0, 0.0066943799901413165
MILLIMETRE_DEG = 1e-8


def meridian_m(latitude_deg):
    """Length of the meridian from the equator, by Simpson's rule."""
    at = np.radians(np.linspace(0.0, latitude_deg, 2001))
    curve = SEMI_MAJOR_M * (1.0 - SQUARED) / (1.0 - SQUARED * np.sin(at) ** 2) ** 1.5
    return (
        (at[1] - at[0]) / 3.0 * (curve[0] + curve[-1] + 4.0 * curve[1::2].sum() + 2.0 * curve[2:-1:2].sum())
    )


@pytest.mark.parametrize("latitude_deg", [0.0, 10.0, 42.3, 50.78, 84.0])
def test_the_middle_meridian_has_its_length_times_the_scale(latitude_deg):
    north_m = np.array([0.9996 * meridian_m(latitude_deg)])
    latitude, longitude, turn = utm_to_geodetic(np.array([500000.0]), north_m, zone=32)
    assert latitude[0] == pytest.approx(latitude_deg, abs=MILLIMETRE_DEG)
    assert longitude[0] == 9.0
    assert turn[0] == 0.0


def steps(east_m, north_m):
    """Where a metre to the grid's east and to its north lead on the ground, and the grid's north as told."""
    latitude, longitude, turn = utm_to_geodetic(
        np.array([east_m, east_m + 1.0, east_m]), np.array([north_m, north_m, north_m + 1.0]), zone=32
    )
    origin = Origin(float(latitude[0]), float(longitude[0]))
    enu = geodetic_to_enu(latitude, longitude, np.zeros(3), origin)
    return enu[1, :2], enu[2, :2], turn[0]


@given(east_m=st.floats(170e3, 830e3), north_m=st.floats(1e4, 9.3e6))
def test_the_grid_keeps_angles_and_its_north_is_where_it_is_told(east_m, north_m):
    east, north, turn = steps(east_m, north_m)
    assert np.hypot(*east) == pytest.approx(np.hypot(*north), rel=1e-6)
    assert east @ north == pytest.approx(0.0, abs=1e-6)
    assert np.arctan2(*north) == pytest.approx(turn, abs=2e-5)


def test_the_southern_half_mirrors_the_northern():
    north = utm_to_geodetic(np.array([3e5]), np.array([5e6]), zone=5)
    south = utm_to_geodetic(np.array([3e5]), np.array([10e6 - 5e6]), zone=5, southern=True)
    assert south[0] == pytest.approx(-north[0])
    assert south[1] == pytest.approx(north[1])
    assert south[2] == pytest.approx(-north[2])


def test_zones_go_round_the_earth_and_others_are_refused():
    assert [utm_zone(at) for at in (-180.0, -174.0, 0.0, 179.9, 180.0)] == [1, 2, 31, 60, 60]
    with pytest.raises(ValueError, match=r"zone must lie within 1\.\.60, got 61"):
        utm_to_geodetic(np.zeros(1), np.zeros(1), zone=61)
