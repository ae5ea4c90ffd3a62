"""Claims about manoeuvres: closed forms, symmetries, and what real trips are known to hold."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.io.trips import read_trips
from modelcast.trips.manoeuvres.base import (
    KINDS,
    FoundManoeuvre,
    ManoeuvreCounts,
    ManoeuvreKind,
)
from modelcast.trips.manoeuvres.bends import MAX_RADIUS_M
from modelcast.trips.manoeuvres.lane_changes import MAX_SHIFT_M, MIN_SHIFT_M, MIN_SPEED_MPS
from modelcast.trips.manoeuvres.rank import count_manoeuvres, rank_trips
from modelcast.trips.manoeuvres.stops import DRIVEN_M, MIN_STAND_S
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.drive import generate_drive
from modelcast.world.manoeuvre_drive import generate_known_drive

SHIFT_ERROR_M = 0.35
"""A lane change of a duration between those that are tried is measured a tenth too small or large."""

ANGLE_ERROR_RAD = np.deg2rad(12.0)
"""A bend's ends are where its radius passes 60 m: a few degrees of what is turned lie outside."""

BRAKING_ERROR_RATIO = 0.05
"""A kink in a made-up speed rings by a few percent where the inspection has the trip conditioned."""

STEP_S = 0.1


def drive(
    pieces: list[tuple[float, float]], speed_mps: float = 12.0, dt_s: float = STEP_S, heading_rad: float = 0.0
) -> Trajectory:
    """A trip at one speed along arcs of (length [m], angle [rad], clockwise)."""
    fine_m = 0.05
    turning = np.concatenate([np.full(round(length / fine_m), angle / length) for length, angle in pieces])
    course = heading_rad + np.concatenate([[0.0], np.cumsum(turning * fine_m)])
    middle = 0.5 * (course[1:] + course[:-1])
    steps = fine_m * np.stack([np.sin(middle), np.cos(middle)], axis=1)
    path = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    way = np.asarray(np.arange(path.shape[0]) * fine_m, dtype=np.float64)
    t_s = np.arange(0.0, way[-1] / speed_mps, dt_s)
    return build_trajectory("made/1", t_s, along(way, path, speed_mps * t_s))


def along(way: FloatArray, path: FloatArray, at: FloatArray) -> FloatArray:
    return np.stack([np.interp(at, way, path[:, axis]) for axis in (0, 1)], axis=1)


def shifted(
    shift_m: float, duration_s: float = 5.0, speed_mps: float = 20.0, radius_m: float | None = None
) -> Trajectory:
    """40 s in a lane and the one beside it to the right, on a straight road or a bend to the right."""
    t_s = np.arange(0.0, 40.0 + 1e-9, STEP_S)
    u = np.clip((t_s - 20.0) / duration_s + 0.5, 0.0, 1.0)
    right = shift_m * (u - np.sin(2.0 * np.pi * u) / (2.0 * np.pi))
    if radius_m is None:
        return build_trajectory("made/1", t_s, np.stack([right, speed_mps * t_s], axis=1))
    angle = speed_mps * t_s / radius_m
    inner = radius_m - right
    return build_trajectory("made/1", t_s, np.stack([-inner * np.cos(angle), inner * np.sin(angle)], axis=1))


def by_speed(speed_mps: FloatArray) -> Trajectory:
    """A straight trip with this speed at every step."""
    way = np.concatenate([[0.0], np.cumsum(0.5 * (speed_mps[1:] + speed_mps[:-1]) * STEP_S)])
    t_s = np.arange(way.size) * STEP_S
    return build_trajectory("made/1", t_s, np.stack([0.0 * way, way], axis=1), speed_mps=speed_mps)


def found(trip: Trajectory) -> list[FoundManoeuvre]:
    return list(count_manoeuvres(trip).manoeuvres)


def kinds(trip: Trajectory) -> list[tuple[str, str]]:
    return [(one.kind.value, one.side) for one in found(trip)]


def mirrored(trip: Trajectory) -> Trajectory:
    return replace(trip, position_m=trip.position_m * np.array([-1.0, 1.0]), heading_rad=None)


def reversed_in_time(trip: Trajectory) -> Trajectory:
    """The same path, driven backwards in time by a car that faces the way it goes."""
    return build_trajectory("made/1", trip.t_s[-1] - trip.t_s[::-1], trip.position_m[::-1])


