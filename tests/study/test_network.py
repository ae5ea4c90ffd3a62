"""Claims about the figures of a network evaluation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.runtime.fleet.bins_kernels import BINS, bin_of, lower_edge
from modelcast.study.network.measure import binned_quantiles
from modelcast.study.network.pool import capacities
from modelcast.study.network.rows import PooledRow

BIN_RATIO = 1.0 / 32.0
"""Bins are a 32nd of an octave's lower edge wide at most."""


@given(st.lists(st.floats(1e-3, 1e3), min_size=1, max_size=50), st.sampled_from([0.1, 0.5, 0.9]))
def test_a_streamed_quantile_errs_by_less_than_a_bin(values: list[float], probability: float) -> None:
    counts = np.zeros(BINS, dtype=np.int64)
    for value in values:
        counts[bin_of(value)] += 1
    found = binned_quantiles(counts, (probability,))[0]
    exact = float(np.quantile(values, probability, method="inverted_cdf"))
    assert found == pytest.approx(exact, rel=BIN_RATIO + 1e-6)


@given(st.floats(0.0, 1e9))
def test_a_number_lies_in_its_bin(value: float) -> None:
    at = bin_of(value)
    assert lower_edge(at) <= np.float32(value)
    assert at == BINS - 1 or np.float32(value) < lower_edge(at + 1)


def row(density_per_km: float, value: float) -> PooledRow:
    return PooledRow(
        density_per_km=density_per_km,
        radio="dsrc",
        policy="j2945",
        bank="none",
        seeds=1,
        figure="pte_p90_100_m",
        value=value,
        low=None,
        high=None,
    )


def test_capacity_is_where_the_error_crosses_from_below() -> None:
    half, whole = capacities([row(100.0, 0.8), row(25.0, 0.2), row(400.0, 0.9)])
    assert half.density_per_km == pytest.approx(50.0)
    assert whole.density_per_km is None
    assert not whole.above_at_lowest


def test_an_error_that_is_too_large_everywhere_says_so() -> None:
    half, _ = capacities([row(25.0, 0.7), row(100.0, 0.9)])
    assert half.density_per_km is None
    assert half.above_at_lowest
