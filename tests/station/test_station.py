"""Claims about the stations that other programs hold."""

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import Origin, local_to_geodetic
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.station.banks import bank_from_text
from modelcast.station.fleet import Fleet, Sending
from modelcast.station.policy.base import MessageKind
from modelcast.station.receiver.ears import Ears
from modelcast.station.receiver.local_dynamic_map import Receipt
from modelcast.station.sender.sender import named_sender
from modelcast.station.station import Station
from modelcast.world.drive import generate_drive

ORIGIN = Origin(48.1, 11.6, 500.0)
DRIVES = [generate_drive(seed=seed, duration_s=90.0).input for seed in (3, 4, 5)]
ROWS = 300


def column(name: str) -> FloatArray:
    return np.array([getattr(drive, name)[:ROWS] for drive in DRIVES])


POSITION_M, SPEED_MPS, HEADING_RAD = column("position_m"), column("speed_mps"), column("heading_rad")


def driven(station: Station, number: int) -> list[Sending]:
    """Drive a station along one of the drives."""
    sent: list[Sending] = []
    for k in range(ROWS):
        sent += station.sense(
            0.1 * k,
            (POSITION_M[number, k, 0], POSITION_M[number, k, 1]),
            speed_mps=SPEED_MPS[number, k],
            heading_rad=HEADING_RAD[number, k],
        )
    return sent


def octets(sent: list[Sending]) -> list[tuple[int, bytes]]:
    """Step and octets of each message; within a step, a fleet spreads its messages."""
    return [(int(one.send_s / 0.1 + 1e-6), one.octets) for one in sent]


@pytest.mark.parametrize("sender", ["mbc", "baseline"])
def test_a_fleet_sends_what_its_stations_send_alone(sender: str) -> None:
    """Whoever else is there, and in whatever order they are given, changes nothing."""
    fleet = Fleet(sender, slots=4)
    found: dict[int, list[Sending]] = {1: [], 2: [], 3: []}
    rng = np.random.default_rng(0)
    for k in range(ROWS):
        order = rng.permutation(3)
        for one in fleet.sense(
            0.1 * k,
            (order + 1).astype(np.int64),
            POSITION_M[order, k],
            speed_mps=SPEED_MPS[order, k],
            heading_rad=HEADING_RAD[order, k],
        ):
            found[one.vehicle].append(one)
    for number in range(3):
        alone = driven(Station(sender, temporary_id=number + 1), number)
        assert len(alone) > 5
        assert octets(found[number + 1]) == octets(alone)


def test_latitude_and_longitude_are_a_place_in_metres() -> None:
    plane = Station("mbc", origin=ORIGIN)
    globe = Station("mbc", origin=ORIGIN)
    places = local_to_geodetic(POSITION_M[0], ORIGIN)
    for k in range(ROWS):
        one = globe.sense(
            0.1 * k,
            place_deg=(places[k, 0], places[k, 1]),
            speed_mps=SPEED_MPS[0, k],
            heading_rad=HEADING_RAD[0, k],
        )
        other = plane.sense(
            0.1 * k,
            (POSITION_M[0, k, 0], POSITION_M[0, k, 1]),
            speed_mps=SPEED_MPS[0, k],
            heading_rad=HEADING_RAD[0, k],
        )
        assert octets(one) == octets(other)


def test_places_come_in_one_way() -> None:
    station = Station()
    with pytest.raises(ValueError, match="position_m or place_deg, one of the two"):
        station.sense(0.0)
    with pytest.raises(ValueError, match="position_m or place_deg, one of the two"):
        station.sense(0.0, (0.0, 0.0), place_deg=(1.0, 2.0))


def test_what_is_not_measured_is_estimated() -> None:
    """Positions alone make a sender too, and its hosts know the speed."""
    sender, host = Station(temporary_id=1), Station(temporary_id=2)
    for k in range(60):
        for one in sender.sense(0.1 * k, (1.5 * k, 0.0)):
            host.hear([one.octets], received_s=[one.send_s])
    around = host.believe(6.0)
    assert around.speed_mps[0] == pytest.approx(15.0, abs=0.2)
    assert around.position_m[0] == pytest.approx([90.0, 0.0], abs=0.5)


def test_who_is_renamed_is_one_remote_at_a_time() -> None:
    """The track of the old id ends when the new one speaks, and nothing is mixed up."""
    sender, host = Station(temporary_id=1), Station(temporary_id=2)
    for k in range(100):
        if k == 50:
            sender.rename(77)
        for one in sender.sense(0.1 * k, (1.5 * k, 0.0), speed_mps=15.0, heading_rad=np.pi / 2):
            receipt = host.hear([one.octets], received_s=[one.send_s])
            assert receipt.tolist() == [Receipt.ACCEPTED]
        around = host.believe(0.1 * k + 0.05)
        assert around.vehicle.tolist() == [1 if k < 50 else 77]
        assert around.position_m[0] == pytest.approx([1.5 * k + 0.75, 0.0], abs=0.3)


