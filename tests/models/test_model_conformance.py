"""The contract of a motion model, over every sub-model and over banks."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.models.numpy_models import Coasting, Smoothed

from modelcast.models.bank import Bank
from modelcast.models.base import AbstractMotionModel, AbstractSubModel, Windows
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.free import Estimates, FreeMotion
from modelcast.models.free.estimates import map_of
from modelcast.models.gp import (
    AxisKernel,
    GaussianProcess,
    Hyperparameters,
    KernelProcess,
    VehicleProcess,
    derivative_process,
    linear_process,
    vehicle_process,
)
from modelcast.models.interacting import InteractingMultipleModel
from modelcast.models.kinematic import (
    ConstantAcceleration,
    ConstantTurnRateAcceleration,
    ConstantTurnRateVelocity,
)
from modelcast.models.learned import FeatureMap, Perceptron
from modelcast.models.predicted_path import PredictedPath
from modelcast.models.profile import default_profile
from modelcast.models.stop_and_go import StopAndGo
from modelcast.models.trusted import Trusted
from modelcast.study.training.free import NETWORK_FEATURES

TRAINED = default_profile().sub_model("gp-trained")


def _shipped(name: str) -> AbstractSubModel:
    """Return the shipped sub-model of that name."""
    found = default_profile().sub_model(name)
    assert found is not None
    return found


def _regimes() -> Bank:
    """Return the shipped bank of all regimes."""
    regimes = default_profile().regimes
    assert regimes is not None
    return regimes.bank


def _free(context: bool) -> FreeMotion:
    """Return estimates of all kinds, moved by a network of chance weights."""
    estimates = (
        Estimates(0.005, speed=("speed", 5, 1), course=("position", 8, 2)),
        Estimates(np.inf, acceleration=("velocity", 10, 2), yaw_rate=("position", 10, 2)),
    )
    features = map_of(estimates, 20, replace(NETWORK_FEATURES, context=context))
    rng = np.random.default_rng(3)
    network = Perceptron(
        np.inf,
        centre=np.zeros(features.inputs),
        width=np.ones(features.inputs),
        weights_1=0.1 * rng.standard_normal((features.inputs, 8)),
        bias_1=np.zeros(8),
        weights_2=rng.standard_normal((8, 6)),
        bias_2=np.zeros(6),
        weights_3=rng.standard_normal((6, 4)),
        bias_3=np.zeros(4),
    )
    return FreeMotion(estimates, (network,), features=features)


FIXED = Hyperparameters(2.0, 1e-4, linear_ratio_per_s2=1.0, variance_m2=25.0)

MODELS: dict[str, AbstractMotionModel] = {
    "cv": ConstantVelocity(),
    "ca": ConstantAcceleration(),
    "ctrv": ConstantTurnRateVelocity(),
    "ctra": ConstantTurnRateAcceleration(),
    "imm": InteractingMultipleModel(),
    "gp-anchored": GaussianProcess(form="anchored"),
    "gp-intercept": GaussianProcess(form="intercept"),
    "gp-anchored-5": GaussianProcess(5, "anchored", noise_floor_m=0.01),
    "gp-intercept-20": GaussianProcess(20, "intercept"),
    "gp-anchored-fixed": GaussianProcess(form="anchored", hyperparameters=FIXED),
    "gp-intercept-fixed": GaussianProcess(form="intercept", hyperparameters=FIXED),
    "gp-adaptive": GaussianProcess(form="intercept", noise="estimated"),
    "gp-linear": linear_process(),
    "gp(linear+matern32)": KernelProcess("linear+matern32"),
    "gp(matern52*(linear+rq))-15": KernelProcess("matern52*(linear+rq)", 15, 0.01),
    "cv+gp(linear)+gp(rbf+matern12)": Bank(
        (ConstantVelocity(), KernelProcess("linear"), KernelProcess("rbf+matern12"))
    ),
    "gp(linear+rbf*periodic)-path": PredictedPath(KernelProcess("linear+rbf*periodic")),
    "gp-vehicle-untrained": vehicle_process(),
    **{member.name: member for member in default_profile().sub_models if member.name.startswith("gp-")},
    "gp-vehicle-20": VehicleProcess("gp-vehicle-20", AxisKernel(4.0, 5.0), samples=20, degree=3),
    "gp-derivative-untrained": derivative_process(),
    "gp-derivative-15": derivative_process(15),
    "gp-derivative+gp-vehicle+gp-trained-1": Bank(
        (
            VehicleProcess("gp-derivative", velocities=True),
            VehicleProcess("gp-vehicle"),
            GaussianProcess(form="intercept", hyperparameters=FIXED, label="gp-trained-1"),
        )
    ),
    "regimes": _regimes(),
    "free": FreeMotion((Estimates(np.inf),), features=FeatureMap(10, ((3, 2),), ((5, 1),))),
    "free-predictive": _free(context=False),
    "free-context": _free(context=True),
    "stop-and-go": StopAndGo(),
    "stop-and-go+cv": Bank((StopAndGo(), ConstantVelocity())),
    "learned": _shipped("learned"),
    "shs": _shipped("shs"),
    "hdp-hmm": _shipped("hdp-hmm"),
    "shs-damped": Trusted(_shipped("shs"), 1.5),
    "hdp-hmm-path": PredictedPath(_shipped("hdp-hmm")),
    "shs+ctra+hdp-hmm": Bank((_shipped("shs"), ConstantTurnRateAcceleration(), _shipped("hdp-hmm"))),
    "learned+ctra": Bank((_shipped("learned"), ConstantTurnRateAcceleration())),
    "gp-vehicle-damped": Trusted(vehicle_process(), 2.0),
    "ctra-damped": Trusted(ConstantTurnRateAcceleration(), 0.5),
    "gp-intercept-damped": Trusted(GaussianProcess(form="intercept"), 1.0),
    "gp-anchored-path": PredictedPath(GaussianProcess(form="anchored")),
    "gp-adaptive-path": PredictedPath(GaussianProcess(form="intercept", noise="estimated")),
    "gp-trained-path": PredictedPath(TRAINED),
    "gp-trained-path-damped": Trusted(PredictedPath(TRAINED), 2.0),
    "gp-intercept-path": PredictedPath(GaussianProcess(form="intercept")),
    "gp-intercept-path-damped": Trusted(PredictedPath(GaussianProcess(form="intercept")), 1.0),
    "cv+gp-anchored": Bank((ConstantVelocity(), GaussianProcess(form="anchored"))),
    "gp-intercept+cv": Bank((GaussianProcess(form="intercept"), ConstantVelocity())),
    "ctra+ca+cv": Bank((ConstantTurnRateAcceleration(), ConstantAcceleration(), ConstantVelocity())),
    "numpy": Coasting(),
    "numpy-path": PredictedPath(Coasting()),
    "numpy-state": Smoothed(),
    "numpy-state-path-damped": Trusted(PredictedPath(Smoothed()), 1.0),
    "numpy+cv": Bank((Smoothed(), Coasting(), ConstantVelocity())),
    "gp-intercept+ctra+cv": Bank(
        (GaussianProcess(form="intercept"), ConstantTurnRateAcceleration(), ConstantVelocity())
    ),
}

HORIZONS_S = np.array([0.0, 0.1, 0.35, 1.0, 2.5])
DT_S = 0.1

EIGENVALUE_ROUNDING_M2 = 1e-12
"""A variance of zero may come out negative by rounding."""

FRAME_ROUNDING_M = 1e-8
"""Reassociated sums may round at the size of the coordinates, 1e-12 m at 8 km, and a fit amplifies that."""

DAMPED_ROUNDING_M = 1e-6
"""Three positions 0.05 s apart give a damped model's turn: 1.5 s later, rounding has grown by 900."""


