"""Claims about sessions: the stations of everywhere, in any order of ids; a refusal changes nothing."""

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.core.kinds import Kind
from modelcast.runtime.external.exchange import MOST_TRACKS, Sent, SessionSettings, Step
from modelcast.runtime.external.kept_messages import KeptMessages
from modelcast.runtime.external.refusal import FieldError
from modelcast.runtime.external.session import Session
from modelcast.station.fleet import Fleet
from modelcast.station.receiver.local_dynamic_map import Receipt
from modelcast.station.station import Station

from ...convoy import Convoy  # noqa: TID252 - tests are no package

SETTINGS = SessionSettings(5, capacity=50, seed=3)


def same(one: object, other: object) -> None:
    for each in fields(one):  # type: ignore[arg-type]
        np.testing.assert_array_equal(getattr(one, each.name), getattr(other, each.name), err_msg=each.name)


def station_motion(step: Step, row: int) -> dict[str, Any]:
    return {
        name: float(getattr(step, name)[row])
        for name in ("speed_mps", "heading_rad", "acceleration_mps2", "yaw_rate_radps")
    }


@pytest.mark.parametrize("sender", ["mbc", "baseline", "j2945-mbc", "cam", "free"])
def test_a_vehicle_of_a_session_sends_what_a_station_sends(sender: str) -> None:
    convoy = Convoy(1)
    session = Session(SessionSettings(1, sender=sender, seed=7, latitude_deg=48.0))
    station = Station(sender, temporary_id=3, seed=7, origin=session.origin)
    octets: list[list[bytes]] = [[], []]
    for number in range(100):
        step = convoy.step(number)
        octets[0] += session.step(step).frames()
        sent = station.sense(step.t_s, tuple(step.position_m[0].tolist()), **station_motion(step, 0))
        octets[1] += [one.octets for one in sent]
    assert octets[0] == octets[1]
    assert octets[0]


def test_it_is_a_fleet() -> None:
    convoy = Convoy(5)
    session = Session(SETTINGS)
    fleet = Fleet("mbc", slots=5, seed=3)
    kept: dict[int, bytes] = {}
    for number in range(40):
        step = convoy.step(number)
        sent = session.step(step)
        for host in convoy.vehicle.tolist():
            mine = np.flatnonzero(step.receiver == host)
            order = mine[np.lexsort((step.message[mine], step.received_s[mine]))]
            octets = [kept[int(step.message[at])] for at in order]
            receipts = fleet.hear(host, octets, received_s=step.received_s[order]) if order.size else order
            np.testing.assert_array_equal(receipts, sent.receipt[order])
        own = fleet.sense(
            step.t_s,
            step.vehicle,
            step.position_m,
            speed_mps=step.speed_mps,
            heading_rad=step.heading_rad,
            acceleration_mps2=step.acceleration_mps2,
            yaw_rate_radps=step.yaw_rate_radps,
        )
        assert [one.octets for one in own] == sent.frames()
        assert [one.send_s for one in own] == sent.send_s.tolist()
        assert [one.frame_bytes for one in own] == sent.frame_bytes.tolist()
        assert [one.power_dbm for one in own] == sent.power_dbm.tolist()
        kept |= dict(zip(sent.message.tolist(), sent.frames(), strict=True))
        convoy.carry(sent)
    around = fleet.believe(3, 4.0)
    found = session.believe(np.array([3]), 4.0)
    np.testing.assert_array_equal(found.position_m, around.position_m)
    np.testing.assert_array_equal(found.covariance_m2, around.covariance_m2)
    assert found.vehicle.tolist() == [10, 17, 24, 31]


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1))
def test_the_order_of_rows_makes_no_difference(seed: int) -> None:
    rng = np.random.default_rng(seed)
    plain, mixed = Convoy(5), Convoy(5)
    one, other = Session(SETTINGS), Session(SETTINGS)
    for number in range(12):
        sent = one.step(plain.step(number))
        shuffled = other.step(mixed.step(number, order=rng.permutation(5)))
        receipts = sent.receipt
        for each in fields(Sent):
            if each.name != "receipt":
                np.testing.assert_array_equal(getattr(sent, each.name), getattr(shuffled, each.name))
        assert sorted(receipts) == sorted(shuffled.receipt)
        plain.carry(sent)
        pairs = sent.message.size * 4
        mixed.carry(shuffled, rng.permutation(pairs))
    same(one.believe(plain.vehicle, 1.2), other.believe(plain.vehicle, 1.2))


