"""smartLoc: ground truth with the odometry of the file beside it."""

import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.io.trips import read_trips


def write(made, truth=None, sensors=None):
    truth = made.smartloc_lines("point3") if truth is None else truth
    paths = [made.write("D_GT.txt", "\n".join(truth) + "\n")]
    if sensors is not None:
        paths.append(made.write("D_Input.txt", "\n".join(sensors) + "\n"))
    return paths


def test_either_file_finds_the_other(made):
    truth, sensors = write(made, sensors=["pseudorange3 0 1 2 3 4 5", *made.smartloc_lines("odom3")])
    (first,), (second,) = read_trips(truth), read_trips(sensors)
    assert first.trip_id == second.trip_id == "D_GT/car"
    assert first.speed_mps[3] == 5.3
    assert first.yaw_rate_radps == pytest.approx(0.1), "anticlockwise in the file, clockwise in a trip"
    assert dict(first.reading.skipped) == {"other measurement": 1}
    assert first.speed_mps.tobytes() == second.speed_mps.tobytes()


def test_both_files_and_their_folder_give_one_trip(made):
    paths = write(made, sensors=made.smartloc_lines("odom3"))
    assert len(list(read_trips(paths))) == 1
    assert len(list(read_trips(made.folder))) == 1


def test_truth_alone_has_positions_only(made):
    (trip,) = read_trips(write(made))
    assert trip.speed_mps is None
    assert trip.up_m is not None
    assert trip.origin.latitude_deg == pytest.approx(52.5, abs=0.1)


def test_missing_odometry_holds_the_last_value_before(made):
    lines = made.smartloc_lines("odom3")
    (trip,) = read_trips(write(made, sensors=[*lines[:4], *lines[5:]]))
    assert trip.speed_mps[4] == 5.3
    assert dict(trip.reading.repaired) == {"odometry missing, last value held": 1}


def test_cut_last_line_is_counted(made):
    path = made.write("D_GT.txt", "\n".join(made.smartloc_lines("point3"))[:-30])
    (trip,) = read_trips(path)
    assert (len(trip), dict(trip.reading.skipped)) == (9, {"partial last line": 1})


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("point3 2.0 x 1 1", "row 11: point3 holds 'x', not a finite number"),
        ("point3 2.0 nan 1 1", "row 11: point3 holds 'nan'"),
        ("point3 2.0 1", "row 11: point3 has 2 numbers, not 4"),
        ("point3 2.0 1 1 1", "row 11: the position is 2 m from the Earth's centre"),
        ("point3 1.0 3785108.5 899901.5 5037234.5", "row 11: time of D_GT/car does not increase"),
        ("17 2.0", "row 11: '17' is no kind of measurement"),
    ],
)
def test_wrong_line_is_an_error(made, line, message):
    with pytest.raises(DataFormatError, match=message):
        list(read_trips(write(made, truth=[*made.smartloc_lines("point3"), line])))


def test_sensor_file_alone_is_an_error(made):
    path = made.write("D_Input.txt", "\n".join(made.smartloc_lines("odom3")) + "\n")
    with pytest.raises(
        DataFormatError, match=r"no point3 line\. Positions are in the file that ends with _GT\.txt"
    ):
        list(read_trips(path))


@pytest.mark.parametrize("first", ["point3", "odom3", "pseudorange3"])
def test_two_measurements_in_one_line_are_an_error(made, first):
    lines = made.smartloc_lines("point3")
    other = lines[3] if first == "point3" else lines[3].replace("point3", first)
    lines[3:5] = [other + lines[4]]
    with pytest.raises(DataFormatError, match=r"row 4: .*(a second measurement|more than 13)"):
        list(read_trips(made.write("Drive_GT.txt", "\n".join([*lines, ""]))))
