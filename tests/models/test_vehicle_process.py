"""Claims about Gaussian processes in the vehicle's frame and about the noise-adaptive fit."""

from dataclasses import replace

import numpy as np
import pytest
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, DotProduct

from modelcast.models.base import AbstractSubModel, Windows
from modelcast.models.gp import AxisKernel, GaussianProcess, VehicleProcess, linear_process
from modelcast.models.gp.conditional import condition_on, log_likelihood
from modelcast.models.gp.vehicle import measured, noise_level, noise_levels_m

DT_S = 0.1
TIMES_S = np.arange(-9, 1) * DT_S
HORIZONS_S = np.array([0.0, 0.5, 1.0, 2.0])
POSITIONS = VehicleProcess("gp-vehicle", AxisKernel(3.0, 5.0), across=AxisKernel(4.0, 8.0))
BOTH = replace(POSITIONS, label="gp-derivative", velocities=True)
each = pytest.mark.parametrize("model", [POSITIONS, BOTH], ids=lambda one: one.name)

STEP_S = 1e-3
"""Half the span of a difference that stands for a derivative; it errs by its square."""

POLYNOMIAL_M = 0.02
"""The fourth-degree polynomial follows the process this closely over 3 s."""

ROUNDING_M = 1e-7
"""Weights of a process with 1 mm of noise and metres of deviation amplify rounding."""


def turning(count: int = 12, *, noise_m: float = 0.005, seed: int = 0) -> np.ndarray:
    """Windows of cars that turn and brake, (B, 10, 7)."""
    rng = np.random.default_rng(seed)
    t = TIMES_S[None, :, None]
    velocity, acceleration = rng.normal(0.0, 10.0, (count, 1, 2)), rng.normal(0.0, 2.0, (count, 1, 2))
    position = velocity * t + 0.5 * acceleration * t**2 + noise_m * rng.standard_normal((count, 10, 2))
    rest = np.zeros((count, 10, 3))
    rest[:, :, 2] = noise_m
    return np.concatenate([position, velocity + acceleration * t, rest], axis=2)


@pytest.mark.parametrize("velocities", [False, True])
def test_weights_agree_with_dense_algebra(velocities: bool) -> None:
    """With scikit-learn's kernels, and velocities as fine differences of them."""
    kernel, noise_m = AxisKernel(1.5, 4.0, slope_deviation_mps=12.0, velocity_noise_mps=0.1), 0.02
    found = condition_on(kernel, TIMES_S, HORIZONS_S, position_noise_m=noise_m, velocities=velocities)
    prior = ConstantKernel(16.0) * RBF(1.5) + ConstantKernel(144.0) * DotProduct(1e-6)
    every = np.concatenate([TIMES_S, TIMES_S - STEP_S, TIMES_S + STEP_S])[:, None]
    rows = np.hstack([np.eye(10), np.zeros((10, 20))])
    noise, constant = np.full(10, noise_m**2), np.ones(10)
    if velocities:
        difference = np.hstack([np.zeros((10, 10)), -np.eye(10), np.eye(10)]) / (2.0 * STEP_S)
        rows = np.vstack([rows, difference])
        noise, constant = np.append(noise, np.full(10, 0.1**2)), np.append(constant, np.zeros(10))
    covariance = rows @ prior(every) @ rows.T + np.diag(noise)
    cross = rows @ prior(every, HORIZONS_S[:, None])
    solved, level = np.linalg.solve(covariance, cross), np.linalg.solve(covariance, constant)
    missing = 1.0 - constant @ solved
    weights = solved + np.outer(level, missing / (constant @ level))
    variance = (
        prior.diag(HORIZONS_S[:, None]) - (cross * solved).sum(axis=0) + missing**2 / (constant @ level)
    )
    assert pytest.approx(weights, rel=1e-4, abs=1e-4) == found.weights.T
    assert found.variance_m2 == pytest.approx(variance, rel=1e-4, abs=1e-6)


