"""Claims about what `inspect` finds in a recording."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.io.trips import read_trips
from modelcast.trips.inspection import inspect
from modelcast.trips.trajectory import Trajectory, build_trajectory
from modelcast.world.drive import generate_drive

GRID_TOLERANCE_RATIO = 0.02
"""A detected grid step lies this close to the true one."""


def held(column: FloatArray, rows: int) -> FloatArray:
    return column[(np.arange(column.size) // rows) * rows]


@pytest.fixture(scope="module")
def drive() -> Trajectory:
    return generate_drive(seed=3, duration_s=120.0).truth


@settings(derandomize=True, deadline=None, max_examples=20)
@given(step_m=st.floats(0.06, 1.5), turned_rad=st.floats(-3.0, 3.0))
def test_a_grid_is_found_whatever_its_step_and_the_road(step_m: float, turned_rad: float) -> None:
    trip = generate_drive(seed=3, duration_s=120.0).truth.moved(turned_rad, (17.0, -4.0))
    found = inspect(replace(trip, position_m=np.round(trip.position_m / step_m) * step_m))
    assert found.grid_axis_m == pytest.approx((step_m, step_m), rel=GRID_TOLERANCE_RATIO)
    assert found.recommended_protocol == "sensor"


@settings(derandomize=True, deadline=None, max_examples=20)
@given(speed_mps=st.floats(0.5, 40.0), course_rad=st.floats(-3.0, 3.0))
def test_steady_driving_is_no_grid(speed_mps: float, course_rad: float) -> None:
    t = np.arange(0.0, 60.0, 0.1)
    path = speed_mps * t[:, None] * np.array([np.sin(course_rad), np.cos(course_rad)])
    assert inspect(build_trajectory("made/1", t, path)).grid_m == 0.0


def test_values_held_for_a_second_are_found_and_fresh_ones_are_not_called_held(drive: Trajectory) -> None:
    assert drive.speed_mps is not None
    fresh = inspect(drive)
    assert not fresh.values_held
    assert fresh.is_clean
    slow = inspect(
        replace(drive, speed_mps=held(drive.speed_mps, 10), acceleration_mps2=None, yaw_rate_radps=None)
    )
    assert slow.held_s == pytest.approx(1.0)
    assert slow.speed_rate_hz is not None
    assert 0.7 < slow.speed_rate_hz <= 1.05  # in a turn at constant speed nothing changes
    assert slow.recommended_protocol == "sensor"


def test_positions_extrapolated_from_a_held_velocity_are_told_from_measured_ones(drive: Trajectory) -> None:
    first = (np.arange(len(drive)) // 10) * 10
    velocity = np.gradient(drive.position_m, drive.t_s, axis=0)
    ahead = velocity[first] * (drive.t_s - drive.t_s[first])[:, None]
    bare = replace(drive, acceleration_mps2=None, yaw_rate_radps=None)
    assert drive.speed_mps is not None
    assert drive.heading_rad is not None
    slow = replace(bare, speed_mps=drive.speed_mps[first], heading_rad=drive.heading_rad[first])
    assert inspect(replace(slow, position_m=drive.position_m[first] + ahead)).is_coasted
    assert not inspect(slow).is_coasted


def test_noise_is_what_a_quadratic_cannot_explain() -> None:
    """Two axes of white noise leave sqrt(2 (n - 3) / n) of their size in windows of n = 11 samples."""
    t = np.arange(0.0, 200.0, 0.1)
    path = np.stack([3.0 * t + 0.1 * t**2, -5.0 * t], axis=1)
    assert inspect(build_trajectory("made/1", t, path)).noise_p95_m < 1e-9
    noisy = path + np.random.default_rng(1).normal(0.0, 0.05, path.shape)
    found = inspect(build_trajectory("made/1", t, noisy)).noise_p50_m
    assert found == pytest.approx(0.05 * np.sqrt(2.0 * 8.0 / 11.0), rel=0.05)


def test_a_stuck_speed_is_caught(drive: Trajectory) -> None:
    assert not inspect(drive).speed_is_stuck
    stuck = inspect(replace(drive, speed_mps=np.full(len(drive), 5.68)))
    assert stuck.speed_is_stuck
    assert stuck.speed_ratio < 1.0


def test_gaps_are_counted_and_do_not_reach_into_the_differences() -> None:
    t = np.concatenate([np.arange(0.0, 30.0, 0.1), np.arange(45.0, 80.0, 0.1)])
    found = inspect(build_trajectory("made/1", t, np.stack([10.0 * t, 0.0 * t], axis=1)))
    assert found.gaps == 1
    assert found.longest_gap_s == pytest.approx(15.1)


@settings(derandomize=True, deadline=None, max_examples=10)
@given(count=st.integers(1, 12))
def test_a_trip_of_a_few_samples_is_inspected_too(count: int) -> None:
    t = np.arange(0.0, 0.1 * count - 0.05, 0.1)
    found = inspect(build_trajectory("made/1", t, np.stack([t, t], axis=1), speed_mps=np.ones(count)))
    assert found.samples == count
    assert found.is_clean


@pytest.mark.real
def test_the_spmd_log_holds_values_extrapolates_and_lies_on_a_float32_grid(data_folder: Path) -> None:
    found = inspect(next(iter(read_trips(data_folder / "spmd" / "bsm_p1_dev.csv"))))
    assert found.grid_axis_m == pytest.approx((0.63, 0.42), abs=0.01)
    assert found.speed_rate_hz == pytest.approx(1.0, abs=0.1)
    assert found.is_coasted
    assert found.recommended_protocol == "sensor"


@pytest.mark.real
def test_no_openacc_trip_shows_a_grid_or_held_values(data_folder: Path) -> None:
    for trip in read_trips(data_folder / "openacc_zalazone" / "short_setting__handling_part14.csv"):
        found = inspect(trip)
        assert found.is_clean, found
        assert not found.speed_is_stuck