WRONG: list[tuple[str, dict[str, Any]]] = [
    ("t_s", {"t_s": 0.1}),
    ("t_s", {"t_s": np.nan}),
    ("t_s", {"t_s": np.inf}),
    ("vehicle", {"vehicle": np.array([3, 10, 17, 24, 24])}),
    ("vehicle", {"vehicle": np.array([3, 10, 17, 24, 2**32])}),
    ("vehicle", {"vehicle": np.array([3, 10, 17, 24, -1])}),
    ("position_m", {"position_m": np.zeros((4, 2))}),
    ("position_m", {"position_m": np.full((5, 2), np.nan)}),
    ("position_m", {"position_m": np.full((5, 2), 1e6)}),
    ("speed_mps", {"speed_mps": np.full(5, -1.0)}),
    ("speed_mps", {"speed_mps": np.zeros(4)}),
    ("columns", {"speed_mps": None}),
    ("heading_rad", {"heading_rad": np.full(5, np.inf)}),
    ("acceleration_mps2", {"acceleration_mps2": np.full(5, 1e9)}),
    ("yaw_rate_radps", {"yaw_rate_radps": np.full(5, np.nan)}),
    ("busy_ratio", {"busy_ratio": np.full(5, 1.5)}),
    ("kind", {"kind": np.full(5, 9)}),
    ("kind", {"kind": np.array([1, 0, 0, 0, 0])}),
    ("vehicle", {"vehicle": np.array([3, 10, 17, 24, 99]), "kind": np.array([0, 0, 0, 0, 1])}),
    ("begins", {"begins": np.full(5, 2)}),
    ("receiver", {"receiver": np.array([99])}),
    ("received_s", {"received_s": np.array([0.3])}),
    ("received_s", {"received_s": np.array([np.nan])}),
    ("received_s", {"received_s": np.empty(0)}),
    ("message", {"message": np.array([1000])}),
    ("message", {"message": np.array([-2])}),
    ("foreign_length", {"message": np.array([-1])}),
    ("foreign_length", {"message": np.array([-1]), "foreign_length": np.array([0])}),
    ("foreign_length", {"message": np.array([-1]), "foreign_length": np.array([5000])}),
    ("foreign_octets", {"message": np.array([-1]), "foreign_length": np.array([5])}),
    ("foreign_octets", {"foreign_octets": b"x"}),
]


@pytest.mark.parametrize(("field", "changed"), WRONG)
def test_a_step_that_is_refused_has_changed_nothing(field: str, changed: dict[str, Any]) -> None:
    one, other = Convoy(5), Convoy(5)
    asked, unasked = Session(SETTINGS), Session(SETTINGS)
    for number in range(6):
        step = one.step(number)
        if number == 2:
            heard = {"receiver": np.array([3]), "received_s": np.array([0.15]), "message": np.array([0])}
            with pytest.raises(FieldError) as told:
                asked.step(replace(step, **{**heard, **changed}))
            assert told.value.field == field
        same(asked.step(step), sent := unasked.step(other.step(number)))
        one.carry(sent)
        other.carry(sent)
    same(asked.believe(one.vehicle, 0.5), unasked.believe(one.vehicle, 0.5))


def test_who_is_missing_has_left_and_may_come_again() -> None:
    session, convoy = Session(replace(SETTINGS, slots=2)), Convoy(3)
    assert session.step(convoy.step(0, order=[0, 1])).left.size == 0
    assert session.step(convoy.step(1, order=[2])).left.tolist() == [3, 10]
    with pytest.raises(FieldError, match="host must be a station of the newest step, got 3"):
        session.believe(np.array([3]), 0.1)
    assert session.step(convoy.step(2, order=[0, 2])).left.size == 0
    with pytest.raises(FieldError, match="at most 2, the session's slots, got 3 stations"):
        session.step(convoy.step(3))


