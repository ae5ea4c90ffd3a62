"""Claims about the rival that sends a Kalman filter's uncertainty ellipse."""

from typing import Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.models.base import Windows
from modelcast.models.stop_and_go import StopAndGo
from modelcast.study.ellipse import EllipseFilter, Ellipses, ellipse_messages
from modelcast.trips.trajectory import Trajectory, build_trajectory

DT_S = 0.1
MODEL = EllipseFilter()


def wander(seed: int, count: int = 120) -> Trajectory:
    """Somebody who walks about, seen with noise."""
    rng = np.random.default_rng(seed)
    velocity = np.array([1.2, 0.4]) + np.cumsum(rng.normal(0.0, 0.1, (count, 2)), axis=0)
    position = DT_S * np.cumsum(velocity, axis=0) + rng.normal(0.0, 0.02, (count, 2))
    return build_trajectory(f"made/{seed}", DT_S * np.arange(count), position)


def textbook(trip: Trajectory, model: EllipseFilter) -> Ellipses:
    """The same filter in matrices of place and velocity east and north."""
    eye, count = np.eye(2), len(trip)
    state = np.concatenate([trip.position_m[0], np.zeros(2)])
    covariance = np.diag([model.noise_m**2] * 2 + [model.prior_mps**2] * 2)
    found: list[tuple[FloatArray, FloatArray]] = [(state, covariance)]
    for k in range(1, count):
        dt_s = trip.t_s[k] - trip.t_s[k - 1]
        speed = np.hypot(*state[2:])
        ahead = np.outer(state[2:], state[2:]) / speed**2 if speed >= 0.1 else np.zeros((2, 2))
        across2 = model.across**2 if speed >= 0.1 else max(model.along, model.across) ** 2
        density = across2 * eye + (model.along**2 - model.across**2) * ahead
        turn = np.block([[eye, dt_s * eye], [0.0 * eye, eye]])
        white = np.kron(np.array([[dt_s**3 / 3.0, dt_s**2 / 2.0], [dt_s**2 / 2.0, dt_s]]), density)
        covariance = turn @ covariance @ turn.T + white
        state = turn @ state
        gain = covariance[:, :2] @ np.linalg.inv(covariance[:2, :2] + model.noise_m**2 * eye)
        state = state + gain @ (trip.position_m[k] - state[:2])
        covariance = covariance - gain @ covariance[:2]
        found.append((state, covariance))
    states = np.array([one for one, _ in found])
    spreads = np.array([one for _, one in found])
    return Ellipses(states[:, :2], states[:, 2:], spreads[:, :2, :2], spreads[:, 2:, 2:])


def test_the_filter_is_the_textbooks() -> None:
    trip = wander(1)
    found, wanted = MODEL.follow(trip), textbook(trip, MODEL)
    assert found.position_m == pytest.approx(wanted.position_m, abs=1e-9)
    assert found.velocity_mps == pytest.approx(wanted.velocity_mps, abs=1e-9)
    assert found.place_m2 == pytest.approx(wanted.place_m2, abs=1e-12)
    assert found.velocity_m2ps2 == pytest.approx(wanted.velocity_m2ps2, abs=1e-12)


def test_with_one_density_it_is_the_steady_filter_of_stop_and_go() -> None:
    trip = wander(2)
    samples = np.zeros((1, len(trip), 9))
    samples[0, :, :2] = trip.position_m
    switch = StopAndGo(steady=0.3, quick=0.6)
    told = switch.fit(Windows(samples, dt_s=DT_S))[0, :2]
    assert EllipseFilter(0.3, 0.3).follow(trip).velocity_mps[-1] == pytest.approx(told, abs=1e-9)


@given(st.integers(0, 50), st.floats(0.1, 1.0), st.sampled_from(("error", "ellipse")))
def test_between_messages_the_rule_holds(
    seed: int, threshold_m: float, rule: Literal["error", "ellipse"]
) -> None:
    trip = wander(seed)
    sent = ellipse_messages(trip, threshold_m, model=MODEL, rule=rule)
    assert sent.starts[0] == 0
    quiet = np.setdiff1d(np.arange(len(trip)), sent.starts)
    if rule == "error":
        assert (sent.error_m[quiet] < threshold_m).all()
        assert (sent.error_m[sent.starts[1:]] >= threshold_m).all()
    else:
        assert sent.within >= quiet.size / len(trip)
        assert (sent.error_m[quiet] < threshold_m).all()  # inside an ellipse no larger than the threshold


def test_every_part_begins_with_a_message() -> None:
    trip = wander(3)
    t_s = trip.t_s + np.where(np.arange(len(trip)) >= 60, 30.0, 0.0)
    parted = build_trajectory("made/parted", t_s, trip.position_m)
    assert parted.segments.tolist() == [0, 60, 120]
    for rule in ("error", "ellipse"):
        assert {0, 60} <= set(ellipse_messages(parted, 0.5, model=MODEL, rule=rule).starts.tolist())


def test_a_threshold_must_be_positive() -> None:
    with pytest.raises(ValueError, match="threshold_m"):
        ellipse_messages(wander(4), 0.0, model=MODEL, rule="error")
