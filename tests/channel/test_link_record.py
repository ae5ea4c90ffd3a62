"""What was lost of counted messages: known losses are found, and nothing else is taken for one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.channel.link_record import SHORTEST_PART, LinkRecord, counted_link

T_STEP_S = 0.1


def link(number: np.ndarray, *, jump: int = 0, since: int = 0, late_s: float = 0.0) -> LinkRecord:
    """A link on which messages of these numbers were heard; from one on, counts jump and times are later."""
    after = number >= since
    return counted_link("a hears b", number * T_STEP_S + late_s * after, (number + 90 + jump * after) % 128)


def spread(lost: np.ndarray, seed: int) -> LinkRecord:
    """The record of these losses from messages that jitter by 24 ms, in disorder, some of them twice."""
    rng = np.random.default_rng(seed)
    number = np.flatnonzero(~lost)
    number = rng.permutation(np.concatenate([number, number[:: max(number.size // 7, 1)]]))
    jitter_s = rng.uniform(-0.024, 0.024, size=lost.size)
    return counted_link("a hears b", number * T_STEP_S + jitter_s[number], (number + 90) % 128)


@given(st.integers(SHORTEST_PART, 700), st.floats(0.0, 0.9), st.integers(0, 10_000))
def test_losses_one_by_one_are_found_as_they_were(count: int, ratio: float, seed: int) -> None:
    lost = np.random.default_rng(seed).random(count) < ratio
    lost[[0, 1, -2, -1]] = False
    found = spread(lost, seed)
    assert np.array_equal(found.lost, lost)
    assert found.heard == count - lost.sum()
    assert (found.unknown, found.short) == (0, 0)
    assert found.period_s == pytest.approx(T_STEP_S, rel=0.1)


@pytest.mark.parametrize(("lost", "known"), [(1, True), (126, True), (127, False), (500, False)])
def test_a_gap_is_known_as_long_as_counts_do_not_come_round(lost: int, known: bool) -> None:
    number = np.concatenate([np.arange(200), np.arange(200 + lost, 400 + lost)])
    found = link(number)
    assert found.unknown == (not known)
    assert found.lost.sum() == (lost if known else 0)
    assert found.unknown_s == pytest.approx(0.0 if known else (lost + 1) * T_STEP_S)
    assert found.lost.size == 400 + (lost if known else 0)


@pytest.mark.parametrize(
    ("late_s", "known"), [(0.1, True), (-0.1, True), (0.2, False), (-0.2, False), (3.0, False)]
)
def test_counts_and_times_may_disagree_by_one_message(late_s: float, known: bool) -> None:
    number = np.concatenate([np.arange(200), np.arange(210, 400)])
    found = link(number, since=205, late_s=late_s)
    assert found.unknown == (not known)
    assert found.lost.sum() == (10 if known else 0)


def test_where_counts_jump_it_is_not_known_what_was_lost() -> None:
    number = np.concatenate([np.arange(150), np.arange(160, 300)])
    found = link(number, jump=40, since=155)
    assert (found.unknown, found.lost.sum(), found.lost.size) == (1, 0, 290)
    assert found.unknown_s == pytest.approx(1.1)


@pytest.mark.parametrize(("lost", "known"), [(0, True), (1, False)])
def test_counts_that_jump_with_an_epoch_are_joined_by_time_where_nothing_is_between(
    lost: int, known: bool
) -> None:
    number = np.concatenate([np.arange(150), np.arange(150 + lost, 300)])
    count = np.where(number < 150, number, number + 77) % 128
    found = counted_link("a hears b", number * T_STEP_S, count, epoch=(number >= 150).astype(np.int64))
    assert (found.unknown == 0) == known
    assert found.lost.size == 300 - lost
    assert not found.lost.any()


def test_times_rounded_to_the_period_lose_nothing() -> None:
    """As in the New York event: one time is stated twice, the next comes two steps later."""
    number = np.arange(160)
    t_s = number * T_STEP_S - np.where(number % 40 == 39, T_STEP_S, 0.0)
    found = counted_link("a hears b", t_s, number % 128)
    assert (found.lost.size, found.lost.sum(), found.unknown) == (160, 0, 0)


def test_messages_of_one_time_may_come_out_of_order() -> None:
    """The very first two among them: the record begins with the lower count."""
    number = np.arange(160)
    number[:2] = [1, 0]
    found = counted_link("a hears b", np.maximum(number, 1) * T_STEP_S, number % 128)
    assert (found.lost.size, found.lost.sum(), found.unknown) == (160, 0, 0)


def test_short_parts_are_left_out_and_counted() -> None:
    number = np.concatenate([np.arange(150), np.arange(1000, 1000 + SHORTEST_PART - 1), [3000]])
    found = link(number)
    assert (found.short, found.unknown, found.lost.size) == (2, 2, 150)
    assert found.heard == number.size


@pytest.mark.parametrize(
    ("t_s", "count"),
    [([], []), ([1.0], [5]), ([1.0, 1.1, 1.2], [7, 7, 7]), ([1.0, 1.0], [7, 8])],
    ids=["none", "one", "counts stand still", "one time"],
)
def test_nothing_is_made_of_what_tells_nothing(t_s: list[float], count: list[int]) -> None:
    found = counted_link("a hears b", np.array(t_s), np.array(count, dtype=np.int64))
    assert (found.lost.size, found.heard, found.short) == (0, len(t_s), 1)


@pytest.mark.parametrize(
    ("t_s", "count", "told"),
    [
        ([0.0, 0.1], [1], "must be"),
        ([0.0, np.nan], [1, 2], "finite"),
        ([0.0, 0.1], [1, 128], r"0\.\.127"),
        ([0.0, 0.1], [-1, 1], r"0\.\.127"),
    ],
)
def test_what_is_no_counted_message_is_refused(t_s: list[float], count: list[int], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        counted_link("a hears b", np.array(t_s), np.array(count, dtype=np.int64))


@pytest.mark.parametrize(
    ("lost", "period_s", "told"),
    [
        ([True, False], 0.1, "begin and end"),
        ([False, True], 0.1, "begin and end"),
        ([[False]], 0.1, "one axis"),
        ([False], 0.0, "period_s"),
        ([False], np.nan, "period_s"),
    ],
)
def test_what_is_no_record_is_refused(lost: object, period_s: float, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        LinkRecord("a hears b", np.array(lost, dtype=np.bool_), period_s=period_s)
