"""Claims about the causal velocity that constant velocity and the baseline coast with."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import ConfigError
from modelcast.station.sensing.sensing import position_noise_m, sample_matrix
from modelcast.station.sensing.velocity import (
    DEFAULT_FROM_POSITIONS,
    REPORTED,
    VelocityEstimator,
    velocity_estimator_for,
)
from modelcast.trips.trajectory import Trajectory, build_trajectory

SLOPES = [VelocityEstimator(f"slope-{k}", k) for k in (2, 3, 5, 8)]
QUADRATICS = [VelocityEstimator(f"quadratic-{k}", k, degree=2) for k in (3, 4, 6)]
ESTIMATORS = [*SLOPES, *QUADRATICS]

ROUNDING_MPS = 1e-9
"""Positions of tens of metres carry 1e-14 m of rounding; windows of 0.2 s and normal equations amplify it."""


def uneven_times(count: int) -> FloatArray:
    """Times about 0.1 s apart, each step up to 20 % off, which still counts as uniform."""
    return np.cumsum(0.1 * np.random.default_rng(4).uniform(0.8, 1.2, count))


def along(t_s: FloatArray, *coefficients: tuple[float, float]) -> Trajectory:
    """A trip whose position is this polynomial of time."""
    position = sum(np.outer((t_s - t_s[0]) ** k, c) for k, c in enumerate(coefficients))
    return build_trajectory("made/1", t_s, np.asarray(position))


def curved() -> Trajectory:
    t = uneven_times(60)
    return build_trajectory("made/1", t, np.stack([12 * t, 4 * np.sin(t)], axis=1))


@pytest.mark.parametrize("estimator", ESTIMATORS, ids=lambda one: one.name)
def test_a_straight_constant_drive_gives_its_velocity_from_the_second_sample_on(
    estimator: VelocityEstimator,
) -> None:
    velocity = sample_matrix(along(uneven_times(40), (3.0, -2.0), (14.0, -9.0)), estimator)[:, 2:4]
    assert np.abs(velocity[1:] - (14.0, -9.0)).max() < ROUNDING_MPS


@pytest.mark.parametrize("estimator", QUADRATICS, ids=lambda one: one.name)
def test_a_quadratic_gives_the_end_velocity_of_a_parabola_from_the_third_sample_on(
    estimator: VelocityEstimator,
) -> None:
    trip = along(uneven_times(40), (0.0, 0.0), (14.0, 2.0), (-1.5, 0.8))
    expected = np.array([14.0, 2.0]) + 2.0 * np.outer(trip.t_s, (-1.5, 0.8))
    assert np.abs(sample_matrix(trip, estimator)[:, 2:4][2:] - expected[2:]).max() < ROUNDING_MPS


@pytest.mark.parametrize("estimator", SLOPES, ids=lambda one: one.name)
def test_a_slope_lags_a_parabola_by_half_its_window(estimator: VelocityEstimator) -> None:
    trip = along(np.arange(40) * 0.1, (0.0, 0.0), (14.0, 2.0), (1.5, 0.0))
    lag_s = 0.05 * (estimator.window - 1)
    full = slice(estimator.window - 1, None)
    expected = 14.0 + 3.0 * (trip.t_s[full] - lag_s)
    assert np.abs(sample_matrix(trip, estimator)[:, 2:4][full, 0] - expected).max() < ROUNDING_MPS


@pytest.mark.parametrize("estimator", ESTIMATORS, ids=lambda one: one.name)
@given(now=st.integers(0, 58))
def test_the_future_changes_nothing(estimator: VelocityEstimator, now: int) -> None:
    trip = curved()
    position = trip.position_m.copy()
    position[now + 1 :] += 5.0  # more would be a jump, which reading judges by what follows
    other = build_trajectory("made/1", trip.t_s, position)
    assert np.array_equal(
        sample_matrix(trip, estimator)[:, 2:4][: now + 1], sample_matrix(other, estimator)[:, 2:4][: now + 1]
    )


@pytest.mark.parametrize("estimator", ESTIMATORS, ids=lambda one: one.name)
def test_a_gap_starts_afresh_with_zero(estimator: VelocityEstimator) -> None:
    trip = curved()
    late = trip.t_s + np.where(np.arange(len(trip)) >= 25, 30.0, 0.0)
    velocity = sample_matrix(build_trajectory("made/1", late, trip.position_m), estimator)[:, 2:4]
    alone = sample_matrix(build_trajectory("made/2", trip.t_s[25:], trip.position_m[25:]), estimator)[:, 2:4]
    assert np.array_equal(velocity[0], (0.0, 0.0))
    assert np.array_equal(velocity[25], (0.0, 0.0))
    assert np.abs(velocity[25:] - alone).max() < ROUNDING_MPS


def test_reported_velocity_is_speed_along_heading() -> None:
    t = np.arange(3) * 0.1
    trip = build_trajectory(
        "made/1", t, np.zeros((3, 2)), speed_mps=np.full(3, 10.0), heading_rad=np.array([0, 0.5, 1]) * np.pi
    )
    assert sample_matrix(trip, REPORTED)[:, 2:4] == pytest.approx(
        np.array([[0, 10], [10, 0], [0, -10]]), abs=1e-12
    )


def test_direction_only_takes_the_size_from_the_log() -> None:
    trip = curved()
    fast = build_trajectory("made/1", trip.t_s, trip.position_m, speed_mps=np.full(len(trip), 33.0))
    velocity = sample_matrix(fast, VelocityEstimator("course", 2, direction_only=True))[:, 2:4]
    assert np.hypot(*velocity[1:].T) == pytest.approx(33.0)


def test_a_log_without_heading_gets_the_default_estimator() -> None:
    trip = curved()
    assert velocity_estimator_for(trip) is DEFAULT_FROM_POSITIONS
    zeros = np.zeros(len(trip))
    reported = build_trajectory("made/1", trip.t_s, trip.position_m, speed_mps=zeros, heading_rad=zeros)
    assert velocity_estimator_for(reported) is REPORTED


def test_an_estimator_may_be_named_whatever_the_log_has() -> None:
    trip = curved()
    zeros = np.zeros(len(trip))
    reported = build_trajectory("made/1", trip.t_s, trip.position_m, speed_mps=zeros, heading_rad=zeros)
    assert velocity_estimator_for(reported, rule="quadratic-4") is DEFAULT_FROM_POSITIONS
    assert velocity_estimator_for(reported, rule="reported", speed_is_stuck=True) is REPORTED
    between = velocity_estimator_for(reported, rule="slope-2")
    assert sample_matrix(trip, between)[5, 2:4] == pytest.approx(
        (trip.position_m[5] - trip.position_m[4]) / (trip.t_s[5] - trip.t_s[4])
    )
    with pytest.raises(ConfigError, match=r"made/1.*slope-2"):
        velocity_estimator_for(trip, rule="reported")


def test_the_sample_matrix_holds_positions_velocities_rates_and_noise() -> None:
    trip = curved()
    samples = sample_matrix(trip, DEFAULT_FROM_POSITIONS)
    slope = np.polynomial.Polynomial.fit(trip.t_s[6:10] - trip.t_s[9], trip.position_m[6:10, 0], 2).convert()
    assert np.array_equal(samples[:, :2], trip.position_m)
    assert samples[9, 2] == pytest.approx(slope.coef[1])
    turn = np.unwrap(np.arctan2(samples[:, 2], samples[:, 3]))
    assert samples[30:, 5] == pytest.approx(np.gradient(turn, trip.t_s)[30:], abs=0.2)
    assert np.array_equal(samples[:, 6], position_noise_m(trip))


@pytest.mark.parametrize(("window", "degree"), [(1, 1), (2, 2), (3, 0), (5, 3), (-2, 1)])
def test_a_window_that_cannot_carry_the_degree_is_refused(window: int, degree: int) -> None:
    with pytest.raises(ValueError, match="must"):
        VelocityEstimator("bad", window, degree=degree)


@pytest.mark.parametrize(
    "estimator", [REPORTED, VelocityEstimator("course", 2, direction_only=True)], ids=lambda one: one.name
)
def test_a_missing_column_is_named(estimator: VelocityEstimator) -> None:
    with pytest.raises(ValueError, match="needs speed"):
        sample_matrix(curved(), estimator)[:, 2:4]
