"""Claims about grants in LTE-V2X mode 4: copies, one-shots, and the interval that is announced."""

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.channel.error_models import ThresholdErrorModel
from modelcast.channel.path_loss import LogDistance
from modelcast.channel.propagation import Propagation
from modelcast.channel.radio import Grant, Receptions, Transmissions
from modelcast.channel.sidelink import Sidelink, SidelinkState
from modelcast.channel.sidelink_grant_kernels import (
    AHEAD,
    BAND,
    COUNTER,
    GRANT_COLUMNS,
    INTERVAL,
    LENGTH,
    NEXT,
    SHOT,
    interval_for,
)
from modelcast.channel.sidelink_parameters import SidelinkParameters, j3161_sidelink_parameters

CLEAR = Propagation(LogDistance(2.0), None, None)
PAIR = np.array([[0.0, 0.0], [50.0, 0.0]])
STEP_S = 0.1


def plain(**changes: Any) -> Sidelink:
    return Sidelink(replace(SidelinkParameters(), **changes), CLEAR, ThresholdErrorModel(5.0))


def one_by_one(
    radio: Sidelink,
    place_m: np.ndarray,
    steps: int,
    rows: dict[int, tuple[float, float, Grant]],
    *,
    senders: tuple[int, ...] = (0,),
    seed: int = 0,
) -> tuple[list[Receptions], list[SidelinkState]]:
    """Messages by step: how far into it they are ready, when the next is said to be [s], the grant."""
    state, heard, states = radio.init(place_m.shape[0], np.random.default_rng(seed)), [], []
    for k in range(steps):
        sent = rows.get(k)
        who = senders if sent is not None else ()
        into_s, next_s, grant = (0.0, np.inf, Grant.ANY) if sent is None else sent
        case = Transmissions(
            np.array(who, dtype=np.int64),
            np.full(len(who), k * STEP_S + into_s),
            size_bytes=np.full(len(who), 80),
            power_dbm=np.full(len(who), 20.0),
            message_id=1000 * k + np.arange(len(who)),
            next_s=np.full(len(who), next_s),
            grant=np.full(len(who), int(grant)),
        )
        one, state = radio.step(state, case, place_m, round((k + 1) * STEP_S, 3))
        heard.append(one)
        states.append(state)
    return heard, states


def send(who: list[int], ready_s: float, message_id: int = 7) -> Transmissions:
    """One short message of each, ready at the same time."""
    return Transmissions(
        np.array(who, dtype=np.int64),
        np.full(len(who), ready_s),
        size_bytes=np.full(len(who), 80),
        power_dbm=np.full(len(who), 20.0),
        message_id=message_id + np.arange(len(who)),
    )


def every_step(steps: int, grant: Grant = Grant.ANY) -> dict[int, tuple[float, float, Grant]]:
    return {k: (0.0, (k + 1) * STEP_S, grant) for k in range(steps)}


def sent_ms(states: list[SidelinkState]) -> list[int]:
    """Subframes in which vehicle 0 sent, within the second that it remembers."""
    sensed = states[-1].sensed[:, 0].reshape(100, 10, -1)
    return np.flatnonzero(np.isinf(sensed[:, :, 0].T)).tolist()


def test_a_message_sent_twice_is_received_and_counted_once() -> None:
    heard, states = one_by_one(plain(transmissions=2), PAIR, 8, every_step(6))
    assert len(sent_ms(states)) == 12
    assert sum(one.size for one in heard) == 6
    assert sum(int(one.outcomes.sum()) for one in heard) == 6
    assert states[-1].copy_pair.shape[0] == 0


def test_copies_are_at_most_15_subframes_apart_and_each_in_its_own() -> None:
    apart = set()
    for seed in range(30):
        _, states = one_by_one(plain(transmissions=2), PAIR, 2, {0: (0.0, np.inf, Grant.ANY)}, seed=seed)
        first, second = sent_ms(states)
        apart.add(second - first)
    assert apart <= set(range(1, 16))
    assert len(apart) > 8


def test_with_two_copies_fewer_messages_are_lost_to_half_duplex() -> None:
    """Two that choose by chance sometimes send at once; both copies must meet the other's for a loss."""
    lost = {}
    for transmissions in (1, 2):
        radio, count, total = plain(transmissions=transmissions, one_shot=True, last_ms=20), 0, 0
        for seed in range(12):
            heard, _ = one_by_one(radio, PAIR, 40, every_step(40), senders=(0, 1), seed=seed)
            outcomes = np.sum([one.outcomes for one in heard], axis=0).sum(axis=0)
            count, total = count + int(outcomes[1]), total + int(outcomes.sum())
        lost[transmissions] = count / total
    assert 0.0 < lost[2] < lost[1]