@pytest.fixture(params=MODELS.values(), ids=MODELS.keys(), name="model")
def _model(request: pytest.FixtureRequest) -> AbstractMotionModel:
    return request.param


def windows(count: int = 30, length: int = 24) -> Windows:
    """Cars that turn and brake, with 1 cm of noise, on a grid of 2**-20 m; the last three stand still."""
    rng = np.random.default_rng(11)
    t = np.arange(1 - length, 1) * DT_S
    velocity = rng.normal(0.0, 15.0, (count, 1, 2))
    acceleration = rng.normal(0.0, 2.0, (count, 1, 2))
    jerk = rng.normal(0.0, 1.0, (count, 1, 2))
    t = t[None, :, None]
    position = velocity * t + acceleration * t**2 / 2 + jerk * t**3 / 6
    position += rng.normal(0.0, 0.01, position.shape)
    velocity = velocity + acceleration * t + jerk * t**2 / 2
    acceleration = acceleration + jerk * t
    speed = np.hypot(velocity[..., 0], velocity[..., 1])
    along = (acceleration * velocity).sum(axis=2) / speed
    turn = (acceleration[..., 0] * velocity[..., 1] - acceleration[..., 1] * velocity[..., 0]) / speed**2
    rates = np.stack([along, np.clip(turn, -1.0, 1.0)], axis=2)
    noise = rng.choice([0.0, 0.001, 0.01, 0.1], (count, 1, 1)) * np.ones((1, length, 1))
    samples = np.concatenate([position, velocity, rates, noise], axis=2)
    samples[-3:] = 0.0
    return Windows(np.round(samples * 2**20) / 2**20, dt_s=DT_S)


