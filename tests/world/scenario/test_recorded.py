"""Claims about recorded trips as traffic: replay, the library, completion, resampling."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.core.geodesy import heading_to_velocity
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.drive import generate_drive
from modelcast.world.scenario.base import STEP_S, FleetFrame, run_scenario
from modelcast.world.scenario.completion import completed
from modelcast.world.scenario.library import TripRoad
from modelcast.world.scenario.recorded import make_replay
from modelcast.world.scenario.resampling import resampled


def straight(speed: float, count: int = 200, *, north: float = 0.0) -> Trajectory:
    t_s = np.arange(count) * STEP_S
    return build_trajectory(f"made/{speed}", t_s, np.stack([speed * t_s, 0.0 * t_s + north], axis=1))


def frames_of(scenario: object, duration_s: float, seed: int = 0) -> list[FleetFrame]:
    return list(run_scenario(scenario, np.random.default_rng(seed), duration_s=duration_s))  # type: ignore[arg-type]


def test_a_replay_keeps_the_clock_that_the_trips_share() -> None:
    late = make_replay([straight(10.0), straight(20.0, 100, north=5.0)], [100.0, 105.0])
    frames = frames_of(late, 20.0)
    assert late.duration_s == pytest.approx(20.0)
    assert frames[0].active.tolist() == [True, False]
    assert frames[49].active.tolist() == [True, False]
    assert frames[50].active.tolist() == [True, True]
    np.testing.assert_allclose(frames[60].position_m, [[60.0, 0.0], [20.0, 5.0]], atol=1e-9)
    np.testing.assert_allclose(frames[60].speed_mps, [10.0, 20.0])
    np.testing.assert_allclose(frames[60].heading_rad, np.pi / 2)
    assert frames[160].active.tolist() == [True, False]


def test_a_replay_is_over_after_its_last_frame() -> None:
    replay = make_replay([straight(10.0, 50)], [0.0])
    assert not replay.frame(50).active.any()
    assert replay.frame(50).vehicle_id.tolist() == [-1]


def test_in_a_gap_the_car_is_not_there_and_comes_back_as_a_new_one() -> None:
    t_s = np.concatenate([np.arange(30), np.arange(50, 80)]) * STEP_S
    trip = build_trajectory("made/gap", t_s, np.stack([10.0 * t_s, 0.0 * t_s], axis=1))
    identity = [frame.vehicle_id[0] for frame in frames_of(make_replay([trip], [0.0]), 8.0)]
    assert identity == [0] * 30 + [-1] * 20 + [1] * 30


def test_a_replay_needs_as_many_starts_as_trips_and_a_fine_clock() -> None:
    with pytest.raises(ValueError, match="starts"):
        make_replay([straight(10.0)], [])
    coarse = build_trajectory("made/c", np.arange(20.0), np.zeros((20, 2)))
    with pytest.raises(ValueError, match="coarser"):
        make_replay([coarse], [0.0])


def test_the_library_drives_at_the_speeds_of_its_trips_and_is_consistent() -> None:
    drive = generate_drive(1, 120.0).truth
    road = TripRoad([drive], 1000.0, 80.0)
    frames = frames_of(road, 40.0)
    identity = np.array([frame.vehicle_id for frame in frames])
    same = identity[1:] == identity[:-1]
    velocity = np.array([heading_to_velocity(f.speed_mps, f.heading_rad) for f in frames])
    moved = np.diff(np.array([f.position_m for f in frames]), axis=0) / STEP_S
    assert np.abs(moved - 0.5 * (velocity[1:] + velocity[:-1]))[same].max() < 1e-9
    speed = np.array([f.speed_mps for f in frames])
    recorded = drive.speed_mps
    assert recorded is not None
    assert speed.max() == pytest.approx(recorded.max(), rel=0.02)
    assert (np.diff(identity, axis=0) != 0).any()


def test_a_straight_trip_stays_in_its_lane_and_a_bend_sways_about_a_metre() -> None:
    still = frames_of(TripRoad([straight(20.0)], 500.0, 40.0, lanes=1, median_m=4.0), 5.0)
    for frame in still:
        np.testing.assert_allclose(np.abs(frame.position_m[:, 1]), 3.75, atol=1e-6)
    bends = frames_of(TripRoad([generate_drive(2, 120.0).truth], 500.0, 40.0, lanes=1), 60.0)
    sway = np.abs(np.abs(np.array([f.position_m[:, 1] for f in bends])) - 3.75)
    assert 0.05 < sway.max() < 2.5


def test_half_of_the_lanes_lead_the_other_way() -> None:
    frame = frames_of(TripRoad([straight(20.0)], 2000.0, 100.0), 0.1)[0]
    east = frame.heading_rad > 0.0
    assert 0.35 < east.mean() < 0.65
    assert (frame.position_m[east, 1] < 0.0).all()
    assert (frame.position_m[~east, 1] > 0.0).all()


def test_a_library_without_a_usable_trip_is_refused() -> None:
    with pytest.raises(ValueError, match="gapless"):
        TripRoad([straight(10.0, 50)])
    with pytest.raises(ValueError, match="density_per_km"):
        TripRoad([straight(10.0)], density_per_km=0.0)


def test_one_seed_gives_the_same_traffic() -> None:
    road = TripRoad([generate_drive(1, 100.0).truth], 500.0, 40.0)
    first, again = frames_of(road, 20.0, 3), frames_of(road, 20.0, 3)
    assert first[-1].position_m.tobytes() == again[-1].position_m.tobytes()


def circling(t_s: float) -> FleetFrame:
    """One car on a circle of 50 m at 10 m/s, clockwise from its north, and an empty slot."""
    angle = 0.2 * t_s
    here = np.array([1.0, 0.0])
    return FleetFrame(
        t_s,
        np.array([[50.0 * np.sin(angle), 50.0 * np.cos(angle)], [0.0, 0.0]]),
        speed_mps=10.0 * here,
        heading_rad=((np.pi / 2 + angle + np.pi) % (2 * np.pi) - np.pi) * here,
        acceleration_mps2=0.0 * here,
        yaw_rate_radps=0.2 * here,
        length_m=4.5 * here,
        vehicle_id=np.array([0, -1]),
        active=np.array([True, False]),
    )


def test_completion_finds_the_motion_of_a_circle() -> None:
    unknown = np.array([np.nan, 0.0])
    bare = [
        replace(
            circling(k * STEP_S),
            speed_mps=unknown,
            heading_rad=unknown,
            acceleration_mps2=unknown,
            yaw_rate_radps=unknown,
        )
        for k in range(30)
    ]
    found = list(completed(bare))
    assert len(found) == 30
    for k in range(2, 28):
        frame, truth = found[k], circling(k * STEP_S)
        np.testing.assert_allclose(frame.speed_mps, truth.speed_mps, rtol=1e-3)  # an arc against its chord
        np.testing.assert_allclose(frame.heading_rad, truth.heading_rad, atol=1e-9)
        np.testing.assert_allclose(frame.yaw_rate_radps, truth.yaw_rate_radps, rtol=1e-6)
        np.testing.assert_allclose(frame.acceleration_mps2, 0.0, atol=1e-6)


def test_what_is_known_is_kept_and_a_single_frame_has_no_rates() -> None:
    frame = replace(circling(0.0), yaw_rate_radps=np.array([np.nan, 0.0]))
    (found,) = completed([frame])
    assert found.speed_mps.tolist() == [10.0, 0.0]
    assert found.yaw_rate_radps.tolist() == [0.0, 0.0]


def test_resampling_a_circle_from_one_second_errs_with_the_fourth_power() -> None:
    """Cubic Hermite: r (w h)^4 / 384 = 50 · 0.2^4 / 384 = 0.2 mm, 625 times less at a fifth of the step."""
    errors = []
    for step_s in (1.0, 0.2):
        given = [circling(k * step_s) for k in range(round(10.0 / step_s) + 1)]
        found = list(resampled(given))
        assert len(found) == 101
        errors.append(max(np.abs(f.position_m - circling(f.t_s).position_m).max() for f in found))
        assert max(abs(f.yaw_rate_radps[0] - 0.2) for f in found) < 0.01
    assert errors[0] == pytest.approx(50.0 * 0.2**4 / 384.0, rel=0.05)
    assert errors[0] / errors[1] == pytest.approx(625.0, rel=0.05)


def test_a_step_that_is_not_positive_is_refused() -> None:
    with pytest.raises(ValueError, match="step_s"):
        list(resampled([circling(0.0)], 0.0))


def test_a_frame_with_columns_of_other_shapes_is_refused() -> None:
    with pytest.raises(ValueError, match="speed_mps"):
        replace(circling(0.0), speed_mps=np.zeros(3))
    with pytest.raises(ValueError, match="position_m"):
        replace(circling(0.0), position_m=np.zeros((3, 2)))
    with pytest.raises(ValueError, match="vehicle_id"):
        replace(circling(0.0), vehicle_id=np.zeros(3, dtype=np.int64))
