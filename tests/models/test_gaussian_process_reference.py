"""Predictions are those of the same Gaussian process in dense algebra, at equal hyper-parameters.

b is the relative noise variance, a the relative linear amplitude, both as fitted or given.

- Every real window of the OpenACC trips (no stride, both forms) agrees with extended precision to 1e-6 m up
  to 2 s, and to 1e-8 relative up to 5 s where b >= 1e-5 and a <= 1e3. So does scikit-learn, to 1e-4 m and
  1e-8, on windows of every trip and on the worst conditioned ones. It knows no flat prior and judges the
  anchored form only.
- Fixed hyper-parameters with b >= 1e-5 and a <= 1e3 agree with mpmath to 1e-8 relative for any window.
  scikit-learn's predictions agree to 1e-8 or its own rounding, whichever is larger: up to 3e-6 for ten
  samples at b = 1e-5 and a = 1e3.
- Elsewhere, b down to 1e-12, a up to 1e8 and 30 s ahead, tracks with up to 1 cm of noise agree with mpmath
  to 1e-4 m. Where noise is far above what b allows for, the payload's doubles are the limit: with 10 cm at
  b = 1e-12 it holds weights of 1e11 m, and the error is 2e-4 m.

"Relative" is to the larger of the displacement predicted on that axis and the largest in its window, because
a prediction near zero is the difference of terms as large as the data; of real windows also to the fit's
noise floor of 1 mm, below which the coordinates of a parked car are only rounding.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, DotProduct, Kernel, WhiteKernel

from modelcast.io.trips import read_trips
from modelcast.models.base import Windows
from modelcast.models.gp import GaussianProcess, Hyperparameters
from modelcast.models.point_kernels import SAMPLE_COLUMNS

DT_S = 0.1
SAMPLES = 10
FORMS = ("anchored", "intercept")
HORIZONS_S = np.array([0.0, 0.1, 0.5, 1.0, 2.0, 3.5, 5.0])
UP_TO_2_S = HORIZONS_S <= 2.0
FAR_S = np.array([0.0, 2.0, 5.0, 30.0])
DIGITS = 50
CHUNK = 4096

CLAIM_M = 1e-4
"""Far below any position that is measured or sent."""
EXACT_M = 1e-6
"""Forty times the worst real window, so that a loss of accuracy shows long before it matters."""
REFERENCE_M = 1e-7
"""A tenth of what extended precision judges; it is off by 4e-9 m where the noise is least."""
CLAIM_RELATIVE = 1e-8
PEER_ROUNDING = 200 * np.finfo(np.float64).eps
"""Rounding of scikit-learn's dense algebra over the condition number: 45 eps at worst in 600,000 windows."""
NOISE_FLOOR_M = 1e-3
"""The models' default."""
SECOND_ORDER = 0.02
"""What is left of the next term in one over the constant's variance: 8e-4 at worst, so with room."""

extended = pytest.mark.skipif(
    np.finfo(np.longdouble).eps > 1e-18, reason="no floating point wider than a double here"
)


def dense(
    y: np.ndarray, hyper: tuple, horizons_s: np.ndarray, form: str, number: Callable[[Any], Any]
) -> np.ndarray:
    """Mean of B processes by elimination on their covariances, y (n, D, B) to (H, D, B).

    ``number`` makes scalars or arrays of the arithmetic; ``hyper`` is lengthscale, b and a, (B,) each.
    """
    exp = np.exp if number is np.longdouble else np.frompyfunc(mpmath.exp, 1, 1)
    y, (ell, b, a) = number(y), map(number, hyper)
    n, D, B = y.shape
    steps = number(np.arange(n, dtype=float))
    t = (steps - steps[-1]) * number(np.array(DT_S))
    middle = (t[0] + t[-1]) / 2 if form == "intercept" else 0 * t[0]
    covariance = exp(-(((t[:, None, None] - t[:, None]) / ell) ** 2) / 2)
    covariance = covariance + a * ((t - middle)[:, None] * (t - middle))[..., None]
    covariance[range(n), range(n)] += b
    solved = np.concatenate([y, number(np.ones((n, 1, B)))], axis=1)
    for j in range(n):
        share = covariance[j + 1 :, j] / covariance[j, j]
        covariance[j + 1 :, j:] -= share[:, None] * covariance[j, j:]
        solved[j + 1 :] -= share[:, None] * solved[j]
    for j in reversed(range(n)):
        solved[j] /= covariance[j, j]
        solved[:j] -= covariance[:j, j][:, None] * solved[j]
    dual, ones = solved[:, :D], solved[:, D:]
    level = number(np.zeros((D, B)))
    if form == "intercept":
        level = dual.sum(axis=0) / ones.sum(axis=0)
        dual = dual - ones * level
    h = number(horizons_s)[:, None, None]
    cross = exp(-(((h - t[:, None]) / ell) ** 2) / 2) + a * (h - middle) * (t - middle)[:, None]
    return level + np.stack([(row[:, None] * dual).sum(axis=0) for row in cross])


