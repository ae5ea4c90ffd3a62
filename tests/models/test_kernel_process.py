"""The sub-model of a kernel: likelihood and derivatives, maximum, predictions and covariance against peers.

Predictions equal scikit-learn's at equal hyper-parameters to 1e-6 m up to 2 s on real windows of all sources;
`validation/kernels.py` does so for all windows. The closed form of ``linear+rbf`` is one more peer.
"""

import itertools
import runpy
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from sklearn.gaussian_process import GaussianProcessRegressor

from modelcast.core.exceptions import ConfigError
from modelcast.core.rules import FieldError
from modelcast.io.trips import read_trips
from modelcast.models.base import Windows
from modelcast.models.gp import (
    GaussianProcess,
    KernelProcess,
    fit_axis,
    fit_kernel,
    likelihood_of_kernel,
    process_of,
)
from modelcast.models.gp.expression_tables import pack_expression
from modelcast.models.gp.kernels import LEAVES, kernel_from_text
from modelcast.models.gp.kernels.base import VARIANCE
from modelcast.models.gp.time_grid import TimeGrid
from modelcast.models.plain import from_plain, to_plain
from modelcast.models.point_kernels import SAMPLE_COLUMNS

PEERS = runpy.run_path(str(Path(__file__).parents[2] / "benchmarks" / "peer_kernels.py"))
DT_S = 0.1
SAMPLES = 10
T_S = np.arange(1 - SAMPLES, 1) * DT_S
HORIZONS_S = np.array([0.0, 0.1, 0.5, 1.0, 2.0])
NOISE_M2 = (1e-6, 1e6)
"""Bounds of the white noise's variance that the sub-model has by default."""
CLAIM_M = 1e-6
"""Far below any position that is measured or sent; beside scikit-learn's own distance from what is exact."""
EXACT_M = 2e-6
"""What doubles leave where the variance is 1e10 times the white noise's."""
TOLERANCE = 1e-3
"""Of a log-likelihood: what no prediction shows."""
SUMS = [f"{a}+{b}" for a, b in itertools.combinations_with_replacement(LEAVES, 2)]
PRODUCTS = [f"{a}*{b}" for a, b in itertools.combinations(LEAVES, 2)]
NESTED = ["matern32*(linear+rbf)", "(linear+rq)*(matern12+periodic)+rbf*linear"]
EVERY = [*LEAVES, *SUMS, *PRODUCTS, *NESTED]


def tracks(count: int, seed: int = 0) -> np.ndarray:
    """One axis of cars that brake and jerk, with noise from 0 to 0.1 m, relative to the end, (B, n)."""
    rng = np.random.default_rng(seed)
    velocity, acceleration, jerk = (rng.normal(0.0, s, (count, 1)) for s in (15.0, 2.0, 1.0))
    y = velocity * T_S + acceleration * T_S**2 / 2 + jerk * T_S**3 / 6
    y += rng.choice([0.0, 1e-3, 1e-2, 0.1], (count, 1)) * rng.normal(size=y.shape)
    return y - y[:, -1:]


def some_hyperparameters(expression: str, count: int, seed: int = 0) -> np.ndarray:
    """Hyper-parameters from 0.3 to 3 with a noise of some centimetres, (B, P)."""
    rng = np.random.default_rng(seed)
    width = len(kernel_from_text(expression).hyperparameters)
    noise = 10.0 ** rng.uniform(-4, -1, (count, 1))
    return np.concatenate([10.0 ** rng.uniform(-0.5, 0.5, (count, width)), noise], axis=1)


def peer_likelihood(expression: str, y: np.ndarray, hyper: np.ndarray) -> np.ndarray:
    """Log-likelihood by scikit-learn, (B,)."""
    found = []
    for window, values in zip(y, hyper, strict=True):
        peer = GaussianProcessRegressor(PEERS["peer_of"](expression, values), alpha=0, optimizer=None)
        found.append(peer.fit(T_S[:, None], window).log_marginal_likelihood_value_)
    return np.array(found)


@pytest.mark.parametrize("expression", EVERY)
def test_likelihoods_are_scikit_learns(expression: str) -> None:
    y, hyper = tracks(5), some_hyperparameters(expression, 5)
    found, _ = likelihood_of_kernel(expression, y, hyper, dt_s=DT_S)
    np.testing.assert_allclose(found, peer_likelihood(expression, y, hyper), rtol=1e-8)


