"""Claims about sub-models that are sent as their predicted path."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.messages.code_table import code_table
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel, Windows
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess, vehicle_process
from modelcast.models.kinematic import ConstantAcceleration
from modelcast.models.plain import from_plain, to_plain
from modelcast.models.predicted_path import DEFAULT_CARRIED, PredictedPath, carried_form, carried_layout
from modelcast.models.profile import default_profile
from modelcast.models.trusted import Trusted

TRAINED = default_profile().sub_model("gp-trained")

DT_S = 0.1
ROUNDING_M = 1e-9
PROCESSES = [GaussianProcess(), GaussianProcess(form="intercept"), TRAINED]

HEADING_M = 0.02
"""Half a step of heading and speed, at 30 m/s over three seconds."""

CLEAN_M = 0.15
"""What four powers leave of a process's path over three seconds, on windows that turn and brake."""


def windows(count: int = 40) -> Windows:
    """Cars that brake and turn, without noise."""
    rng = np.random.default_rng(8)
    t = np.arange(-24, 1)[None, :] * DT_S
    speed, turn = rng.uniform(5.0, 30.0, (count, 1)), rng.uniform(-0.2, 0.2, (count, 1))
    course, braking = rng.uniform(-3.0, 3.0, (count, 1)) + turn * t, rng.uniform(-2.0, 1.0, (count, 1))
    velocity = (speed + braking * t)[..., None] * np.stack([np.sin(course), np.cos(course)], axis=-1)
    steps = 0.5 * DT_S * (velocity[:, 1:] + velocity[:, :-1])
    position = np.concatenate([np.zeros((count, 1, 2)), np.cumsum(steps, axis=1)], axis=1)
    same = np.ones_like(course)
    rates = np.stack([braking * same, turn * same, 0.001 * same], axis=-1)
    return Windows(np.concatenate([position, velocity, rates], axis=2), dt_s=DT_S)


def path(model: AbstractSubModel, horizons_s: FloatArray) -> FloatArray:
    return model.predict(model.fit(windows()), horizons_s, dt_s=DT_S)


def test_a_path_that_is_a_polynomial_comes_through_exactly() -> None:
    """With constant acceleration the path is one of second power until the car stops."""
    within = np.linspace(0.0, 2.0, 9)
    model = ConstantAcceleration()
    sent = PredictedPath(model, span_s=2.0)
    np.testing.assert_allclose(path(sent, within), path(model, within), atol=ROUNDING_M)


def test_beyond_its_span_a_path_is_straight_at_its_last_velocity() -> None:
    sent = PredictedPath(GaussianProcess(), span_s=2.0)
    before, end, one, two = (path(sent, np.array([h]))[:, 0] for h in (2.0 - 1e-4, 2.0, 3.0, 5.0))
    np.testing.assert_allclose(one - end, (end - before) / 1e-4, atol=2e-3)
    np.testing.assert_allclose(two - end, 3.0 * (one - end), atol=ROUNDING_M)


@pytest.mark.parametrize("model", PROCESSES, ids=lambda model: model.name)
def test_four_powers_follow_a_process(model: AbstractSubModel) -> None:
    at_s = np.linspace(0.0, 3.0, 13)
    assert np.abs(path(PredictedPath(model), at_s) - path(model, at_s)).max() < CLEAN_M


@pytest.mark.parametrize("model", PROCESSES, ids=lambda model: model.name)
def test_rounding_moves_a_path_by_half_a_step_of_each_power_at_most(model: AbstractSubModel) -> None:
    at_s = np.linspace(0.0, 3.0, 13)
    sent = PredictedPath(model)
    _, held = code_table(Bank((sent,))).quantise(sent.fit(windows()))
    off = np.abs(sent.predict(held, at_s, dt_s=DT_S) - path(sent, at_s)).max(axis=(0, 2))
    powers = np.vander(at_s / sent.span_s, len(DEFAULT_CARRIED), increasing=True)
    bound_m = powers @ np.array([step / 2.0 for step, _ in DEFAULT_CARRIED]) + HEADING_M * at_s
    assert (off <= bound_m + ROUNDING_M).all()


def test_a_receiver_predicts_without_the_window_and_the_hyper_parameters() -> None:
    """Two processes that differ in everything predict alike from the same parameters."""
    one, other = (PredictedPath(model) for model in (GaussianProcess(20), TRAINED))
    parameters = one.fit(windows())
    at_s = np.array([0.4, 2.0, 9.0])
    np.testing.assert_array_equal(
        one.predict(parameters, at_s, dt_s=DT_S), other.predict(parameters, at_s, dt_s=0.05)
    )


def test_the_form_that_is_carried_keeps_the_trusted_horizon_outside() -> None:
    gp = GaussianProcess()
    assert carried_form(Trusted(gp, 2.0)) == Trusted(PredictedPath(gp), 2.0)
    assert carried_form(vehicle_process()) == vehicle_process()
    assert carried_form(carried_form(gp)) == PredictedPath(gp)
    for model in (gp, Trusted(gp, 2.0), vehicle_process(), ConstantVelocity()):
        assert carried_layout(model) == carried_form(model).payload_layout


def test_a_profile_may_name_a_path() -> None:
    given = PredictedPath(TRAINED, span_s=2.0, carried=DEFAULT_CARRIED[:3])
    assert from_plain(to_plain(given)) == given


def test_impossible_paths_are_refused() -> None:
    good = PredictedPath(GaussianProcess())
    with pytest.raises(ValueError, match="trusted horizon"):
        PredictedPath(Trusted(GaussianProcess(), 2.0))
    with pytest.raises(ValueError, match="2 to 7 items"):
        replace(good, carried=DEFAULT_CARRIED[:1])
    with pytest.raises(ValueError, match="span_s"):
        replace(good, span_s=0.0)
    with pytest.raises(ValueError, match=r"carried\[1\]\[1\] must be a whole number from 1 to 32"):
        replace(good, carried=((0.1, 6), (0.1, 40)))