@settings(max_examples=15)
@given(seed=st.integers(0, 10_000), steps=st.integers(1, 6))
def test_copies_change_no_count_of_pairs(seed: int, steps: int) -> None:
    """Every message that is not expired counts once for each vehicle in reach, once it has been sent."""
    rng = np.random.default_rng(seed)
    vehicles = 12
    place_m = rng.uniform(0.0, 300.0, (vehicles, 2))
    radio = plain(transmissions=2, interleaved=True, bins=40)
    state, sent, expired, pairs, received = radio.init(vehicles, rng), 0, 0, 0, set[tuple[int, int]]()
    for k in range(steps + 2):
        who = rng.integers(0, vehicles, 20 if k < steps else 0)
        case = Transmissions(
            who,
            np.sort(rng.uniform(k * STEP_S, k * STEP_S + 0.0999, who.size)),
            size_bytes=np.full(who.size, 80),
            power_dbm=np.full(who.size, 20.0),
            message_id=1000 * k + np.arange(who.size),
            grant=rng.integers(0, 3, who.size),
        )
        one, state = radio.step(state, case, place_m, round((k + 1) * STEP_S, 3))
        sent, expired, pairs = sent + who.size, expired + one.expired.size, pairs + int(one.outcomes.sum())
        found = set(zip(one.message_id.tolist(), one.receiver.tolist(), strict=True))
        assert len(found) == one.size
        assert not found & received
        received |= found
    assert pairs == (sent - expired) * (vehicles - 1)


def test_a_step_that_ends_between_two_copies_loses_nothing() -> None:
    """Steps of one millisecond give what one long step gives."""
    radio = plain(transmissions=2)
    case = Transmissions(
        np.array([0]), np.array([0.0]), size_bytes=np.array([80]), power_dbm=np.array([20.0]),
        message_id=np.array([7]),
    )  # fmt: skip
    nothing = replace(case, **{one.name: getattr(case, one.name)[:0] for one in fields(case)})
    whole, _ = radio.step(radio.init(2, np.random.default_rng(5)), case, PAIR, 0.15)
    state, times, outcomes = radio.init(2, np.random.default_rng(5)), list[float](), 0
    for k in range(150):
        one, state = radio.step(state, case if k == 0 else nothing, PAIR, round((k + 1) * 1e-3, 3))
        times += one.t_s.tolist()
        outcomes = outcomes + one.outcomes
    assert times == whole.t_s.tolist()
    assert np.array_equal(outcomes, whole.outcomes)


@pytest.mark.parametrize("one_shot", [True, False])
def test_the_first_copy_announces_the_second_alone(one_shot: bool) -> None:
    """A receiver holds one subframe for it, and none once it is over; a reservation has its own beside."""
    radio = plain(transmissions=2, one_shot=one_shot, last_ms=20)
    state, held = radio.init(2, np.random.default_rng(3)), list[list[int]]()
    for k in range(60):
        _, state = radio.step(state, send([0] if k == 0 else [], 0.0), PAIR, round((k + 1) * 1e-3, 3))
        held.append(np.flatnonzero(state.reserved[:, 1].any(axis=1)).tolist())
    first, second = sent_ms([state])
    again = [] if one_shot else [first]
    assert held[first - 1] == []
    assert held[first : second - 1] == [sorted([*again, second])] * (second - 1 - first)
    assert held[second] == ([] if one_shot else [first, second])


AWAY = np.array([[np.nan, np.nan], [50.0, 0.0]])
NORTHLESS = np.array([[0.0, np.nan], [50.0, 0.0]])


@pytest.mark.parametrize("gone", [AWAY, NORTHLESS])
@pytest.mark.parametrize("one_shot", [False, True])
def test_who_leaves_between_two_copies_leaves_its_message_counted(gone: np.ndarray, one_shot: bool) -> None:
    radio = plain(transmissions=2, one_shot=one_shot)
    state, place_m, received, counted = radio.init(2, np.random.default_rng(1)), PAIR, 0, 0
    for k in range(130):
        case = send([0] if k == 0 else [], 0.0)
        one, state = radio.step(state, case, place_m, round((k + 1) * 1e-3, 3))
        received, counted = received + one.size, counted + int(one.outcomes.sum())
        place_m = gone if received else place_m
        assert one.expired.size == 0
    assert (received, counted, state.copy_pair.shape[0]) == (1, 1, 0)
    assert len(sent_ms([state])) == 1