@pytest.mark.parametrize("expression", EVERY)
def test_derivatives_are_those_of_the_likelihood(expression: str) -> None:
    """Central differences, whose error is the square of their step, on windows drawn from the process."""
    hyper = some_hyperparameters(expression, 5, seed=1)
    kernel = kernel_from_text(expression)
    covariance = kernel.at(hyper[:, None, None, :-1], T_S[:, None], T_S) + hyper[:, -1:, None] * np.eye(
        SAMPLES
    )
    drawn = np.random.default_rng(1).normal(size=(5, SAMPLES, 1))
    y = (np.linalg.cholesky(covariance) @ drawn)[..., 0]
    step = 1e-5
    _, slopes = likelihood_of_kernel(expression, y, hyper, dt_s=DT_S)
    for p in range(hyper.shape[1]):
        factor = np.where(np.arange(hyper.shape[1]) == p, np.exp(step), 1.0)
        above, below = (
            likelihood_of_kernel(expression, y, one, dt_s=DT_S)[0] for one in (hyper * factor, hyper / factor)
        )
        differences = (above - below) / (2 * step)
        np.testing.assert_allclose(differences, slopes[:, p], rtol=1e-5, atol=1e-6 * np.abs(above).max())


@pytest.mark.parametrize("expression", EVERY)
def test_a_fit_is_a_maximum_within_the_bounds(expression: str) -> None:
    """No slope is left but towards a bound, and what the fit returns is consistent."""
    y = tracks(40, seed=2)
    fits = fit_kernel(expression, y, dt_s=DT_S)
    again, slopes = likelihood_of_kernel(expression, y, fits.hyperparameters, dt_s=DT_S)
    np.testing.assert_allclose(fits.log_likelihood, again, rtol=1e-6, atol=1e-6)
    bounds = [(one.low, one.high) for one in kernel_from_text(expression).hyperparameters]
    low, high = np.array([*bounds, NOISE_M2]).T
    hyper = fits.hyperparameters
    assert (hyper >= low * (1 - 1e-9)).all()
    assert (hyper <= high * (1 + 1e-9)).all()
    held = ((hyper <= low * (1 + 1e-9)) & (slopes < 0)) | ((hyper >= high * (1 - 1e-9)) & (slopes > 0))
    # A curvature of 1 or less in the logarithm and the search's tolerance of 1e-5 leave a slope of that size.
    assert np.median(np.abs(np.where(held, 0.0, slopes)).max(axis=1)) < 0.05


def test_the_general_search_finds_what_the_closed_form_finds() -> None:
    """Of ``linear+rbf``: the one general path against the one special path, by likelihood."""
    y = tracks(300, seed=3)
    general, closed = fit_kernel("linear+rbf", y, dt_s=DT_S), fit_axis(y, dt_s=DT_S)
    s = closed.variance_m2
    linear, rbf = (np.clip(part, VARIANCE.low, VARIANCE.high) for part in (closed.linear_ratio_per_s2 * s, s))
    hyper = np.stack([linear, rbf, closed.lengthscale_s, closed.noise_ratio * s], axis=1)
    best, _ = likelihood_of_kernel("linear+rbf", y, hyper, dt_s=DT_S)
    short = best - general.log_likelihood
    assert (short < TOLERANCE).mean() > 0.9
    assert short.mean() < 0.02


def real_windows(folder: Path, count: int) -> Iterator[np.ndarray]:
    """Windows of every source at 10 Hz, (count, n, 2)."""
    sources = ("openacc_zalazone", "spmd/bsm_p1_dev.csv", "comma2k19", "nyc_cvpd")
    for at, source in enumerate(sources):
        parts = [
            np.lib.stride_tricks.sliding_window_view(trip.position_m[first:end], SAMPLES, axis=0)
            for trip in read_trips(folder / source)
            if round(trip.dt_s, 3) == DT_S
            for first, end in zip(trip.segments[:-1], trip.segments[1:], strict=True)
            if end - first >= SAMPLES
        ]
        if parts:
            every = np.concatenate(parts).transpose(0, 2, 1)
            chosen = np.random.default_rng(at).choice(len(every), min(count, len(every)), replace=False)
            yield np.ascontiguousarray(every[chosen])


@pytest.fixture(scope="module", name="windows")
def _windows(data_folder: Path) -> np.ndarray:
    return np.concatenate(list(real_windows(data_folder, 60)))