def test_people_and_roadside_units_are_stations_too() -> None:
    session = Session(replace(SETTINGS, people_slots=1))
    convoy, kind = Convoy(4), np.array([Kind.VEHICLE, Kind.PEDESTRIAN, Kind.ROADSIDE, Kind.CYCLIST])
    senders: set[int] = set()
    for number in range(30):
        sent = session.step(convoy.step(number, kind=kind))
        assert (np.diff(sent.send_s) >= 0.0).all()
        senders |= set(sent.vehicle.tolist())
        convoy.carry(sent)
    assert senders == {3, 10, 24}
    around = session.believe(np.array([17]), 3.0)
    assert around.vehicle.tolist() == [3, 10, 24]
    assert around.kind.tolist() == [Kind.VEHICLE, Kind.PEDESTRIAN, Kind.CYCLIST]
    with pytest.raises(FieldError, match="a roadside unit is not warned"):
        session.warnings(np.array([17]), ["fcw"])
    gone = session.step(convoy.step(30, order=[0], kind=kind[:1], receiver=np.empty(0, dtype=np.int64),
                                    received_s=np.empty(0), message=np.empty(0, dtype=np.int64)))  # fmt: skip
    assert gone.left.tolist() == [10, 17, 24]
    back = session.step(Step(3.1, np.array([3, 17]), position_m=np.zeros((2, 2)), kind=np.array([0, 4]),
                             **station_columns(convoy.step(31, order=[0, 1]))))  # fmt: skip
    assert back.left.size == 0
    assert session.believe(np.array([17]), 3.1).vehicle.size == 0


def station_columns(step: Step) -> dict[str, Any]:
    names = ("speed_mps", "heading_rad", "acceleration_mps2", "yaw_rate_radps")
    return {name: getattr(step, name) for name in names}


def test_a_vehicle_that_closes_in_is_warned_of() -> None:
    session = Session(replace(SETTINGS, slots=2))
    heard: dict[str, Any] = {}
    for number in range(60):
        t_s = 0.1 * number
        sent = session.step(
            Step(
                t_s,
                np.array([1, 2]),
                position_m=np.array([[0.0, 25.0 * t_s], [0.0, 180.0]]),
                speed_mps=np.array([25.0, 0.0]),
                heading_rad=np.zeros(2),
                acceleration_mps2=np.zeros(2),
                yaw_rate_radps=np.zeros(2),
                **heard,
            )
        )
        heard = {"receiver": 3 - sent.vehicle, "received_s": sent.send_s, "message": sent.message}
    found = session.warnings(np.array([2, 1]), ["ima", "fcw"])
    assert (found.host.tolist(), found.vehicle.tolist(), found.application.tolist()) == ([1], [2], [1])
    assert found.level.tolist() == [2]
    assert found.time_s[0] == pytest.approx((180.0 - 25.0 * 5.9 - 4.5) / 25.0, abs=0.1)
    with pytest.raises(FieldError, match="application must be a safety application"):
        session.warnings(np.array([1]), ["fly"])


def test_foreign_messages_are_read_as_any_other() -> None:
    other = Station("baseline", temporary_id=900)
    frame = other.sense(0.0, (50.0, 50.0), speed_mps=3.0, heading_rad=1.0)
    session, convoy = Session(SETTINGS), Convoy(5)
    session.step(convoy.step(0))
    sent = session.step(
        convoy.step(
            1,
            receiver=np.array([10, 3, 3]),
            received_s=np.array([0.08, 0.09, 0.1]),
            message=np.array([-1, -1, -1]),
            foreign_length=np.array([len(frame[0].octets), 3, len(frame[0].octets)]),
            foreign_octets=frame[0].octets + b"bad" + frame[0].octets,
        )
    )
    assert sent.receipt.tolist() == [Receipt.ACCEPTED, Receipt.MALFORMED, Receipt.ACCEPTED]
    assert session.believe(np.array([3]), 0.1).vehicle.tolist() == [900]


