"""Claims about sending at a fixed rate."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.station.policy.base import TransmitInputs
from modelcast.station.policy.periodic import Periodic
from modelcast.trips.trajectory import Trajectory

TEN_HZ_S = np.arange(3000) * 0.1


def looped(policy: Periodic, t_s: FloatArray, rng: np.random.Generator) -> IntArray:
    """Samples at which one vehicle sends when asked sample by sample."""
    state = policy.init(1, 1)
    sent = []
    for index, now in enumerate(t_s):
        one = np.full(1, now)
        inputs = TransmitInputs(
            one,
            one,
            silence_s=one,
            tracking_error_m=np.zeros((1, 1)),
            available=np.ones((1, 1), dtype=np.bool_),
        )
        decisions, state = policy.decide(state, inputs, rng)
        if decisions.kind[0]:
            sent.append(index)
    return np.array(sent)


@given(rate_hz=st.floats(0.05, 9.9), seed=st.integers(0, 1000))
def test_the_count_is_the_rate_times_the_time_beside_the_first(rate_hz: float, seed: int) -> None:
    sent = Periodic(rate_hz).transmit_indices(TEN_HZ_S, np.random.default_rng(seed))
    assert sent[0] == 0
    assert abs(sent.size - 1 - rate_hz * TEN_HZ_S[-1]) <= 1.0


def test_the_mean_rate_over_phases_is_the_rate() -> None:
    counts = [Periodic(0.73).transmit_indices(TEN_HZ_S, np.random.default_rng(k)).size for k in range(400)]
    assert np.mean(counts) - 1 == pytest.approx(0.73 * TEN_HZ_S[-1], abs=4 * 0.5 / np.sqrt(400))


def test_the_phase_is_uniform_over_seeds() -> None:
    fine_s = np.arange(0.0, 3.0, 1e-3)
    phases = [
        fine_s[Periodic(0.5).transmit_indices(fine_s, np.random.default_rng(k))[1]] / 2.0 for k in range(500)
    ]
    assert stats.kstest(phases, "uniform").pvalue > 0.01


def test_a_rate_above_the_samples_sends_at_every_one() -> None:
    sent = Periodic(25.0).transmit_indices(TEN_HZ_S, np.random.default_rng(0))
    assert np.array_equal(sent, np.arange(TEN_HZ_S.size))


@given(rate_hz=st.floats(0.05, 30.0), seed=st.integers(0, 1000))
def test_asked_sample_by_sample_it_sends_the_same(rate_hz: float, seed: int) -> None:
    policy = Periodic(rate_hz)
    t_s = TEN_HZ_S[:300]
    expected = policy.transmit_indices(t_s, np.random.default_rng(seed))
    assert np.array_equal(looped(policy, t_s, np.random.default_rng(seed)), expected)


@given(rate_hz=st.floats(0.2, 9.0), gap_s=st.floats(0.3, 60.0), seed=st.integers(0, 1000))
def test_after_a_gap_one_message_leaves_and_not_all_that_fell_due(
    rate_hz: float, gap_s: float, seed: int
) -> None:
    t_s = TEN_HZ_S[:200].copy()
    t_s[100:] += gap_s
    policy = Periodic(rate_hz)
    expected = policy.transmit_indices(t_s, np.random.default_rng(seed))
    # Each part holds what falls due in it, give or take one, and the gap one message.
    assert abs(expected.size - 1 - rate_hz * (t_s[-1] - gap_s)) <= 3.0
    assert np.array_equal(looped(policy, t_s, np.random.default_rng(seed)), expected)


@pytest.mark.real
def test_on_real_sample_times_both_ways_agree(dynamic_trips: dict[str, Trajectory]) -> None:
    for name in ("TESLA_MODEL3", "MERCEDES_GLE450"):
        t_s = dynamic_trips[name].t_s
        policy = Periodic(1.37)
        expected = policy.transmit_indices(t_s, np.random.default_rng(5))
        assert np.array_equal(looped(policy, t_s, np.random.default_rng(5)), expected)


@pytest.mark.parametrize("rate_hz", [0.0, -1.0, np.nan, np.inf])
def test_a_rate_must_be_positive_and_finite(rate_hz: float) -> None:
    with pytest.raises(ValueError, match="rate_hz"):
        Periodic(rate_hz)
