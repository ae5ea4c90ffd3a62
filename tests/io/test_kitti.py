"""KITTI: axes of the camera and of the inertial unit, packets that are missing, files that do not fit."""

import numpy as np
import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.io.registry import detect_format, get_reader
from modelcast.io.trips import read_trips

COUNT = 12


def refusal(path, name):
    with pytest.raises(DataFormatError) as caught:
        list(read_trips(path, name))
    return str(caught.value)


def test_a_camera_that_moves_where_it_looks_drives_north_with_heading_zero(made):
    (trip,) = read_trips(made.kitti_poses(made.folder))
    assert trip.trip_id == "00/car"
    assert trip.position_m[:, 0] == pytest.approx(0.0)
    assert trip.position_m[:, 1] == pytest.approx(np.arange(COUNT))
    assert trip.heading_rad == pytest.approx(0.0)
    assert trip.up_m == pytest.approx(0.5), "y is down"
    assert (trip.origin, trip.start_unix_s, trip.speed_mps) == (None, None, None)


def test_a_circle_to_the_right_turns_the_heading_clockwise(made):
    turn = np.linspace(0.0, 1.1, COUNT)
    poses = []
    for angle in turn:
        words = made.kitti_pose(20.0 * np.sin(angle), angle).split()
        words[3] = str(20.0 * (1.0 - np.cos(angle)))
        poses.append(" ".join(words))
    (trip,) = read_trips(made.kitti_poses(made.folder, poses))
    assert trip.heading_rad == pytest.approx(turn, abs=1e-6)
    step = np.diff(trip.position_m, axis=0)
    assert np.arctan2(step[:, 0], step[:, 1]) == pytest.approx((turn[1:] + turn[:-1]) / 2, abs=1e-5), (
        "poses have seven digits"
    )


def test_times_are_found_beside_the_poses_and_in_the_sequence(made):
    path = made.kitti_poses(made.folder)
    times = made.folder / "sequences" / "00" / "times.txt"
    expected = next(iter(read_trips(path))).t_s
    for place in (path.with_name("00_times.txt"), path.with_name("times.txt")):
        times = times.rename(place)
        assert next(iter(read_trips(path))).t_s.tobytes() == expected.tobytes()
    times.unlink()
    assert "poses/00.txt: no times with these poses: none of " in refusal(path, "kitti-poses")


def test_poses_in_their_sequence_are_named_by_it(made):
    poses = made.kitti_poses(made.folder)
    path = poses.rename(made.folder / "sequences" / "00" / "poses.txt")
    assert [trip.trip_id for trip in read_trips(path)] == ["00/car"]


def test_a_cut_last_pose_is_counted_and_a_lost_one_an_error(made):
    path = made.kitti_poses(made.folder)
    whole = path.read_bytes()
    path.write_bytes(whole[:-40])
    (trip,) = read_trips(path)
    assert (len(trip), dict(trip.reading.skipped)) == (COUNT - 1, {"partial last line": 1})
    path.write_bytes(whole[: whole.rindex(b"\n", 0, -1) + 1])
    assert "11 poses, but 12 times in" in refusal(path, "kitti-poses")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("1 0 0 0 0 1 0 0 0 0 2 0", "row 3: the axis in columns 3, 7 and 11 has the length 2, not 1"),
        ("1 0 0 0 0 1 0 0 0 0 1", "row 3: 11 fields where the format has 12"),
        ("1 0 0 0 0 1 0 0 0 0 1 nan", "row 3: column 12 is 'nan', not a finite number"),
        ("1 0 0 0 0 1 0 0 0 0 NULL 1", "row 3: a number is missing"),
    ],
)
def test_what_is_no_pose_is_named_by_row(made, line, message):
    poses = [made.kitti_pose(at) for at in range(COUNT)]
    poses[2] = line
    assert message in refusal(made.kitti_poses(made.folder, poses), "kitti-poses")


def test_a_time_that_stands_still_is_an_error(made):
    path = made.kitti_poses(made.folder, times=["0.1"] * COUNT)
    assert "row 2: time of 00/car does not increase" in refusal(path, "kitti-poses")