@pytest.mark.parametrize("gone", [AWAY, NORTHLESS])
@pytest.mark.parametrize("one_shot", [False, True])
def test_a_message_whose_turn_comes_while_its_sender_is_away_expires(
    gone: np.ndarray, one_shot: bool
) -> None:
    """And is not sent when the sender is back."""
    radio = plain(reselect_after=9, one_shot=one_shot)
    _, state = radio.step(radio.init(2, np.random.default_rng(1)), send([0], 0.0), PAIR, 0.001)
    away, state = radio.step(state, send([], 0.0), gone, 0.15)
    back, state = radio.step(state, send([], 0.0), PAIR, 0.6)
    assert (away.size, away.expired.tolist()) == (0, [7])
    assert (back.size, back.expired.size, int(back.outcomes.sum())) == (0, 0, 0)


def test_a_message_ready_while_its_sender_is_away_takes_the_waiting_one_along() -> None:
    radio = plain()
    _, state = radio.step(radio.init(2, np.random.default_rng(1)), send([0], 0.0), PAIR, 0.001)
    assert state.grant[0, NEXT] > 2
    away, state = radio.step(state, send([0], 0.001, 8), AWAY, 0.002)
    back, _ = radio.step(state, send([], 0.0), PAIR, 0.6)
    assert away.expired.tolist() == [7, 8]
    assert (back.size, back.expired.size) == (0, 0)


def test_every_second_to_sixth_message_is_a_one_shot_and_the_reservation_stays() -> None:
    heard, _ = one_by_one(plain(interleaved=True, keep_ratio=1.0), PAIR, 120, every_step(120))
    phase = np.array([round(1e3 * one.t_s[0]) % 100 for one in heard if one.size])
    reserved = np.bincount(phase).argmax()
    shots = np.flatnonzero(phase != reserved)
    assert set(np.diff(shots).tolist()) <= {2, 3, 4, 5, 6}
    assert np.diff(shots).mean() == pytest.approx(4.0, abs=0.6)  # of 2 to 6, 30 of them


def test_an_interleaved_one_shot_ends_a_collision_that_would_last() -> None:
    """Two with one resource never hear each other; with one-shots at least every 6th message."""
    longest = {}
    for interleaved in (False, True):
        radio = plain(interleaved=interleaved, keep_ratio=1.0, sub_channels=1, first_ms=1, last_ms=20)
        state = radio.init(3, np.random.default_rng(1))
        state.grant[:2, BAND], state.grant[:2, NEXT], state.grant[:2, INTERVAL] = 0, 10, 100
        state.grant[:2, LENGTH], state.grant[:2, COUNTER] = 1, 5
        place_m = np.array([[0.0, 0.0], [20.0, 0.0], [10.0, 0.0]])
        gaps, gap = [], 0
        for k in range(80):
            case = Transmissions(
                np.array([0, 1]), np.full(2, k * STEP_S), size_bytes=np.array([80, 80]),
                power_dbm=np.full(2, 20.0), message_id=np.array([2 * k, 2 * k + 1]),
            )  # fmt: skip
            one, state = radio.step(state, case, place_m, round((k + 1) * STEP_S, 3))
            heard = np.any((one.sender == 0) & (one.receiver == 1))
            gaps, gap = ([*gaps, gap], 0) if heard else (gaps, gap + 1)
        longest[interleaved] = max([*gaps, gap])
    assert longest[False] == 80
    assert longest[True] <= 6


def test_a_grant_asked_for_is_what_a_message_gets() -> None:
    for one_shot in (False, True):
        radio = plain(one_shot=one_shot, keep_ratio=1.0)
        heard, states = one_by_one(radio, PAIR, 20, every_step(20, Grant.PERIODIC))
        assert len({round(1e3 * t_s) % 100 for one in heard for t_s in one.t_s}) == 1
        assert states[-1].reserved[:, 1].any()
        heard, states = one_by_one(radio, PAIR, 20, every_step(20, Grant.ONE_SHOT))
        assert len({round(1e3 * t_s) % 100 for one in heard for t_s in one.t_s}) > 8
        assert not states[-1].reserved[:, 1].any()


def test_a_one_shot_asked_for_leaves_the_reservation_its_turns() -> None:
    """It passes without a message, as it would for silence: `reselect_after` turns later it is gone."""
    rows = every_step(4, Grant.PERIODIC)
    rows[4] = (0.0, np.inf, Grant.ONE_SHOT)
    for reselect_after, held in ((1, False), (3, True)):
        radio = plain(keep_ratio=1.0, reselect_after=reselect_after, first_ms=1, last_ms=20)
        _, states = one_by_one(radio, PAIR, 6, rows)
        assert bool(states[5].grant[0, BAND] >= 0) == held
        assert states[5].grant[0, BAND + SHOT] == -1


