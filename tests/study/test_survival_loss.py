"""Claims about the loss that the learned sub-model is trained on."""

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.study.training.survival_kernels import FORGIVEN_S, survival_slopes

HORIZONS_S = np.arange(1, 41) * 0.1
STEPS_S = np.full(40, 0.1)
BASIS = np.vander(HORIZONS_S / 4.0, 3, increasing=True)


def loss(coefficients: FloatArray, errors_m: FloatArray, softness: float) -> tuple[float, FloatArray]:
    slopes = np.empty_like(coefficients)
    found = survival_slopes(coefficients, errors_m, BASIS, STEPS_S, np.array([0.2, 0.5]), softness, slopes)
    return found, slopes


def batch() -> tuple[FloatArray, FloatArray]:
    rng = np.random.default_rng(4)
    errors_m = rng.normal(0.0, 0.05, (6, 40, 2)).cumsum(axis=1)
    return rng.normal(0.0, 0.1, (6, 6)), errors_m


def test_slopes_are_those_of_finite_differences() -> None:
    coefficients, errors_m = batch()
    _, slopes = loss(coefficients, errors_m, 0.25)
    step = 1e-6
    for row in range(6):
        for column in range(6):
            ends: list[float] = []
            for sign in (1.0, -1.0):
                moved = coefficients.copy()
                moved[row, column] += sign * step
                ends.append(6.0 * loss(moved, errors_m, 0.25)[0])
            assert slopes[row, column] == pytest.approx((ends[0] - ends[1]) / (2 * step), abs=2e-5)


def test_a_sharp_step_counts_the_time_until_the_threshold_is_crossed() -> None:
    """An error of 0.1·t along reaches 0.2 m after 2 s and 0.5 m never, of 4 s."""
    errors_m = np.zeros((1, 40, 2))
    errors_m[0, :, 0] = 0.1 * HORIZONS_S
    found, _ = loss(np.zeros((1, 6)), errors_m, 1e-3)
    assert found == pytest.approx(-0.5 * (np.log(1.95 + FORGIVEN_S) + np.log(4.0 + FORGIVEN_S)), abs=0.02)


def test_an_error_no_threshold_forgives_has_no_slope() -> None:
    errors_m = np.full((1, 40, 2), 50.0)
    _, slopes = loss(np.zeros((1, 6)), errors_m, 0.25)
    assert np.abs(slopes).max() < 1e-12


def test_an_error_that_has_come_and_gone_counts_as_failed() -> None:
    errors_m = np.zeros((2, 40, 2))
    errors_m[:, 5, 1] = 3.0
    errors_m[1, 6:, 1] = 3.0
    (gone,), (stayed,) = ([loss(np.zeros((1, 6)), errors_m[row : row + 1], 0.25)[0]] for row in range(2))
    assert gone == stayed