def exact(window: np.ndarray, hyper: tuple, horizons_s: np.ndarray, form: str) -> np.ndarray:
    """Mean of one window (n, D) to 50 digits, (H, D)."""
    number = np.frompyfunc(mpmath.mpf, 1, 1)
    with mpmath.workdps(DIGITS):
        y = number(window) - number(window[-1])
        found = dense(y[..., None], np.array(hyper)[:, None], horizons_s, form, number)
        return found[..., 0].astype(float)


def peer(y: np.ndarray, hyper: tuple, *, variance: float = 1.0, prior: Kernel | None = None, middle_s=0.0):
    """Return scikit-learn's predictor of the columns of y (n, D), times measured from ``middle_s``."""
    ell, b, a = hyper
    kernel = ConstantKernel(variance) * RBF(ell) + WhiteKernel(variance * b)
    if a > 0:
        kernel += ConstantKernel(variance * a) * DotProduct(0, "fixed")
    if prior is not None:
        kernel += prior
    times = (np.arange(len(y)) - len(y) + 1) * DT_S
    fitted = GaussianProcessRegressor(kernel, alpha=0, optimizer=None).fit((times - middle_s)[:, None], y)
    return lambda horizons_s: fitted.predict((horizons_s - middle_s)[:, None])


def predictions(model: GaussianProcess, windows: np.ndarray, horizons_s: np.ndarray):
    """Return parameters by name and predictions (B, H, 2) for windows of positions (B, n, 2)."""
    full = np.zeros((*windows.shape[:2], SAMPLE_COLUMNS))
    full[..., :2] = windows
    parameters = model.fit(Windows(full, dt_s=DT_S))
    named = dict(zip(model.parameter_names, parameters.T, strict=True))
    return named, model.predict(parameters, horizons_s, dt_s=DT_S)


def hyper_of(named: dict[str, np.ndarray], form: str, axis: str) -> tuple:
    end = f"_{axis}" if form == "anchored" else ""
    return named[f"lengthscale{end}_s"], named[f"noise_ratio{end}"], named[f"linear_ratio{end}_per_s2"]


def scale_m(found: np.ndarray, windows: np.ndarray) -> np.ndarray:
    """What "relative" is relative to, for predictions (..., H, D) from windows (..., n, D)."""
    data = np.abs(windows - windows[..., -1:, :]).max(axis=-2)
    return np.maximum(np.abs(found), data[..., None, :])


class RealFits(NamedTuple):
    """Fits of all real windows by one form: the axes have an entry each in ``hyper`` and ``variance``."""

    form: str
    windows: np.ndarray
    trip: np.ndarray
    hyper: tuple[tuple, tuple]
    variance: tuple[np.ndarray, np.ndarray]
    found: np.ndarray

    def mild(self, axis: int) -> np.ndarray:
        """Which windows the relative claim speaks of, (B,)."""
        _, b, a = self.hyper[axis]
        return (b >= 1e-5) & (a <= 1e3)


@pytest.fixture(scope="module", name="real_windows")
def _real_windows(data_folder) -> tuple[np.ndarray, np.ndarray]:
    windows, trips = [], []
    for at, trip in enumerate(read_trips(data_folder / "openacc_zalazone")):
        assert round(trip.dt_s, 6) == DT_S
        for first, end in zip(trip.segments[:-1], trip.segments[1:], strict=True):
            if end - first >= SAMPLES:
                part = np.lib.stride_tricks.sliding_window_view(trip.position_m[first:end], SAMPLES, axis=0)
                windows.append(part.transpose(0, 2, 1))
                trips.append(np.full(len(part), at))
    return np.concatenate(windows), np.concatenate(trips)


@pytest.fixture(scope="module", params=FORMS, name="real")
def _real(request, real_windows) -> RealFits:
    windows, trip = real_windows
    form = request.param
    named, found = predictions(GaussianProcess(form=form), windows, HORIZONS_S)
    ends = ("_east", "_north") if form == "anchored" else ("", "")
    hyper = (hyper_of(named, form, "east"), hyper_of(named, form, "north"))
    variance = (named[f"variance{ends[0]}_m2"], named[f"variance{ends[1]}_m2"])
    return RealFits(form, windows, trip, hyper, variance, found)


