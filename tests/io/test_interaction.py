"""INTERACTION: tracks of vehicles and people in the plane of a map."""

import numpy as np
import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.io.trips import read_trips

HEADER = "track_id,frame_id,timestamp_ms,agent_type,x,y,vx,vy"


def test_heading_is_the_way_that_the_track_goes(made):
    trip = next(iter(read_trips(made.valid("interaction"))))
    east_m, north_m = np.diff(trip.position_m, axis=0).T
    assert trip.heading_rad[1:] == pytest.approx(np.arctan2(east_m, north_m), abs=1e-6)
    assert trip.speed_mps == pytest.approx(np.hypot(10.0, 20.0))


def test_tracks_of_a_file_share_a_clock_and_have_no_origin(made):
    rows = [
        f"{track},1,{100 * at + start},car,{at},0,1,0"
        for track, start in ((1, 100), (2, 700))
        for at in range(3)
    ]
    trips = list(read_trips(made.write("vehicle_tracks_000.csv", made.interaction(rows, header=HEADER))))
    assert [trip.trip_id for trip in trips] == ["vehicle_tracks_000/1", "vehicle_tracks_000/2"]
    assert [trip.clock_s for trip in trips] == pytest.approx([0.1, 0.7])
    assert all(trip.origin is None and trip.start_unix_s is None for trip in trips)


def test_people_without_a_heading_have_the_other_columns(made):
    path = made.write(
        "p.csv",
        made.interaction(
            [f"P1,{at},{100 * at},pedestrian/bicycle,{at},0,1,0" for at in range(5)], header=HEADER
        ),
    )
    (trip,) = read_trips(path)
    assert (trip.trip_id, trip.heading_rad) == ("p/P1", None)
    blank = [f"P1,{at},{100 * at},pedestrian/bicycle,{at},0,1,0,,," for at in range(5)]
    (trip,) = read_trips(made.write("q.csv", made.interaction(blank)))
    assert trip.heading_rad is None
    assert dict(trip.reading.repaired) == {"heading left out, too often missing": 5}


def test_cases_of_the_challenge_are_trips_of_their_own_without_a_shared_clock(made):
    rows = [f"{case},7,{at},{100 * at},car,{at},0,1,0" for case in ("1.0", "2.0") for at in range(3)]
    path = made.write("val.csv", made.interaction(rows, header="case_id," + HEADER))
    trips = list(read_trips(path))
    assert [trip.trip_id for trip in trips] == ["val/1.0-7", "val/2.0-7"]
    assert [trip.clock_s for trip in trips] == [None, None]


def test_rows_in_any_order_and_twice_are_put_right_and_counted(made):
    rows = [f"1,{at},{100 * at},car,{at},0,1,0" for at in (0, 2, 1, 1, 3)]
    rows += ["1,9,,car,9,0,1,0", "1,9,900,car,,0,1,0"]
    (trip,) = read_trips(made.write("v.csv", made.interaction(rows, header=HEADER)))
    assert trip.position_m[:, 0].tolist() == [0.0, 1.0, 2.0, 3.0]
    assert dict(trip.reading.skipped) == {"time missing": 1, "position missing": 1, "duplicate time": 1}
    assert dict(trip.reading.repaired) == {"out of time order": 2}


@pytest.mark.parametrize(
    ("header", "row", "told"),
    [
        (HEADER.replace(",vy", ""), "1,1,100,car,0,0,1", "row 1: the header has no column 'vy'"),
        (HEADER, ",1,100,car,0,0,1,0", "row 2: track_id is blank"),
        (HEADER, "1,1,100,car,0,east,1,0", "row 2: y is 'east', not a finite number"),
    ],
)
def test_what_is_wrong_is_told_with_its_line(made, header, row, told):
    path = made.write("v.csv", made.interaction([row], header=header))
    with pytest.raises(DataFormatError, match=told):
        list(read_trips(path, "interaction"))
