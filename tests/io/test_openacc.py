"""OpenACC: cars by their place in Vehicle_order, one frame, missing cells."""

import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import Origin
from modelcast.io.openacc import read_platoon
from modelcast.io.trips import read_trips


def row(at, second="10.0,90,50,16.8,46.9,230", time=None):
    return f"{5370 + at / 10 if time is None else time},10.0,{100 + at},50,16.8,46.9,229,{second},5.5"


def test_car_k_is_the_kth_name_and_cars_without_columns_are_reported(made):
    told = {}
    trips = list(read_trips(made.write("p.csv", made.openacc()), on_skipped=told.__setitem__))
    assert [trip.trip_id for trip in trips] == ["p/FIRST", "p/SECOND"]
    assert told == {"p/GHOST": "named in Vehicle_order but without columns"}


def test_cars_share_the_frame_of_the_first_valid_sample(made):
    first, second = read_trips(made.write("p.csv", made.openacc()))
    assert first.origin == second.origin == Origin(46.9, 16.8, 229.0)
    assert first.position_m[0].tolist() == [0, 0]
    assert second.position_m[1].tolist() == [-9, 0]
    assert second.up_m[0] == 1.0
    assert first.heading_rad is None


def test_blank_cells_leave_a_gap_and_are_counted(made):
    rows = [row(at, second=",,,,," if 3 <= at < 7 else "10.0,90,50,16.8,46.9,230") for at in range(12)]
    _, second = read_trips(made.write("p.csv", made.openacc(rows)))
    assert second.segments.tolist() == [0, 3, 8]
    assert dict(second.reading.skipped) == {"position missing": 4}


def test_missing_speed_is_held(made):
    rows = [row(at, second=f"{'' if at == 5 else at},90,50,16.8,46.9,230") for at in range(12)]
    _, second = read_trips(made.write("p.csv", made.openacc(rows)))
    assert second.speed_mps[5] == 4.0
    assert dict(second.reading.repaired) == {"speed missing, last value held": 1}


def test_car_with_blank_cells_only_is_reported(made):
    told = {}
    rows = [row(at, second=",,,,,") for at in range(4)]
    (only,) = read_trips(made.write("p.csv", made.openacc(rows)), on_skipped=told.__setitem__)
    assert only.trip_id == "p/FIRST"
    assert told["p/SECOND"] == "no usable row: 4 position missing"


def test_cut_last_line_counts_for_every_car(made):
    for trip in read_trips(made.write("p.csv", made.openacc()[:-40])):
        assert trip.reading.rows == 12
        assert dict(trip.reading.skipped) == {"partial last line": 1}


def test_time_running_backwards_is_an_error(made):
    rows = [row(0), row(2), row(1)]
    with pytest.raises(
        DataFormatError, match=r"row 9: time of p/FIRST does not increase: 5370\.1 after 5370\.2"
    ):
        list(read_trips(made.write("p.csv", made.openacc(rows))))


def test_column_without_a_name_is_an_error(made):
    with pytest.raises(DataFormatError, match=r"row 6: Speed3 has no name; Vehicle_order names 2 cars"):
        list(read_trips(made.write("p.csv", made.openacc(order="GHOST,FIRST,"))))


def test_two_cars_of_one_model_keep_different_names(made):
    trips = read_trips(made.write("p.csv", made.openacc(order="GHOST,FIRST,FIRST,")))
    assert [trip.trip_id for trip in trips] == ["p/FIRST-2", "p/FIRST-3"]


def test_a_platoon_keeps_the_clock_of_its_file(made):
    rows = [row(at, second=",,,,," if at < 4 else f"10.0,{90 + at},50,16.8,46.9,230") for at in range(12)]
    platoon = read_platoon(made.write("p.csv", made.openacc(rows)))
    assert platoon.slots == 2
    assert platoon.active[:, 0].all()
    assert platoon.active[:, 1].tolist() == [False] * 4 + [True] * 8
    assert (platoon.position_m[4:, 0, 0] - platoon.position_m[4:, 1, 0]).tolist() == pytest.approx([10.0] * 8)
    assert platoon.heading_rad[5, 0] == pytest.approx(1.5707963)


def test_a_platoon_without_a_car_is_an_error(made):
    rows = [f"{5370 + at / 10},,,,,,,,,,,,," for at in range(4)]
    with pytest.raises(DataFormatError, match="no car"):
        read_platoon(made.write("p.csv", made.openacc(rows)))
