"""highD and inD: boxes, axes, directions, the grid's north, road users by class, tables that do not fit."""

import numpy as np
import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.core.geodesy import local_to_geodetic
from modelcast.core.utm import utm_to_geodetic
from modelcast.io.registry import get_reader
from modelcast.io.trips import read_trips

COUNT = 12
GRID_NORTH_RAD = np.radians(-2.2700)
"""At the made recording's origin: see the test of the grid."""


def refusal(path, name):
    with pytest.raises(DataFormatError) as caught:
        list(read_trips(path, name))
    return str(caught.value)


def test_a_box_gives_its_middle_with_the_upper_side_north(made):
    first, second = read_trips(made.highd(made.folder))
    assert [first.trip_id, second.trip_id] == ["01_tracks/1", "01_tracks/2"]
    assert first.position_m[0] == pytest.approx([299.6 + 6.0, -21.25])
    assert first.dt_s == pytest.approx(0.04)
    assert (first.speed_mps == 10.0).all()
    assert first.heading_rad == pytest.approx(-np.pi / 2), "leftward is west"
    assert first.acceleration_mps2 == pytest.approx(0.5), "along the heading"
    assert first.clock_s == second.clock_s == 0.04
    assert (first.origin, first.yaw_rate_radps) == (None, None)


def test_downward_in_the_picture_is_south(made):
    rows = [made.highd_row(at, xVelocity=6.0, yVelocity=8.0, yAcceleration=1.0) for at in range(COUNT)]
    (trip,) = read_trips(made.highd(made.folder, tracks=[made.highd_names, *rows]))
    assert np.sin(trip.heading_rad) == pytest.approx(0.6)
    assert np.cos(trip.heading_rad) == pytest.approx(-0.8)
    assert trip.acceleration_mps2 == pytest.approx(-0.5 * 0.6 + 1.0 * 0.8)


def test_at_a_crawl_the_driving_direction_says_the_heading(made):
    rows = [made.highd_row(at, xVelocity=0.1, yVelocity=-0.2) for at in range(COUNT)]
    (trip,) = read_trips(made.highd(made.folder, tracks=[made.highd_names, *rows]))
    assert trip.heading_rad == pytest.approx(-np.pi / 2)


def test_every_file_of_a_recording_stands_for_it(made):
    path = made.highd(made.folder)
    files = sorted(path.parent.glob("01_*.csv"))
    assert len(files) == 3
    for file in files:
        assert len(list(read_trips(file))) == 2
    told = {}
    assert len(list(read_trips([*files, made.folder], on_skipped=told.__setitem__))) == 2
    assert told == {}


def test_road_users_are_told_apart(made):
    told = {}
    trips = list(read_trips(made.ind(made.folder), on_skipped=told.__setitem__))
    assert [trip.trip_id for trip in trips] == ["07_tracks/0", "07_tracks/bicycle-1"]
    assert told == {"07_tracks/pedestrian-2": "no usable row: 12 of a pedestrian"}


def test_a_car_along_the_grid_drives_along_the_grid_on_earth(made):
    car, _ = read_trips(made.ind(made.folder))
    assert car.heading_rad == pytest.approx(GRID_NORTH_RAD, abs=1e-4)
    way = car.position_m[-1] - car.position_m[0]
    assert np.arctan2(*way) == pytest.approx(car.heading_rad[0], abs=2e-5), "meridians meet"
    assert np.hypot(*way) == pytest.approx(0.4 * 11, rel=2e-4), "the grid's scale there"
    assert (car.speed_mps, car.acceleration_mps2) == (pytest.approx(10.0), pytest.approx(0.5))
    latitude, longitude, _ = utm_to_geodetic(np.array([293537.1224]), np.array([5629671.58]), zone=32)
    found = local_to_geodetic(car.position_m[:1], car.origin)
    assert np.ravel(found)[:2] == pytest.approx([latitude[0], longitude[0]], abs=1e-8)