def test_a_new_id_begins_with_an_update() -> None:
    fleet = Fleet("mbc", slots=1)

    def step(k: int, vehicle: int) -> list[Sending]:
        return fleet.sense(
            0.1 * k,
            np.array([vehicle]),
            np.array([[1.5 * k, 0.0]]),
            speed_mps=np.array([15.0]),
            heading_rad=np.array([np.pi / 2]),
        )

    assert [one.kind for k in range(6) for one in step(k, 5)] == [MessageKind.UPDATE]
    fleet.rename(5, 6)
    after = step(6, 6)
    assert [(one.vehicle, one.kind) for one in after] == [(6, MessageKind.UPDATE)]


def test_a_roadside_unit_hears_without_measuring() -> None:
    fleet = Fleet("mbc", slots=2)
    fleet.admit(9)
    for k in range(20):
        for one in fleet.sense(
            0.1 * k,
            np.array([5]),
            np.array([[1.5 * k, 0.0]]),
            speed_mps=np.array([15.0]),
            heading_rad=np.array([np.pi / 2]),
        ):
            fleet.hear(9, [one.octets], received_s=[one.send_s])
    assert fleet.believe(9, 2.0).vehicle.tolist() == [5]


def test_who_leaves_and_returns_begins_anew() -> None:
    fleet = Fleet("mbc", slots=2)
    sent: dict[int, list[int]] = {5: [], 6: []}
    for k in range(40):
        here = np.array([5, 6]) if not 10 <= k < 20 else np.array([6])
        for one in fleet.sense(
            0.1 * k,
            here,
            np.array([[1.5 * k, 10.0 * number] for number in here]),
            speed_mps=np.full(here.size, 15.0),
            heading_rad=np.full(here.size, np.pi / 2),
        ):
            sent[one.vehicle].append(k)
    assert 20 in sent[5]  # at once, when back
    with pytest.raises(ValueError, match="vehicle 8 is not in the fleet"):
        fleet.believe(8, 4.0)


def test_octets_of_nobody_change_nothing() -> None:
    station = Station()
    rng = np.random.default_rng(1)
    noise = [rng.bytes(size) for size in range(200)]
    receipts = station.hear(noise, received_s=[0.0] * len(noise))
    assert set(receipts.tolist()) == {Receipt.MALFORMED}
    assert station.believe(0.0).vehicle.size == 0


def test_a_host_without_the_profile_uses_part_i() -> None:
    """Constant velocity from the plain part, counted; a host that holds the profile uses the model."""
    bank = bank_from_text("learned+cv")
    sender = Station(named_sender("mbc", bank=bank), temporary_id=1)
    plain = Station(temporary_id=2, ears=Ears((Bank((ConstantVelocity(),)),)))
    able = Station(temporary_id=3, ears=Ears((bank,)))
    drive = DRIVES[0]
    for one in driven(sender, 0):
        for host in (plain, able):
            host.hear([one.octets], received_s=[one.send_s])
    t_s = 0.1 * ROWS
    assert plain.believe(t_s).profile.tolist() == [-1]
    assert able.believe(t_s).profile.tolist() == [0]
    assert np.hypot(*(able.believe(t_s).position_m[0] - drive.position_m[ROWS])) < 1.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"t_s": 0.0}, "t_s must increase, got 0.0 after 0.0"),
        ({"position_m": np.array([[np.nan, 0.0], [0.0, 0.0]])}, "position_m of vehicle 3 must be finite"),
        ({"position_m": np.zeros((3, 2))}, r"position_m must be \(2, 2\), got \(3, 2\)"),
        ({"speed_mps": np.array([1.0, np.inf])}, "speed_mps of vehicle 4 must be finite, got inf"),
        ({"speed_mps": np.ones(3)}, r"speed_mps must be \(2,\), got \(3,\)"),
        ({"speed_mps": None}, "columns measured must stay the same: speed_mps, heading_rad"),
        ({"vehicle": np.array([3, 3])}, "vehicles must be distinct"),
        ({"vehicle": np.array([3, -1])}, "vehicles must be distinct and from 0"),
        ({"vehicle": np.array([3, 2**32])}, "vehicles must be distinct and from 0"),
        ({"vehicle": np.array([3, 5]), "slots": 1}, "the fleet has 1 slots, and all are taken"),
    ],
)
def test_bad_measurements_are_told(change: dict[str, object], message: str) -> None:
    slots = change.pop("slots", 2)
    assert isinstance(slots, int)
    fine = {
        "t_s": 0.0,
        "vehicle": np.array([3, 4]),
        "position_m": np.zeros((2, 2)),
        "speed_mps": np.ones(2),
        "heading_rad": np.zeros(2),
    }
    fleet = Fleet("mbc", slots=slots)
    if slots == 2:
        fleet.sense(**fine)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=message):
        fleet.sense(**{**fine, "t_s": 0.1, **change})  # type: ignore[arg-type]


