"""Claims about the stop-and-go switch: what its filters find, what it states, what receivers make of it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.models.base import Windows
from modelcast.models.plain_meaning import is_free
from modelcast.models.point_kernels import REPORTS_HEADING, REPORTS_SPEED
from modelcast.models.stop_and_go import StopAndGo

DT_S = 0.1
MODEL = StopAndGo()


def walk(position_m: FloatArray, *, reported_mps: FloatArray | None = None) -> Windows:
    """One window of positions (n, 2), and of velocities (n, 2) where the device reports them."""
    samples = np.zeros((1, len(position_m), 9))
    samples[0, :, :2] = position_m
    if reported_mps is not None:
        samples[0, :, 2:4] = reported_mps
        samples[0, :, 8] = REPORTS_SPEED + REPORTS_HEADING
    return Windows(samples, dt_s=DT_S)


def steady_filter(position_m: FloatArray, density: float, noise_m: float) -> FloatArray:
    """Velocity (2,) by the textbook filter in matrices, from a first velocity of 0 ± 1 m/s."""
    turn = np.array([[1.0, DT_S], [0.0, 1.0]])
    process = density**2 * np.array([[DT_S**3 / 3.0, DT_S**2 / 2.0], [DT_S**2 / 2.0, DT_S]])
    state = np.stack([position_m[0], np.zeros(2)])
    covariance = np.diag([noise_m**2, 1.0])
    for seen in position_m[1:]:
        state, covariance = turn @ state, turn @ covariance @ turn.T + process
        gain = covariance[:, :1] / (covariance[0, 0] + noise_m**2)
        state = state + gain * (seen - state[0])
        covariance = covariance - gain @ covariance[:1]
    return state[1]


def test_the_stated_velocity_is_that_of_the_textbook_filter() -> None:
    rng = np.random.default_rng(5)
    position = np.cumsum(rng.normal(0.1, 0.05, (40, 2)), axis=0)
    found = MODEL.fit(walk(position))[0]
    assert found[:2] == pytest.approx(steady_filter(position, MODEL.steady, MODEL.noise_floor_m), abs=1e-12)
    quick = steady_filter(position, MODEL.quick, MODEL.noise_floor_m)
    ahead = (quick - found[:2]) @ found[:2] / np.hypot(*found[:2])
    assert found[2] == pytest.approx(MODEL.gain_per_s * ahead, abs=1e-12)


def test_a_reported_velocity_is_followed_at_once() -> None:
    """Positions alone leave a first sample's velocity unknown; a device that reports it does not."""
    start = np.zeros((1, 2))
    told = MODEL.fit(walk(start, reported_mps=np.array([[1.2, 0.5]])))[0]
    assert told[:2] == pytest.approx([1.2, 0.5])
    positions = np.cumsum(np.tile([0.12, 0.05], (20, 1)), axis=0)
    wrong = np.tile([3.0, 0.5], (20, 1))
    between = MODEL.fit(walk(positions, reported_mps=wrong))[0, 0]
    assert 1.2 < between < 3.0
    trusting = replace(MODEL, velocity_noise_mps=0.01)
    assert trusting.fit(walk(positions, reported_mps=wrong))[0, 0] > between


def test_a_person_who_slows_down_is_told_to_and_one_who_holds_the_pace_is_not() -> None:
    speed = np.where(np.arange(74) < 70, 1.4, 0.7)
    stopping = np.stack([np.zeros(74), DT_S * np.cumsum(speed)], axis=1)
    assert MODEL.fit(walk(stopping))[0, 2] < -MODEL.least_change_mps2
    assert MODEL.fit(walk(stopping[:70]))[0, 2] == 0.0
    assert replace(MODEL, gain_per_s=0.0).fit(walk(stopping))[0, 2] == 0.0


def way(east: float, change: float, horizon_s: float) -> float:
    """Way along the course of a person at a speed, in a model with a phase of 1 s and a pace of 1.5 m/s."""
    parameters = np.array([[east, 0.0, change]])
    return MODEL.predict(parameters, np.array([horizon_s]), dt_s=DT_S)[0, 0, 0]


def test_a_change_of_pace_ends_at_a_stand_at_the_pace_or_after_its_phase() -> None:
    assert way(1.0, -2.0, 5.0) == pytest.approx(0.25)  # stands after 0.5 s, v²/2a
    assert way(1.0, 1.0, 2.0) == pytest.approx(0.5 + 0.125 + 1.5 * 1.5)  # 1.5 m/s after 0.5 s
    assert way(3.0, -1.0, 3.0) == pytest.approx(2.5 + 2.0 * 2.0)  # slows for 1 s, then holds 2 m/s
    assert way(3.0, 1.0, 3.0) == pytest.approx(9.0)  # faster than the pace: not taken to speed up
    assert way(0.05, 1.0, 4.0) == pytest.approx(0.2)  # too slow for a course


@given(
    st.floats(-8.0, 8.0),
    st.floats(-8.0, 8.0),
    st.floats(-5.0, 5.0),
    st.floats(0.0, 10.0),
    st.floats(0.0, 2.0),
)
def test_nobody_walks_backwards_or_jumps(
    east: float, north: float, change: float, horizon_s: float, later_s: float
) -> None:
    parameters = np.array([[east, north, change]])
    first, second = MODEL.predict(parameters, np.array([horizon_s, horizon_s + later_s]), dt_s=DT_S)[0]
    course = np.array([east, north])
    speed = np.hypot(east, north)
    moved = second - first
    assert moved @ course >= -1e-9
    assert np.hypot(*moved) <= max(speed, MODEL.pace_mps) * later_s + 1e-9


def test_a_plain_message_says_it_all() -> None:
    assert is_free(MODEL)
    assert MODEL.payload_layout is not None
    assert MODEL.payload_layout.bits == 0


@pytest.mark.parametrize(
    ("wrong", "named"),
    [({"steady": 0.6}, "quick"), ({"phase_s": -1.0}, "phase_s"), ({"noise_floor_m": 0.0}, "noise_floor_m")],
)
def test_numbers_out_of_range_are_refused(wrong: dict[str, Any], named: str) -> None:
    with pytest.raises(ValueError, match=named):
        StopAndGo(**wrong)
