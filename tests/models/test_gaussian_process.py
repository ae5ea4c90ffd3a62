"""The Gaussian process agrees with dense algebra, with scikit-learn and with mpmath."""

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import minimize
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, DotProduct, WhiteKernel

from modelcast.models.base import Windows
from modelcast.models.gp import GaussianProcess, Hyperparameters, fit_axis

DT_S = 0.1
FORMS = ("anchored", "intercept")


def made_windows(count: int, samples: int = 10, *, noise_m: float = 0.02, seed: int = 0) -> np.ndarray:
    """Return turning, braking windows with noise, (B, n, 7)."""
    rng = np.random.default_rng(seed)
    t = (np.arange(samples) - samples + 1) * DT_S
    speed = rng.uniform(0, 30, (count, 1)) + rng.uniform(-4, 4, (count, 1)) * t
    heading = rng.uniform(0, 6, (count, 1)) + rng.uniform(-0.5, 0.5, (count, 1)) * t
    step = np.stack([speed * np.cos(heading), speed * np.sin(heading)], axis=2)
    position = np.cumsum(step, axis=1) * DT_S + noise_m * rng.normal(size=step.shape)
    return np.concatenate([position + 100.0, step, np.zeros((*step.shape[:2], 3))], axis=2)


def times(samples: int, dt_s: float = DT_S) -> np.ndarray:
    return (np.arange(samples) - samples + 1) * dt_s


def dense_terms(form: str, hyper: Hyperparameters, samples: int, dt_s: float = DT_S):
    """Return times, C / s² and the flat directions, (n, 0 or 1)."""
    t = times(samples, dt_s)
    C = np.exp(-0.5 * np.square((t[:, None] - t) / hyper.lengthscale_s))
    C += hyper.noise_ratio * np.eye(samples)
    H = np.ones((samples, int(form == "intercept")))
    centred = t - t.mean() if form == "intercept" else t
    return centred, C + hyper.linear_ratio_per_s2 * np.outer(centred, centred), H


def dense_log_likelihood(y: np.ndarray, form: str, hyper: Hyperparameters) -> float:
    """Return the (restricted) log-likelihood of the columns of y, (n, D)."""
    n, D = y.shape
    _, C, H = dense_terms(form, hyper, n)
    C = hyper.variance_m2 * C
    P = np.linalg.inv(C)
    total = np.linalg.slogdet(C)[1]
    m = n - H.shape[1]
    if m < n:
        o = (H.T @ P @ H).item()
        total += np.log(o)
        P -= P @ H @ H.T @ P / o
    return -0.5 * (np.einsum("jd,jk,kd->", y, P, y) + D * total + m * D * np.log(2 * np.pi))