@given(
    ahead=st.integers(1, 2500), subframe=st.integers(0, 10_000), shortest=st.sampled_from([20, 50, 100, 300])
)
def test_the_interval_announced_is_the_shortest_that_outlasts_the_wait(
    ahead: int, subframe: int, shortest: int
) -> None:
    radio = plain(interval_by_next=True, interval_ms=shortest, longest_interval_ms=600, first_ms=2)
    grant = np.zeros((1, GRANT_COLUMNS), dtype=np.int64)
    grant[0, AHEAD] = subframe + ahead
    allowed = [one for one in (20, 50, *range(100, 601, 100)) if one >= shortest]
    fitting = [one for one in allowed if one >= ahead + 2]
    assert interval_for(grant, 0, subframe, radio.constants) == (fitting[0] if fitting else 600)
    grant[0, AHEAD] = -1
    assert interval_for(grant, 0, subframe, radio.constants) == shortest


def test_a_message_that_comes_when_it_was_expected_goes_out_where_others_were_told() -> None:
    rows = {0: (0.05, 0.75, Grant.ANY), 7: (0.05, np.inf, Grant.ANY)}
    radio = plain(interval_by_next=True, grant_by_next=True)
    for seed in range(10):
        _, states = one_by_one(radio, PAIR, 7, rows, seed=seed)
        told = np.argwhere(states[-1].reserved[:, 1] > 0.0)
        assert told.shape[0] == 1
        heard, states = one_by_one(radio, PAIR, 10, rows, seed=seed)
        (first_s,), (second_s,) = (one.t_s for one in heard if one.size)
        interval_ms = round(1e3 * (second_s - first_s))
        assert interval_ms in {700, 800}
        assert (round(1e3 * second_s) - 1) % 1000 == told[0, 0]
        assert 1 <= round(1e3 * second_s) - 1 - 750 <= 100
        assert not states[-1].reserved[:, 1].any()  # nothing is known of the one after


def test_without_a_next_message_or_one_too_far_nothing_is_reserved() -> None:
    radio = plain(grant_by_next=True, interval_by_next=True, longest_interval_ms=500)
    for next_s, reserves in ((np.inf, False), (0.9, False), (0.3, True)):
        _, states = one_by_one(radio, PAIR, 2, {0: (0.0, next_s, Grant.ANY)})
        assert states[-1].reserved[:, 1].any() == reserves


def test_a_place_that_another_announced_is_not_announced_again() -> None:
    radio = plain(interval_by_next=True, sub_channels=1)
    state = radio.init(2, np.random.default_rng(2))
    state.reserved[100:, 0, 0] = 1.0  # another has announced all that lies more than 100 ms ahead
    case = Transmissions(
        np.array([0]), np.array([0.0]), size_bytes=np.array([80]), power_dbm=np.array([20.0]),
        message_id=np.array([1]), next_s=np.array([0.15]),
    )  # fmt: skip
    _, after = radio.step(state, case, PAIR, 0.101)
    assert after.grant[0, BAND] == -1
    assert not after.reserved[:, 1].any()


@pytest.mark.parametrize("longest_ms", [100, 600])
def test_what_another_announced_for_now_keeps_nobody_from_coming_back(longest_ms: int) -> None:
    """It is over by then, also where the longest interval leads back to its phase."""
    radio = plain(interval_by_next=True, longest_interval_ms=longest_ms, keep_ratio=1.0)
    state = radio.init(2, np.random.default_rng(3))
    case = replace(send([0], 0.0), next_s=np.array([0.001 * longest_ms]))
    _, state = radio.step(state, case, PAIR, 0.001)
    turn, band = int(state.grant[0, NEXT]), int(state.grant[0, BAND])
    state.reserved[turn % longest_ms, 0, band] = 1.0
    _, state = radio.step(state, send([], 0.0), PAIR, round((turn + 1) * 1e-3, 3))
    assert state.grant[0, BAND] == band
    assert state.grant[0, NEXT] == turn + state.grant[0, INTERVAL]
    assert not state.reserved[:, 0].any()


def test_deployed_radios_have_20_mhz_two_copies_and_interleaved_one_shots() -> None:
    deployed = j3161_sidelink_parameters()
    assert deployed.sub_channels * deployed.blocks == 100
    assert (deployed.transmissions, deployed.interleaved, deployed.one_shot) == (2, True, False)
    heard, states = one_by_one(Sidelink(deployed, CLEAR, ThresholdErrorModel(5.0)), PAIR, 12, every_step(10))
    assert sum(one.size for one in heard) == 10
    assert len(sent_ms(states)) in {16, 17, 18, 19, 20}


@pytest.mark.parametrize(
    "change",
    [
        {"transmissions": 3},
        {"transmissions": 0},
        {"one_shot_least": 0},
        {"one_shot_least": 7},
        {"longest_interval_ms": 150},
        {"longest_interval_ms": 200, "interval_ms": 300},
        {"interleaved": True, "one_shot": True},
    ],
)
def test_impossible_grants_are_refused(change: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="must"):
        replace(SidelinkParameters(), **change)
