"""Claims about payload layouts: what messages carry of a sub-model beside Part I."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.models.base import AbstractSubModel, Windows
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess, vehicle_process
from modelcast.models.payload import PayloadField, PayloadLayout
from modelcast.models.predicted_path import PredictedPath
from modelcast.models.profile import default_profile

DT_S = 0.1
ROUNDING = 1e-9
"""Of products of steps and codes."""


def windows(count: int) -> Windows:
    """Windows of 25 equal rows each, which is enough for every sub-model."""
    rng = np.random.default_rng(4)
    samples = rng.normal(0.0, 1.0, (count, 7)) * np.array([5000.0, 5000.0, 20.0, 20.0, 3.0, 0.3, 0.0])
    return Windows(np.repeat(samples[:, None, :], 25, axis=1), dt_s=DT_S)


@pytest.mark.parametrize(
    "model",
    [
        *default_profile().bank.members,
        ConstantVelocity(),
        vehicle_process(),
        PredictedPath(GaussianProcess(form="intercept")),
    ],
    ids=lambda model: model.name,
)
def test_no_model_that_a_message_carries_predicts_by_the_sampling_interval(model: AbstractSubModel) -> None:
    """So no message says what it was."""
    assert model.payload_layout is not None
    parameters = model.fit(windows(20))
    one, other = (model.predict(parameters, np.array([0.4, 3.0]), dt_s=dt_s) for dt_s in (DT_S, 0.05))
    np.testing.assert_array_equal(one, other)


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
