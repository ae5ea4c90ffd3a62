"""Claims about the loss that the networks of sub-models are trained on."""

from functools import partial
from typing import Any

import jax
import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.study.training.survival import FORGIVEN_S, survival_cost

HORIZONS_S = np.arange(1, 41) * 0.1
STEPS_S = np.full(40, 0.1)
KNOWN = np.ones((1, 40))


@partial(jax.jit, static_argnames="softness")
def compiled_cost(off_m: Any, known: Any, *, softness: float) -> Any:
    return survival_cost(off_m, known, STEPS_S, thresholds_m=(0.2, 0.5), softness=softness)


def cost(off_m: FloatArray, softness: float, known: FloatArray = KNOWN) -> float:
    return float(compiled_cost(off_m, known, softness=softness))


@partial(jax.jit, static_argnames="softness")
def compiled_slopes(off_m: Any, *, softness: float) -> Any:
    grad: Any = jax.grad
    return grad(partial(compiled_cost, softness=softness))(off_m, KNOWN)


def slopes(off_m: FloatArray, softness: float) -> FloatArray:
    return np.asarray(compiled_slopes(off_m, softness=softness), dtype=np.float64)


def test_a_sharp_step_counts_the_time_until_the_threshold_is_crossed() -> None:
    """An error of 0.1·t along reaches 0.2 m after 2 s and 0.5 m never, of 4 s."""
    off_m = np.zeros((1, 40, 2))
    off_m[0, :, 0] = 0.1 * HORIZONS_S
    expected = -0.5 * (np.log(1.95 + FORGIVEN_S) + np.log(4.0 + FORGIVEN_S))
    assert cost(off_m, 1e-3) == pytest.approx(expected, abs=0.02)


def test_beyond_the_end_of_the_truth_a_path_neither_holds_nor_fails() -> None:
    """Of 4 s only 3 s are known: what lies beyond counts for nothing, whatever it is."""
    known = np.ones((1, 40))
    known[0, 30:] = 0.0
    off_m = np.zeros((1, 40, 2))
    off_m[0, 30:] = 99.0
    assert cost(off_m, 1e-3, known) == pytest.approx(-np.log(3.0 + FORGIVEN_S), abs=1e-4)


def test_an_error_no_threshold_forgives_has_no_slope() -> None:
    assert np.abs(slopes(np.full((1, 40, 2), 50.0), 0.25)).max() < 1e-12


def test_an_error_near_the_threshold_pulls_the_path_back() -> None:
    """Only where it is the greatest so far: later and smaller ones change no survival."""
    off_m = np.zeros((1, 40, 2))
    off_m[0, 10, 0], off_m[0, 20, 0] = 0.19, 0.1
    found = slopes(off_m, 0.25)
    assert found[0, 10, 0] > 0.1
    assert found[0, 20, 0] == 0.0


def test_an_error_that_has_come_and_gone_counts_as_failed() -> None:
    off_m = np.zeros((2, 40, 2))
    off_m[:, 5, 1] = 3.0
    off_m[1, 6:, 1] = 3.0
    gone, stayed = (cost(off_m[row : row + 1], 0.25) for row in range(2))
    assert gone == stayed