@pytest.mark.parametrize("radius_m", [None, 400.0, 900.0])
@pytest.mark.parametrize("shift_m", [3.0, -3.5, 4.2])
@pytest.mark.parametrize("duration_s", [3.5, 5.0, 7.0])
def test_a_lane_change_is_found_with_its_shift_and_side_on_any_road(
    shift_m: float, duration_s: float, radius_m: float | None
) -> None:
    (one,) = found(shifted(shift_m, duration_s, radius_m=radius_m))
    assert one.kind is ManoeuvreKind.LANE_CHANGE
    assert one.side == ("right" if shift_m > 0.0 else "left")
    assert one.size == pytest.approx(abs(shift_m), abs=SHIFT_ERROR_M)
    assert one.start_s < 20.0 < one.end_s
    assert one.end_s - one.start_s == pytest.approx(duration_s, abs=2.0)


@pytest.mark.parametrize("shift_m", [0.5, 0.8 * MIN_SHIFT_M, 1.2 * MAX_SHIFT_M, 12.0])
def test_a_shift_that_is_not_one_lane_is_no_lane_change(shift_m: float) -> None:
    assert found(shifted(shift_m)) == []


def test_who_crawls_changes_no_lane() -> None:
    assert found(shifted(3.5, speed_mps=0.9 * MIN_SPEED_MPS)) == []
    assert len(found(shifted(3.5, speed_mps=1.2 * MIN_SPEED_MPS))) == 1


@pytest.mark.parametrize("radius_m", [1.2 * MAX_RADIUS_M, 150.0, 600.0])
@pytest.mark.parametrize("angle_deg", [10.0, 45.0, 90.0, 400.0])
def test_a_wide_bend_is_nothing(radius_m: float, angle_deg: float) -> None:
    angle = np.deg2rad(angle_deg)
    assert found(drive([(200.0, 0.0), (radius_m * angle, angle), (200.0, 0.0)])) == []


@pytest.mark.parametrize("radius_m", [100.0, 250.0, 800.0])
@pytest.mark.parametrize("angle_deg", [20.0, 40.0])
@pytest.mark.parametrize("between_m", [1.0, 60.0])
def test_an_s_bend_is_nothing(radius_m: float, angle_deg: float, between_m: float) -> None:
    angle = np.deg2rad(angle_deg)
    bend = radius_m * angle
    path = [(300.0, 0.0), (bend, angle), (between_m, 0.0), (bend, -angle), (300.0, 0.0)]
    assert found(drive(path, speed_mps=16.0)) == []


@pytest.mark.parametrize("radius_m", [6.0, 12.0, 25.0])
@pytest.mark.parametrize("angle_deg", [60.0, -90.0, 120.0])
def test_a_tight_bend_is_one_turn(radius_m: float, angle_deg: float) -> None:
    angle = np.deg2rad(angle_deg)
    (one,) = found(drive([(80.0, 0.0), (radius_m * abs(angle), angle), (80.0, 0.0)], 6.0))
    assert (one.kind, one.side) == (ManoeuvreKind.TURN, "right" if angle > 0.0 else "left")
    assert one.size == pytest.approx(abs(angle), abs=ANGLE_ERROR_RAD)


def test_a_tight_bend_back_is_a_u_turn_and_a_wide_one_a_turn() -> None:
    for radius_m, kind in ((7.0, "U-turn"), (30.0, "turn")):
        assert kinds(drive([(80.0, 0.0), (radius_m * np.pi, -np.pi), (80.0, 0.0)], 5.0)) == [(kind, "left")]


@pytest.mark.parametrize("island", [-1.0, 1.0])
@pytest.mark.parametrize("angle_deg", [70.0, 160.0, 250.0])
def test_entry_circulation_and_exit_are_one_roundabout(island: float, angle_deg: float) -> None:
    angle, aside = np.deg2rad(angle_deg), np.deg2rad(35.0)
    path = [(80.0, 0.0), (20.0 * aside, -island * aside), (18.0 * angle, island * angle)]
    path += [(20.0 * aside, -island * aside), (80.0, 0.0)]
    (one,) = found(drive(path, 7.0))
    assert (one.kind, one.side) == (ManoeuvreKind.ROUNDABOUT, "right" if island > 0.0 else "left")
    assert one.size == pytest.approx(angle, abs=2.0 * ANGLE_ERROR_RAD)


