"""Claims about the training of hyper-parameters."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import AxisKernel, GaussianProcess, VehicleProcess
from modelcast.models.regimes import regime_features
from modelcast.study.training.families import AbstractFamily, FixedFamily, VehicleFamily
from modelcast.study.training.hyperparameters import train_hyperparameters
from modelcast.study.training.regimes import train_regimes
from modelcast.study.training.windows import TrainingWindows, survival_s, training_windows
from modelcast.trips.trajectory import Trajectory, build_trajectory

FAMILIES: dict[str, AbstractFamily] = {
    "vehicle": VehicleFamily(VehicleProcess("gp-vehicle", degree=3)),
    "derivative": VehicleFamily(VehicleProcess("gp-derivative", degree=3, velocities=True)),
    "fixed": FixedFamily(GaussianProcess(form="intercept")),
}
each_family = pytest.mark.parametrize("family", FAMILIES.values(), ids=FAMILIES.keys())


def weaving(seconds: float = 120.0, *, dt_s: float = 0.1, noise_m: float = 0.005) -> Trajectory:
    """A car that weaves and brakes."""
    t = np.arange(0.0, seconds, dt_s)
    position = np.stack([12.0 * t + 8.0 * np.sin(0.5 * t), 5.0 * np.sin(0.4 * t)], axis=1)
    position += noise_m * np.random.default_rng(2).standard_normal(position.shape)
    return build_trajectory("made/1", t, position)


def cut(count: int = 300, *, trip: Trajectory | None = None, samples: int = 10) -> TrainingWindows:
    rng = np.random.default_rng(0)
    return training_windows([trip or weaving()], samples=samples, longest_s=4.0, count=count, rng=rng)


def test_windows_are_followed_by_their_own_future() -> None:
    trip = weaving(noise_m=0.0)
    training = cut(50, trip=trip)
    assert training.samples.shape == (50, 10, 9)
    assert training.future_m.shape == (50, 40, 2)
    for window, future in zip(training.samples, training.future_m, strict=True):
        at = int(np.flatnonzero((trip.position_m == window[-1, :2]).all(axis=1))[0])
        assert np.array_equal(trip.position_m[at + 1 : at + 41] - trip.position_m[at], future)


def test_no_window_or_future_straddles_a_gap() -> None:
    whole = weaving(30.0)
    late = np.where(np.arange(300) >= 150, 60.0, 0.0)
    trip = replace(whole, t_s=whole.t_s + late, segments=np.array([0, 150, 300]))
    training = cut(10_000, trip=trip)
    assert len(training) == 2 * (150 - 9 - 40)


def test_constant_velocity_survives_an_acceleration_for_as_long_as_the_closed_form_says() -> None:
    """``a·t²/2`` reaches the threshold at ``sqrt(2·th/a)``; linear interpolation errs by less than a step."""
    dt_s, acceleration = 0.01, 2.0
    horizons_s = np.arange(1, 201) * dt_s
    samples = np.zeros((1, 1, 7))
    samples[0, 0, 2] = 10.0
    future_m = np.stack([10.0 * horizons_s + 0.5 * acceleration * horizons_s**2, 0.0 * horizons_s], axis=1)
    training = TrainingWindows(samples, future_m[None], horizons_s=horizons_s, dt_s=dt_s)
    thresholds_m = np.array([0.2, 0.5, 100.0])
    found = survival_s(ConstantVelocity(), training, thresholds_m)[0]
    assert found[:2] == pytest.approx(np.sqrt(2.0 * thresholds_m[:2] / acceleration), abs=1e-4)
    assert found[2] == horizons_s[-1]


@each_family
def test_training_improves_what_it_searches_for_and_repeats(family: AbstractFamily) -> None:
    training = cut()
    start = family.build(family.start)
    pair = train_hyperparameters(training, family, evaluations=40)
    likely_at_start = family.log_likelihood(family.start, training)
    assert pair.likelihood.log_likelihood > likely_at_start
    thresholds_m = np.array([0.2, 0.3, 0.5])
    rate_hz = (1.0 / (survival_s(start, training, thresholds_m) + 0.05)).mean(axis=0)
    assert np.log(pair.survival.message_rate_hz).sum() < np.log(rate_hz).sum()
    assert np.log(pair.better.message_rate_hz).sum() <= np.log(pair.likelihood.message_rate_hz).sum()
    again = train_hyperparameters(training, family, evaluations=40)
    assert again == pair


def test_the_likelihood_finds_the_noise_of_its_own_process() -> None:
    """Of 400 windows drawn from the prior, the noise comes back within 5 %."""
    rng = np.random.default_rng(3)
    t = np.arange(-9, 1) * 0.1
    prior = 4.0**2 * np.exp(-0.5 * np.square((t[:, None] - t) / 1.5)) + 10.0**2 * np.outer(t, t)
    drawn = rng.multivariate_normal(np.zeros(10), prior + 0.05**2 * np.eye(10), (400, 2))
    samples = np.zeros((400, 10, 7))
    samples[:, :, :2] = drawn.transpose(0, 2, 1)
    training = TrainingWindows(samples, np.zeros((400, 1, 2)), horizons_s=np.array([0.1]), dt_s=0.1)
    family = FixedFamily(GaussianProcess(form="intercept"))
    pair = train_hyperparameters(training, family, evaluations=300)
    model = pair.likelihood.model
    assert isinstance(model, GaussianProcess)
    assert model.hyperparameters is not None
    noise_m = np.sqrt(model.hyperparameters.noise_ratio * model.hyperparameters.variance_m2)
    assert noise_m == pytest.approx(0.05, rel=0.05)
    assert model.name == "gp-trained"


def test_progress_reaches_its_end_in_order() -> None:
    seen: list[tuple[int, int]] = []
    train_hyperparameters(
        cut(50), FAMILIES["fixed"], evaluations=20, progress=lambda done, every: seen.append((done, every))
    )
    assert {every for _, every in seen} == {40}
    done = [one for one, _ in seen]
    assert done == sorted(done)
    assert done[-1] <= 40


def test_regimes_have_distinct_names_and_are_told_apart_by_their_features() -> None:
    """A trip with a fast, straight half and a slow, winding half."""
    t = np.arange(0.0, 60.0, 0.1)
    fast = np.stack([25.0 * t, 0.0 * t], axis=1)
    slow = 6.0 * np.stack([np.sin(0.5 * t), np.cos(0.5 * t)], axis=1)
    trips = [build_trajectory(f"made/{i}", t, one) for i, one in enumerate((fast, slow))]
    rng = np.random.default_rng(0)
    training = training_windows(trips, samples=10, longest_s=2.0, count=400, rng=rng)
    family = VehicleFamily(VehicleProcess("gp", AxisKernel(3.0, 10.0), degree=3))
    found = train_regimes(
        training, family, 2, label="gp-regime", rng=np.random.default_rng(1), evaluations=10
    )
    regimes = found.regimes
    assert [member.name for member in regimes.members] == ["gp-regime-1", "gp-regime-2"]
    assert regimes.members == tuple(pair.better.model for pair in found.pairs)
    assert regimes.shares[0] >= regimes.shares[1]
    regime = regimes.of(training.samples)
    is_fast = regime_features(training.samples)[:, 0] > 15.0
    assert np.unique(regime[is_fast]).size == np.unique(regime[~is_fast]).size == 1
    assert regime[is_fast][0] != regime[~is_fast][0]


def test_impossible_requests_are_refused() -> None:
    training = cut(20)
    rng = np.random.default_rng(0)
    with pytest.raises(ValueError, match="count must be"):
        train_regimes(training, FAMILIES["vehicle"], 1, label="gp", rng=rng)
    with pytest.raises(ValueError, match="no window"):
        cut(trip=weaving(3.0))
    with pytest.raises(ValueError, match="no trip"):
        training_windows([], samples=10, longest_s=1.0, count=5, rng=rng)
    trips = [weaving(), weaving(dt_s=0.2)]
    with pytest.raises(ValueError, match="share one sampling interval"):
        training_windows(trips, samples=10, longest_s=1.0, count=5, rng=rng)
    with pytest.raises(ValueError, match="form 'intercept'"):
        FixedFamily(GaussianProcess(form="anchored"))
