"""Claims about the causal acceleration along the course and yaw rate."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.models.point_kernels import REPORTS
from modelcast.station.sensing.rates import (
    NO_RATES_BELOW_MPS,
    RATES_FROM_VELOCITY,
    RateEstimator,
)
from modelcast.station.sensing.sensing import sample_matrix
from modelcast.station.sensing.velocity import (
    DEFAULT_FROM_POSITIONS,
    VelocityEstimator,
    velocity_estimator_for,
)
from modelcast.trips.trajectory import Trajectory, build_trajectory

ESTIMATORS = [
    RATES_FROM_VELOCITY,
    RateEstimator("velocity-line-0.2", 0.2, 1),
    RateEstimator("velocity-quadratic-0.4", 0.4, 2),
]

ROUNDING_MPS2 = 1e-7
"""Velocities of tens of m/s carry 1e-14 of rounding (1e-9 from positions); windows of 0.1 s amplify it."""

TURN_BIAS = 0.1
"""Times ω³ and span²: what the end slope of a quadratic makes of a sine's third order."""


def straight(acceleration: float, *, reported: bool, count: int = 40) -> Trajectory:
    """Drive 10 m/s to the north-east and change speed, without columns of acceleration or yaw rate."""
    t = 0.1 * np.arange(count)
    speed = 10.0 + acceleration * t
    distance = 10.0 * t + 0.5 * acceleration * t**2
    position = np.outer(distance, [np.sqrt(0.5), np.sqrt(0.5)])
    heading = np.full(count, np.pi / 4)
    if not reported:
        return build_trajectory("made/1", t, position)
    return build_trajectory("made/1", t, position, speed_mps=speed, heading_rad=heading)


def circle(yaw_rate: float, *, reported: bool) -> Trajectory:
    """12 m/s, the heading clockwise from north."""
    t = 0.1 * np.arange(60)
    heading = yaw_rate * t
    position = 12.0 / yaw_rate * np.stack([1.0 - np.cos(heading), np.sin(heading)], axis=1)
    if not reported:
        return build_trajectory("made/1", t, position)
    return build_trajectory("made/1", t, position, speed_mps=np.full(60, 12.0), heading_rad=heading)


def rates(trip: Trajectory) -> FloatArray:
    return sample_matrix(trip, velocity_estimator_for(trip))[:, 4:6]


def weaving(count: int = 60) -> Trajectory:
    t = np.cumsum(0.1 * np.random.default_rng(4).uniform(0.8, 1.2, count))
    return build_trajectory("made/1", t, np.stack([12 * t + t**2, 4 * np.sin(t)], axis=1))


@pytest.mark.parametrize("reported", [False, True])
@pytest.mark.parametrize("acceleration", [-2.0, 0.0, 3.0])
def test_constant_acceleration_is_found_at_once_if_reported_else_after_a_window(
    acceleration: float, *, reported: bool
) -> None:
    """From positions the second velocity is a line's slope, which lags by half a step."""
    found = rates(straight(acceleration, reported=reported))
    settled = found[2:] if reported else found[21:]
    assert np.abs(settled - (acceleration, 0.0)).max() < ROUNDING_MPS2


@pytest.mark.parametrize("reported", [False, True])
@pytest.mark.parametrize("yaw_rate", [-0.3, 0.3])
def test_a_steady_turn_has_its_yaw_rate_clockwise(yaw_rate: float, *, reported: bool) -> None:
    found = rates(circle(yaw_rate, reported=reported))[21:]
    bound = TURN_BIAS * abs(yaw_rate) ** 3 * RATES_FROM_VELOCITY.span_s**2
    assert np.abs(found[:, 1] - yaw_rate).max() < bound


def test_a_log_with_the_columns_reports_them() -> None:
    trip = replace(
        circle(0.3, reported=True), acceleration_mps2=np.full(60, 1.5), yaw_rate_radps=np.full(60, -0.2)
    )
    assert np.array_equal(rates(trip), np.tile([1.5, -0.2], (60, 1)))
    only_yaw = replace(trip, acceleration_mps2=None)
    assert np.array_equal(rates(only_yaw)[:, 1], np.full(60, -0.2))
    assert not np.array_equal(rates(only_yaw)[:, 0], np.full(60, 1.5))


