"""Claims about the figures of a network evaluation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from made_rows import filled
from modelcast.runtime.fleet.bins_kernels import BINS, bin_of, lower_edge
from modelcast.study.network.measure import binned_quantiles
from modelcast.study.network.pool import pool
from modelcast.study.network.rows import RUNS, NetworkCase
from modelcast.study.table import Row

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


def test_every_threshold_has_a_pool_of_its_own() -> None:
    runs = [
        filled(RUNS, value, **NetworkCase(25.0, "dsrc", "mbc", "cv", 0, threshold_m=value).values())
        for value in (0.2, 0.5)
    ]
    pooled = {one.threshold_m: one.value for one in pool(runs) if one.figure == "busy_ratio"}
    assert pooled == {0.2: 0.2, 0.5: 0.5}


def test_seeds_are_pooled_bank_by_bank() -> None:
    rows: list[Row] = []
    for bank, first in (("cv", 1.0), ("paper", 5.0)):
        for run in (0, 1, 2):
            key = NetworkCase(25.0, "dsrc", "mbc", bank, run).values()
            rows.append(filled(RUNS, first + run, **key))
    found = {one.bank: one for one in pool(rows) if one.figure == "pte_p90_m"}
    assert {bank: (one.seeds, one.value) for bank, one in found.items()} == {
        "cv": (3, 2.0),
        "paper": (3, 6.0),
    }
    low, high = found["cv"].low, found["cv"].high
    assert low is not None
    assert high is not None
    # Student's t at 97.5 % with 2 degrees of freedom, over the root of 3.
    assert (low, high) == pytest.approx((2.0 - 4.302653 / 3**0.5, 2.0 + 4.302653 / 3**0.5))
