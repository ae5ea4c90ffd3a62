"""Claims about when a sender expects its own next message, and about the grant that it asks for."""

import itertools
from dataclasses import replace
from math import inf, isinf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.channel.radio import Grant
from modelcast.core.exceptions import ConfigError
from modelcast.station.fleet import Fleet, Sending
from modelcast.station.policy import cam_kernels
from modelcast.station.policy.cam import CooperativeAwareness
from modelcast.station.policy.j2945 import J2945
from modelcast.station.policy.j2945_kernels import DENSITY, STATE_COLUMNS
from modelcast.station.policy.j2945_parameters import (
    J2945Parameters,
    j2945_relaxed_parameters,
    j3161_parameters,
)
from modelcast.station.policy.policy_numbers import RULE_PLAIN
from modelcast.station.sender.expecting_kernels import (
    calls_at_once,
    error_that_calls,
    life_of,
    steps_on,
    until_cam,
)
from modelcast.station.sender.names import (
    SENDERS,
    check_one_word_each,
    check_sender,
    has_threshold,
    own_settings,
    sends_models,
)
from modelcast.station.sender.sender import Sender, engine_parameters, named_sender
from modelcast.station.sensing.motion_filter import MotionFilter

DT_S, JITTER_S = 0.1, 0.005
ROUNDING = 1e-9


def straight(sender: Sender, steps: int, *, speed_mps: float = 8.0, yaw_radps: float = 0.0) -> list[Sending]:
    """One car at a steady speed and turn."""
    fleet, sent = Fleet(sender, slots=1, seed=3), list[Sending]()
    place_m, heading = np.zeros((1, 2)), np.zeros(1)
    for step in range(steps):
        heading = heading + DT_S * yaw_radps
        place_m = place_m + DT_S * speed_mps * np.stack([np.sin(heading), np.cos(heading)], axis=1)
        sent += fleet.sense(
            step * DT_S,
            np.array([1]),
            place_m,
            speed_mps=np.full(1, speed_mps),
            heading_rad=heading % (2.0 * np.pi),
            acceleration_mps2=np.zeros(1),
            yaw_rate_radps=np.full(1, yaw_radps),
        )
    return sent


@given(st.floats(0.05, 20.0), st.floats(1e-3, 1e3), st.floats(0.001, 10.0))
def test_an_error_that_grows_with_the_square_reaches_its_threshold_when_it_is_said_to(
    age_s: float, growth: float, threshold_m: float
) -> None:
    life_s = life_of(age_s, growth * age_s**2, threshold_m)
    assert growth * life_s**2 == pytest.approx(threshold_m, rel=ROUNDING)


@pytest.mark.parametrize(("age_s", "error_m"), [(0.0, 0.1), (0.5, inf), (0.5, 0.0)])
def test_of_what_never_erred_no_end_is_known(age_s: float, error_m: float) -> None:
    assert life_of(age_s, error_m, 0.2) == inf
    assert steps_on(3.0, inf, DT_S) == inf


@given(st.integers(1, 40), st.floats(0.001, 0.999))
def test_a_station_asks_at_the_first_step_after_a_life(steps: int, into: float) -> None:
    assert steps_on(3.0, DT_S * (steps - 1 + into), DT_S) == pytest.approx(3.0 + DT_S * steps)
    assert steps_on(3.0, DT_S * steps, DT_S) == pytest.approx(3.0 + DT_S * steps)
    assert steps_on(3.0, 0.0, DT_S) == 3.0 + DT_S


def test_an_error_calls_for_certain_only_where_both_its_bounds_are_one() -> None:
    standard, relaxed = J2945Parameters(), j2945_relaxed_parameters()
    assert not calls_at_once(standard.constants())
    assert calls_at_once(relaxed.constants())
    assert not calls_at_once(replace(relaxed, tracking_error_trigger=False).constants())
    row = np.zeros(STATE_COLUMNS)
    row[DENSITY] = 75.0
    assert error_that_calls(row, relaxed.constants()) == pytest.approx(0.03)


@pytest.mark.parametrize(("speed_mps", "wait_s"), [(20.0, 0.2), (2.0, 1.0), (100.0, 0.1), (0.0, 1.0)])
def test_awareness_messages_come_every_four_metres_or_by_their_timer(speed_mps: float, wait_s: float) -> None:
    numbers = CooperativeAwareness().numbers
    row = np.zeros(cam_kernels.STATE_COLUMNS)
    cam_kernels.start(row, numbers.constants)
    sample = np.array([0.0, 0.0, 0.0, speed_mps, 0.0, 0.0])
    assert until_cam(row, sample, 0.1, numbers.constants) == pytest.approx(wait_s)


