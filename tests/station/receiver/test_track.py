"""Claims about the rules of one track: what a host holds of a remote follows from what arrived, and when."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.station.receiver import track_kernels as track
from modelcast.station.receiver.track_kernels import (
    ACCEPTED,
    IN_FUTURE,
    OLDER,
    REPEATED,
    STALE,
    UNKNOWN_UPDATE,
)

EXPIRY_S = 3.0


def empty() -> FloatArray:
    held = np.full(track.TRACK_COLUMNS, math.nan)
    track.forget(held)
    return held


def holding(content: int = 4, fit_s: float = 10.0) -> FloatArray:
    """An update of that instant, received at once, with sub-model 1 in use."""
    held = empty()
    assert track.take_update(held, content, 1, fit_s, fit_s, EXPIRY_S) == ACCEPTED
    return held


def test_nothing_is_held_before_the_first_message_even_where_nothing_expires() -> None:
    assert empty().tolist() == [-1.0, 0.0, -math.inf, -math.inf, -math.inf]
    assert not track.is_live(empty(), 0.0, math.inf)
    assert not track.is_live(empty(), -math.inf, math.inf)


def test_the_first_update_is_held_whatever_its_number() -> None:
    assert holding(0, -5.0).tolist() == [0.0, 1.0, -5.0, -5.0, -5.0]
    assert track.is_live(holding(0), 10.0, EXPIRY_S)


@pytest.mark.parametrize(("after_s", "live"), [(-1.0, True), (0.0, True), (3.0, True), (3.001, False)])
def test_a_track_lives_up_to_the_expiry_and_no_longer(after_s: float, live: bool) -> None:
    assert track.is_live(holding(), 10.0 + after_s, EXPIRY_S) == live


def test_nothing_expires_where_the_expiry_is_infinite() -> None:
    assert track.is_live(holding(), 1e9, math.inf)


@pytest.mark.parametrize(
    ("fit_s", "status", "after"),
    [
        (9.9, OLDER, [4.0, 1.0, 10.0, 10.0, 10.0]),
        (10.0, REPEATED, [4.0, 1.0, 10.0, 10.0, 12.0]),
        (10.1, ACCEPTED, [5.0, 2.0, 10.1, 10.1, 12.0]),
    ],
)
def test_an_update_replaces_what_was_fitted_before_it(fit_s: float, status: int, after: list[float]) -> None:
    held = holding()
    assert track.take_update(held, 5, 2, fit_s, 12.0, EXPIRY_S) == status
    assert held.tolist() == after


def test_a_copy_of_what_is_held_does_not_tell_that_the_remote_is_alive() -> None:
    held = holding()
    before = held.tolist()
    assert track.take_update(held, 4, 1, 10.0, 12.0, EXPIRY_S) == REPEATED
    assert held.tolist() == before


def test_after_an_expiry_an_older_update_is_a_first_one() -> None:
    held = holding()
    assert track.take_update(held, 5, 2, 9.9, 13.1, EXPIRY_S) == ACCEPTED
    assert held.tolist() == [5.0, 2.0, 9.9, 9.9, 13.1]


def test_an_update_begins_anew_what_identifications_are_compared_with() -> None:
    held = holding()
    track.take_identification(held, 4, 0, 11.0, 11.0, EXPIRY_S)
    assert track.take_update(held, 5, 2, 10.5, 11.5, EXPIRY_S) == ACCEPTED
    assert track.take_identification(held, 5, 0, 10.6, 11.6, EXPIRY_S) == ACCEPTED


@pytest.mark.parametrize(
    ("content", "named_s", "received_s", "status", "after"),
    [
        (4, 11.0, 12.0, ACCEPTED, [4.0, 0.0, 10.0, 11.0, 12.0]),
        (4, 10.0, 12.0, OLDER, [4.0, 1.0, 10.0, 10.0, 10.0]),
        (4, 9.0, 12.0, OLDER, [4.0, 1.0, 10.0, 10.0, 10.0]),
        (5, 11.0, 12.0, UNKNOWN_UPDATE, [4.0, 1.0, 10.0, 10.0, 10.0]),
        (3, 11.0, 12.0, UNKNOWN_UPDATE, [4.0, 1.0, 10.0, 10.0, 10.0]),
        (4, 11.0, 13.0, ACCEPTED, [4.0, 0.0, 10.0, 11.0, 13.0]),
        (4, 11.0, 13.1, UNKNOWN_UPDATE, [-1.0, 0.0, -math.inf, -math.inf, -math.inf]),
    ],
)
def test_an_identification_names_a_sub_model_of_the_update_held_and_of_no_other(
    content: int, named_s: float, received_s: float, status: int, after: list[float]
) -> None:
    held = holding()
    assert track.take_identification(held, content, 0, named_s, received_s, EXPIRY_S) == status
    assert held.tolist() == after


def test_an_identification_brings_no_remote_into_being() -> None:
    held = empty()
    assert track.take_identification(held, -1, 0, 11.0, 11.0, math.inf) == UNKNOWN_UPDATE
    assert held.tolist() == empty().tolist()


def test_identifications_of_an_update_never_received_do_not_keep_a_remote_alive() -> None:
    held = holding()
    for step in range(1, 40):
        now_s = 10.0 + 0.1 * step
        assert track.take_identification(held, 5, 0, now_s, now_s, EXPIRY_S) == UNKNOWN_UPDATE
        assert track.is_live(held, now_s, EXPIRY_S) == (step <= 30)


@pytest.mark.parametrize(
    ("t_s", "status"),
    [
        (99.0, ACCEPTED),
        (101.0, ACCEPTED),
        (101.001, IN_FUTURE),
        (math.inf, IN_FUTURE),
        (math.nan, IN_FUTURE),
        (90.0, ACCEPTED),
        (89.999, STALE),
        (-math.inf, STALE),
    ],
)
def test_a_message_is_dated_near_its_arrival(t_s: float, status: int) -> None:
    assert track.is_timely(t_s, 100.0, 1.0, 10.0) == status


# The same in plain Python ----------------------------------------------------------------------------------


@dataclass
class Reference:
    """The rules in words: ``held`` is (content, fit instant), ``named`` (sub-model, instant)."""

    held: tuple[int, float] | None = None
    named: tuple[int, float] = (0, -math.inf)
    renewed_s: float = -math.inf

    def take(self, kind: str, content: int, member: int, t_s: float, received_s: float) -> int:
        """Take in one message."""
        if self.held is None or received_s - self.renewed_s > EXPIRY_S:
            self.held, self.named, self.renewed_s = None, (0, -math.inf), -math.inf
        if kind == "identification":
            if self.held is None or self.held[0] != content:
                return UNKNOWN_UPDATE
            if t_s <= self.named[1]:
                return OLDER
        elif self.held is not None and t_s < self.held[1]:
            return OLDER
        elif self.held is not None and t_s == self.held[1]:
            if content != self.held[0]:
                self.renewed_s = received_s
            return REPEATED
        else:
            self.held = content, t_s
        self.named, self.renewed_s = (member, t_s), received_s
        return ACCEPTED


MESSAGES = st.lists(
    st.tuples(
        st.sampled_from(["update", "identification"]),
        st.integers(0, 3),
        st.integers(0, 2),
        st.integers(-4, 0).map(float),  # dated before its arrival [s]
        st.integers(0, 4).map(float),  # arrives after the one before [s]
    ),
    max_size=30,
)


@given(MESSAGES)
def test_any_messages_are_taken_as_the_rules_in_words_say(
    messages: list[tuple[str, int, int, float, float]],
) -> None:
    held, reference, now_s = empty(), Reference(), 0.0
    for kind, content, member, age_s, gap_s in messages:
        now_s += gap_s
        take = track.take_update if kind == "update" else track.take_identification
        status = take(held, content, member, now_s + age_s, now_s, EXPIRY_S)
        assert status == reference.take(kind, content, member, now_s + age_s, now_s)
        fit = reference.held or (-1, -math.inf)
        assert held.tolist() == [fit[0], reference.named[0], fit[1], reference.named[1], reference.renewed_s]
        assert track.is_live(held, now_s, EXPIRY_S) == (reference.held is not None)
