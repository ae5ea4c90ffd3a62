"""Recorded losses replayed: the ratio and the bursts are those of the record."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.channel.link_record import LinkRecord
from modelcast.channel.recorded import RecordedLosses

T_S = np.arange(400) * 0.1


def link(inner: list[bool], period_s: float = 0.1) -> LinkRecord:
    """A record with these losses between its first message and its last."""
    return LinkRecord("a hears b", np.array([False, *inner, False]), period_s=period_s)


links = st.lists(st.lists(st.booleans(), min_size=1, max_size=60).map(link), min_size=1, max_size=4).map(
    lambda found: RecordedLosses(tuple(found))
)


def runs(lost: np.ndarray) -> list[int]:
    """Lengths of the runs of losses of a circle that begins with a message heard."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], lost, [False]]).astype(np.int8)))
    return sorted((edges[1::2] - edges[::2]).tolist())


@given(links, st.integers(0, 399))
def test_over_all_places_the_loss_at_any_instant_is_the_record_s(channel: RecordedLosses, at: int) -> None:
    lost = [channel.losses_from(start + 0.5, T_S[at : at + 1])[0] for start in range(channel.messages)]
    assert np.mean(lost) == pytest.approx(channel.packet_error_ratio, abs=1e-12)
    assert channel.packet_error_ratio == sum(one.lost.sum() for one in channel.links) / channel.messages


@given(links, st.floats(0.01, 0.99))
def test_bursts_at_the_recorded_rate_are_those_of_the_record(channel: RecordedLosses, phase: float) -> None:
    first = 0
    for one in channel.links:
        count = one.lost.size
        found = channel.losses_from(first + phase, np.arange(count) * 0.1)
        assert np.array_equal(found, one.lost)
        # From another place on, and twice round: the same bursts, none of them cut or grown.
        later = channel.losses_from(first + count // 2 + phase, np.arange(2 * count) * 0.1)
        whole = np.roll(later, count // 2)
        assert runs(whole) == sorted(2 * one.bursts.tolist())
        first += count


def test_a_record_without_losses_loses_nothing() -> None:
    channel = RecordedLosses((link([False] * 50),))
    assert (channel.packet_error_ratio, channel.mean_burst_s, channel.bursts_s.size) == (0.0, None, 0)
    assert not any(channel.losses(T_S, np.random.default_rng(seed)).any() for seed in range(20))


def test_bursts_have_the_time_they_took() -> None:
    channel = RecordedLosses((link([True, True, False, True]), link([True] * 5, 0.2)))
    assert channel.bursts_s.tolist() == pytest.approx([0.2, 0.1, 1.0])
    assert channel.mean_burst_s == pytest.approx(1.3 / 3)


def test_between_two_messages_the_one_before_counts() -> None:
    lost = RecordedLosses((link([True, False, True]),)).losses_from(0.0, np.arange(10) * 0.05 + 0.01)
    assert lost.tolist() == [False, False, True, True, False, False, True, True, False, False]


def test_links_stand_one_behind_the_other() -> None:
    channel = RecordedLosses((link([True] * 8), link([False, True, False])))
    assert channel.losses_from(10.0, np.arange(5) * 0.1 + 0.01).tolist() == [False, False, True, False, False]


def test_runs_draw_links_as_often_as_they_have_messages() -> None:
    """Of links of 30 and 90 messages the first has all losses: a quarter of 2,000 runs, 4 standard errors."""
    channel = RecordedLosses((link([True] * 28), link([False] * 88)))
    drawn = [channel.losses(T_S, np.random.default_rng(seed)).any() for seed in range(2000)]
    assert np.mean(drawn) == pytest.approx(0.25, abs=4 * np.sqrt(0.25 * 0.75 / 2000))


def test_one_number_is_drawn_whatever_the_record() -> None:
    left: list[float] = []
    for channel in (RecordedLosses((link([True]),)), RecordedLosses((link([False] * 80), link([True] * 9)))):
        rng = np.random.default_rng(5)
        channel.losses(T_S, rng)
        left.append(rng.random())
    assert left[0] == left[1]


def test_what_cannot_be_replayed_is_refused() -> None:
    with pytest.raises(ValueError, match="one link"):
        RecordedLosses(())
    with pytest.raises(ValueError, match="no message"):
        RecordedLosses((LinkRecord("a hears b", np.zeros(0, dtype=np.bool_), period_s=0.1),))
    channel = RecordedLosses((link([True]),))
    for start in (-0.1, 3.0, np.nan):
        with pytest.raises(ValueError, match=r"0\.\.3"):
            channel.losses_from(start, T_S)
