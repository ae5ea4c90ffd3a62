"""Claims about angles of tables: degrees that cannot be are refused, all that can be are read."""

import math
from pathlib import Path

import numpy as np
import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import wrap_angle_rad
from modelcast.io.trips import read_trips
from modelcast.trips.trajectory import build_trajectory


def _place(latitude: float, longitude: float, rows: int = 5) -> str:
    lines = [f"{k / 10},{latitude + 1e-6 * k:.8f},{longitude:.8f}" for k in range(rows)]
    return "\n".join(["t_s,lat,lon", *lines]) + "\n"


@pytest.mark.parametrize(
    ("latitude", "longitude"),
    [
        (42.3, -83.7),
        (-77.85, 166.7),  # a road to McMurdo
        (-54.8, -68.3),  # Ushuaia
        (1.29, 103.85),  # Singapore
        (5.55, -0.2),  # Accra
        (0.33, 6.73),  # São Tomé
        (0.0, 0.0),  # not known
        (51.5, 0.0),  # Greenwich
    ],
)
def test_places_with_roads_are_read(latitude: float, longitude: float, made) -> None:
    assert len(read_trips(made.write("a.csv", _place(latitude, longitude)))[0]) == 5


@pytest.mark.parametrize(
    ("latitude", "longitude", "problem", "remedy"),
    [
        (-83.7, 42.3, "south of all roads", "lat=lon,lon=lat"),
        (139.7, 35.7, "beyond 90", "lat=lon,lon=lat"),
        (423000000.0, -837000000.0, "beyond 90", "lat_e7=lat,lon_e7=lon"),
        (math.radians(42.3), math.radians(-83.7), "at sea", "lat_rad=lat,lon_rad=lon"),
        (math.radians(-33.9), math.radians(151.2), "at sea", "lat_rad=lat,lon_rad=lon"),
    ],
)
def test_places_without_are_refused(
    latitude: float, longitude: float, problem: str, remedy: str, made
) -> None:
    with pytest.raises(DataFormatError) as refused:
        list(read_trips(made.write("a.csv", _place(latitude, longitude))))
    assert problem in refused.value.problem
    assert remedy in refused.value.remedy
    assert refused.value.row == 2


def _drive(latitude: float, longitude: float, east_mps: float, names: str = "t_s,lat,lon") -> str:
    step_deg = east_mps / 10.0 / 111_320.0
    lines = [f"{k / 10},{latitude:.9f},{longitude + step_deg * k:.9f}" for k in range(50)]
    return "\n".join([names, *lines]) + "\n"


def test_a_drive_near_the_origin_of_a_simulator_is_read(made) -> None:
    (trip,) = read_trips(made.write("a.csv", _drive(0.001, 0.002, 12.0)))
    assert trip.position_m[-1, 0] == pytest.approx(49 * 1.2, rel=0.01)


def test_what_moves_as_slowly_as_radians_would_is_read_where_degrees_are_stated(made) -> None:
    path = made.write("a.csv", _drive(0.001, 0.002, 1.0))
    with pytest.raises(DataFormatError, match=r"at sea.*--columns latitude_deg=lat\."):
        list(read_trips(path))
    assert len(read_trips(path, columns={"latitude_deg": "lat"})[0]) == 50
    named = made.write("b.csv", _drive(0.001, 0.002, 1.0, "t_s,Latitude [deg],Longitude [deg]"))
    assert len(read_trips(named)[0]) == 50


def test_a_glitch_does_not_make_degrees_of_radians(made) -> None:
    lines = _drive(math.radians(42.3), math.radians(-83.7), 12.0 / 57.3).splitlines()
    with pytest.raises(DataFormatError, match="at sea"):
        list(read_trips(made.write("a.csv", "\n".join([*lines[:9], "0.8,0,0", *lines[10:]]) + "\n")))


def _circles(laps: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times, headings that go on and positions of circles of 50 m at about 8 m/s."""
    heading = np.arange(0.0, laps * 2.0 * np.pi, 0.016)
    position_m = 50.0 * np.stack([-np.cos(heading), np.sin(heading)], axis=1)
    return np.arange(heading.size) / 10, heading, position_m


def _written(made, t_s: np.ndarray, heading: np.ndarray, position_m: np.ndarray) -> Path:
    rows = zip(t_s, *position_m.T, heading, strict=True)
    lines = (f"{t:.1f},{x:.6f},{y:.6f},{angle:.12f}\n" for t, x, y, angle in rows)
    return made.write("a.csv", "t_s,east_m,north_m,heading_rad\n" + "".join(lines))


def test_headings_in_radians_may_go_on_over_any_number_of_circles(made) -> None:
    t_s, heading, position_m = _circles(12.0)
    assert len(build_trajectory("a", t_s, position_m, heading_rad=heading)) == t_s.size
    (trip,) = read_trips(_written(made, t_s, heading, position_m))
    assert trip.heading_rad == pytest.approx(wrap_angle_rad(heading), abs=1e-9)


def _straight(heading: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    course = np.radians(heading)
    way_m = np.arange(60)[:, None]
    return np.arange(60) / 10, np.full(60, heading), way_m * np.array([np.sin(course), np.cos(course)])


def _in_degrees(laps: float, *, wrapped: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    t_s, heading, position_m = _circles(laps)
    degrees = np.degrees(heading)
    return t_s, degrees % 360.0 if wrapped else degrees, position_m


@pytest.mark.parametrize(
    ("t_s", "heading", "position_m"),
    [
        _in_degrees(3.0, wrapped=True),
        _in_degrees(0.9, wrapped=True),
        _in_degrees(3.0, wrapped=False),
        _straight(270.0),
        _straight(100.0),
        _straight(-90.0),
        (np.arange(60) / 10, np.full(60, 180.0), np.arange(60)[:, None] * np.array([0.0, 1.0])),  # backwards
        (np.arange(60) / 10, np.where(np.arange(60) % 20 < 10, 359.0, 1.0), np.zeros((60, 2))),
    ],
)
def test_degrees_called_radians_are_refused(t_s, heading, position_m, made) -> None:
    with pytest.raises(DataFormatError, match=r"too large for radians.*heading_deg=heading_rad"):
        list(read_trips(_written(made, t_s, heading, position_m)))
    with pytest.raises(ValueError, match=r"a: heading_rad is .* at sample \d+, too large for radians"):
        build_trajectory("a", t_s, position_m, heading_rad=heading)


@pytest.mark.filterwarnings("error")
def test_headings_that_are_all_missing_are_an_error_without_a_warning_before_it() -> None:
    with pytest.raises(ValueError, match="heading_rad is not finite at sample 0"):
        build_trajectory("a", [0.0, 0.1], [[0, 0], [1, 0]], heading_rad=[math.nan, math.nan])
