"""Relays: each message once, young, near and not where another relay did so; hosts are not deceived by it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.station.receiver.local_dynamic_map import Receipt
from modelcast.station.relay import Overheard, RelayRule
from modelcast.station.station import Station

TURN_S = 0.1
RULE = RelayRule(max_age_s=0.3, rate_hz=50.0, within_m=200.0)


def overheard(*rows: tuple[int, int, int, float, float, float, bool]) -> Overheard:
    """Rows of unit, key, author, made, heard, distance, copy."""
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    unit, key, author = (column.astype(np.int64) for column in columns[:3])
    made_s, heard_s, distance_m = (column.astype(np.float64) for column in columns[3:6])
    return Overheard(
        unit, key, author, made_s=made_s, heard_s=heard_s, distance_m=distance_m, is_copy=columns[6]
    )


def one(
    key: int = 7, author: int = 3, made_s: float = 0.0, *, far_m: float = 50.0, copy: bool = False
) -> Overheard:
    return overheard((0, key, author, made_s, made_s + 0.01, far_m, copy))


@pytest.mark.parametrize(
    ("heard", "now_s", "why"),
    [
        (one(), 0.1, "repeated"),
        (one(), 0.3, "repeated"),
        (one(), 0.31, "too_old"),
        (one(far_m=200.0), 0.1, "repeated"),
        (one(far_m=200.1), 0.1, "too_far"),
        (one(far_m=np.nan), 0.1, "too_far"),
        (one(copy=True), 0.1, "by_another"),
    ],
)
def test_what_is_repeated_and_why_not(heard: Overheard, now_s: float, why: str) -> None:
    repeats, state = RULE.turn(RULE.init(1), heard, now_s, now_s + TURN_S)
    assert repeats.key.tolist() == ([7] if why == "repeated" else [])
    for name in ("repeated", "by_another", "replaced", "too_old", "too_far"):
        assert getattr(state, name).tolist() == [int(name == why)]


def test_a_copy_heard_while_the_message_waits_takes_its_place() -> None:
    slow = RelayRule(rate_hz=1.0)
    repeats, state = slow.turn(slow.init(1), one(), 0.1, 0.2)
    assert not repeats.key.size
    _, state = slow.turn(state, one(copy=True), 0.2, 0.3)
    assert state.by_another.tolist() == [1]


def test_a_newer_message_of_the_author_takes_the_place_of_one_that_waits() -> None:
    both = overheard((0, 1, 3, 0.0, 0.01, 9.0, False), (0, 2, 3, 0.05, 0.06, 9.0, False))
    repeats, state = RULE.turn(RULE.init(1), both, 0.1, 0.2)
    assert repeats.key.tolist() == [2]
    assert state.replaced.tolist() == [1]


def test_of_too_many_those_are_repeated_that_came_first_and_evenly_spread() -> None:
    many = overheard(*((0, k, k, 0.0, 0.02 - 0.0001 * k, 9.0, False) for k in range(20)))
    repeats, _ = RULE.turn(RULE.init(1), many, 0.1, 0.2)
    assert repeats.key.tolist() == [19, 18, 17, 16, 15]
    assert np.diff(repeats.send_s) == pytest.approx(1.0 / RULE.rate_hz)


FRAMES = st.lists(
    st.tuples(st.integers(0, 2), st.integers(0, 30), st.floats(0.0, 0.35), st.booleans(), st.integers(0, 4)),
    max_size=40,
)


@given(FRAMES)
def test_each_message_leaves_a_relay_at_most_once_young_and_within_the_rate(
    frames: list[tuple[int, int, float, bool, int]],
) -> None:
    state, sent = RULE.init(3), list[tuple[int, int]]()
    for turn in range(1, 7):
        now_s = turn * TURN_S
        rows = [
            (unit, key, key % 5, 0.1 * (key % 4), max(now_s - late_s, 0.0), 10.0, copy)
            for unit, key, late_s, copy, when in frames
            if when == turn
        ]
        given_rows = overheard(*rows) if rows else Overheard.nothing()
        repeats, state = RULE.turn(state, given_rows, now_s, now_s + TURN_S)
        assert ((repeats.send_s >= now_s) & (repeats.send_s < now_s + TURN_S)).all()
        assert (np.diff(repeats.send_s) >= 0.0).all()
        assert (now_s - 0.1 * (repeats.key % 4) <= RULE.max_age_s + 1e-9).all()
        assert (np.bincount(repeats.unit, minlength=3) <= 1 + RULE.rate_hz * TURN_S).all()
        sent += list(zip(repeats.unit.tolist(), repeats.key.tolist(), strict=True))
    assert len(sent) == len(set(sent))
    assert state.repeated.sum() == len(sent)


def test_settings_out_of_range_are_refused() -> None:
    for wrong in ({"max_age_s": 0.0}, {"rate_hz": np.inf}, {"within_m": -1.0}):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            RelayRule(**wrong)
    with pytest.raises(ValueError, match="unit must lie in"):
        RULE.turn(RULE.init(1), overheard((1, 1, 1, 0.0, 0.0, 0.0, False)), 0.1, 0.2)


def driven(seconds: float) -> list[tuple[float, bytes]]:
    """What a car on a straight road sends: when, and the octets."""
    car, sent = Station("bsm-10hz", temporary_id=1), list[tuple[float, bytes]]()
    for step in range(round(10 * seconds)):
        t_s = 0.1 * step
        for message in car.sense(t_s, (15.0 * t_s, 0.0), speed_mps=15.0, heading_rad=np.pi / 2):
            sent.append((message.send_s, message.octets))
    return sent


def test_copies_change_nothing_of_what_a_host_believes() -> None:
    """Every message comes twice, the second time after the next original: late, and never newer."""
    plain, repeated = Station(temporary_id=2), Station(temporary_id=2)
    sent = driven(3.0)
    for at, (send_s, octets) in enumerate(sent):
        plain.hear([octets], received_s=[send_s])
        repeated.hear([octets], received_s=[send_s])
        copies = [sent[at][1]] + ([sent[at - 1][1]] if at else [])
        receipts = repeated.hear(copies, received_s=[send_s + 0.01] * len(copies))
        assert set(receipts.tolist()) <= {Receipt.REPEATED, Receipt.OLDER}
        one, other = plain.believe(send_s + 0.02), repeated.believe(send_s + 0.02)
        np.testing.assert_array_equal(one.position_m, other.position_m)
        np.testing.assert_array_equal(one.received_s, other.received_s)
        np.testing.assert_array_equal(one.information_age_s, other.information_age_s)


def test_a_station_does_not_track_itself_by_its_own_messages_repeated() -> None:
    car = Station("bsm-10hz", temporary_id=1)
    sent = [
        message
        for step in range(10)
        for message in car.sense(0.1 * step, (1.5 * step, 0.0), speed_mps=15.0, heading_rad=np.pi / 2)
    ]
    octets, times = [one.octets for one in sent], [one.send_s + 0.1 for one in sent]
    assert set(car.hear(octets[:5], received_s=times[:5]).tolist()) == {Receipt.REPEATED}
    car.rename(77)
    assert set(car.hear(octets[5:], received_s=times[5:]).tolist()) == {Receipt.REPEATED}
    assert car.believe(1.1).vehicle.size == 0
    other = Station("bsm-10hz", temporary_id=2)
    other.hear(octets, received_s=times)
    assert other.believe(1.1).vehicle.tolist() == [1]


def test_a_copy_of_a_lost_message_is_as_old_as_the_message() -> None:
    host = Station(temporary_id=2)
    send_s, octets = driven(1.0)[-1]
    assert host.hear([octets], received_s=[send_s + 0.25]).tolist() == [Receipt.ACCEPTED]
    direct = Station(temporary_id=2)
    direct.hear([octets], received_s=[send_s])
    one, other = host.believe(send_s + 0.3), direct.believe(send_s + 0.3)
    np.testing.assert_array_equal(one.information_age_s, other.information_age_s)
    np.testing.assert_array_equal(one.position_m, other.position_m)
