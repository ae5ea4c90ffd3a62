"""Claims about histograms: how far their quantiles lie from the exact ones, and that merging is exact."""

from fractions import Fraction
from random import Random

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from modelcast.study.histogram import BIN_RATIO, MILLIONTHS, SMALLEST, Histogram

Singles = npt.NDArray[np.float32]

PROBABILITIES = (0.0, 0.1, 0.5, 0.9, 0.95, 0.99, 1.0)

SIZES = st.one_of(
    st.just(0.0),
    st.floats(0.0, 2.0**-19, width=32),
    st.floats(0.0, 10.0, width=32),
    st.floats(0.0, 1e6, width=32),
)
PARTS = st.lists(
    st.tuples(
        arrays(np.float32, st.integers(0, 40), elements=SIZES), st.sampled_from([1, 50_000, 100_000, 200_000])
    ),
    max_size=5,
)


def filled(parts: list[tuple[Singles, int]]) -> Histogram:
    found = Histogram()
    for values, weight in parts:
        found.add(values, weight)
    return found


def state(one: Histogram) -> tuple[int, bytes, int, int, float]:
    return one.first, one.counts.tobytes(), one.weight, one.total, one.largest


@given(parts=PARTS)
def test_a_quantile_is_within_its_bin_of_the_exact_weighted_one(parts: list[tuple[Singles, int]]) -> None:
    histogram = filled(parts)
    pairs = sorted((float(value), weight) for values, weight in parts for value in values)
    if not pairs:
        assert np.isnan(histogram.quantiles(PROBABILITIES)).all()
        return
    reached = np.cumsum([weight for _, weight in pairs])
    for probability, found in zip(PROBABILITIES, histogram.quantiles(PROBABILITIES), strict=True):
        target = Fraction(probability) * int(reached[-1])
        # On a step of the distribution rounding decides: either side is right.
        steps = [
            next(v for (v, _), r in zip(pairs, reached, strict=True) if r >= target - shift)
            for shift in (0, 1)
        ]
        for_step = [
            abs(found - exact) <= max(BIN_RATIO * exact, SMALLEST) for exact in steps if exact < 2**17
        ]
        assert any(for_step) or any(exact >= 2**17 and 2**17 <= found <= pairs[-1][0] for exact in steps)


@given(parts=PARTS, order=st.randoms(use_true_random=False))
def test_merging_in_any_order_and_grouping_gives_the_same_bytes(
    parts: list[tuple[Singles, int]], order: Random
) -> None:
    whole = filled(parts)
    shuffled = [filled([part]) for part in parts]
    order.shuffle(shuffled)
    cut = len(shuffled) // 2
    left, right = Histogram.merged(shuffled[:cut]), Histogram.merged(shuffled[cut:])
    assert state(Histogram.merged([right, left])) == state(whole)


def test_the_mean_is_that_of_the_sizes_to_half_a_millionth_of_a_part() -> None:
    values = np.random.default_rng(2).lognormal(0.0, 1.0, 20_000).astype(np.float32)
    histogram = filled([(values, 100_000)])
    assert abs(histogram.mean - values.mean(dtype=np.float64)) <= 0.5 / MILLIONTHS / values.size + 1e-12


def test_sizes_count_and_nan_is_left_out() -> None:
    histogram = filled([(np.array([[-2.0, np.nan], [2.0, np.nan]], dtype=np.float32), 5)])
    assert (histogram.weight, histogram.mean, histogram.largest) == (10, 2.0, 2.0)
    assert histogram.quantile(0.9) == 2.0


def test_exact_zeros_and_the_largest_size_are_told_apart() -> None:
    histogram = filled([(np.array([0.0, 0.0, 1e-9, 1e30], dtype=np.float32), 1)])
    assert histogram.quantile(0.5) == 0.0
    assert 0.0 < histogram.quantile(0.75) <= SMALLEST
    assert histogram.quantile(1.0) == pytest.approx(1e30)


def test_a_histogram_never_grows_beyond_its_bins() -> None:
    histogram = filled([(np.geomspace(1e-30, 1e30, 100_000).astype(np.float32), 1)])
    size = histogram.counts.size
    for _ in range(3):
        histogram.add(np.geomspace(1e-30, 1e30, 100_000).astype(np.float32), 1)
    assert histogram.counts.size == size < 20_000


def test_an_empty_histogram_has_no_figures() -> None:
    assert np.isnan(Histogram().mean)
    assert np.isnan(Histogram().quantile(0.5))