def test_messages_are_kept_for_ten_seconds() -> None:
    session, convoy = Session(SETTINGS), Convoy(5)
    first = session.step(convoy.step(0))
    assert first.message.size
    for number in range(1, 101):
        sent = session.step(convoy.step(number))
    heard = {"receiver": np.array([3]), "received_s": np.array([10.0]), "message": first.message[:1]}
    session.step(convoy.step(101, **heard))
    with pytest.raises(
        FieldError, match=r"of the last 1048576 messages of the last 10 s: one from \d+ to \d+"
    ):
        session.step(convoy.step(102, **heard))
    assert sent.message.size == 0 or sent.message[0] > 0


@pytest.mark.parametrize(
    ("name", "value"),
    [("slots", 0), ("slots", 10_001), ("dt_s", 0.0), ("dt_s", np.nan), ("seed", -1), ("latitude_deg", 91.0),
     ("capacity", MOST_TRACKS), ("threshold_m", 0.0)],
)  # fmt: skip
def test_settings_out_of_range_are_refused(name: str, value: float) -> None:
    with pytest.raises(FieldError) as told:
        replace(SETTINGS, **{name: value})
    assert told.value.field == name


def test_a_session_has_bounds_on_what_it_holds() -> None:
    with pytest.raises(FieldError, match="capacity must be at most 209 for so many slots"):
        SessionSettings(10_000)
    with pytest.raises(FieldError, match="sender must be a sender"):
        Session(replace(SETTINGS, sender="pigeon"))
    with pytest.raises(FieldError, match="j2945-mbc filters the motion"):
        Session(replace(SETTINGS, sender="j2945-mbc")).step(
            Step(0.0, np.array([1]), position_m=np.zeros((1, 2)))
        )


def test_nobody_asks_for_more_than_there_is() -> None:
    """Hosts and applications once each: an answer is never longer than what the session holds."""
    session, convoy = Session(SETTINGS), Convoy(5)
    session.step(convoy.step(0))
    hosts = convoy.vehicle
    for ask in (lambda own: session.believe(own, 0.0), lambda own: session.warnings(own, ["fcw"])):
        ask(hosts)
        with pytest.raises(FieldError, match="host must be there once, not twice, got 10"):
            ask(np.array([3, 10, 10]))
        with pytest.raises(FieldError, match=r"host must be at most the 5 stations of the newest step"):
            ask(np.tile(hosts, 1000))
        with pytest.raises(FieldError, match=r"host must be at most the 5 stations.*got shape \(1, 5\)"):
            ask(hosts[None])
    with pytest.raises(FieldError, match="applications must be there once, not twice, got fcw"):
        session.warnings(hosts, ["fcw", "ima", "fcw"])
    with pytest.raises(FieldError, match="applications must be at most 32, got 33 names"):
        session.warnings(hosts, [f"fcw:{number}" for number in range(33)])


def test_every_answer_has_one_bound_on_its_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("modelcast.runtime.external.session.MOST_ROWS", 3)
    session, heard = Session(replace(SETTINGS, slots=3)), dict[str, Any]()
    for number in range(60):  # one behind another, and all too close
        t_s = 0.1 * number
        sent = session.step(
            Step(
                t_s,
                np.array([1, 2, 3]),
                position_m=np.array([[0.0, 25.0 * t_s - 20.0], [0.0, 25.0 * t_s], [0.0, 160.0]]),
                speed_mps=np.array([25.0, 25.0, 0.0]),
                heading_rad=np.zeros(3),
                acceleration_mps2=np.zeros(3),
                yaw_rate_radps=np.zeros(3),
                **heard,
            )
        )
        others = [[two for two in (1, 2, 3) if two != one] for one in sent.vehicle.tolist()]
        heard = {
            "receiver": np.array(others, dtype=np.int64).ravel(),
            "received_s": np.repeat(sent.send_s, 2),
            "message": np.repeat(sent.message, 2),
        }
    full = "host must be fewer: an answer holds 3 rows, got 3 hosts"
    with pytest.raises(FieldError, match=full):
        session.believe(np.array([1, 2, 3]), 5.9)
    assert session.believe(np.array([1]), 5.9).vehicle.tolist() == [2, 3]
    near = "fcw"
    assert session.warnings(np.array([1, 2]), [near]).host.size
    with pytest.raises(FieldError, match=full):
        session.warnings(
            np.array([1, 2, 3]),
            [near, "fcw:longest_gap_m=190.5", "fcw:longest_gap_m=180.5", "fcw:longest_gap_m=170.5"],
        )