def in_extended_precision(real: RealFits, rows: np.ndarray, axis: int) -> np.ndarray:
    """Reference of one axis, (B, H)."""
    y = real.windows[rows, :, axis].T.astype(np.longdouble)
    hyper = tuple(part[rows] for part in real.hyper[axis])
    return dense((y - y[-1])[:, None], hyper, HORIZONS_S, real.form, np.longdouble)[:, 0].T


@pytest.mark.slow
@pytest.mark.real
@extended
def test_all_real_windows_equal_extended_precision(real):
    """Measured: 3e-9 m anchored, 2e-8 m intercept; relative, where claimed, 1e-11 and 8e-11."""
    count = len(real.windows)
    assert count > 75_000
    for axis in range(2):
        for first in range(0, count, CHUNK):
            rows = np.arange(first, min(first + CHUNK, count))
            found = real.found[rows, :, axis]
            error = np.abs(found - in_extended_precision(real, rows, axis))
            assert error[:, UP_TO_2_S].max() < EXACT_M
            scale = np.maximum(scale_m(found[..., None], real.windows[rows, :, axis, None]), NOISE_FLOOR_M)
            mild = real.mild(axis)[rows]
            assert (error <= CLAIM_RELATIVE * scale[..., 0])[mild].all()


@pytest.mark.slow
@pytest.mark.real
@extended
def test_extended_precision_and_fits_equal_mpmath_where_real_noise_is_least(real):
    for axis in range(2):
        rows = np.argsort(real.hyper[axis][1])[:10]
        reference = in_extended_precision(real, rows, axis).astype(float)
        for at, row in enumerate(rows):
            hyper = tuple(part[row] for part in real.hyper[axis])
            truth = exact(real.windows[row, :, [axis]].T, hyper, HORIZONS_S, real.form)[:, 0]
            np.testing.assert_allclose(reference[at], truth, rtol=0, atol=REFERENCE_M)
            np.testing.assert_allclose(real.found[row, :, axis], truth, rtol=0, atol=EXACT_M)


@pytest.mark.real
@pytest.mark.parametrize("real", ["anchored"], indirect=True)
def test_real_windows_equal_scikit_learn(real):
    """Five windows an axis of every trip, and the hundred of least noise, where both round most."""
    rng = np.random.default_rng(5)
    for axis in range(2):
        spread = [rng.choice(np.flatnonzero(real.trip == k), 5) for k in range(real.trip[-1] + 1)]
        rows = np.concatenate([*spread, np.argsort(real.hyper[axis][1])[:100]])
        mild = real.mild(axis)
        assert mild[rows].sum() > 10
        for row in rows:
            y = real.windows[row, :, [axis]].T
            hyper = tuple(part[row] for part in real.hyper[axis])
            found = real.found[row, :, [axis]].T
            other = peer(y - y[-1], hyper, variance=real.variance[axis][row])(HORIZONS_S)
            error = np.abs(found[:, 0] - other)
            assert error[UP_TO_2_S].max() < CLAIM_M
            scale = np.maximum(scale_m(found, y), NOISE_FLOOR_M)[:, 0]
            assert not mild[row] or (error <= CLAIM_RELATIVE * scale).all()


def logarithmic(low: float, high: float) -> st.SearchStrategy[float]:
    """Powers of ten between two exponents, the lowest and the highest often."""
    return st.sampled_from([low, high]).map(lambda at: 10.0**at) | st.floats(low, high).map(
        lambda at: 10.0**at
    )


def normal(samples: int) -> st.SearchStrategy[np.ndarray]:
    """Normal numbers without any order, (n, 2): the hardest windows for rounding."""
    return st.integers(0, 2**32 - 1).map(lambda seed: np.random.default_rng(seed).normal(size=(samples, 2)))


def any_window(samples: int) -> st.SearchStrategy[np.ndarray]:
    """Positions of any kind, (n, 2)."""
    return normal(samples) | arrays(
        np.float64, (samples, 2), elements=st.floats(-100, 100, allow_subnormal=False)
    )


MILD = st.tuples(logarithmic(-1, 1), logarithmic(-5, 0), st.just(0.0) | logarithmic(-3, 3))
WILD = st.tuples(logarithmic(-1, 1), logarithmic(-12, 0), st.just(0.0) | logarithmic(-3, 8))
ANY_WINDOW = st.sampled_from([3, SAMPLES, 20]).flatmap(any_window)


