"""Claims about positions on the grid of a map: read from a point near them, which messages can state."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.io.trips import read_trips
from modelcast.io.write_trips import write_csv
from modelcast.station.sensing.sensing import Sensing, sensed_trip
from modelcast.station.sensing.velocity import DEFAULT_FROM_POSITIONS

MUNICH = (691_000.0, 5_336_001.0)
SYDNEY = (334_000.0, 6_252_000.0)
WITH_ZONE = (32_691_000.0, 5_336_001.0)


def utm(start, vehicle="a", rows=30):
    east, north = start
    return [f"{k / 10},{east + k},{north},{vehicle}" for k in range(rows)]


def table(*lines: str) -> str:
    return "\n".join(["time,Easting,Northing,vehicle", *lines]) + "\n"


@pytest.mark.parametrize(
    ("start", "origin"),
    [(MUNICH, (700_000, 5_300_000)), (SYDNEY, (300_000, 6_300_000)), (WITH_ZONE, (32_700_000, 5_300_000))],
)
def test_far_positions_are_counted_from_a_near_point_and_can_be_sent(start, origin, made):
    (trip,) = read_trips(made.write("a.csv", table(*utm(start))))
    assert dict(trip.reading.repaired) == {f"position counted from ({origin[0]}, {origin[1]})": 30}
    assert trip.position_m[-1] + origin == pytest.approx((start[0] + 29, start[1]), abs=1e-6)
    sensing = Sensing.of(trip, DEFAULT_FROM_POSITIONS, quantised=True)
    assert np.isfinite(sensed_trip(trip, sensing).samples[0, :30]).all()


def test_vehicles_of_one_table_and_of_two_files_keep_their_distance(made):
    east, north = MUNICH
    other = utm((east + 250, north + 40), "b")
    first, second = read_trips(made.write("a.csv", table(*utm(MUNICH), *other)))
    (alone,) = read_trips(made.write("b.csv", table(*other)))
    assert second.position_m[0] - first.position_m[0] == pytest.approx((250, 40))
    assert (alone.position_m == second.position_m).all()


def test_a_first_row_without_a_fix_does_not_choose_the_point(made):
    (trip,) = read_trips(made.write("a.csv", table("-0.1,0,0,a", *utm(MUNICH))))
    assert len(trip) == 30
    assert np.hypot(*trip.position_m.T).max() < 100_000


@pytest.mark.parametrize("start", [(0.0, 0.0), (180_000.0, 20_000.0), (1e9, 0.0)])
def test_near_positions_and_such_as_are_on_no_map_are_left(start, made):
    trips = read_trips(made.write("a.csv", table(*utm(start))), on_skipped=lambda *_: None)
    assert all(not trip.reading.repaired and trip.position_m[0, 0] == start[0] for trip in trips)


def test_a_trip_that_states_its_origin_is_left(made, tmp_path):
    (trip,) = read_trips(made.write("a.csv", "t,lat,lon\n0,48,11\n0.1,48,11\n"))
    far = replace(trip.moved(0.0, (300_000.0, 0.0)), origin=trip.origin)
    path = tmp_path / "far.csv"
    write_csv([far], path)
    (again,) = read_trips(path)
    assert (again.position_m == far.position_m).all()