def test_twelve_numbers_that_are_no_rotation_are_not_taken_for_poses(made):
    path = made.write("numbers.txt", "1 2 3 4 5 6 7 8 9 10 11 12\n" * 3)
    with pytest.raises(DataFormatError, match="no reader knows this file"):
        detect_format(path)


def test_the_unit_turns_and_heads_in_our_sense(made):
    (trip,) = read_trips(made.oxts(made.folder / "drive"))
    assert trip.trip_id == "drive/car"
    assert trip.heading_rad == pytest.approx(0.0), "yaw pi/2 is north"
    assert trip.yaw_rate_radps == pytest.approx(-0.25), "anticlockwise in the file, clockwise in a trip"
    assert (trip.speed_mps == 10.0).all()
    assert (trip.acceleration_mps2 == 0.5).all()
    assert trip.position_m[:, 1] == pytest.approx(np.arange(COUNT), rel=0.01)
    assert trip.t_s == pytest.approx(np.arange(COUNT) / 10, abs=1e-12)
    assert trip.start_unix_s is None, "no zone is said"


def test_packets_and_times_are_paired_by_number(made):
    packets = {at: made.oxts_packet(at) for at in range(COUNT + 2) if at not in (3, 7)}
    packets[5] = ""
    times = [made.oxts_time(at) for at in range(COUNT)]
    times[8] = ""
    (trip,) = read_trips(made.oxts(made.folder / "drive", packets, times))
    assert dict(trip.reading.skipped) == {"packet missing": 2, "packet empty": 1, "time missing": 3}
    assert trip.reading.rows == COUNT + 2
    assert trip.position_m[:, 1] == pytest.approx(10.0 * trip.t_s, rel=0.01), (
        "none is moved to another's time"
    )


def test_times_that_jump_back_and_forth_are_sorted_and_gaps_part_the_trip(made):
    times = [made.oxts_time(at + 20 * (at > 8)) for at in range(COUNT)]
    times[3], times[4] = times[4], times[3]
    packets = {at: made.oxts_packet(at + 20 * (at > 8)) for at in range(COUNT)}
    packets[3], packets[4] = packets[4], packets[3]
    (trip,) = read_trips(made.oxts(made.folder / "drive", packets, times))
    assert dict(trip.reading.repaired) == {"out of time order": 1}
    assert trip.segments.tolist() == [0, 9, 12]


def test_the_folder_oxts_is_the_same_recording_as_its_drive(made):
    drive = made.oxts(made.folder / "drive")
    assert len(list(read_trips([drive, drive / "oxts"]))) == 1
    assert [trip.trip_id for trip in read_trips(made.folder)] == ["drive/car"]


def test_other_files_among_the_packets_are_reported(made):
    drive = made.oxts(made.folder / "drive")
    (drive / "oxts" / "data" / "notes.md").write_text("x")
    (drive / "oxts" / "data" / "3.txt").write_text("x")
    told = {}
    assert len(list(read_trips(drive, on_skipped=told.__setitem__))) == 1
    assert set(told) == {"drive/car/notes.md", "drive/car/3.txt"}


@pytest.mark.parametrize(
    ("packet", "message"),
    [
        ("1 2 3", "0000000004.txt, row 1: holds 3 words, not 30 numbers"),
        ("nan " * 30, "0000000004.txt, row 1: number 0 is 'nan', not a finite number"),
        ("x " * 30, "number 0 is 'x'"),
        ("0 " * 5000, "words, not 30 numbers"),
    ],
)
def test_what_is_no_packet_is_named_by_its_file(made, packet, message):
    packets = {at: made.oxts_packet(at) for at in range(COUNT)} | {4: packet}
    assert message in refusal(made.oxts(made.folder / "drive", packets), "kitti-oxts")


def test_times_of_another_kind_are_refused(made):
    drive = made.oxts(made.folder / "drive", times=["12.5"] * COUNT)
    assert "timestamps.txt, row 1: the time is '12.5', not as 2011-09-26" in refusal(drive, "kitti-oxts")


@pytest.mark.parametrize("name", ["kitti-poses", "kitti-oxts"])
def test_a_drive_over_the_limit_is_an_error_that_names_it(made, name):
    with pytest.raises(DataFormatError, match=r"the trip \S+/car has over"):
        list(get_reader(name).within(200).read(str(made.valid(name))))
