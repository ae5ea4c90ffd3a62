"""Claims about prediction beyond the trusted horizon."""

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel, Windows
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.models.kinematic import (
    ConstantAcceleration,
    ConstantTurnRateAcceleration,
    ConstantTurnRateVelocity,
)
from modelcast.models.point_kernels import SAMPLE_COLUMNS
from modelcast.models.trusted import Trusted
from modelcast.runtime.trip.replay import replay, schedules_of
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.trips.trajectory import Trajectory

DT_S = 0.1
AGES_S = np.linspace(0.0, 12.0, 241)

STEP_M = 1e-7
"""Velocity and turn come from three positions 0.05 s apart: rounding grows by (12 s / 0.05 s)²."""


def windows(count: int = 20) -> Windows:
    """Cars on turns, with a little noise."""
    rng = np.random.default_rng(5)
    t = np.arange(-9, 1) * DT_S
    speed, turn = rng.uniform(5.0, 30.0, (count, 1)), rng.uniform(-0.3, 0.3, (count, 1))
    course = rng.uniform(0.0, 2 * np.pi, (count, 1)) + turn * t
    velocity = np.stack([speed * np.sin(course), speed * np.cos(course)], axis=2)
    position = np.stack([-speed / turn * np.cos(course), speed / turn * np.sin(course)], axis=2)
    position += rng.normal(0.0, 0.01, position.shape)
    rates = np.stack(np.broadcast_arrays(rng.normal(0.0, 2.0, (count, 1)), turn + 0 * t), axis=2)
    samples = np.zeros((count, 10, SAMPLE_COLUMNS))
    samples[:, :, :6] = np.concatenate([position, velocity, rates], axis=2)
    return Windows(samples, dt_s=DT_S)


def predicted(model: AbstractSubModel, ages_s: FloatArray = AGES_S) -> FloatArray:
    given = windows()
    return model.predict(model.fit(given), ages_s, dt_s=DT_S)


@pytest.mark.parametrize("model", [ConstantTurnRateAcceleration(), GaussianProcess(form="intercept")])
def test_up_to_the_horizon_nothing_changes_in_any_bit(model: AbstractSubModel) -> None:
    near = AGES_S <= 2.0
    assert np.array_equal(predicted(Trusted(model, 2.0))[:, near], predicted(model)[:, near])
    assert np.array_equal(predicted(Trusted(model, np.inf)), predicted(model))


@pytest.mark.parametrize("turn_s", [0.0, 2.0, np.inf])
def test_constant_velocity_goes_on_as_it_would(turn_s: float) -> None:
    whole = predicted(ConstantVelocity())
    assert np.abs(predicted(Trusted(ConstantVelocity(), 1.0, turn_s)) - whole).max() < STEP_M


def test_a_circle_stays_a_circle_while_the_turn_goes_on() -> None:
    whole = predicted(ConstantTurnRateVelocity())
    assert np.abs(predicted(Trusted(ConstantTurnRateVelocity(), 1.0, np.inf)) - whole).max() < STEP_M


@pytest.mark.parametrize("turn_s", [0.0, 1.5])
def test_after_the_turn_it_goes_straight_along_the_tangent(turn_s: float) -> None:
    model = ConstantTurnRateVelocity()
    given = windows()
    parameters = model.fit(given)
    leaves_s = 1.0 + turn_s
    there = model.predict(parameters, np.array([leaves_s]), dt_s=DT_S)
    angle = parameters[:, 2] * leaves_s
    east, north = parameters[:, 0], parameters[:, 1]
    course = np.stack(
        [east * np.cos(angle) + north * np.sin(angle), north * np.cos(angle) - east * np.sin(angle)], axis=1
    )
    ages = np.array([leaves_s + 0.5, leaves_s + 9.0])
    moved = Trusted(model, 1.0, turn_s).predict(parameters, ages, dt_s=DT_S)
    straight = there + course[:, None] * (ages - leaves_s)[None, :, None]
    assert np.abs(moved - straight).max() < STEP_M


def test_a_car_that_accelerates_keeps_the_speed_of_the_horizon() -> None:
    model = ConstantAcceleration()
    parameters = np.array([[6.0, 8.0, 1.5], [20.0, 0.0, -3.0], [0.0, 10.0, -20.0]])
    moved = Trusted(model, 2.0).predict(parameters, np.array([2.0, 3.0, 7.0]), dt_s=DT_S)
    along = np.hypot(moved[..., 0], moved[..., 1])
    assert along[0] == pytest.approx([23.0, 23.0 + 13.0, 23.0 + 5 * 13.0])
    assert along[1] == pytest.approx([34.0, 34.0 + 14.0, 34.0 + 5 * 14.0])
    assert along[2] == pytest.approx([2.5, 2.5, 2.5])


