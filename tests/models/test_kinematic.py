"""Claims about constant acceleration, constant turn rate, and both."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.models import kinematic_kernels
from modelcast.models.base import AbstractSubModel, Windows
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.kinematic import (
    ConstantAcceleration,
    ConstantTurnRateAcceleration,
    ConstantTurnRateVelocity,
)

CA = ConstantAcceleration()
CTRV = ConstantTurnRateVelocity()
CTRA = ConstantTurnRateAcceleration()
ALL = pytest.mark.parametrize("model", [CA, CTRV, CTRA], ids=lambda one: one.name)

ROUNDING_M = 1e-9
"""Displacements of hundreds of metres carry less rounding than this."""

QUADRATURE_M = 1e-8
"""Gauss-Legendre with 64 points is exact to rounding on turns of a few revolutions."""

SERIES_ERROR = 1e-14
"""Stated error of the shares about the switch: rounding over the angle."""

speeds = st.floats(0.1, 60.0)
courses = st.floats(-3.2, 3.2)
accelerations = st.floats(-9.0, 9.0)
yaw_rates = st.floats(-1.5, 1.5)
horizons = st.floats(0.0, 10.0)


def sample(speed: float, course_rad: float, acceleration: float = 0.0, yaw_rate: float = 0.0) -> Windows:
    """One sample; the course is clockwise from north."""
    velocity = speed * np.sin(course_rad), speed * np.cos(course_rad)
    return Windows(np.array([[[5.0, 7.0, *velocity, acceleration, yaw_rate, 0.0]]]), dt_s=0.1)


def moved(model: AbstractSubModel, window: Windows, *horizons_s: float) -> FloatArray:
    return model.predict(model.fit(window), np.array(horizons_s), dt_s=0.1)[0]


def integrated(
    speed: float, course_rad: float, acceleration: float, yaw_rate: float, until_s: float
) -> FloatArray:
    """Displacement by numerical integration of speed along the turning course, until the car stops."""
    if acceleration < 0.0:
        until_s = min(until_s, -speed / acceleration)
    nodes, weights = np.polynomial.legendre.leggauss(64)
    t = 0.5 * until_s * (nodes + 1.0)
    course = course_rad + yaw_rate * t
    velocity = (speed + acceleration * t) * np.array([np.sin(course), np.cos(course)])
    return 0.5 * until_s * (velocity @ weights)


@given(speed=speeds, course=courses, acceleration=accelerations, horizon_s=horizons)
def test_ca_is_exact_on_constant_acceleration_until_it_stops(
    speed: float, course: float, acceleration: float, horizon_s: float
) -> None:
    driven_s = min(horizon_s, -speed / acceleration) if acceleration < 0.0 else horizon_s
    distance = speed * driven_s + 0.5 * acceleration * driven_s**2
    expected = distance * np.array([np.sin(course), np.cos(course)])
    found = moved(CA, sample(speed, course, acceleration), horizon_s)[0]
    assert np.abs(found - expected).max() < ROUNDING_M


@pytest.mark.parametrize("model", [CA, CTRA], ids=lambda one: one.name)
def test_a_braking_car_stops_and_stays(model: AbstractSubModel) -> None:
    stop, later, much_later = moved(model, sample(12.0, 0.4, -4.0, 0.1), 3.0, 5.0, 3600.0)
    assert np.abs(later - stop).max() < ROUNDING_M
    assert np.array_equal(later, much_later)


@pytest.mark.parametrize("acceleration", [-3.0, 0.0, 3.0])
@ALL
def test_a_standing_car_stays(model: AbstractSubModel, acceleration: float) -> None:
    assert not moved(model, sample(0.0, 0.0, acceleration, 0.3), 0.5, 5.0).any()


@given(speed=speeds, course=courses, radius_m=st.floats(5.0, 2000.0), horizon_s=horizons)
def test_ctrv_is_exact_on_circles(speed: float, course: float, radius_m: float, horizon_s: float) -> None:
    """Clockwise: the centre lies to the right."""
    yaw_rate = speed / radius_m
    right = np.array([np.cos(course), -np.sin(course)])
    angle = course + yaw_rate * horizon_s
    expected = radius_m * (right - np.array([np.cos(angle), -np.sin(angle)]))
    found = moved(CTRV, sample(speed, course, 0.0, yaw_rate), horizon_s)[0]
    assert np.abs(found - expected).max() < ROUNDING_M


@given(speed=speeds, course=courses, acceleration=accelerations, yaw_rate=yaw_rates, horizon_s=horizons)
def test_ctra_equals_numerical_integration(
    speed: float, course: float, acceleration: float, yaw_rate: float, horizon_s: float
) -> None:
    expected = integrated(speed, course, acceleration, yaw_rate, horizon_s)
    found = moved(CTRA, sample(speed, course, acceleration, yaw_rate), horizon_s)[0]
    assert np.abs(found - expected).max() < QUADRATURE_M


@given(speed=st.floats(0.0, 60.0), course=courses)
@ALL
def test_without_acceleration_and_turn_it_is_constant_velocity(
    model: AbstractSubModel, speed: float, course: float
) -> None:
    window = sample(speed, course)
    assert np.array_equal(moved(model, window, 0.3, 4.0), moved(ConstantVelocity(), window, 0.3, 4.0))


@given(speed=speeds, acceleration=accelerations, yaw_rate=yaw_rates)
def test_ctra_passes_into_ca_and_ctrv(speed: float, acceleration: float, yaw_rate: float) -> None:
    straight = sample(speed, 0.7, acceleration, 0.0)
    steady = sample(speed, 0.7, 0.0, yaw_rate)
    assert np.array_equal(moved(CTRA, straight, 0.5, 6.0), moved(CA, straight, 0.5, 6.0))
    assert np.array_equal(moved(CTRA, steady, 0.5, 6.0), moved(CTRV, steady, 0.5, 6.0))


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_series_and_closed_form_meet_at_the_switch(sign: float) -> None:
    switch = sign * kinematic_kernels.SERIES_BELOW_RAD
    inside, outside = kinematic_kernels.turned(np.nextafter(switch, 0.0)), kinematic_kernels.turned(switch)
    assert np.abs(np.subtract(inside, outside)).max() < SERIES_ERROR


@pytest.mark.parametrize("angle", [1e-300, 1e-12, 1e-6, 1e-3, 0.03, 0.0999, 0.1, 0.1001, 0.4, 2.0, 40.0])
def test_the_shares_are_integrals(angle: float) -> None:
    """A and B average cos and sin of the angle turned so far; C and D the same, weighted by time."""
    nodes, weights = np.polynomial.legendre.leggauss(64)
    turn, weight = 0.5 * angle * (nodes + 1.0), 0.5 * weights
    late = weight * 0.5 * (nodes + 1.0)
    expected = (weight @ np.cos(turn), weight @ np.sin(turn), late @ np.cos(turn), late @ np.sin(turn))
    assert np.abs(np.subtract(kinematic_kernels.turned(angle), expected)).max() < SERIES_ERROR


def test_a_slowly_growing_yaw_rate_moves_the_prediction_smoothly() -> None:
    """Straight on, through the switch, into a turn: steps of equal size, none where the formula changes."""
    places = [moved(CTRA, sample(20.0, 0.0, 1.5, 1e-3 * k), 2.0)[0] for k in range(100)]
    steps = [np.hypot(*(b - a)) for a, b in pairwise(places)]
    assert max(steps) < 1.01 * min(steps)


@given(speed=speeds, course=courses, acceleration=accelerations, yaw_rate=yaw_rates, turn=courses)
@ALL
def test_turning_the_frame_turns_prediction_and_covariance(
    model: AbstractSubModel, *, speed: float, course: float, acceleration: float, yaw_rate: float, turn: float
) -> None:
    clockwise = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    here = sample(speed, course, acceleration, yaw_rate)
    there = sample(speed, course + turn, acceleration, yaw_rate)
    assert moved(model, there, 0.5, 5.0) == pytest.approx(
        moved(model, here, 0.5, 5.0) @ clockwise.T, abs=ROUNDING_M
    )
    spread = [model.covariance(model.fit(w), np.array([0.5, 5.0]), dt_s=0.1)[0] for w in (here, there)]
    assert spread[1] == pytest.approx(clockwise @ spread[0] @ clockwise.T, rel=1e-9, abs=1e-6)


@given(speed=speeds, acceleration=accelerations, yaw_rate=yaw_rates)
@ALL
def test_left_is_the_mirror_of_right(
    model: AbstractSubModel, speed: float, acceleration: float, yaw_rate: float
) -> None:
    right = moved(model, sample(speed, 0.0, acceleration, yaw_rate), 0.7, 4.0)
    left = moved(model, sample(speed, 0.0, acceleration, -yaw_rate), 0.7, 4.0)
    assert np.array_equal(left * (-1.0, 1.0), right)


def test_the_covariances_are_those_of_the_stated_spreads() -> None:
    """Northbound, straight on, after 3 s: along the course is north."""
    north = sample(10.0, 0.0)
    expected = {
        CA: (4.5, 4.5),
        CTRV: (10.0 * 0.1 * 27.0 / 6.0, 4.5),
        CTRA: (10.0 * 0.1 * 27.0 / 6.0, 4.5),
    }
    for model, spreads in expected.items():
        covariance = model.covariance(model.fit(north), np.array([0.0, 3.0]), dt_s=0.1)[0]
        assert not covariance[0].any()
        assert covariance[1] == pytest.approx(np.diag(np.square(spreads)), abs=ROUNDING_M)


@ALL
def test_a_message_carries_nothing_beyond_the_core(model: AbstractSubModel) -> None:
    assert model.payload_parameters == 0