def test_the_likelihood_is_that_of_the_contrasts_that_know_no_constant() -> None:
    kernel, noise_m = AxisKernel(2.0, 3.0, slope_deviation_mps=8.0), 0.05
    windows = turning()[:, :, 0]
    narrow = ConstantKernel(9.0) * RBF(2.0) + ConstantKernel(64.0) * DotProduct(0.0)
    covariance = narrow(TIMES_S[:, None]) + noise_m**2 * np.eye(10)
    contrasts = np.linalg.svd(np.ones((1, 10)))[2][1:]
    inner = contrasts @ covariance @ contrasts.T
    moved = windows @ contrasts.T
    squares = np.einsum("bi,ij,bj->b", moved, np.linalg.inv(inner), moved)
    expected = -0.5 * (squares + np.linalg.slogdet(inner)[1] + 9 * np.log(2 * np.pi))
    found = log_likelihood(kernel, TIMES_S, windows, position_noise_m=noise_m)
    # The contrasts are orthonormal, the constant's own direction is not: n = 10.
    assert found + 0.5 * np.log(10.0) == pytest.approx(expected, rel=1e-6, abs=1e-6)


@each
def test_the_polynomial_follows_the_process_and_then_goes_straight_on(model: VehicleProcess) -> None:
    samples = turning(40)
    horizons_s = np.linspace(0.0, 3.0, 13)
    parameters = model.fit(Windows(samples, dt_s=DT_S))
    moving = parameters[:, -2] == model.straight_after_s
    assert moving.sum() > 5
    predicted = model.predict(parameters, horizons_s, dt_s=DT_S)
    noise_m = float(noise_levels_m()[int(parameters[0, -1])])
    turned = measured(samples, velocities=model.velocities)
    along, across = (
        turned[:, axis]
        @ condition_on(
            kernel, TIMES_S, horizons_s, position_noise_m=noise_m, velocities=model.velocities
        ).weights.T
        for axis, kernel in enumerate((model.along, model.across))
    )
    exact = np.hypot(along, across)
    assert np.abs(np.hypot(*predicted.transpose(2, 0, 1)) - exact)[moving].max() < POLYNOMIAL_M
    late = model.predict(parameters, np.array([4.0, 5.0, 6.0]), dt_s=DT_S)[moving]
    assert np.abs(np.diff(late, 2, axis=1)).max() < ROUNDING_M


@each
def test_a_braking_car_stops_and_stays(model: VehicleProcess) -> None:
    """From 4 m/s at -4 m/s², it stops after 1 s and 2 m."""
    model = replace(model, along=AxisKernel(5.0, 200.0))
    samples = np.zeros((1, 10, 7))
    samples[0, :, 0] = 4.0 * TIMES_S - 2.0 * TIMES_S**2
    samples[0, :, 2] = 4.0 - 4.0 * TIMES_S
    samples[0, :, 6] = 0.001
    parameters = model.fit(Windows(samples, dt_s=DT_S))
    moved = model.predict(parameters, np.array([0.5, 3.0, 60.0]), dt_s=DT_S)[0, :, 0]
    assert moved[0] == pytest.approx(1.5, abs=0.05)
    assert moved[1] == moved[2] == pytest.approx(2.0, abs=0.1)
    assert parameters[0, -2] == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize(
    "model",
    [POSITIONS, BOTH, linear_process(), GaussianProcess(form="intercept", noise="estimated")],
    ids=lambda one: one.name,
)
def test_turning_the_frame_turns_the_prediction(model: AbstractSubModel) -> None:
    samples = turning(20)
    rotation = np.array([[np.cos(0.7), np.sin(0.7)], [-np.sin(0.7), np.cos(0.7)]])
    turned = np.concatenate(
        [samples[..., :2] @ rotation, samples[..., 2:4] @ rotation, samples[..., 4:]], axis=2
    )
    one, two = (
        model.predict(model.fit(Windows(w, dt_s=DT_S)), HORIZONS_S, dt_s=DT_S) for w in (samples, turned)
    )
    assert np.abs(one @ rotation - two).max() < (1e-4 if isinstance(model, GaussianProcess) else ROUNDING_M)