def dense_prediction(
    y: np.ndarray, form: str, hyper: Hyperparameters, horizons: np.ndarray, dt_s: float = DT_S
) -> tuple[np.ndarray, np.ndarray]:
    """Return mean (H, D) and variance (H,) by dense algebra with generalised least squares."""
    n = len(y)
    t, C, H = dense_terms(form, hyper, n, dt_s)
    shift = times(n, dt_s)[0] - t[0]
    cross = np.exp(-0.5 * np.square((horizons[:, None] - times(n, dt_s)) / hyper.lengthscale_s))
    cross += hyper.linear_ratio_per_s2 * np.outer(horizons - shift, t)
    solved = np.linalg.solve(C, cross.T)
    mean = solved.T @ y
    variance = (
        1 + hyper.linear_ratio_per_s2 * np.square(horizons - shift) - np.einsum("hj,jh->h", cross, solved)
    )
    if H.shape[1]:
        back = np.linalg.solve(C, H)
        o = (H.T @ back).item()
        level = (back.T @ y) / o
        missing = 1 - cross @ back
        mean += missing @ level
        variance += np.square(missing[:, 0]) / o
    return mean, hyper.variance_m2 * variance


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    ("samples", "dt_s"), [(3, 0.1), (5, 0.1), (10, 0.1), (11, 0.05), (20, 0.1), (30, 0.2)]
)
def test_fixed_hyperparameters_equal_dense_algebra(form, samples, dt_s):
    hyper = Hyperparameters(0.7, 1e-3, linear_ratio_per_s2=300.0, variance_m2=2.0)
    model = GaussianProcess(samples, form, hyperparameters=hyper)
    windows = made_windows(4, samples)
    horizons = np.array([0.0, 0.35, 1.0, 2.5, 30.0])
    parameters = model.fit(Windows(windows, dt_s=dt_s))
    assert parameters.shape == (4, len(model.parameter_names))
    found = model.predict(parameters, horizons, dt_s=dt_s)
    covariance = model.covariance(parameters, horizons, dt_s=dt_s)
    for row, window in enumerate(windows[:, :, :2]):
        mean, variance = dense_prediction(window - window[-1], form, hyper, horizons, dt_s)
        np.testing.assert_allclose(found[row], mean, rtol=1e-8, atol=1e-8)
        np.testing.assert_allclose(
            covariance[row], variance[:, None, None] * np.eye(2), rtol=1e-6, atol=1e-10
        )


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("samples", [5, 10, 20, 30])
def test_fitted_parameters_predict_as_dense_algebra_with_the_same_hyperparameters(form, samples):
    windows = made_windows(3, samples)
    model = GaussianProcess(samples, form)
    parameters = model.fit(Windows(windows, dt_s=DT_S))
    horizons = np.array([0.0, 0.3, 2.0])
    found = model.predict(parameters, horizons, dt_s=DT_S)
    covariance = model.covariance(parameters, horizons, dt_s=DT_S)
    for row, window in enumerate(windows[:, :, :2]):
        for axis, name in enumerate(("east", "north")):
            end = f"_{name}" if form == "anchored" else ""
            value = dict(zip(model.parameter_names, parameters[row], strict=True))
            hyper = Hyperparameters(
                value[f"lengthscale{end}_s"],
                value[f"noise_ratio{end}"],
                linear_ratio_per_s2=value[f"linear_ratio{end}_per_s2"],
                variance_m2=value[f"variance{end}_m2"],
            )
            y = (window - window[-1])[:, [axis]]
            mean, variance = dense_prediction(y, form, hyper, horizons)
            np.testing.assert_allclose(found[row, :, axis], mean[:, 0], rtol=1e-5, atol=1e-5)
            np.testing.assert_allclose(covariance[row, :, axis, axis], variance, rtol=1e-3, atol=1e-7)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("floor_m", [0.001, 0.05])
def test_likelihood_equals_dense_algebra_and_is_not_beaten_by_dense_optimisation(form, floor_m):
    y = made_windows(6, noise_m=0.02)[:, :, 0]
    y -= y[:, -1:]
    fits = fit_axis(y, dt_s=DT_S, form=form, noise_floor_m=floor_m)
    assert ((np.sqrt(fits.noise_ratio * fits.variance_m2)) > floor_m * (1 - 1e-9)).all()
    for row in range(len(y)):
        at = np.log(
            [fits.lengthscale_s[row], fits.noise_ratio[row] * fits.variance_m2[row], fits.variance_m2[row]]
        )
        slope_variance = fits.linear_ratio_per_s2[row] * fits.variance_m2[row]

        def cost(theta: np.ndarray, row: int = row) -> float:
            lengthscale, noise, variance, slope = np.exp(theta)
            hyper = Hyperparameters(
                lengthscale, noise / variance, linear_ratio_per_s2=slope / variance, variance_m2=variance
            )
            return -dense_log_likelihood(y[row][:, None], form, hyper)

        start = np.array([*at, np.log(max(slope_variance, 1e-8))])
        assert fits.log_likelihood[row] == pytest.approx(-cost(start), abs=2e-5)
        bounds = [(np.log(0.1), np.log(10)), (np.log(floor_m**2), 0), (np.log(1e-8), np.log(1e8)), (-18, 18)]
        for begin in (start, np.log([1.0, max(1e-3, floor_m**2), 1.0, 100.0])):
            best = minimize(cost, begin, method="L-BFGS-B", bounds=bounds)
            assert fits.log_likelihood[row] >= -best.fun - 1e-3