def test_the_same_shape_taken_fast_or_wide_is_no_roundabout() -> None:
    def shape(radius_m: float) -> list[tuple[float, float]]:
        return [(80.0, 0.0), (radius_m, -1.0), (2.0 * radius_m, 2.0), (radius_m, -1.0), (80.0, 0.0)]

    assert kinds(drive(shape(20.0), 7.0)) == [("roundabout", "right")]
    assert "roundabout" not in [kind for kind, _ in kinds(drive(shape(20.0), 16.0))]
    assert "roundabout" not in [kind for kind, _ in kinds(drive(shape(45.0), 7.0))]


def test_circles_are_one_roundabout_and_laps_of_a_track_none() -> None:
    assert kinds(drive([(80.0, 0.0), (20.0 * 4.0 * np.pi, 4.0 * np.pi), (80.0, 0.0)], 7.0)) == [
        ("roundabout", "right")
    ]
    lap = [(300.0, 0.0), (80.0 * np.pi, np.pi)] * 6
    assert found(drive(lap, 20.0)) == []


@pytest.mark.parametrize("stood_s", [0.5 * MIN_STAND_S, MIN_STAND_S + 1.0, 30.0])
def test_a_stop_lasts_as_long_as_it_stands(stood_s: float) -> None:
    ramp = np.linspace(10.0, 0.0, 60)
    speed = np.concatenate([np.full(50, 10.0), ramp, np.zeros(round(stood_s / STEP_S)), ramp[::-1]])
    stops = [one for one in found(by_speed(speed)) if one.kind is ManoeuvreKind.STOP]
    if stood_s < MIN_STAND_S:
        assert stops == []
    else:
        assert [one.size for one in stops] == [pytest.approx(stood_s, abs=1.2)]


def test_rest_at_the_beginning_is_no_stop_and_moving_up_in_a_queue_no_new_one() -> None:
    stand, creep = np.zeros(60), np.array([0.0, *np.full(round(0.6 * DRIVEN_M / 1.5 / STEP_S), 1.5), 0.0])
    drive_off = np.concatenate([np.linspace(0.0, 8.0, 50), np.linspace(8.0, 0.0, 50)])
    assert count_manoeuvres(by_speed(np.concatenate([stand, drive_off]))).by_kind[ManoeuvreKind.STOP] == 0
    queue = np.concatenate([stand, drive_off, stand, creep, stand, drive_off, stand])
    assert count_manoeuvres(by_speed(queue)).by_kind[ManoeuvreKind.STOP] == 2


@pytest.mark.parametrize(("braking_mps2", "hard"), [(2.0, False), (3.6, False), (4.4, True), (8.0, True)])
def test_braking_over_four_tenths_of_g_for_a_second_is_hard(braking_mps2: float, *, hard: bool) -> None:
    falling = np.arange(25.0, 5.0, -braking_mps2 * STEP_S)
    brakes = found(by_speed(np.concatenate([np.full(50, 25.0), falling, np.full(50, falling[-1])])))
    assert [one.kind for one in brakes] == [ManoeuvreKind.HARD_BRAKE] * hard
    assert [one.size for one in brakes] == [pytest.approx(braking_mps2, rel=BRAKING_ERROR_RATIO)] * hard


def test_a_jolt_shorter_than_a_second_is_no_hard_brake() -> None:
    speed = np.concatenate([np.full(50, 25.0), np.linspace(25.0, 22.5, 4), np.full(50, 22.5)])
    assert found(by_speed(speed)) == []


@settings(derandomize=True, deadline=None, max_examples=6)
@given(seed=st.integers(0, 10**6))
def test_a_mirror_swaps_left_and_right(seed: int) -> None:
    trip = generate_known_drive(seed, 200.0).truth
    other = {"left": "right", "right": "left", "": ""}
    assert kinds(mirrored(trip)) == [(kind, other[side]) for kind, side in kinds(trip)]


@settings(derandomize=True, deadline=None, max_examples=6)
@given(seed=st.integers(0, 10**6), turned=st.floats(-3.0, 3.0), east=st.floats(-1e5, 1e5))
def test_where_and_which_way_a_trip_is_driven_does_not_matter(seed: int, turned: float, east: float) -> None:
    trip = generate_known_drive(seed, 200.0).truth
    assert kinds(trip.moved(turned, (east, -east))) == kinds(trip)