@pytest.mark.parametrize(
    ("name", "speed_mps"), [("bsm-10hz", 8.0), ("baseline", 8.0), ("mbc", 8.0), ("baseline", 30.0)]
)
def test_where_time_calls_the_next_message_comes_when_it_was_said_to(name: str, speed_mps: float) -> None:
    sent = straight(named_sender(name), 60, speed_mps=speed_mps)
    assert len(sent) >= 5
    for one, after in itertools.pairwise(sent):
        assert one.next_s - JITTER_S - ROUNDING <= after.send_s <= one.next_s + ROUNDING


def test_where_an_error_calls_as_regularly_it_is_said_as_well() -> None:
    """A car on a circle whose messages coast straight on: each errs as the one before."""
    sent = straight(named_sender("baseline", keep_alive_s=5.0), 80, yaw_radps=0.3)
    gaps = np.diff([one.send_s for one in sent])
    assert gaps[3:].max() < 1.0
    said = [one.next_s - after.send_s for one, after in itertools.pairwise(sent)]
    assert np.mean(np.abs(said) <= DT_S + JITTER_S) > 0.9


def test_every_sender_says_when_it_sends_next() -> None:
    for name in SENDERS:
        sender = named_sender(name)
        if sender.policy.numbers.rule == RULE_PLAIN:  # a rule in NumPy does not say
            continue
        sent = straight(sender, 12)
        assert sent
        assert not any(isinf(one.next_s) for one in sent)
        assert all(one.next_s > one.send_s for one in sent)


def test_every_message_asks_for_the_grant_that_the_sender_s_word_names() -> None:
    for word, grant in (("bsm-10hz", Grant.ANY), ("bsm-10hz:grant=periodic", Grant.PERIODIC)):
        assert {one.grant for one in straight(named_sender(word), 5)} == {grant}
    one_shot = named_sender("j3161-mbc:grant=one-shot,power_control=yes")
    assert (one_shot.grant, one_shot.name) == (
        Grant.ONE_SHOT,
        "j3161-mbc:grant=one-shot,power_control=yes",
    )
    assert {one.grant for one in straight(one_shot, 5)} == {Grant.ONE_SHOT}


def test_senders_under_j3161_are_those_under_j2945_with_its_switches() -> None:
    off, own = j3161_parameters(), MotionFilter()
    for name, motion in (("j3161", None), ("j3161-mbc", own)):
        made = named_sender(name)
        other = named_sender(name.replace("j3161", "j2945"))
        assert made.policy == J2945(engine_parameters(off))
        assert (made.bank, made.start, made.motion) == (other.bank, other.start, motion)
    relaxed = named_sender("j3161-mbc-relaxed")
    assert relaxed.policy == J2945(
        replace(j2945_relaxed_parameters(2.0, engine_parameters()), power_control=False)
    )
    assert relaxed.motion == own
    both = named_sender("j3161:power_control=yes,tracking_error_trigger=true")
    assert both.policy == named_sender("j2945").policy


@pytest.mark.parametrize(
    ("word", "told"),
    [
        ("j3161:power=no", "no setting 'power'; it takes grant, power_control, tracking_error_trigger"),
        ("j2945:power_control=no", "no setting 'power_control'; it takes grant"),
        ("mbc:grant=sometimes", "grant must be one of any, periodic, one-shot"),
        ("j3161:power_control=3", "power_control must be yes or no, got 3"),
        ("j3161:power_control=1", "power_control must be yes or no, got 1"),
        ("j3161:power_control=0.0", "power_control must be yes or no, got 0.0"),
        ("j3161:power_control", "is not KEY=VALUE"),
    ],
)
def test_a_word_that_sets_what_is_not_there_is_refused(word: str, told: str) -> None:
    with pytest.raises(ConfigError, match=told):
        check_sender(word)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("j3161:power_control=no", "j3161:power_control=false"),
        ("j3161:power_control=yes,grant=periodic", "j3161:grant=periodic,power_control=yes"),
        ("mbc", "mbc:grant=any"),
    ],
)
def test_two_words_for_one_sender_are_refused(one: str, other: str) -> None:
    check_one_word_each([one, "j3161", "j3161:power_control=yes", "j3161:grant=periodic", one])
    with pytest.raises(ConfigError, match=f"{other}' is '{one}': name it once"):
        check_one_word_each([one, "j3161", other])


def test_a_relaxed_sender_without_its_trigger_is_refused() -> None:
    with pytest.raises(ValueError, match="tracking_error_trigger must be yes"):
        named_sender("j3161-mbc-relaxed:tracking_error_trigger=no")


def test_settings_change_neither_bank_nor_threshold_of_a_sender() -> None:
    for name in SENDERS:
        word = f"{name}:grant=one-shot"
        assert sends_models(word) == sends_models(name)
        assert has_threshold(word) == has_threshold(name)
        assert own_settings(word).grant == "one-shot"
        assert own_settings(name).grant == "any"