@pytest.mark.slow
@pytest.mark.real
@pytest.mark.skipif(np.finfo(np.longdouble).eps > 1e-18, reason="no extended precision here")
@pytest.mark.parametrize(
    "expression",
    [pytest.param(one, marks=pytest.mark.slow) if one in SUMS else one for one in EVERY],
)
def test_real_windows_are_predicted_as_by_scikit_learn(expression: str, windows: np.ndarray) -> None:
    """At equal hyper-parameters; a dozen windows an expression, so that every window meets some.

    Extended precision is the judge: scikit-learn's power of its rational quadratic kernel rounds by 1e-5 m.
    """
    model = KernelProcess(expression)
    every = len(EVERY) // 6
    chosen = windows[EVERY.index(expression) % every :: every]
    assert len(chosen) >= 12
    rest = np.zeros((*chosen.shape[:2], SAMPLE_COLUMNS - 2))
    parameters = model.fit(Windows(np.concatenate([chosen, rest], axis=2), dt_s=DT_S))
    found = model.predict(parameters, HORIZONS_S, dt_s=DT_S)
    count = len(model.kernel.hyperparameters) + 1
    for axis in range(2):
        first = axis * (count + SAMPLES)
        hyper = parameters[:, first : first + count]
        y = chosen[:, :, axis] - chosen[:, -1:, axis]
        exact = PEERS["extended_prediction"](expression, y, hyper, DT_S, HORIZONS_S)
        np.testing.assert_allclose(found[..., axis], exact, rtol=0, atol=EXACT_M)
        for row, values in enumerate(hyper):
            kernel = PEERS["peer_of"](expression, values)
            process = GaussianProcessRegressor(kernel, alpha=0, optimizer=None).fit(T_S[:, None], y[row])
            theirs = process.predict(HORIZONS_S[:, None])
            off_m = np.abs(theirs - exact[row])
            assert (np.abs(found[row, :, axis] - theirs) <= CLAIM_M + off_m).all()


@pytest.mark.slow
@pytest.mark.real
@pytest.mark.parametrize(
    "expression", ["rbf", "matern32", "periodic", "linear+matern52", "linear+rq", "rbf*linear"]
)
def test_real_windows_are_fitted_as_well_as_by_scikit_learn(expression: str, windows: np.ndarray) -> None:
    """One start each. Both stop in local maxima: ours must rarely be worse, and on average not at all."""
    y = np.ascontiguousarray(windows[::12, :, 0] - windows[::12, -1:, 0])
    ours = fit_kernel(expression, y, dt_s=DT_S)
    theirs = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a search that ends at a bound
        for window in y:
            kernel = PEERS["peer_of"](expression, noise_bounds_m2=NOISE_M2)
            theirs.append(GaussianProcessRegressor(kernel, alpha=0).fit(T_S[:, None], window))
    short = np.array([one.log_marginal_likelihood_value_ for one in theirs]) - ours.log_likelihood
    assert (short < TOLERANCE).mean() >= 0.9
    assert short.mean() < TOLERANCE


def test_covariances_are_scikit_learns() -> None:
    model = KernelProcess("linear*matern32+rbf")
    y = tracks(4, seed=4)
    samples = np.concatenate([np.stack([y[:2], y[2:]], axis=2), np.zeros((2, SAMPLES, 5))], axis=2)
    parameters = model.fit(Windows(samples, dt_s=DT_S))
    found = model.covariance(parameters, HORIZONS_S, dt_s=DT_S)
    assert np.array_equal(found[..., 0, 1], np.zeros((2, HORIZONS_S.size)))
    count = len(model.kernel.hyperparameters) + 1
    for row, axis in itertools.product(range(2), range(2)):
        first = axis * (count + SAMPLES)
        values = parameters[row, first : first + count]
        peer = PEERS["peer_of"](model.expression, values)
        process = GaussianProcessRegressor(peer, alpha=0, optimizer=None).fit(
            T_S[:, None], samples[row, :, axis]
        )
        _, deviation = process.predict(HORIZONS_S[:, None], return_std=True)
        # White noise is part of scikit-learn's kernel, and so of what it predicts.
        theirs = deviation**2 - values[-1]
        np.testing.assert_allclose(found[row, :, axis, axis], theirs, rtol=1e-5, atol=1e-8)


def test_the_closed_form_serves_where_there_is_one() -> None:
    closed = process_of("rbf + linear", 12, noise_floor_m=0.01)
    assert closed == GaussianProcess(12, "anchored", noise_floor_m=0.01, label="gp(rbf+linear)")
    for text in ("linear", "linear+rbf+rbf", "linear*rbf", "linear+matern32"):
        assert process_of(text, 12, noise_floor_m=0.01) == KernelProcess(text, 12, 0.01)


def test_both_are_the_same_process() -> None:
    """The closed form and the general path predict the same where they find the same maximum."""
    y = tracks(60, seed=5)
    samples = np.concatenate([np.stack([y, y[::-1]], axis=2), np.zeros((60, SAMPLES, 5))], axis=2)
    models = (KernelProcess("linear+rbf"), process_of("linear+rbf"))
    both = [model.predict(model.fit(Windows(samples, dt_s=DT_S)), HORIZONS_S, dt_s=DT_S) for model in models]
    assert np.median(np.abs(both[0] - both[1])[:, 3]) < 0.01