def exact_prediction(y: np.ndarray, hyper: Hyperparameters, horizon: float) -> float:
    """Return the anchored mean at one horizon, to 60 digits."""
    n = len(y)
    with mpmath.workdps(60):
        a, ell = mpmath.mpf(hyper.linear_ratio_per_s2), mpmath.mpf(hyper.lengthscale_s)
        t = [mpmath.mpf(DT_S) * (j - n + 1) for j in range(n)]
        C = mpmath.matrix(n, n)
        for i in range(n):
            for j in range(n):
                C[i, j] = mpmath.exp(-(((t[i] - t[j]) / ell) ** 2) / 2) + a * t[i] * t[j]
            C[i, i] += mpmath.mpf(hyper.noise_ratio)
        weights = mpmath.lu_solve(C, mpmath.matrix([mpmath.mpf(float(v)) for v in y]))
        cross = [mpmath.exp(-(((horizon - t[j]) / ell) ** 2) / 2) + a * horizon * t[j] for j in range(n)]
        return float(sum(weights[j] * cross[j] for j in range(n)))


@pytest.mark.parametrize("noise_ratio", [1e-10, 1e-7, 1e-3])
def test_fixed_predictions_equal_high_precision(noise_ratio):
    window = np.zeros((1, 10, 7))
    window[0, :, 0] = 20 * np.sin(0.4 * times(10))
    hyper = Hyperparameters(8.0, noise_ratio, linear_ratio_per_s2=1e4)
    model = GaussianProcess(hyperparameters=hyper)
    found = model.predict(model.fit(Windows(window, dt_s=DT_S)), np.array([2.0]), dt_s=DT_S)[0, 0, 0]
    assert found == pytest.approx(exact_prediction(window[0, :, 0], hyper, 2.0), abs=1e-4)


@pytest.mark.parametrize("floor_m", [1e-6, 1e-5, 1e-3])
@pytest.mark.parametrize("samples", [10, 20])
def test_fitted_predictions_equal_high_precision_where_the_noise_vanishes(samples, floor_m):
    window = np.zeros((1, samples, 7))
    window[0, :, 0] = 20 * np.sin(0.4 * times(samples))
    model = GaussianProcess(samples, noise_floor_m=floor_m)
    parameters = model.fit(Windows(window, dt_s=DT_S))
    value = dict(zip(model.parameter_names, parameters[0], strict=True))
    hyper = Hyperparameters(
        value["lengthscale_east_s"],
        value["noise_ratio_east"],
        linear_ratio_per_s2=value["linear_ratio_east_per_s2"],
    )
    found = model.predict(parameters, np.array([2.0]), dt_s=DT_S)[0, 0, 0]
    assert found == pytest.approx(exact_prediction(window[0, :, 0], hyper, 2.0), abs=1e-4)


@pytest.mark.parametrize("form", FORMS)
def test_a_batch_equals_its_windows_one_by_one(form):
    windows = made_windows(7)
    model = GaussianProcess(form=form)
    together = model.fit(Windows(windows, dt_s=DT_S))
    alone = np.concatenate([model.fit(Windows(windows[[row]], dt_s=DT_S)) for row in range(7)])
    np.testing.assert_array_equal(together, alone)


def turned(windows: np.ndarray, angle: float) -> np.ndarray:
    rotation = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    parts = [windows[..., :2] @ rotation, windows[..., 2:4] @ rotation, windows[..., 4:]]
    return np.concatenate(parts, axis=2)


@pytest.mark.parametrize("form", FORMS)
def test_a_shift_of_the_frame_changes_nothing(form):
    model = GaussianProcess(form=form)
    windows = made_windows(5)
    moved = windows + np.array([300.0, -700.0, *np.zeros(5)])
    h = np.array([0.0, 1.0, 3.0])
    one, two = (model.predict(model.fit(Windows(w, dt_s=DT_S)), h, dt_s=DT_S) for w in (windows, moved))
    np.testing.assert_allclose(one, two, atol=1e-4)


def test_a_turn_of_the_frame_turns_the_joint_fit_but_changes_the_anchored_one():
    windows = made_windows(5)
    h = np.array([0.0, 1.0, 3.0])
    worst = {}
    for form in FORMS:
        model = GaussianProcess(form=form)
        one = model.predict(model.fit(Windows(windows, dt_s=DT_S)), h, dt_s=DT_S)
        two = model.predict(model.fit(Windows(turned(windows, 0.7), dt_s=DT_S)), h, dt_s=DT_S)
        rotation = np.array([[np.cos(0.7), np.sin(0.7)], [-np.sin(0.7), np.cos(0.7)]])
        worst[form] = np.abs(one @ rotation - two).max()
    assert worst["intercept"] < 1e-4
    assert worst["anchored"] > 1e-2


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("speed_mps", [0.0, 1e-3, 25.0])
def test_a_noise_free_line_is_continued(form, speed_mps):
    windows = np.zeros((1, 10, 7))
    windows[0, :, 0] = speed_mps * times(10)
    windows[0, :, 1] = -2 * speed_mps * times(10)
    model = GaussianProcess(form=form)
    parameters = model.fit(Windows(windows, dt_s=DT_S))
    h = np.array([0.0, 1.0, 10.0])
    found = model.predict(parameters, h, dt_s=DT_S)[0]
    # A slope within the noise floor is shrunk; one well above it is not.
    tolerance = 1e-2 * np.maximum(h, 0.1)
    assert (np.abs(found[:, 0] - speed_mps * h) < tolerance).all()
    floors = [at for at, name in enumerate(model.parameter_names) if name.startswith("floored")]
    assert (parameters[0, floors] == 1.0).all()


