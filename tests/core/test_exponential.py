"""The inlined exponential and logarithms against the library's."""

import numpy as np

from modelcast.core.exponential_kernels import LOWEST, fast_asinh, fast_exp, fast_log

CLAIMED = 1e-11
"""Relative error that the exponential states."""

CLAIMED_LOG = 1e-15
"""Error that the logarithms state, of the value or of 1."""


def test_the_inlined_exponential_agrees_with_the_library() -> None:
    exponents = np.concatenate([np.linspace(LOWEST + 1.0, 700.0, 5001), np.linspace(-2.0, 2.0, 1001)])
    worst = max(abs(fast_exp(x) / np.exp(x) - 1.0) for x in exponents)
    assert worst < CLAIMED


def test_the_inlined_exponential_is_exact_at_zero_and_nothing_far_below() -> None:
    assert fast_exp(0.0) == 1.0
    assert fast_exp(-0.0) == 1.0
    assert fast_exp(LOWEST) == 0.0
    assert fast_exp(-np.inf) == 0.0


def test_the_inlined_logarithm_agrees_with_the_library() -> None:
    exponents = np.concatenate([np.linspace(-300.0, 300.0, 5001), np.linspace(-0.01, 0.01, 1001)])
    numbers = np.concatenate([10.0**exponents, [0.5**0.5, np.nextafter(0.5**0.5, 0.0), 2.0**0.5, 2.0]])
    exact = np.log(numbers)
    found = np.array([fast_log(x) for x in numbers])
    assert np.max(np.abs(found - exact) / np.maximum(np.abs(exact), 1.0)) < CLAIMED_LOG
    assert fast_log(1.0) == 0.0


def test_the_inlined_inverse_hyperbolic_sine_agrees_with_the_library_and_is_odd() -> None:
    numbers = np.concatenate([np.linspace(-5.0, 5.0, 2001), 10.0 ** np.linspace(-12.0, 149.0, 2001)])
    exact = np.arcsinh(numbers)
    found = np.array([fast_asinh(x) for x in numbers])
    assert np.max(np.abs(found - exact) / np.maximum(np.abs(exact), 1.0)) < CLAIMED_LOG
    assert [fast_asinh(-x) for x in numbers] == list(-found)
