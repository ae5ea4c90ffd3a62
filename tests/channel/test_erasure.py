"""Claims about channels without contention."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from modelcast.channel.erasure import GilbertElliott, Ideal, IndependentErasure
from modelcast.core.arrays import BoolArray

TEN_HZ_S = np.arange(20_000) * 0.1
RATIOS = (0.05, 0.1, 0.3, 0.4, 0.6, 0.9)


def bursts(lost: BoolArray) -> list[int]:
    """Lengths of the runs of losses that begin and end inside."""
    edges = np.flatnonzero(np.diff(lost.astype(int)))
    starts = edges[~lost[edges]]
    return [int(edges[edges > start][0] - start) for start in starts if (edges > start).any()]


def test_an_ideal_channel_loses_nothing() -> None:
    assert not Ideal().losses(TEN_HZ_S, np.random.default_rng(0)).any()
    assert Ideal().packet_error_ratio == 0.0


@pytest.mark.parametrize("ratio", RATIOS)
def test_independent_losses_match_their_ratio_within_binomial_bounds(ratio: float) -> None:
    lost = IndependentErasure(ratio).losses(TEN_HZ_S, np.random.default_rng(17))
    assert stats.binomtest(int(lost.sum()), lost.size, ratio).pvalue > 0.001


def test_independent_losses_are_independent_of_the_one_before() -> None:
    lost = IndependentErasure(0.4).losses(TEN_HZ_S, np.random.default_rng(17))
    after_loss = lost[1:][lost[:-1]]
    assert stats.binomtest(int(after_loss.sum()), after_loss.size, 0.4).pvalue > 0.001


@pytest.mark.parametrize("ratio", RATIOS)
def test_burst_losses_match_their_ratio_at_every_instant(ratio: float) -> None:
    """Over independent runs, so that the bounds are binomial."""
    channel = GilbertElliott(ratio, 0.5)
    runs = np.array([channel.losses(TEN_HZ_S[:20], np.random.default_rng(k)) for k in range(3000)])
    for at in (0, 7, 19):
        assert stats.binomtest(int(runs[:, at].sum()), 3000, ratio).pvalue > 0.001


@pytest.mark.parametrize(("ratio", "mean_burst_s"), [(0.1, 0.5), (0.4, 0.5), (0.4, 2.0), (0.6, 0.2)])
def test_bursts_have_the_mean_length_of_the_chain(ratio: float, mean_burst_s: float) -> None:
    """Sampled finely, a visit to the bad state lasts its mean time, within four standard errors."""
    step_s = mean_burst_s / 50
    t_s = np.arange(400_000) * step_s
    lengths_s = np.array(bursts(GilbertElliott(ratio, mean_burst_s).losses(t_s, np.random.default_rng(3))))
    # Visits between two samples are not seen: what is seen is geometric in steps.
    leave_chance = (1 - ratio) * (1 - np.exp(-step_s / (mean_burst_s * (1 - ratio))))
    expected = 1.0 / leave_chance
    assert expected * step_s == pytest.approx(mean_burst_s, rel=0.05)
    assert lengths_s.mean() == pytest.approx(expected, abs=4 * expected / np.sqrt(lengths_s.size))


@given(
    ratios=st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)).map(sorted),
    seed=st.integers(0, 2**32 - 1),
)
def test_a_higher_ratio_loses_all_that_a_lower_one_loses(ratios: list[float], seed: int) -> None:
    low, high = (
        IndependentErasure(ratio).losses(TEN_HZ_S[:500], np.random.default_rng(seed)) for ratio in ratios
    )
    assert not (low & ~high).any()


@pytest.mark.parametrize("mean_burst_s", [0.0, -1.0, np.nan, np.inf])
def test_a_burst_must_have_a_positive_finite_length(mean_burst_s: float) -> None:
    with pytest.raises(ValueError, match="mean_burst_s"):
        GilbertElliott(0.4, mean_burst_s)