def test_ids_are_four_octets_and_not_shared() -> None:
    fleet = Fleet("mbc", slots=3)
    fleet.admit(1)
    fleet.admit(2)
    for bad in (1, -1, 2**32):
        with pytest.raises(ValueError, match="vehicle must be new"):
            fleet.admit(bad)
    for bad in (2, -1, 2**32):
        with pytest.raises(ValueError, match="temporary_id must be free"):
            fleet.rename(1, bad)
    with pytest.raises(ValueError, match="slots must be at least 1"):
        Fleet("mbc", slots=0)


def test_hosts_that_hear_at_once_hear_as_each_alone() -> None:
    """Updates and identifications mixed, octets of nobody between them, own messages repeated."""
    sender = named_sender("mbc", bank=bank_from_text("cv+ca"), start="order", identify="on-failure")
    at_once, alone = Fleet(sender, slots=5, seed=4), Fleet(sender, slots=5, seed=4)
    rng, ids = np.random.default_rng(2), np.arange(5)
    drives = [generate_drive(seed=seed, duration_s=90.0).truth for seed in range(5)]
    receipts: set[int] = set()
    kinds: set[int] = set()
    heard: list[tuple[int, list[bytes], list[float]]] = []
    for step in range(250):
        t_s = 0.1 * step
        if heard:
            host = np.repeat([one for one, _, _ in heard], [len(octets) for _, octets, _ in heard])
            every = [one for _, octets, _ in heard for one in octets]
            found = at_once.hear_each(host, every, received_s=[one for *_, times in heard for one in times])
            each = [alone.hear(one, octets, received_s=times) for one, octets, times in heard]
            np.testing.assert_array_equal(found, np.concatenate(each))
            receipts |= set(found.tolist())
        place = np.array([one.position_m[step] for one in drives])
        motion = {
            name: np.array([getattr(one, name)[step] for one in drives])
            for name in ("speed_mps", "heading_rad")
        }
        sent = at_once.sense(t_s, ids, place, **motion)
        assert sent == alone.sense(t_s, ids, place, **motion)
        kinds |= {one.kind for one in sent}
        heard = [
            (host, [one.octets for one in mine], [one.send_s for one in mine])
            for host in rng.permutation(5).tolist()
            if (mine := [one for one in sent if rng.random() < 0.9])
        ]
        if heard and step % 7 == 0:
            heard[0][1].insert(0, rng.bytes(20))
            heard[0][2].insert(0, heard[0][2][0])
    assert {Receipt.ACCEPTED, Receipt.REPEATED, Receipt.MALFORMED} <= receipts
    assert MessageKind.IDENTIFICATION in kinds
    for host in range(5):
        one, other = at_once.believe(host, 25.0), alone.believe(host, 25.0)
        np.testing.assert_array_equal(one.position_m, other.position_m)
        np.testing.assert_array_equal(one.vehicle, other.vehicle)
        counts = at_once.deliveries(host, ids, 25.0), alone.deliveries(host, ids, 25.0)
        np.testing.assert_array_equal(counts[0].received, counts[1].received)


def test_who_was_admitted_is_let_go_of() -> None:
    fleet = Fleet("mbc", slots=2)
    fleet.admit(9)
    fleet.sense(0.0, np.array([1]), np.zeros((1, 2)))
    with pytest.raises(ValueError, match="vehicle 1 measures: leave it out of the next step instead"):
        fleet.dismiss(1)
    with pytest.raises(ValueError, match="vehicle 9 measured nothing"):
        fleet.own_motion(9)
    fleet.dismiss(9)
    with pytest.raises(ValueError, match="vehicle 9 is not in the fleet"):
        fleet.believe(9, 0.0)
    fleet.sense(0.1, np.array([1, 2]), np.zeros((2, 2)))


def test_a_vehicle_sees_itself_as_it_measures() -> None:
    fleet = Fleet("mbc", slots=2)
    fleet.sense(
        0.0, np.array([7]), np.array([[3.0, 4.0]]), speed_mps=np.array([5.0]), heading_rad=np.array([6.0])
    )
    np.testing.assert_array_equal(fleet.own_motion(7), [3.0, 4.0, 5.0, 6.0, np.nan, np.nan])