def test_backwards_a_lane_change_keeps_its_side_and_a_turn_changes_it() -> None:
    lane = shifted(3.5)
    assert kinds(reversed_in_time(lane)) == kinds(lane) == [("lane change", "right")]
    turn = drive([(80.0, 0.0), (15.0, 1.5), (80.0, 0.0)], 6.0)
    assert (kinds(turn), kinds(reversed_in_time(turn))) == ([("turn", "right")], [("turn", "left")])


def test_a_gap_parts_a_trip_but_loses_nothing_beside_it() -> None:
    """Two lane changes, the seconds between them missing."""
    one = shifted(3.5)
    t_s = np.concatenate([one.t_s, one.t_s[-1] + 8.0 + one.t_s])
    offset = np.array([3.5, one.position_m[-1, 1] + 160.0])  # a jump over the gap is no braking
    trip = build_trajectory("made/1", t_s, np.concatenate([one.position_m, one.position_m + offset]))
    assert trip.segments.size == 3
    assert kinds(trip) == [("lane change", "right")] * 2


@settings(derandomize=True, deadline=None, max_examples=4)
@given(seed=st.integers(0, 1000))
def test_manoeuvres_of_the_demo_drive_are_counted_as_its_script_says(seed: int) -> None:
    drive = generate_drive(seed, duration_s=200.0)
    whole = [m.name for m in drive.manoeuvres if m.end_s < 199.0]
    for trip in (drive.truth, drive.input):
        found = count_manoeuvres(trip).by_kind
        assert whole.count("stop") <= found[ManoeuvreKind.STOP] <= whole.count("stop") + 1
        assert whole.count("turn") <= found[ManoeuvreKind.TURN] <= whole.count("turn") + 1
        assert found[ManoeuvreKind.HARD_BRAKE] == 1


def test_the_merit_is_total_then_kinds_then_manoeuvres_a_kilometre() -> None:
    def counts(name: str, distance_m: float, *found: ManoeuvreKind) -> ManoeuvreCounts:
        items = tuple(FoundManoeuvre(kind, 0.0, 1.0, size=1.0) for kind in found)
        return ManoeuvreCounts(name, 60.0, distance_m=distance_m, manoeuvres=items)

    turn, stop = ManoeuvreKind.TURN, ManoeuvreKind.STOP
    trips = [
        counts("same b", 1000.0, turn, turn),
        counts("same a", 1000.0, turn, turn),
        counts("denser", 500.0, turn, turn),
        counts("more kinds", 9000.0, turn, stop),
        counts("more", 9000.0, turn, turn, turn),
        counts("none", 0.0),
    ]
    order = [one.trip_id for one in rank_trips(trips)]
    assert order == ["more", "more kinds", "denser", "same a", "same b", "none"]
    assert trips[-1].per_km == 0.0
    assert trips[3].by_kind == {kind: int(kind in (turn, stop)) for kind in KINDS}


def test_a_manoeuvre_does_not_end_before_it_begins() -> None:
    with pytest.raises(ValueError, match="lies before"):
        FoundManoeuvre(ManoeuvreKind.TURN, 2.0, 1.0, size=1.0)
    with pytest.raises(ValueError, match="at least 0"):
        FoundManoeuvre(ManoeuvreKind.TURN, 1.0, 2.0, size=-1.0)


@pytest.mark.parametrize("samples", [1, 2, 5, 20])
def test_a_trip_of_a_moment_holds_nothing(samples: int) -> None:
    t_s = np.arange(samples) * STEP_S
    assert found(build_trajectory("made/1", t_s, np.stack([10.0 * t_s, 0.0 * t_s], axis=1))) == []


@pytest.mark.real
def test_the_safety_pilot_trip_holds_its_one_turn_and_no_stop(spmd_trip: Trajectory) -> None:
    by_kind = count_manoeuvres(spmd_trip).by_kind
    assert by_kind[ManoeuvreKind.TURN] == 1
    assert by_kind[ManoeuvreKind.STOP] == by_kind[ManoeuvreKind.HARD_BRAKE] == 0
    assert by_kind[ManoeuvreKind.ROUNDABOUT] == by_kind[ManoeuvreKind.U_TURN] == 0