def test_the_noise_floor_is_kept_and_holds_up_a_straight_line() -> None:
    """A line without noise has no noise but the floor, and is continued."""
    y = np.ascontiguousarray(12.0 * T_S[None])
    for floor_m in (1e-3, 1e-2):
        fits = fit_kernel("linear+matern32", y, dt_s=DT_S, noise_floor_m=floor_m)
        np.testing.assert_allclose(fits.hyperparameters[0, -1], floor_m**2, rtol=1e-9)
    model = KernelProcess("linear")
    samples = np.concatenate([np.stack([y, -y], axis=2), np.zeros((1, SAMPLES, 5))], axis=2)
    moved = model.predict(model.fit(Windows(samples, dt_s=DT_S)), HORIZONS_S, dt_s=DT_S)
    np.testing.assert_allclose(moved[0, :, 0], 12.0 * HORIZONS_S, atol=1e-4)
    np.testing.assert_allclose(moved[0, :, 1], -12.0 * HORIZONS_S, atol=1e-4)


@pytest.mark.parametrize("factors", [1, *(pytest.param(n, marks=pytest.mark.slow) for n in (2, 3, 4, 5)), 6])
@pytest.mark.parametrize("samples", [10, 60])
@pytest.mark.parametrize("dt_s", [0.1, 1.0])
def test_no_moving_window_is_taken_for_a_standing_one(factors: int, samples: int, dt_s: float) -> None:
    """Powers of the linear kernel reach 1e21 times their variance: every fit has a finite likelihood."""
    expression = "*".join(["linear"] * factors)
    rng = np.random.default_rng(factors)
    t_s = np.arange(1 - samples, 1) * dt_s
    velocity, acceleration = (rng.normal(0.0, s, (200, 1)) for s in (15.0, 0.3))
    y = velocity * t_s + acceleration * t_s**2 / 2 + 0.01 * rng.normal(size=(200, samples))
    y[::2] *= 1e-4  # as good as standing: the least variances are far too much
    fits = fit_kernel(expression, y, dt_s=dt_s)
    assert np.isfinite(fits.log_likelihood).all()
    assert np.isfinite(fits.weights_per_m).all()
    assert (fits.weights_per_m != 0.0).any(axis=1).all()
    for variance, noise_m2 in itertools.product(np.geomspace(1e-8, 1e4, 13), np.geomspace(*NOISE_M2, 13)):
        hyper = np.tile([variance, noise_m2], (10, 1))
        other, _ = likelihood_of_kernel(expression, y[:10], hyper, dt_s=dt_s)
        # Where rounding leaves no Cholesky factor the other is minus infinity.
        assert (fits.log_likelihood[:10] >= other - TOLERANCE).all()


@pytest.mark.parametrize("samples", [10, 60])
def test_a_kernel_that_outgrows_doubles_is_refused_by_name(samples: int) -> None:
    expression = "*".join(["linear"] * 6)
    with pytest.raises(
        ConfigError, match=rf"linear\*linear.* grows too much over {samples} samples every 1000 s"
    ):
        KernelProcess(expression, samples).point_functions(1000.0)


@pytest.mark.slow
@pytest.mark.parametrize("expression", ["linear*linear*linear*linear", "rbf+linear*linear*linear*rq"])
@pytest.mark.parametrize("samples", [3, 10, 30, 60])
@pytest.mark.parametrize("dt_s", [0.1, 1.0, 10.0])
def test_tables_are_finite_over_windows_and_intervals(expression: str, samples: int, dt_s: float) -> None:
    assert np.isfinite(pack_expression(expression, TimeGrid(samples, dt_s), 0.001)).all()


def test_the_expression_is_kept_in_its_canonical_form() -> None:
    model = KernelProcess(" (linear) +( rbf*rq ) ")
    assert model == KernelProcess("linear+rbf*rq")
    assert model.name == "gp(linear+rbf*rq)"
    assert model.payload_layout is None


def test_a_profile_holds_it_and_refuses_what_is_none() -> None:
    model = KernelProcess("linear+rbf*rq", 12, 0.01)
    plain = to_plain(model)
    assert from_plain(plain) == model
    for field, value in (
        ("expression", "linear+"),
        ("expression", "(" * 1000),
        ("expression", 3),
        ("samples", 1_000_000),
        ("noise_floor_m", 0.0),
    ):
        with pytest.raises(FieldError, match=rf"^\$\.{field} must be"):
            from_plain({**plain, field: value})


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_windows_that_are_not_finite_are_refused(value: float) -> None:
    y = tracks(2)
    y[1, 3] = value
    with pytest.raises(ValueError, match="must be finite"):
        fit_kernel("rbf", y, dt_s=DT_S)


def test_hyperparameters_of_another_shape_are_refused() -> None:
    with pytest.raises(ValueError, match=r"hyperparameters must be \(2, 3\), got \(2, 4\)"):
        likelihood_of_kernel("rbf", tracks(2), np.ones((2, 4)), dt_s=DT_S)
