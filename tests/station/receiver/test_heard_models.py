"""Claims about hosts that run a sub-model in Python on parameters which anybody may have sent."""

import copy
import warnings
from dataclasses import dataclass

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import ConfigError, ModelcastWarning, SubModelError
from modelcast.messages.mbc import ModelUpdate
from modelcast.models import heard_functions
from modelcast.models.bank import Bank
from modelcast.models.base import Windows
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.numpy_model import AbstractNumpySubModel
from modelcast.models.payload import PayloadField, PayloadLayout
from modelcast.station.receiver.heard import Heard, heard_messages
from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap, Receipt


@dataclass(frozen=True, slots=True)
class Damped(AbstractNumpySubModel):
    """A velocity that decays; at a rate of 0 it gives 0/0, or raises; its covariance may fail as well."""

    fault: str = "nan"

    name = "damped"
    window = 2
    parameter_names = ("rate_1ps", "mean_east_mps", "mean_north_mps")
    payload_layout = PayloadLayout(
        (
            PayloadField("rate_1ps", 0.01, bits=8),
            PayloadField("mean_east_mps", 0.1, bits=12),
            PayloadField("mean_north_mps", 0.1, bits=12),
        )
    )

    def fit_batch(self, windows: Windows) -> FloatArray:
        """Newest velocity, and a rate of 0.1/s."""
        velocity_mps = (windows.positions_m[:, -1] - windows.positions_m[:, -2]) / windows.dt_s
        return np.column_stack([np.full(len(velocity_mps), 0.1), velocity_mps])

    def predict_batch(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:  # noqa: ARG002
        """Go v·(1 - exp(-k·t))/k."""
        rate = parameters[:, :1]
        if self.fault == "raises" and (rate == 0.0).any():
            raise ZeroDivisionError("no rate")
        if self.fault == "words":
            return np.array(f"{rate[0, 0]:g}/s")
        if self.fault == "own":
            raise SubModelError(f"no rate of {rate[0, 0]:g}")
        if self.fault == "options":
            raise ConfigError(f"no rate of {rate[0, 0]:g}")
        with np.errstate(all="ignore"):
            return parameters[:, None, 1:] * ((1.0 - np.exp(-rate * horizons_s)) / rate)[..., None]

    def covariance_batch(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """As constant velocity's."""
        if self.fault == "spread":
            raise ArithmeticError("no spread")
        return super(Damped, self).covariance_batch(parameters, horizons_s, dt_s=dt_s)


@pytest.fixture(autouse=True)
def _not_yet_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(heard_functions, "_told", set[tuple[str, str]]())


def updates(model: Damped, *rates_1ps: float) -> tuple[LocalDynamicMap, Heard, FloatArray]:
    """A map that holds the model, and a second between messages at these rates; when they arrive."""
    around = LocalDynamicMap((Bank((model, ConstantVelocity())),))
    at_s = 0.5 + np.arange(len(rates_1ps), dtype=np.float64)
    sent = [
        ModelUpdate(
            5,
            number,
            float(t_s),
            position_m=np.array([20.0 * t_s, 0.0]),
            in_use=0,
            parameters=np.array([rate, 20.0, 0.0, 20.0, 0.0]),
            dt_s=0.1,
        )
        for number, (rate, t_s) in enumerate(zip(rates_1ps, at_s, strict=True))
    ]
    return around, heard_messages(sent, at_s.tolist()), at_s


@pytest.mark.parametrize(("fault", "told"), [("nan", "gave nan"), ("raises", "ZeroDivisionError: no rate")])
def test_a_message_that_the_model_fails_on_is_refused_and_told_once(fault: str, told: str) -> None:
    around, heard, at_s = updates(Damped(fault), 0.1, 0.0, 0.0, 0.2)
    with pytest.warns(ModelcastWarning, match=f"The sub-model damped .*{told}") as met:
        receipts, state = around.hear(around.init(), heard)
    assert receipts.tolist() == [Receipt.ACCEPTED, Receipt.MALFORMED, Receipt.MALFORMED, Receipt.ACCEPTED]
    assert len(met) == 1
    held = around.believe(state, float(at_s[-1]) + 1.0)
    assert held.position_m[0, 0] == pytest.approx(20.0 * at_s[-1] + 20.0 * (1.0 - np.exp(-0.2)) / 0.2)


@pytest.mark.parametrize(
    ("fault", "told"),
    [
        ("words", "gave no array of numbers from predict_batch: 0.1/s"),
        ("own", "failed in predict_batch: SubModelError: no rate of 0.1"),
        ("options", "failed in predict_batch: ConfigError: no rate of 0.1"),
    ],
)
def test_what_strangers_send_does_not_multiply_what_is_told(fault: str, told: str) -> None:
    around, heard, _ = updates(Damped(fault), 0.1, 0.2, 0.3, 0.4)
    with pytest.warns(ModelcastWarning, match=f"The sub-model damped {told}") as met:
        receipts, _ = around.hear(around.init(), heard)
    assert receipts.tolist() == [Receipt.MALFORMED] * 4
    assert len(met) == 1


def test_each_function_that_fails_is_told_once() -> None:
    failures = [
        SubModelError(f"{number}", model="damped", called=called)
        for number in range(3)
        for called in ("predict_batch", "covariance_batch")
    ]
    with warnings.catch_warnings(record=True) as met:
        warnings.simplefilter("always")
        for one in failures:
            heard_functions.tell_failure(one)
    assert [str(one.message)[0] for one in met] == ["0", "0"]


def test_a_failure_keeps_its_names_on_the_way_to_another_process() -> None:
    failure = copy.copy(SubModelError("no rate", model="damped", called="fit_batch"))  # as pickle does it
    assert (str(failure), failure.model, failure.called) == ("no rate", "damped", "fit_batch")


def test_a_spread_that_fails_is_that_of_constant_velocity() -> None:
    found: list[FloatArray] = []
    for fault in ("spread", ""):
        around, heard, at_s = updates(Damped(fault), 0.1)
        _, state = around.hear(around.init(), heard)
        with warnings.catch_warnings(record=True) as met:
            warnings.simplefilter("always")
            found.append(around.believe(state, float(at_s[-1]) + 2.0).covariance_m2)
        assert len(met) == (fault == "spread")
    assert found[0] == pytest.approx(found[1])


def test_its_own_vehicle_is_told_as_before() -> None:
    """Nothing is forgiven where the parameters are its own."""
    with pytest.raises(SubModelError, match="gave nan from predict_batch"):
        Damped().predict(np.zeros((1, 3)), np.array([1.0]), dt_s=0.1)