@pytest.mark.parametrize(
    "recording",
    [
        ["recordingId,locationId,frameRate", "7,1,25.0"],
        [
            "recordingId,locationId,frameRate,latLocation,lonLocation,xUtmOrigin,yUtmOrigin",
            "7,1,25.0,51.78,6.07,293487.1224,5629711.58",
        ],
        [
            "recordingId,locationId,frameRate,latLocation,lonLocation,xUtmOrigin,yUtmOrigin",
            "7,1,25.0,0,0,0,0",
        ],
    ],
)
def test_without_a_place_that_holds_the_frame_is_the_grids(made, recording):
    car, _ = read_trips(made.ind(made.folder, recordingMeta=recording))
    assert car.origin is None
    assert car.position_m[0] == pytest.approx([50.0, -40.0])
    assert car.heading_rad == pytest.approx(0.0, abs=1e-12)
    assert dict(car.reading.repaired) == {"place not known, grid north taken": COUNT}


def test_reverse_is_a_negative_speed_along_the_heading(made):
    rows = [made.ind_row(at, yVelocity=-1.0, heading=90.0) for at in range(COUNT)]
    (trip,) = read_trips(made.ind(made.folder, tracks=[made.ind_names, *rows]))
    assert trip.speed_mps == pytest.approx(-1.0)


def test_rows_in_any_order_give_the_same_trips_within_any_memory(made):
    lines = [made.ind_row(at, user) for user in (0, 1) for at in range(COUNT)]
    path = made.ind(made.folder, tracks=[made.ind_names, *lines])
    expected = list(read_trips(path))
    made.ind(made.folder, tracks=[made.ind_names, *lines[::2], *lines[1::2]])
    for reader in (get_reader("ind"), get_reader("ind").within(COUNT * 8 * 10 + 4000)):
        found = sorted(reader.read(str(path)), key=lambda trip: trip.trip_id)
        for one, other in zip(found, expected, strict=True):
            assert one.position_m.tobytes() == other.position_m.tobytes()


def test_a_trip_over_the_limit_is_an_error_that_names_it(made):
    with pytest.raises(DataFormatError, match="the trip 01_tracks/1 has over"):
        list(get_reader("highd").within(100).read(str(made.highd(made.folder))))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"recordingMeta": ["id,frameRate,upperLaneMarkings", "1,0,1;2"]}, "row 2: frameRate is 0"),
        ({"recordingMeta": ["id,frameRate,upperLaneMarkings", "1,x,1;2"]}, "row 2: frameRate is 'x', not a"),
        (
            {"recordingMeta": ["id,frameRate,upperLaneMarkings"]},
            "_recordingMeta.csv: no rows after the header",
        ),
        ({"recordingMeta": ["id,frameRate,upperLaneMarkings", "1,25,1", "2,25,1"]}, "row 3: more than one"),
        ({"recordingMeta": ["id,upperLaneMarkings", "1,1"]}, "row 1: no column frameRate among id, upper"),
        (
            {"tracksMeta": ["id,class,drivingDirection", "1,Car,3", "2,Car,1"]},
            "row 2: drivingDirection is '3', not 1 or 2",
        ),
        (
            {"tracksMeta": ["id,class,drivingDirection", "2,Car,1"]},
            "row 2: id '1' is not in 01_tracksMeta.csv",
        ),
        (
            {"tracks": ["id,frame,x,y", "1,1,1,1"]},
            "_tracks.csv, row 1: no column width among id, frame, x, y",
        ),
    ],
)
def test_tables_that_do_not_fit_are_named_with_row_and_value(made, changed, message):
    assert message in refusal(made.highd(made.folder, **changed), "highd")


@pytest.mark.parametrize(
    ("value", "message"), [("", "x is blank"), ("nan", "x is 'nan', not a finite number")]
)
def test_a_cell_that_is_no_number_is_an_error(made, value, message):
    rows = [made.highd_row(1), made.highd_row(2, x=value)]
    assert f"row 3: {message}" in refusal(made.highd(made.folder, tracks=[made.highd_names, *rows]), "highd")


def test_a_table_alone_is_an_error_that_names_the_others(made):
    path = made.highd(made.folder)
    path.with_name("01_tracksMeta.csv").unlink()
    assert "01_tracks.csv: 01_tracksMeta.csv is not beside it" in refusal(path, "highd")
    assert "is called otherwise than <recording>_tracks.csv" in refusal(
        path.rename(path.with_name("a.csv")), "highd"
    )