def test_prediction_is_continuous_and_ends_in_the_line():
    model = GaussianProcess(form="intercept")
    parameters = model.fit(Windows(made_windows(20), dt_s=DT_S))
    h = np.linspace(0, 200, 400_001)
    path = model.predict(parameters, h, dt_s=DT_S)
    line = parameters[:, None, :2] + parameters[:, None, 2:4] * h[[-1], None]
    np.testing.assert_allclose(path[:, -1:], line, atol=1e-9)
    assert np.abs(np.diff(path, n=2, axis=1)).max() < 1e-3


@settings(derandomize=True, max_examples=60, deadline=None)
@given(
    arrays(np.float64, (10, 2), elements=st.floats(-1e4, 1e4)),
    st.sampled_from(FORMS),
    st.sampled_from([1e-3, 1.0]),
)
def test_any_finite_window_gives_finite_numbers(position, form, scale):
    window = np.zeros((1, 10, 7))
    window[0, :, :2] = position * scale
    model = GaussianProcess(form=form)
    parameters = model.fit(Windows(window, dt_s=DT_S))
    h = np.array([0.0, 0.1, 1.0, 30.0])
    assert np.isfinite(parameters).all()
    assert np.isfinite(model.predict(parameters, h, dt_s=DT_S)).all()
    assert np.isfinite(model.covariance(parameters, h, dt_s=DT_S)).all()


@pytest.mark.parametrize(
    "wrong",
    [{"samples": 2}, {"samples": 61}, {"noise_floor_m": 0.0}, {"noise_floor_m": 2.0}, {"form": "other"}],
)
def test_a_field_outside_its_bounds_is_refused(wrong):
    with pytest.raises(ValueError, match="must"):
        GaussianProcess(**wrong)


def test_a_hyperparameter_outside_its_bounds_is_refused():
    with pytest.raises(ValueError, match=r"lengthscale_s must be a number from 0\.05"):
        Hyperparameters(0.0, 1e-3, linear_ratio_per_s2=1.0)


@pytest.mark.real
def test_predictions_on_real_windows_equal_scikit_learn(data_folder):
    path = min((data_folder / "openacc_zalazone").glob("*.csv"))
    track = np.genfromtxt(path, delimiter=",", skip_header=6, usecols=(2, 3))[:400]
    windows = np.lib.stride_tricks.sliding_window_view(track, 10, axis=0).transpose(0, 2, 1)[::20]
    windows = windows[np.isfinite(windows).all(axis=(1, 2))]
    h = np.array([0.0, 0.5, 1.0, 2.0])
    fits = fit_axis(windows[:, :, 0], dt_s=DT_S)
    full = np.concatenate([windows, np.zeros((*windows.shape[:2], 5))], axis=2)
    model = GaussianProcess()
    found = model.predict(model.fit(Windows(full, dt_s=DT_S)), h, dt_s=DT_S)[:, :, 0]
    for row, window in enumerate(windows[:, :, 0]):
        s, b, a = fits.variance_m2[row], fits.noise_ratio[row], fits.linear_ratio_per_s2[row]
        kernel = ConstantKernel(s) * RBF(fits.lengthscale_s[row])
        if a > 0:
            kernel += ConstantKernel(s * a) * DotProduct(0, "fixed")
        kernel += WhiteKernel(s * b)
        peer = GaussianProcessRegressor(kernel, alpha=0, optimizer=None)
        peer.fit(times(10)[:, None], window - window[-1])
        np.testing.assert_allclose(found[row], peer.predict(h[:, None]), atol=1e-4)
