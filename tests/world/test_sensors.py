"""Claims about what a sender sees of the truth."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import wrap_angle_rad
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.drive import generate_drive
from modelcast.world.sensors import IDEAL, SensorModel, sense, with_motion


def straight(duration_s: float = 2000.0, speed_mps: float = 10.0) -> Trajectory:
    t = np.arange(0.0, duration_s, 0.1)
    return build_trajectory("made/1", t, np.stack([speed_mps * t, 0.0 * t], axis=1))


def present(column: FloatArray | None) -> FloatArray:
    assert column is not None
    return column


def test_an_ideal_sensor_shows_the_truth() -> None:
    truth = generate_drive(1, duration_s=90.0).truth
    seen = sense(truth, IDEAL, np.random.default_rng(0))
    assert np.array_equal(seen.position_m, truth.position_m)
    assert np.array_equal(present(seen.speed_mps), present(truth.speed_mps))


def test_white_errors_have_the_stated_sizes() -> None:
    truth = with_motion(straight())
    seen = sense(truth, SensorModel(), np.random.default_rng(2))
    assert np.std(seen.position_m - truth.position_m, axis=0) == pytest.approx((0.01, 0.01), rel=0.03)
    assert np.std(present(seen.speed_mps)) == pytest.approx(0.05, rel=0.03)
    assert np.rad2deg(np.std(present(seen.heading_rad))) == pytest.approx(0.2, rel=0.03)


def test_the_slow_error_has_its_size_and_correlation() -> None:
    model = replace(IDEAL, slow_position_noise_m=0.5, slow_correlation_s=2.0)
    truth = straight(20_000.0)
    error = (sense(truth, model, np.random.default_rng(3)).position_m - truth.position_m)[:, 0]
    assert error.std() == pytest.approx(0.5, rel=0.03)
    assert np.corrcoef(error[:-20], error[20:])[0, 1] == pytest.approx(np.exp(-1.0), abs=0.03)


@settings(derandomize=True, deadline=None, max_examples=15)
@given(latency_s=st.floats(0.0, 1.5))
def test_latency_shows_the_truth_of_earlier(latency_s: float) -> None:
    truth = straight(20.0)
    seen = sense(truth, replace(IDEAL, latency_s=latency_s), np.random.default_rng(0))
    late = truth.t_s >= latency_s
    expected = 10.0 * np.where(late, truth.t_s - latency_s, 0.0)
    assert np.abs(seen.position_m[:, 0] - expected).max() < 1e-9


def test_latency_does_not_reach_over_a_gap() -> None:
    t = np.concatenate([np.arange(0.0, 5.0, 0.1), np.arange(50.0, 55.0, 0.1)])
    truth = build_trajectory("made/1", t, np.stack([t, t], axis=1))
    seen = sense(truth, replace(IDEAL, latency_s=0.3), np.random.default_rng(0))
    first = truth.segments[1]
    assert np.array_equal(seen.position_m[first], truth.position_m[first])


def test_an_input_never_depends_on_later_truth() -> None:
    drive = generate_drive(2, duration_s=90.0).truth
    moved = drive.position_m.copy()
    moved[500:] += 100.0
    a = sense(drive, SensorModel(slow_position_noise_m=0.5, latency_s=0.1), np.random.default_rng(4))
    b = sense(
        replace(drive, position_m=moved),
        SensorModel(slow_position_noise_m=0.5, latency_s=0.1),
        np.random.default_rng(4),
    )
    assert np.array_equal(a.position_m[:500], b.position_m[:500])


def test_heading_is_held_with_its_error_while_the_car_stands() -> None:
    truth = generate_drive(3, duration_s=100.0).truth
    heading = present(sense(truth, SensorModel(), np.random.default_rng(5)).heading_rad)
    still = np.flatnonzero((present(truth.speed_mps) == 0.0) & (truth.t_s < 60.0))
    assert np.ptp(heading[still]) == 0.0
    assert 0.0 < abs(float(wrap_angle_rad(heading - present(truth.heading_rad))[still[0]])) < 0.02


def test_speed_is_never_negative() -> None:
    truth = generate_drive(3, duration_s=100.0).truth
    assert present(sense(truth, SensorModel(), np.random.default_rng(6)).speed_mps).min() >= 0.0


def test_one_seed_gives_one_input_and_sizes_scale_the_same_draws() -> None:
    truth = straight(50.0)
    fine, rough = SensorModel(position_noise_m=0.01), SensorModel(position_noise_m=0.02)
    a, again, b = (sense(truth, m, np.random.default_rng(7)).position_m for m in (fine, fine, rough))
    assert a.tobytes() == again.tobytes()
    np.testing.assert_allclose(b - truth.position_m, 2.0 * (a - truth.position_m), atol=1e-9)


def test_a_trip_draws_each_kind_of_error_for_all_its_samples_in_the_order_of_old() -> None:
    """Numbers of later kinds come last, so that inputs and event lists of earlier versions stay."""
    drive = generate_drive(4, duration_s=90.0).truth
    truth = replace(drive, speed_mps=present(drive.speed_mps) + 1.0)
    model = SensorModel(slow_position_noise_m=0.5)
    seen = sense(truth, model, np.random.default_rng(8))
    numbers = np.random.default_rng(8).standard_normal((8, len(truth)))
    slow = numbers[2:4].T.copy()
    for i, step_s in enumerate(np.diff(truth.t_s), start=1):
        kept = np.exp(-step_s / 300.0)
        slow[i] = kept * slow[i - 1] + np.sqrt(1.0 - kept**2) * slow[i]
    np.testing.assert_allclose(
        seen.position_m, truth.position_m + 0.01 * numbers[:2].T + 0.5 * slow, atol=1e-10
    )
    default = sense(truth, SensorModel(), np.random.default_rng(8))
    assert np.array_equal(default.position_m, truth.position_m + 0.01 * numbers[:2].T)
    assert np.array_equal(
        present(default.speed_mps), np.maximum(present(truth.speed_mps) + 0.05 * numbers[4], 0.0)
    )
    course = present(truth.heading_rad) + model.heading_noise_rad * numbers[5]
    assert np.array_equal(present(default.heading_rad), wrap_angle_rad(course))
    acceleration = present(truth.acceleration_mps2) + 0.05 * numbers[6]
    assert np.array_equal(present(default.acceleration_mps2), acceleration)
    turning = present(truth.yaw_rate_radps) + model.yaw_rate_noise_radps * numbers[7]
    assert np.array_equal(present(default.yaw_rate_radps), turning)


def test_sizes_may_be_whole_numbers() -> None:
    truth = straight(5.0)
    whole, real = (
        SensorModel(position_noise_m=1, latency_s=1),
        SensorModel(position_noise_m=1.0, latency_s=1.0),
    )
    a, b = (sense(truth, model, np.random.default_rng(9)).position_m for model in (whole, real))
    assert a.tobytes() == b.tobytes()


def test_motion_is_taken_from_positions_only_where_it_is_missing() -> None:
    trip = straight(20.0)
    known = replace(trip, speed_mps=np.full(len(trip), 9.0))
    found = with_motion(known)
    assert found.speed_mps is known.speed_mps
    assert np.allclose(present(found.heading_rad), np.pi / 2)
    assert np.allclose(present(with_motion(trip).speed_mps), 10.0)


@pytest.mark.parametrize("name", SensorModel.__slots__)
@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf")])
def test_a_size_that_is_none_is_refused_by_name(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=name):
        SensorModel(**{name: value})


@pytest.mark.parametrize("name", ["slow_correlation_s", "multipath_correlation_s"])
def test_a_correlation_time_of_zero_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match=f"{name} must be positive"):
        SensorModel(**{name: 0.0})


def test_a_car_that_has_not_moved_yet_shows_no_later_heading() -> None:
    t = np.arange(0.0, 10.0, 0.1)
    speed = np.maximum(t - 5.0, 0.0)
    path = np.stack([0.5 * speed**2, 0.0 * t], axis=1)
    truth = build_trajectory(
        "made/1", t, path, speed_mps=speed, heading_rad=np.where(t < 5.0, 1.0, np.pi / 2)
    )
    heading = present(sense(truth, IDEAL, np.random.default_rng(0)).heading_rad)
    assert np.allclose(heading[t < 5.0], 1.0)
    unknown = with_motion(replace(truth, heading_rad=None))
    assert np.allclose(present(unknown.heading_rad), np.pi / 2)