def test_the_linear_kernel_alone_is_a_least_squares_line() -> None:
    """Its prior of 30 m/s on the slope pulls by less than a millimetre."""
    samples = turning(20)
    parameters = linear_process().fit(Windows(samples, dt_s=DT_S))
    assert len(linear_process().parameter_names) == 6
    moving = parameters[:, -2] > 0.0
    predicted = linear_process().predict(parameters, HORIZONS_S, dt_s=DT_S)[moving]
    for row, window in enumerate(samples[moving]):
        for axis in range(2):
            line = np.polynomial.Polynomial.fit(TIMES_S, window[:, axis] - window[-1, axis], 1)
            assert predicted[row, :, axis] == pytest.approx(line(HORIZONS_S), abs=1e-3)


def test_noise_chooses_the_nearest_level() -> None:
    levels = noise_levels_m()
    assert noise_level(levels).tolist() == list(range(8))
    assert noise_level(levels * 1.5).tolist() == [0, 1, 2, 3, 4, 5, 6, 7]
    assert noise_level(np.array([1e-9, 10.0, 0.0])).tolist() == [0, 7, noise_level(np.array([0.01]))[0]]
    samples = np.repeat(turning(1), 8, axis=0)
    samples[:, :, 6] = levels[:, None]
    parameters = POSITIONS.fit(Windows(samples, dt_s=DT_S))
    assert parameters[:, -1].tolist() == list(range(8))


def test_more_noise_weighs_the_newest_velocity_more() -> None:
    """A velocity of 0.1 m/s says more than positions of 0.5 m, and less than positions of 1 mm."""
    samples = np.repeat(turning(1), 2, axis=0)
    samples[:, :, 6] = np.array([0.0005, 0.5])[:, None]
    other = samples.copy()
    other[:, :, 2:4] *= 1.05
    moved = [BOTH.predict(BOTH.fit(Windows(w, dt_s=DT_S)), np.ones(1), dt_s=DT_S) for w in (samples, other)]
    change = np.hypot(*(moved[1] - moved[0])[:, 0].T)
    assert change[1] > 5.0 * change[0]


def test_the_adaptive_fit_is_the_fit_with_the_estimate_as_its_floor() -> None:
    samples = turning(30, noise_m=0.02)
    adaptive = GaussianProcess(form="intercept", noise="estimated")
    for noise_m, floor_m in ((0.0, 0.001), (0.0004, 0.001), (0.02, 0.02), (0.1, 0.1)):
        samples[:, :, 6] = noise_m
        windows = Windows(samples, dt_s=DT_S)
        plain = GaussianProcess(form="intercept", noise_floor_m=floor_m)
        one, two = (m.predict(m.fit(windows), HORIZONS_S, dt_s=DT_S) for m in (adaptive, plain))
        # On a ridge of the likelihood, the other bounds, which are stretched with the floor, decide.
        assert np.quantile(np.abs(one - two).max(axis=(1, 2)), 0.8) < 0.01


def test_names_say_what_a_process_does() -> None:
    assert GaussianProcess(form="intercept", noise="estimated").name == "gp-adaptive"
    assert GaussianProcess(form="intercept", label="gp-trained-2").name == "gp-trained-2"
    assert linear_process().name == "gp-linear"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"label": ""}, "label must"),
        ({"degree": 0}, "degree must"),
        ({"degree": 7}, "degree must"),
        ({"straight_after_s": 0.0}, "straight_after_s must"),
        ({"samples": 2}, "samples must be a whole number from 3"),
    ],
)
def test_settings_out_of_range_are_refused(change: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        replace(POSITIONS, **change)
    with pytest.raises(ValueError, match="needs form 'intercept'"):
        GaussianProcess(form="anchored", noise="estimated")
    for wrong in ({"lengthscale_s": 0.0}, {"deviation_m": -1.0}, {"velocity_noise_mps": np.nan}):
        with pytest.raises(ValueError, match=f"{next(iter(wrong))} must"):
            AxisKernel(**wrong)
