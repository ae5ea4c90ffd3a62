"""Claims about the guard's rule: its bound on any messages, and each step of it on messages made by hand."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from modelcast.core.arrays import BoolArray, IntArray
from modelcast.station.policy import guard_kernels as kernels
from modelcast.station.policy.guard import Steered, most_behind, steered

T = 150


@st.composite
def messages(draw: st.DrawFn) -> tuple[BoolArray, BoolArray]:
    """What a bank and its guards send, in stretches of random density: quiet, busy, all at once."""
    count = draw(st.integers(1, 2))
    rows = np.zeros((T, 1 + count), dtype=np.bool_)
    at = 0
    while at < T:
        length = draw(st.integers(1, 60))
        densities = draw(st.lists(st.sampled_from((0.0, 0.1, 0.5, 1.0)), min_size=3, max_size=3))
        rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
        stretch = rows[at : at + length]
        stretch[:] = rng.random(stretch.shape) < densities[: 1 + count]
        at += length
    rows[0] = True  # all begin with a message
    return rows[:, 0], rows[:, 1:]


def within_silences(bank: BoolArray, guards: BoolArray) -> int:
    """Most messages that the bank or a guard sends between two messages of a guard."""
    every = np.column_stack([bank, guards])
    most = 0
    for silent in guards.T:
        bounds = [*np.flatnonzero(silent), silent.size]
        for first, end in pairwise(bounds):
            most = max(most, int(every[first + 1 : end].sum(axis=0).max(initial=0)))
    return most


def visits(found: Steered) -> IntArray:
    """Guards that the sender was in step with since the bank last served, itself among them."""
    count = np.zeros(found.step.size, dtype=np.int64)
    before, so_far = -1, 0
    for at, step in enumerate(found.step.tolist()):
        so_far = 0 if step < 0 else so_far + (step != before)
        count[at], before = so_far, step
    return count


@given(messages())
def test_a_sender_is_never_further_behind_a_guard_than_the_bound(made: tuple[BoolArray, BoolArray]) -> None:
    bank, guards = made
    found = steered(bank, guards)
    behind = np.cumsum(found.sends)[:, None] - np.cumsum(guards, axis=0)
    most, several = within_silences(bank | found.restarts, guards), guards.shape[1] > 1
    for at, count in enumerate(visits(found)):
        sent = guards[: at + 1].sum(axis=0)
        assert behind[at].max() < most_behind(sent, most, int(count) if several else 0)


@given(messages())
def test_the_compiled_rule_is_the_one_in_plain_python(
    steering: type[Any], made: tuple[BoolArray, BoolArray]
) -> None:
    bank, guards = made
    plain = steering({i: dict.fromkeys(np.flatnonzero(one), "update") for i, one in enumerate(guards.T)})
    restarts = [plain.take(now, bool(sends)) for now, sends in enumerate(bank)]
    found = steered(bank, guards)
    assert found.restarts.tolist() == restarts
    assert found.step.tolist() == [-1 if one is None else one for one in plain.past]
    assert int(found.sends.sum()) == plain.own


@given(messages())
def test_in_step_it_sends_what_the_guard_sends_and_else_what_the_bank_sends(
    made: tuple[BoolArray, BoolArray],
) -> None:
    """And whoever takes over speaks at that instant, so that remotes hold what it said."""
    bank, guards = made
    found = steered(bank, guards)
    whose = np.column_stack([guards, bank | found.restarts])
    assert np.array_equal(found.sends, whose[np.arange(T), found.step])
    changes = np.flatnonzero(np.diff(found.step)) + 1
    assert whose[changes, found.step[changes]].all()
    assert whose[changes, found.step[changes - 1]][found.step[changes] < 0].all()  # coming back costs nothing


@given(arrays.arrays(np.bool_, T))
def test_a_bank_that_sends_with_its_guard_is_left_alone(guard: BoolArray) -> None:
    found = steered(guard, guard[:, None])
    assert set(found.step) == {-1}
    assert not found.restarts.any()


def one_guard(*said: str) -> Steered:
    """Steer by samples of ``b`` (the bank sends), ``c`` (constant velocity), ``bc`` or nothing."""
    return steered(np.array(["b" in one for one in said]), np.array([["c" in one] for one in said]))


def test_two_messages_behind_constant_velocity_serves_from_its_next_message_on() -> None:
    assert one_guard("bc", "b", "c", "b", "bc").step.tolist() == [-1] * 5  # never two behind with its message
    assert one_guard("bc", "b", "b", "c", "", "b").step.tolist() == [-1] * 6  # its message makes up for one
    lost = one_guard("bc", "b", "b", "", "bc", "b", "c")
    assert lost.step.tolist() == [-1, -1, -1, -1, 0, 0, 0]
    assert lost.sends.tolist() == [True, True, True, False, True, False, True]
    assert one_guard("bc", "b", "b", "b", "c", "b").step.tolist() == [-1, -1, -1, -1, 0, 0]


@pytest.mark.parametrize(("lost", "lead"), [(2, 4), (3, 16), (4, 64)])
def test_each_message_lost_quadruples_the_lead_it_takes(lost: int, lead: int) -> None:
    """Two may be lost always: they take a lead of 4, and one more message may then be lost."""
    found = one_guard("bc", *["b"] * lost, "bc", *["c"] * lead, "c", "b", "bc")
    assert found.step[: lost + 1].tolist() == [-1] * (lost + 1)
    assert np.flatnonzero(found.restarts).tolist() == [lost + 1 + lead]
    back = one_guard("bc", *["b"] * lost, "bc", *["c"] * lead, "b", "bc", "b", "bc")
    assert back.step[lost + 1 + lead :].tolist() == [-1, -1, 0, 0, 0]  # one more lost is what was granted


def test_a_lead_is_counted_from_its_lowest_on() -> None:
    """What the bank lost while it was put away does not count against it."""
    away = ["bc", "b", "b", "bc", *["b"] * 20, *["c"] * 4]
    assert np.flatnonzero(one_guard(*away).restarts).tolist() == [len(away) - 1]
    assert not one_guard(*away[:-1], "bc", "", "").restarts.any()


def test_what_was_made_up_for_is_granted_no_more() -> None:
    """Back at three behind it may lose one more; once it has gained two, two behind is the limit again."""
    lost = ["bc", "b", "b", "b", "bc", *["c"] * 16]
    gained = [*lost, "c", "c"]
    assert one_guard(*lost, "b", "bc").step[-1] == 0
    assert one_guard(*gained, "b", "bc").step[-1] == 0
    assert one_guard(*gained, "c", "b", "bc").step[-1] == -1


def test_shares_of_what_the_guards_send_may_be_lost_on_long_trips() -> None:
    for guard, (least, share) in enumerate(((2.0, 0.01), (4.0, 0.03))):
        for sent in (0, 100, 299, 300, 301, 2000):
            assert kernels.allowance(guard, sent) == max(least, share * sent - 1.0)
    assert [kernels.needed_lead(over) for over in (-7.0, 0.0, 0.5, 1.0)] == [4.0, 4.0, 8.0, 16.0]


def test_it_is_in_step_with_the_guard_that_has_sent_fewest_and_of_equals_with_the_second() -> None:
    start, both = [1, 1, 1], [[1, 0, 0]] * 3
    for before, first in (([0, 1, 0], 1), ([0, 0, 1], 0), ([0, 1, 1], 1)):
        said = np.array([start, before, *both, [1, 1, 1]], dtype=np.bool_)
        assert steered(said[:, 0], said[:, 1:]).step.tolist()[-1] == first


@pytest.mark.parametrize("more", [1, 2])
def test_it_changes_guards_where_the_other_has_sent_two_messages_fewer(more: int) -> None:
    said = np.array([[1, 1, 1], *[[1, 0, 0]] * 5, [1, 1, 1], *[[1, 0, 1]] * more, [1, 1, 0]], dtype=np.bool_)
    found = steered(said[:, 0], said[:, 1:])
    assert found.step.tolist() == [-1] * 6 + [1] * (1 + more) + [0 if more == 2 else 1]


def test_a_bank_that_goes_on_losing_carries_the_guard_that_it_waits_for() -> None:
    state = kernels.guarding(1)
    stands: list[int] = []
    for bank, guard in ((True, True), *[(True, False)] * 4, (False, True)):
        kernels.steer(state, 0, bank, (guard, guard), 1)
        stands.append(int(state.stand_in[0]))
    assert stands == [-1, -1, -1, 0, 0, -1]


def test_no_causal_sender_that_leaves_its_guard_does_without_what_is_lost_in_its_silence() -> None:
    """All that the bank sends while the guard is silent is lost, however long that is."""
    for silence in (5, 50, 500):
        found = one_guard("bc", *["b"] * silence, "c", *[""] * 9)
        assert int(found.sends.sum()) == silence + 2
        assert silence < most_behind(np.array([2]), silence, 0)


def test_shapes_must_agree() -> None:
    for bank, guards in ((4, (4,)), (4, (3, 1)), (4, (4, 3)), (4, (4, 0))):
        with pytest.raises(ValueError, match=r"bank must be \(T,\) and guards"):
            steered(np.zeros(bank, dtype=np.bool_), np.zeros(guards, dtype=np.bool_))