def test_shapes_follow_the_batch(model: AbstractMotionModel) -> None:
    parameters = model.fit(windows(7))
    assert parameters.shape == (7, len(model.parameter_names))
    assert model.predict(parameters, HORIZONS_S, dt_s=DT_S).shape == (7, HORIZONS_S.size, 2)
    assert model.predict_at(parameters, np.ones(7), dt_s=DT_S).shape == (7, 2)
    assert model.covariance(parameters, HORIZONS_S, dt_s=DT_S).shape == (7, HORIZONS_S.size, 2, 2)


def test_an_empty_batch_is_a_batch(model: AbstractMotionModel) -> None:
    parameters = model.fit(Windows(np.empty((0, 24, 7)), dt_s=DT_S))
    assert parameters.shape == (0, len(model.parameter_names))
    assert model.predict(parameters, HORIZONS_S, dt_s=DT_S).shape == (0, HORIZONS_S.size, 2)
    assert model.covariance(parameters, HORIZONS_S, dt_s=DT_S).shape == (0, HORIZONS_S.size, 2, 2)
    assert model.predict(parameters, HORIZONS_S, dt_s=DT_S).shape == (0, HORIZONS_S.size, 2)
    assert model.predict_at(parameters, np.empty(0), dt_s=DT_S).shape == (0, 2)


def test_parameters_are_finite_and_each_has_its_own_name(model: AbstractMotionModel) -> None:
    assert np.isfinite(model.fit(windows())).all()
    assert len(set(model.parameter_names)) == len(model.parameter_names)


def test_predictions_are_finite_far_ahead(model: AbstractMotionModel) -> None:
    parameters = model.fit(windows())
    assert np.isfinite(model.predict(parameters, np.array([30.0, 3600.0]), dt_s=DT_S)).all()


def test_predict_at_is_the_diagonal_of_predict(model: AbstractMotionModel) -> None:
    parameters = model.fit(windows(HORIZONS_S.size))
    all_pairs = model.predict(parameters, HORIZONS_S, dt_s=DT_S)
    each = model.predict_at(parameters, HORIZONS_S, dt_s=DT_S)
    assert np.array_equal(each, np.einsum("iik->ik", all_pairs))


def test_a_batch_equals_its_rows_one_by_one(model: AbstractMotionModel) -> None:
    together = windows()
    parameters = model.fit(together)
    moved = model.predict(parameters, HORIZONS_S, dt_s=DT_S)
    for row in range(0, 30, 7):
        alone = model.fit(Windows(together.samples[row : row + 1], dt_s=DT_S))
        assert np.array_equal(alone[0], parameters[row])
        assert np.array_equal(model.predict(alone, HORIZONS_S, dt_s=DT_S)[0], moved[row])


def test_moving_the_frame_changes_no_prediction(model: AbstractMotionModel) -> None:
    """The windows lie on a binary grid, so that the shift itself is exact."""
    here = windows()
    there = Windows(here.samples + np.array([4096.0, -8192.0, *np.zeros(7)]), dt_s=DT_S)
    predicted = [model.predict(model.fit(one), HORIZONS_S, dt_s=DT_S) for one in (here, there)]
    rounding_m = DAMPED_ROUNDING_M if isinstance(model, Trusted) else FRAME_ROUNDING_M
    assert np.abs(predicted[1] - predicted[0]).max() < rounding_m


def carries_state(model: AbstractMotionModel) -> bool:
    """Return whether a sub-model, or a member of a bank, carries state from sample to sample."""
    members = model.members if isinstance(model, Bank) else (model,)
    return any(
        isinstance(member, AbstractSubModel) and member.point_functions(DT_S).stream is not None
        for member in members
    )