@pytest.mark.real
def test_a_test_track_is_not_taken_for_roundabouts(data_folder: Path) -> None:
    """Two laps of the handling course: its one tight bend twice, and the stop at the end."""
    trips = list(read_trips(data_folder / "openacc_zalazone" / "no_ACC__handling_part22.csv"))
    counts = [count_manoeuvres(trip) for trip in trips]
    assert sum(one.by_kind[ManoeuvreKind.ROUNDABOUT] for one in counts) == 0
    assert all(one.by_kind[ManoeuvreKind.TURN] in (2, 3) for one in counts)
    assert sum(one.by_kind[ManoeuvreKind.LANE_CHANGE] for one in counts) <= 2


@pytest.mark.real
def test_two_receivers_in_one_car_tell_the_same_manoeuvres(data_folder: Path) -> None:
    """A plain receiver beside an RTK one: bends and stops alike, lane changes within one."""
    plain, rtk = (
        count_manoeuvres(t).by_kind for t in read_trips(data_folder / "roads/beijing_gps_and_rtk.parquet")
    )
    for kind in KINDS:
        assert abs(plain[kind] - rtk[kind]) <= (kind is ManoeuvreKind.LANE_CHANGE)


def test_reversing_out_of_a_bay_is_no_u_turn() -> None:
    way = np.concatenate(
        [np.linspace(0.0, 60.0, 200), np.linspace(60.0, 30.0, 150), np.linspace(30.0, 90.0, 200)]
    )
    t_s = np.arange(way.size) * STEP_S
    assert found(build_trajectory("made/1", t_s, np.stack([way, 0.001 * way], axis=1))) == []


def test_a_position_that_wanders_while_the_car_stands_makes_no_bend() -> None:
    rng = np.random.default_rng(3)
    ahead = np.concatenate([np.linspace(0.0, 80.0, 100), np.full(600, 80.0), np.linspace(80.0, 160.0, 100)])
    noise = 0.05 * rng.standard_normal((ahead.size, 2))
    trip = build_trajectory(
        "made/1", np.arange(ahead.size) * STEP_S, np.stack([ahead, 0.0 * ahead], axis=1) + noise
    )
    assert {one.kind for one in found(trip)} <= {ManoeuvreKind.STOP, ManoeuvreKind.HARD_BRAKE}


def test_a_weave_at_walking_pace_is_no_roundabout() -> None:
    """Entry, circulation and exit at walking pace: a car park."""
    shape = [(80.0, 0.0), (12.0, -0.7), (30.0, 2.0), (12.0, -0.7), (80.0, 0.0)]
    assert kinds(drive(shape, 7.0)) == [("roundabout", "right")]
    assert ManoeuvreKind.ROUNDABOUT not in [one.kind for one in found(drive(shape, 1.6))]


def test_bends_far_from_the_circulation_are_none_of_its_own() -> None:
    def shape(between_m: float) -> list[tuple[float, float]]:
        return [
            (80.0, 0.0),
            (12.0, -1.0),
            (between_m, 0.0),
            (30.0, 2.0),
            (between_m, 0.0),
            (12.0, -1.0),
            (80.0, 0.0),
        ]

    assert kinds(drive(shape(3.0), 7.0)) == [("roundabout", "right")]
    assert kinds(drive(shape(60.0), 7.0)) == [("turn", "left"), ("turn", "right"), ("turn", "left")]


def test_a_turn_between_slight_bends_to_the_other_side_is_a_turn() -> None:
    def shape(aside: float) -> list[tuple[float, float]]:
        return [(80.0, 0.0), (20.0 * aside, -aside), (36.0, 1.8), (20.0 * aside, -aside), (80.0, 0.0)]

    assert kinds(drive(shape(0.5), 7.0)) == [("roundabout", "right")]
    assert kinds(drive(shape(0.15), 7.0)) == [("turn", "right")]


def test_in_a_tight_bend_no_lane_change_is_told() -> None:
    assert kinds(shifted(3.5, radius_m=300.0)) == [("lane change", "right")]
    assert found(shifted(3.5, radius_m=150.0)) == []


def test_a_turn_in_two_strokes_is_one() -> None:
    stroke = (12.0 * 0.8, 0.8)
    (one,) = found(drive([(80.0, 0.0), stroke, (7.0, 0.0), stroke, (80.0, 0.0)], 6.0))
    assert (one.kind, one.side) == (ManoeuvreKind.TURN, "right")
    assert one.size == pytest.approx(1.6, abs=ANGLE_ERROR_RAD)