def test_no_flood_of_messages_within_ten_seconds_is_kept() -> None:
    """Time may stand all but still: what is kept has a bound in messages too, and whole steps go."""
    kept = KeptMessages(10.0, most=100)
    for number in range(1000):
        first = kept.add(1e-6 * number, [b"x"] * 7)
        assert first == 7 * number
    kept.check(np.arange(7 * 1000 - 98, 7 * 1000))
    with pytest.raises(FieldError, match="one of the last 100 messages of the last 10 s: one from 6902 to"):
        kept.check(np.array([7 * 1000 - 99]))
    kept.add(1.0, [])
    kept.check(np.array([6999]))
    kept.add(11.0, [])
    with pytest.raises(FieldError, match="none yet"):
        kept.check(np.array([6999]))


def test_a_step_without_stations_is_one() -> None:
    session, convoy = Session(SETTINGS), Convoy(5)
    nobody = Step(-0.2, np.empty(0, dtype=np.int64), position_m=np.empty((0, 2)))
    assert session.step(nobody).message.size == 0
    session.step(convoy.step(0))
    assert session.step(replace(nobody, t_s=0.05)).left.tolist() == convoy.vehicle.tolist()
    assert session.step(convoy.step(1)).left.size == 0


@settings(max_examples=20)
@given(
    sender=st.sampled_from(["mbc", "baseline", "j2945-mbc", "cam", "free"]),
    seed=st.integers(0, 2**32 - 1),
    latitude_deg=st.sampled_from([0.0, 89.0, -60.0]),
    dt_s=st.sampled_from([0.001, 0.1, 10.0]),
)
def test_whatever_is_in_range_is_served(sender: str, seed: int, latitude_deg: float, dt_s: float) -> None:
    """Vehicles that jump, spin and stop as none can, at the ends of what is allowed; frames of any octets."""
    rng = np.random.default_rng(seed)
    session = Session(
        SessionSettings(
            3, sender=sender, seed=seed, latitude_deg=latitude_deg, longitude_deg=179.9, dt_s=dt_s, capacity=2
        )
    )
    ids, heard = rng.choice(2**32, 3, replace=False), dict[str, Any]()

    def drawn(most: float, least: float) -> Any:
        return np.where(rng.random(3) < 0.5, rng.uniform(least, most, 3), rng.choice([least, most, 0.0], 3))

    t_s = float(rng.choice([-1e8, 0.0, 5e8]))
    for _ in range(8):
        t_s += dt_s * float(rng.choice([0.5, 1.0, 40.0]))
        sent = session.step(
            Step(
                t_s,
                ids,
                position_m=np.stack([drawn(2e5, -2e5), drawn(2e5, -2e5)], axis=1),
                speed_mps=drawn(200.0, 0.0),
                heading_rad=drawn(100.0, -100.0),
                acceleration_mps2=drawn(200.0, -200.0),
                yaw_rate_radps=drawn(100.0, -100.0),
                busy_ratio=drawn(1.0, 0.0),
                begins=rng.integers(0, 2, 3),
                **heard,
            )
        )
        length = rng.integers(1, 80, 2)
        heard = {
            "receiver": np.append(np.repeat(ids, sent.message.size), ids[:2]),
            "received_s": np.full(3 * sent.message.size + 2, t_s - rng.choice([0.0, 1e3])),
            "message": np.append(np.tile(sent.message, 3), [-1, -1]),
            "foreign_length": length,
            "foreign_octets": rng.bytes(int(length.sum())),
        }
        session.believe(ids, t_s + float(rng.choice([0.0, 1e6])))
        session.warnings(ids, ["fcw", "eebl", "ima", "vru"])
        assert (sent.length > 0).all()