def fixed(window: np.ndarray, hyper: tuple, horizons_s: np.ndarray, form: str) -> np.ndarray:
    """Prediction of one window with fixed hyper-parameters, (H, 2)."""
    ell, b, a = hyper
    given_ones = Hyperparameters(ell, b, linear_ratio_per_s2=a)
    model = GaussianProcess(len(window), form, hyperparameters=given_ones)
    return predictions(model, window[None], horizons_s)[1][0]


@settings(max_examples=100)
@given(ANY_WINDOW, MILD, st.sampled_from(FORMS))
def test_any_window_equals_mpmath_where_the_noise_is_not_small(window, hyper, form):
    """Measured: 1e-10 relative."""
    found = fixed(window, hyper, HORIZONS_S, form)
    truth = exact(window, hyper, HORIZONS_S, form)
    assert (np.abs(found - truth) <= CLAIM_RELATIVE * scale_m(truth, window)).all()


@settings(max_examples=150)
@given(ANY_WINDOW, MILD)
def test_any_window_equals_scikit_learn_up_to_its_rounding(window, hyper):
    """The difference is scikit-learn's: the test above holds for the same windows."""
    found = fixed(window, hyper, HORIZONS_S, "anchored")
    other = peer(window - window[-1], hyper)(HORIZONS_S)
    _, b, a = hyper
    times = np.arange(len(window)) * DT_S
    condition = (len(window) + a * np.square(times).sum()) / b + 1
    tolerance = max(CLAIM_RELATIVE, PEER_ROUNDING * condition)
    assert (np.abs(found - other) <= tolerance * scale_m(found, window)).all()


def test_the_flat_prior_is_the_limit_of_scikit_learns_wide_constant():
    """The difference falls as the constant's variance rises, tenfold for tenfold."""
    hyper = (1.5, 1e-2, 30.0)
    window = track(12.0, 0.3, 2.0)
    found = fixed(window, hyper, HORIZONS_S, "intercept")
    middle_s = -0.5 * (SAMPLES - 1) * DT_S
    worst = []
    for variance in (1e3, 1e4, 1e5):
        wide = peer(window - window[-1], hyper, prior=ConstantKernel(variance), middle_s=middle_s)
        worst.append(np.abs(wide(HORIZONS_S) - found).max())
    np.testing.assert_allclose(np.divide(worst[:-1], worst[1:]), 10.0, rtol=SECOND_ORDER)


def track(speed_mps: float, turn_radps: float, acceleration_mps2: float, samples: int = SAMPLES):
    """Positions of a car that turns and brakes, (n, 2)."""
    t = (np.arange(samples) - samples + 1) * DT_S
    along = speed_mps * t + acceleration_mps2 * t**2 / 2
    return np.stack([along * np.cos(turn_radps * t), along * np.sin(turn_radps * t)], axis=1)


TRACKS = st.builds(track, st.floats(0, 40), st.floats(-0.5, 0.5), st.floats(-8, 4))
NOISE_M = st.builds(np.multiply, st.sampled_from([0.0, 1e-3, 1e-2]), normal(SAMPLES))


@settings(max_examples=150)
@given(TRACKS, NOISE_M, WILD, st.sampled_from(FORMS))
def test_tracks_equal_mpmath_at_any_hyperparameters(smooth, noise, hyper, form):
    """Measured: 2e-5 m; without noise 1e-6 m."""
    found = fixed(smooth + noise, hyper, FAR_S, form)
    np.testing.assert_allclose(found, exact(smooth + noise, hyper, FAR_S, form), rtol=0, atol=CLAIM_M)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("floor_m", [1e-6, 1e-3])
@pytest.mark.parametrize("samples", [5, SAMPLES, 20])
def test_fitted_tracks_equal_mpmath_far_ahead(samples, floor_m, form):
    """With a floor of 1e-6 m the fits go down to the search's bound, b = 1e-14. Measured: 4e-7 m."""
    rng = np.random.default_rng(samples)
    noise = [0.0, 1e-6, 1e-3, 1e-2]
    windows = np.array([track(30.0, 0.2, -3.0, samples) + s * rng.normal(size=(samples, 2)) for s in noise])
    named, found = predictions(GaussianProcess(samples, form, noise_floor_m=floor_m), windows, FAR_S)
    for axis, name in enumerate(("east", "north")):
        for row, window in enumerate(windows):
            hyper = tuple(part[row] for part in hyper_of(named, form, name))
            truth = exact(window[:, [axis]], hyper, FAR_S, form)[:, 0]
            np.testing.assert_allclose(found[row, :, axis], truth, rtol=0, atol=EXACT_M)
