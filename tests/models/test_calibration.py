"""Claims about calibrated covariances and the time until a threshold."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from modelcast.core.arrays import FloatArray
from modelcast.models.calibration import LEVELS, Calibration, course_axes, gaussian_radius
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.models.kinematic import ConstantTurnRateVelocity
from modelcast.models.threshold_time import expected_time_to_threshold, hold_chance

DRAWS = 400_000
SAMPLING = 4.0 * 0.5 / DRAWS**0.5
"""Four standard errors of a share."""

HORIZONS_S = np.array([0.5, 1.0, 2.0])
TABLE = Calibration(
    "ctrv",
    HORIZONS_S,
    unmodelled=0.3,
    factors=np.array([[2.0, 0.5], [1.5, 0.7], [1.0, 1.0]]),
    radii=np.array([[0.5, 2.146, 4.0], [0.8, 2.146, 3.0], [1.177, 2.146, 2.448]]),
    instants=99,
)


def drawn(covariance: FloatArray) -> FloatArray:
    return np.random.default_rng(1).multivariate_normal(np.zeros(2), covariance, DRAWS)


@pytest.mark.parametrize(
    "covariance",
    [np.diag([1.0, 1.0]), np.diag([4.0, 0.01]), np.array([[2.0, 1.2], [1.2, 1.0]]), np.diag([1.0, 0.0])],
)
@pytest.mark.parametrize("threshold_m", [0.1, 0.7, 2.5])
def test_the_chance_to_hold_is_the_share_of_draws(covariance: FloatArray, threshold_m: float) -> None:
    errors = drawn(covariance)
    share = (np.hypot(errors[:, 0], errors[:, 1]) < threshold_m).mean()
    assert abs(hold_chance(covariance, threshold_m) - share) < SAMPLING


@given(
    large=st.floats(0.05, 5.0),
    ratio=st.floats(1 / 30, 1.0),
    angle=st.floats(0.0, 3.2),
    radius=st.floats(0.05, 9),
)
def test_the_chance_to_hold_is_the_integral_of_the_density(
    large: float, ratio: float, angle: float, radius: float
) -> None:
    """Along the radius in closed form, over the direction by adaptive quadrature."""
    small = ratio * large
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    covariance = turn @ np.diag([large**2, small**2]) @ turn.T

    def ring(direction: float) -> float:
        weight = (np.cos(direction) / large) ** 2 + (np.sin(direction) / small) ** 2
        return -np.expm1(-0.5 * radius**2 * weight) / weight

    exact = 4 * quad(ring, 0.0, np.pi / 2, limit=200)[0] / (2 * np.pi * large * small)
    assert hold_chance(covariance, radius) == pytest.approx(exact, abs=1e-4)


def test_of_a_round_covariance_the_chance_is_the_rayleigh_distribution() -> None:
    radii = gaussian_radius(LEVELS)
    chances = [float(hold_chance(0.25 * np.eye(2), 0.5 * radius)) for radius in radii]
    assert chances == pytest.approx(list(LEVELS), abs=1e-12)


def test_a_covariance_of_zero_holds_for_certain() -> None:
    assert hold_chance(np.zeros((3, 2, 2)), 0.1).tolist() == [1.0, 1.0, 1.0]


def test_expected_time_is_the_mean_over_draws_that_grow_with_the_square_of_time() -> None:
    """Errors ``a·h²/2`` keep their direction: who is out stays out."""
    horizons_s = np.arange(1, 501) * 0.01
    spread = np.array([[1.0, 0.3], [0.3, 0.4]])
    covariances = (0.25 * horizons_s**4)[:, None, None] * spread
    acceleration = np.hypot(*drawn(spread).T)
    crossed_s = np.minimum(np.sqrt(2 * 0.5 / acceleration), 5.0)
    expected = expected_time_to_threshold(covariances[None], horizons_s, 0.5)[0]
    assert expected == pytest.approx(crossed_s.mean(), abs=5.0 * crossed_s.std() / DRAWS**0.5 + 1e-4)


def test_expected_time_falls_with_the_spread_and_rises_with_the_threshold() -> None:
    horizons_s = np.arange(1, 26) * 0.2
    covariances = np.stack([(a * horizons_s**2)[:, None, None] ** 2 * np.eye(2) for a in (0.1, 0.5, 2.0)])
    times = [expected_time_to_threshold(covariances, horizons_s, th) for th in (0.2, 0.5)]
    assert (np.diff(times[0]) < 0).all()
    assert (times[1] > times[0]).all()
    assert (times[1] < horizons_s[-1]).all()


def test_gaussian_radii_change_no_expected_time() -> None:
    horizons_s = np.arange(1, 26) * 0.2
    covariances = (0.3 * horizons_s**2)[None, :, None, None] ** 2 * np.diag([1.0, 0.2])
    radii = np.tile(gaussian_radius(LEVELS), (25, 1))
    same = expected_time_to_threshold(covariances, horizons_s, 0.4, radii=radii)
    assert np.array_equal(same, expected_time_to_threshold(covariances, horizons_s, 0.4))


def test_a_narrow_middle_makes_the_expected_time_longer() -> None:
    horizons_s = np.arange(1, 26) * 0.2
    covariances = (0.3 * horizons_s**2)[None, :, None, None] ** 2 * np.eye(2)
    radii = np.tile([0.3, 2.146, 4.0], (25, 1))
    narrow = expected_time_to_threshold(covariances, horizons_s, 0.2, radii=radii)
    assert narrow > expected_time_to_threshold(covariances, horizons_s, 0.2)


@pytest.mark.parametrize(
    ("shape", "horizons_s", "threshold_m", "named"),
    [
        ((2, 3, 2, 2), [1.0, 2.0], 0.2, "covariances_m2"),
        ((2, 2, 2, 2), [2.0, 1.0], 0.2, "horizons_s"),
        ((2, 2, 2, 2), [0.0, 1.0], 0.2, "horizons_s"),
        ((2, 2, 2, 2), [1.0, 2.0], 0.0, "threshold_m"),
    ],
)
def test_impossible_questions_are_refused(
    shape: tuple[int, ...], horizons_s: list[float], threshold_m: float, named: str
) -> None:
    with pytest.raises(ValueError, match=named):
        expected_time_to_threshold(np.zeros(shape), np.array(horizons_s), threshold_m)


def test_radii_of_another_length_are_refused() -> None:
    with pytest.raises(ValueError, match="radii"):
        expected_time_to_threshold(np.zeros((1, 2, 2, 2)), np.array([1.0, 2.0]), 0.2, radii=np.ones((2, 2)))


def test_calibration_scales_along_and_across_the_predicted_course() -> None:
    model = ConstantTurnRateVelocity()
    parameters = np.array([[9.0, 12.0, 0.1], [0.0, -5.0, -0.3]])
    ages_s = np.array([0.5, 1.0, 2.0])
    axes = course_axes(model.predict(parameters, ages_s, dt_s=0.1))
    turned = axes @ TABLE.covariance(model, parameters, ages_s, dt_s=0.1) @ axes.swapaxes(-1, -2)
    nominal = axes @ model.covariance(parameters, ages_s, dt_s=0.1) @ axes.swapaxes(-1, -2)
    extra = 0.001**2 + (0.3 * (0.02 + 0.05 * ages_s)) ** 2
    for axis in range(2):
        wanted = TABLE.factors[:, axis] ** 2 * (nominal[:, :, axis, axis] + extra)
        assert turned[:, :, axis, axis] == pytest.approx(wanted)


def test_between_horizons_factors_lie_between_and_beyond_them_stay() -> None:
    base = np.zeros((1, 4, 2, 2))
    ages_s = np.array([0.1, 0.5, 2.0, 60.0])
    table = replace(TABLE, unmodelled=0.0)
    along = np.sqrt(table.scaled(base, ages_s)[0, :, 0, 0]) / 0.001
    assert along == pytest.approx([2.0, 2.0, 1.0, 1.0])
    middle = np.sqrt(table.scaled(base[:, :1], np.array([0.7]))[0, 0, 0, 0]) / 0.001
    assert 1.5 < middle < 2.0


def test_calibrated_covariances_are_symmetric_and_positive() -> None:
    model = GaussianProcess(form="anchored")
    rng = np.random.default_rng(2)
    parameters = np.abs(rng.normal(1.0, 0.3, (5, len(model.parameter_names))))
    table = replace(TABLE, sub_model="gp-anchored")
    covariance = table.covariance(model, parameters, np.array([0.1, 3.0]), dt_s=0.1)
    assert np.array_equal(covariance, covariance.swapaxes(-1, -2))
    assert np.linalg.eigvalsh(covariance).min() > 0


def test_the_radius_rises_with_the_level_and_meets_the_learnt_ones() -> None:
    for level, column in zip(LEVELS, TABLE.radii.T, strict=True):
        assert TABLE.radius(level, HORIZONS_S) == pytest.approx(column)
    rising = np.stack([TABLE.radius(level, HORIZONS_S) for level in (0.0, 0.2, 0.5, 0.8, 0.9, 0.97, 0.999)])
    assert (np.diff(rising, axis=0) > 0).all()


def test_plain_values_make_the_same_calibration() -> None:
    plain = json.loads(json.dumps(TABLE.as_plain()))
    again = Calibration.from_plain(plain)
    assert again.as_plain() == TABLE.as_plain()


def test_another_sub_model_is_refused() -> None:
    with pytest.raises(ValueError, match="is for ctrv, not for cv"):
        TABLE.covariance(ConstantVelocity(), np.zeros((1, 2)), HORIZONS_S, dt_s=0.1)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"horizons_s": np.array([1.0, 0.5, 2.0])}, "rise"),
        ({"factors": np.ones((2, 2))}, "factors must be"),
        ({"factors": np.zeros((3, 2))}, r"factors\[0\]\[0\] must be a number from 1e-06"),
        ({"radii": np.array([[2.0, 1.0, 3.0]] * 3)}, "fall"),
    ],
)
def test_impossible_tables_are_refused(change: dict[str, FloatArray], named: str) -> None:
    with pytest.raises(ValueError, match=named):
        replace(TABLE, **change)