@pytest.mark.parametrize(
    "model", [ConstantTurnRateAcceleration(), GaussianProcess(form="intercept"), GaussianProcess()]
)
def test_position_and_velocity_join_at_the_horizon(model: AbstractSubModel) -> None:
    step_s = 1e-4
    ages = 1.5 + step_s * np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
    moved = predicted(Trusted(model, 1.5), ages)
    velocity = np.diff(moved, axis=1) / step_s
    jump = np.abs(velocity[:, 2] - velocity[:, 1]).max()
    assert jump < 0.05, "what jerk and yaw acceleration change in the last 0.1 s"


def test_far_ahead_the_speed_is_constant_and_the_way_straight() -> None:
    moved = predicted(Trusted(GaussianProcess(form="intercept"), 1.0, 2.0), np.array([3.5, 20.0, 36.5]))
    first, second = moved[:, 1] - moved[:, 0], moved[:, 2] - moved[:, 1]
    assert np.abs(first - second).max() < STEP_M


def test_a_model_that_stands_or_spins_at_its_horizon_goes_straight_on() -> None:
    spins = np.array([[0.0, 5.0, 2.0]])
    model = ConstantTurnRateVelocity()
    moved = Trusted(model, 0.5, np.inf).predict(spins, np.array([0.5, 1.5, 2.5]), dt_s=DT_S)[0]
    assert np.abs((moved[2] - moved[1]) - (moved[1] - moved[0])).max() < STEP_M
    stands = Trusted(model, 0.5).predict(np.zeros((1, 3)), np.array([9.0]), dt_s=DT_S)
    assert not stands.any()


def test_sender_batch_and_replay_agree_in_every_bit(drive: Trajectory) -> None:
    """Without losses the host's error before a message is the sender's, of the sub-model in use."""
    member = Trusted(GaussianProcess(form="intercept"), 0.4, 0.3)
    bank = TripRuntime(drive, Bank((member,)), velocity_estimator_for(drive))
    walk = bank.run(ErrorDriven(0.5))
    count = len(drive)
    before = np.concatenate([[0], walk.update_index[:-1]])
    age_s = drive.t_s - drive.t_s[before]
    damped = np.flatnonzero((age_s > 0.4) & (walk.in_use == 0) & (np.roll(walk.in_use, 1) == 0))
    assert damped.size > 50
    own = bank.parameters[before[damped], : len(member.parameter_names)]
    moved = member.predict_at(own, age_s[damped], dt_s=drive.dt_s)
    off = drive.position_m[before[damped]] + moved - drive.position_m[damped]
    assert np.array_equal(np.sqrt((off * off).sum(axis=1)), bank.tracking_error_m(walk)[damped, 0])

    nothing, east = np.zeros((1, count), dtype=np.bool_), np.tile([1.0, 0.0], (count, 1))
    errors = replay(bank, schedules_of([walk]), nothing, drive.position_m, east).errors
    assert np.array_equal(errors[1, 0, damped], bank.tracking_error_m(walk)[damped, 0])


def test_name_and_payload_stay_the_models() -> None:
    inner = GaussianProcess(form="intercept")
    model = Trusted(inner, 1.0)
    assert (model.name, model.window, model.parameter_names, model.payload_parameters) == (
        inner.name,
        inner.window,
        inner.parameter_names,
        inner.payload_parameters,
    )
    assert Bank((model, ConstantVelocity())).trust.tolist() == [[1.0, 2.0], [np.inf, np.inf]]


@pytest.mark.parametrize("horizon_s", [0.15, 0.0, -1.0, np.nan])
def test_a_horizon_too_short_is_refused(horizon_s: float) -> None:
    with pytest.raises(ValueError, match=r"horizon_s must be a number from 0\.2"):
        Trusted(ConstantVelocity(), horizon_s)


def test_a_negative_turn_and_a_second_wrapping_are_refused() -> None:
    with pytest.raises(ValueError, match="turn_s"):
        Trusted(ConstantVelocity(), 1.0, -1.0)
    with pytest.raises(ValueError, match="already"):
        Trusted(Trusted(ConstantVelocity(), 1.0), 2.0)