@pytest.mark.parametrize("heading", [False, True])
@pytest.mark.parametrize("acceleration", [False, True])
@pytest.mark.parametrize("yaw_rate", [False, True])
def test_every_value_that_a_log_has_is_said_to_be_reported(
    *, heading: bool, acceleration: bool, yaw_rate: bool
) -> None:
    """1 for speed, 2 for heading, 4 for acceleration, 8 for yaw rate."""
    trip = circle(0.3, reported=True)
    trip = replace(
        trip,
        heading_rad=trip.heading_rad if heading else None,
        acceleration_mps2=np.full(60, 1.5) if acceleration else None,
        yaw_rate_radps=np.full(60, -0.2) if yaw_rate else None,
    )
    found = sample_matrix(trip, velocity_estimator_for(trip))[:, REPORTS]
    assert set(found) == {1 + 2 * heading + 4 * acceleration + 8 * yaw_rate}
    bare = replace(trip, speed_mps=None, heading_rad=None)
    found = sample_matrix(bare, velocity_estimator_for(bare))[:, REPORTS]
    assert set(found) == {4 * acceleration + 8 * yaw_rate}


def test_a_standing_car_neither_accelerates_nor_turns() -> None:
    """Reported or not: a gyroscope has an offset, and positions have noise."""
    noise = np.random.default_rng(3).normal(0.0, 0.003, (80, 2))
    trip = build_trajectory("made/1", 0.1 * np.arange(80), noise)
    velocity = sample_matrix(trip, DEFAULT_FROM_POSITIONS)[:, 2:4]
    slow = np.hypot(*velocity.T) < NO_RATES_BELOW_MPS
    assert slow.all()
    assert not rates(trip).any()
    assert not rates(replace(trip, acceleration_mps2=np.ones(80), yaw_rate_radps=np.ones(80))).any()


@given(now=st.integers(0, 58))
def test_the_future_changes_no_sample(now: int) -> None:
    trip = weaving()
    position = trip.position_m.copy()
    position[now + 1 :] += 5.0  # more would be a jump, which reading judges by what follows
    changed = build_trajectory("made/1", trip.t_s, position)
    assert np.array_equal(
        sample_matrix(trip, DEFAULT_FROM_POSITIONS)[: now + 1],
        sample_matrix(changed, DEFAULT_FROM_POSITIONS)[: now + 1],
    )


@given(now=st.integers(0, 58))
def test_the_future_of_reported_columns_changes_no_sample(now: int) -> None:
    trip = circle(0.3, reported=True)
    speed, heading = (np.array(column) for column in (trip.speed_mps, trip.heading_rad))
    speed[now + 1 :] += 5.0
    heading[now + 1 :] += 1.0
    changed = replace(trip, speed_mps=speed, heading_rad=heading)
    assert np.array_equal(rates(trip)[: now + 1], rates(changed)[: now + 1])


@pytest.mark.parametrize("reported", [False, True])
def test_a_gap_starts_afresh_without_rates(*, reported: bool) -> None:
    trip = circle(0.3, reported=reported)
    gap = np.where(np.arange(len(trip)) >= 25, 30.0, 0.0)
    late = replace(trip, t_s=trip.t_s + gap, segments=np.array([0, 25, 60]))
    alone = build_trajectory(
        "made/2",
        trip.t_s[25:],
        trip.position_m[25:],
        speed_mps=None if trip.speed_mps is None else trip.speed_mps[25:],
        heading_rad=None if trip.heading_rad is None else trip.heading_rad[25:],
    )
    found = rates(late)
    assert not found[:2].any()
    assert not found[25:27].any()
    assert np.abs(found[25:] - rates(alone)).max() < ROUNDING_MPS2


@pytest.mark.parametrize("estimator", ESTIMATORS, ids=lambda one: one.name)
def test_turning_the_frame_changes_no_rate(estimator: RateEstimator) -> None:
    trip = weaving()
    found = [
        sample_matrix(one, DEFAULT_FROM_POSITIONS, rates=estimator)[:, 4:6]
        for one in (trip, trip.moved(0.8, (0.0, 0.0)))
    ]
    assert np.abs(found[1] - found[0]).max() < ROUNDING_MPS2


def test_the_velocity_estimator_does_not_matter_on_a_straight_drive() -> None:
    trip = straight(0.0, reported=False)
    for estimator in (DEFAULT_FROM_POSITIONS, VelocityEstimator("slope-3", 3)):
        assert np.abs(sample_matrix(trip, estimator)[:, 4:6]).max() < ROUNDING_MPS2


@pytest.mark.parametrize(("dt_s", "window"), [(0.1, 20), (0.05, 39), (0.5, 5), (1.0, 4)])
def test_the_window_spans_a_time_but_always_carries_the_degree(dt_s: float, window: int) -> None:
    assert RATES_FROM_VELOCITY.window(dt_s) == window


@pytest.mark.parametrize(
    ("span_s", "degree"), [(0.0, 1), (-1.0, 2), (np.inf, 2), (np.nan, 1), (1.0, 0), (1.0, 3)]
)
def test_a_span_or_degree_out_of_range_is_refused(span_s: float, degree: int) -> None:
    with pytest.raises(ValueError, match="must be"):
        RateEstimator("bad", span_s, degree)