def test_only_the_newest_samples_count(model: AbstractMotionModel) -> None:
    """Of a bank, as many as its longest member needs; of what carries state, all."""
    long = windows()
    needed = int(model.windows.max()) if isinstance(model, Bank) else model.window
    if carries_state(model):
        assert not np.array_equal(
            model.fit(long), model.fit(Windows(long.samples[:, -needed:].copy(), dt_s=DT_S))
        )
        return
    newest = Windows(long.samples[:, -needed:].copy(), dt_s=DT_S)
    assert np.array_equal(model.fit(long), model.fit(newest))


def test_arguments_are_left_alone(model: AbstractMotionModel) -> None:
    given = windows()
    kept = given.samples.copy()
    parameters = model.fit(given)
    sent = parameters.copy()
    horizons = HORIZONS_S.copy()
    model.predict(parameters, horizons, dt_s=DT_S)
    model.predict_at(parameters[:5], horizons, dt_s=DT_S)
    model.covariance(parameters, horizons, dt_s=DT_S)
    assert np.array_equal(given.samples, kept)
    assert np.array_equal(parameters, sent)
    assert np.array_equal(horizons, HORIZONS_S)


def test_arrays_in_any_memory_order_give_the_same(model: AbstractMotionModel) -> None:
    given = windows()
    scattered = Windows(np.asfortranarray(given.samples), dt_s=DT_S)
    parameters = model.fit(given)
    assert np.array_equal(model.fit(scattered), parameters)
    moved = model.predict(np.asfortranarray(parameters), HORIZONS_S, dt_s=DT_S)
    assert np.array_equal(moved, model.predict(parameters, HORIZONS_S, dt_s=DT_S))


def test_covariances_are_symmetric_positive_and_grow(model: AbstractMotionModel) -> None:
    covariance = model.covariance(model.fit(windows()), HORIZONS_S, dt_s=DT_S)
    assert np.array_equal(covariance, covariance.swapaxes(-1, -2))
    assert np.linalg.eigvalsh(covariance).min() >= -EIGENVALUE_ROUNDING_M2
    size = np.trace(covariance, axis1=-2, axis2=-1)
    assert np.diff(size, axis=1).min() >= -EIGENVALUE_ROUNDING_M2


def test_a_window_too_short_is_refused(model: AbstractMotionModel) -> None:
    short = Windows(windows().samples[:, : model.window - 1], dt_s=DT_S)
    with pytest.raises(ValueError, match=f"windows of {model.window} samples, got {model.window - 1}"):
        model.fit(short)


def test_parameters_of_another_length_are_refused(model: AbstractMotionModel) -> None:
    """Compiled code would otherwise read past their end."""
    parameters = model.fit(windows(2))[:, :-1]
    with pytest.raises(ValueError, match="parameters"):
        model.predict(parameters, HORIZONS_S, dt_s=DT_S)
    with pytest.raises(ValueError, match="parameters"):
        model.predict_at(parameters, np.ones(2), dt_s=DT_S)


def test_as_many_ages_as_rows_are_needed(model: AbstractMotionModel) -> None:
    """Compiled code would otherwise read past their end."""
    parameters = model.fit(windows(3))
    with pytest.raises(ValueError, match="ages_s"):
        model.predict_at(parameters, np.ones(2), dt_s=DT_S)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_windows_that_are_not_finite_are_refused(value: float) -> None:
    samples = windows().samples.copy()
    samples[3, 4, 1] = value
    with pytest.raises(ValueError, match="finite"):
        Windows(samples, dt_s=DT_S)


@pytest.mark.parametrize("shape", [(20, 7), (3, 20, 2), (3, 20, 6), (3, 20, 8), (3, 20, 10)])
def test_windows_of_another_shape_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="samples must be"):
        Windows(np.zeros(shape), dt_s=DT_S)


@pytest.mark.parametrize("dt_s", [0.0, -0.1, np.nan, np.inf])
def test_an_interval_that_is_no_interval_is_refused(dt_s: float) -> None:
    with pytest.raises(ValueError, match="dt_s"):
        Windows(np.zeros((1, 10, 7)), dt_s=dt_s)


def test_every_model_is_held_to_the_contract(
    concrete_classes: Callable[[type[Any]], set[type[Any]]],
) -> None:
    ours = {type(model) for model in MODELS.values() if type(model).__module__.startswith("modelcast.")}
    assert concrete_classes(AbstractMotionModel) == ours
