"""The inlined exponential against the library's."""

import numpy as np

from modelcast.core.exponential_kernels import LOWEST, fast_exp

CLAIMED = 1e-11
"""Relative error that the function states."""


def test_the_inlined_exponential_agrees_with_the_library() -> None:
    exponents = np.concatenate([np.linspace(LOWEST + 1.0, 700.0, 5001), np.linspace(-2.0, 2.0, 1001)])
    worst = max(abs(fast_exp(x) / np.exp(x) - 1.0) for x in exponents)
    assert worst < CLAIMED


def test_the_inlined_exponential_is_exact_at_zero_and_nothing_far_below() -> None:
    assert fast_exp(0.0) == 1.0
    assert fast_exp(-0.0) == 1.0
    assert fast_exp(LOWEST) == 0.0
    assert fast_exp(-np.inf) == 0.0
