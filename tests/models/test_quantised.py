"""Claims about sub-models whose parameters have gone through the codes of the wire."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.messages.quantisation import core_steps, quantised_bank
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel, Windows
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess, vehicle_process
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.payload import PayloadField, PayloadLayout
from modelcast.models.predicted_path import PredictedPath
from modelcast.models.profile import default_profile
from modelcast.models.quantised import CoreSteps, Quantised
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.world.drive import generate_drive

TRAINED = default_profile().sub_model("gp-trained")

DT_S = 0.1
ROUNDING = 1e-9
"""Of products of steps and codes."""


def windows(samples: FloatArray) -> Windows:
    """Windows of 25 equal rows each, which is enough for every sub-model."""
    return Windows(np.repeat(samples[:, None, :], 25, axis=1), dt_s=DT_S)


def states(count: int = 200) -> FloatArray:
    rng = np.random.default_rng(4)
    spread = np.array([5000.0, 5000.0, 20.0, 20.0, 3.0, 0.3, 0.0])
    return rng.normal(0.0, 1.0, (count, 7)) * spread


def test_every_kinematic_parameter_is_within_half_a_step_and_on_its_grid() -> None:
    steps, samples = core_steps(), states()
    model = Quantised(ConstantTurnRateAcceleration(), steps)
    held = model.fit(windows(samples))
    speed, exact = np.hypot(held[:, 0], held[:, 1]), np.hypot(samples[:, 2], samples[:, 3])
    turned = np.arctan2(held[:, 0], held[:, 1]) - np.arctan2(samples[:, 2], samples[:, 3])
    assert np.abs(speed - exact).max() <= steps.speed_mps / 2 + ROUNDING
    assert np.abs((turned + np.pi) % (2 * np.pi) - np.pi).max() <= steps.heading_rad / 2 + ROUNDING
    for column, value, step in ((2, 4, steps.acceleration_mps2), (3, 5, steps.yaw_rate_radps)):
        assert np.abs(held[:, column] - samples[:, value]).max() <= step / 2 + ROUNDING
        np.testing.assert_allclose(held[:, column] / step, np.rint(held[:, column] / step), atol=1e-6)
    np.testing.assert_allclose(speed / steps.speed_mps, np.rint(speed / steps.speed_mps), atol=1e-6)


def test_a_prediction_begins_at_the_position_that_was_sent() -> None:
    steps, samples = core_steps(), states()
    model = Quantised(ConstantVelocity(), steps)
    begins = samples[:, :2] + model.predict(model.fit(windows(samples)), np.zeros(1), dt_s=DT_S)[:, 0]
    np.testing.assert_allclose(begins / steps.position_m, np.rint(begins / steps.position_m), atol=1e-6)
    assert np.abs(begins - samples[:, :2]).max() <= steps.position_m / 2 + ROUNDING


def test_values_beyond_the_last_code_take_it() -> None:
    fast = np.array([[0.0, 0.0, 0.0, 500.0, -99.0, 9.0, 0.0]])
    held = Quantised(ConstantTurnRateAcceleration(), core_steps()).fit(windows(fast))[0]
    np.testing.assert_allclose(held[:4], [0.0, 163.8, -20.0, np.deg2rad(327.67)], atol=ROUNDING)


@pytest.mark.parametrize(
    "model",
    [
        ConstantTurnRateAcceleration(),
        vehicle_process(),
        default_profile().bank.members[0],
        PredictedPath(GaussianProcess()),
        PredictedPath(TRAINED),
    ],
    ids=lambda model: model.name,
)
def test_what_was_quantised_once_stays_as_it_is(model: AbstractSubModel) -> None:
    """A receiver that quantised again would hold the same."""
    case = generate_drive(3, 90.0)
    ready = TripRuntime(case.input, Bank((model,)), velocity_estimator_for(case.input), quantised=True)
    at = np.arange(100, 500, 7)
    ready.fit_at(at)
    count = len(model.parameter_names)
    held = ready.parameters[at, :count]
    layout = model.payload_layout
    assert layout is not None
    places = [model.parameter_names.index(name) for name in layout.names]
    np.testing.assert_allclose(layout.quantise(held[:, places]), held[:, places], atol=ROUNDING)


@pytest.mark.parametrize(
    "model",
    [
        *default_profile().bank.members,
        ConstantVelocity(),
        vehicle_process(),
        PredictedPath(GaussianProcess(form="intercept")),
    ],
)
def test_no_model_that_a_message_carries_predicts_by_the_sampling_interval(model: AbstractSubModel) -> None:
    """So no message says what it was."""
    assert model.payload_layout is not None
    parameters = model.fit(windows(states(20)))
    one, other = (model.predict(parameters, np.array([0.4, 3.0]), dt_s=dt_s) for dt_s in (DT_S, 0.05))
    np.testing.assert_array_equal(one, other)


def test_fine_steps_change_nothing() -> None:
    model = ConstantTurnRateAcceleration()
    fine = CoreSteps(
        1e-9,
        1e-9,
        heading_rad=1e-10,
        yaw_rate_radps=1e-10,
        last_speed=2**60,
        last_acceleration=2**60,
        last_yaw_rate=2**60,
        position_m=1e-9,
    )
    horizons_s = np.array([0.5, 2.0])
    given_ = windows(states(20))
    one, other = (m.predict(m.fit(given_), horizons_s, dt_s=DT_S) for m in (model, Quantised(model, fine)))
    np.testing.assert_allclose(one, other, atol=1e-6)


def test_what_has_no_layout_is_sent_as_its_predicted_path() -> None:
    model = GaussianProcess(form="intercept")
    assert model.payload_layout is None
    (sent,) = quantised_bank(Bank((model,))).members
    assert sent == Quantised(PredictedPath(model), core_steps())
    with pytest.raises(ValueError, match="no payload layout"):
        Quantised(model, core_steps())


def test_a_bank_completes_itself_with_a_quantised_member() -> None:
    bank = quantised_bank(Bank((vehicle_process(),))).complete()
    assert all(isinstance(member, Quantised) for member in bank.members)
    assert quantised_bank(bank) == bank


def test_quantising_costs_few_messages() -> None:
    """On a drive with 1 cm of noise, five millimetres of grid are no matter."""
    drive = generate_drive(5, 300.0)
    bank, estimator = default_profile().bank, velocity_estimator_for(drive.input)
    policy = ErrorDriven(0.2, "order", "never")
    plain, sent = (
        TripRuntime(drive.input, bank, estimator, quantised=one).run(policy) for one in (False, True)
    )
    assert abs(sent.updates - plain.updates) <= 0.05 * plain.updates + 2


def test_impossible_wrappings_are_refused() -> None:
    steps = core_steps()
    with pytest.raises(ValueError, match="quantised already"):
        Quantised(Quantised(ConstantVelocity(), steps), steps)
    for changes in ({"speed_mps": 0.0}, {"position_m": -1.0}, {"last_speed": 0}):
        with pytest.raises(ValueError, match=next(iter(changes))):
            replace(steps, **changes)


@given(
    st.floats(1e-3, 10.0),
    st.integers(1, 32),
    st.booleans(),
    st.floats(-1e6, 1e6),
)
def test_a_field_gives_a_value_within_half_a_step_or_its_last_code(
    step: float, bits: int, signed: bool, value: float
) -> None:
    field = PayloadField("x_m", step, bits=bits, signed=signed)
    layout = PayloadLayout((field,))
    code = int(layout.codes_of(np.array([[value]]))[0, 0])
    held = float(layout.values_of(np.array([[code]]))[0, 0])
    assert field.low <= code <= field.high
    nearest = min(max(value, field.low * step), field.high * step)
    assert abs(held - nearest) <= 0.5 * step * (1 + ROUNDING) + ROUNDING


def test_impossible_layouts_are_refused() -> None:
    field = PayloadField("x_m", 0.1, bits=8)
    with pytest.raises(ValueError, match="distinct"):
        PayloadLayout((field, field))
    with pytest.raises(ValueError, match="Part I"):
        PayloadLayout((replace(field, name="yaw_rate_radps"),))
    with pytest.raises(ValueError, match="bits"):
        replace(field, bits=0)
    with pytest.raises(ValueError, match="step"):
        replace(field, step=0.0)
    with pytest.raises(ValueError, match="number"):
        PayloadLayout((field,)).codes_of(np.array([[np.nan]]))
    with pytest.raises(ValueError, match="column"):
        PayloadLayout((field,)).codes_of(np.zeros((1, 2)))
