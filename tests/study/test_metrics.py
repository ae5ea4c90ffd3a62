"""Claims about quantiles and confidence limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import stats

from modelcast.core.arrays import FloatArray
from modelcast.study.metrics import confidence_limits, quantiles

PROBABILITIES = (0.0, 0.1, 0.5, 0.9, 0.95, 0.99, 1.0)


@given(
    parts=st.lists(
        arrays(np.float64, st.integers(0, 30), elements=st.floats(0.0, 100.0)), min_size=1, max_size=5
    ),
    weights=st.lists(st.sampled_from([0.1, 0.2, 0.5, 1.0]), min_size=5, max_size=5),
)
def test_quantiles_are_numpys_inverted_cdf_with_weights(
    parts: list[FloatArray], weights: list[float]
) -> None:
    values = np.concatenate(parts)
    share = np.concatenate([np.full(one.size, weight) for one, weight in zip(parts, weights, strict=False)])
    found = quantiles([np.sort(one) for one in parts], weights[: len(parts)], PROBABILITIES)
    if values.size == 0:
        assert np.isnan(found).all()
        return
    # Where a probability falls on a step of the distribution, rounding decides: either side is right.
    low, high = (
        np.quantile(values, np.clip(np.add(PROBABILITIES, shift), 0, 1), weights=share, method="inverted_cdf")
        for shift in (-1e-9, 1e-9)
    )
    assert ((found == low) | (found == high)).all()


def test_a_quantile_on_a_step_is_the_lower_value() -> None:
    assert quantiles([np.array([1.0, 2.0, 3.0, 4.0])], [1.0], [0.25, 0.5, 0.75, 1.0]).tolist() == [1, 2, 3, 4]


def test_a_sample_twice_as_long_counts_twice() -> None:
    doubled = quantiles([np.array([1.0, 5.0]), np.array([3.0])], [1.0, 2.0], PROBABILITIES)
    assert np.array_equal(doubled, quantiles([np.array([1.0, 3.0, 3.0, 5.0])], [1.0], PROBABILITIES))


@given(values=arrays(np.float64, st.integers(2, 12), elements=st.floats(0.0, 10.0)))
def test_confidence_limits_are_students(values: FloatArray) -> None:
    low, high = confidence_limits(values)
    assert low is not None
    assert high is not None
    if values.std() > 1e-9:
        expected = stats.ttest_1samp(values, 0.0).confidence_interval(0.95)
        assert (low, high) == pytest.approx((expected.low, expected.high))


def test_one_value_has_no_confidence_limits() -> None:
    assert confidence_limits(np.array([1.0])) == (None, None)
    assert confidence_limits(np.array([1.0, np.nan])) == (None, None)
