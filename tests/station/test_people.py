"""People as stations: they speak personal safety messages, and hosts know them for what they are."""

import numpy as np
import pytest

from modelcast.apps.around import believed_motions
from modelcast.core.kinds import PEOPLE, SIZES_M, Kind
from modelcast.messages.psm import PersonalSafetyMessage, encode_psm, person_codes
from modelcast.messages.psm_fields import PERSONAL_SAFETY_MESSAGE
from modelcast.models.bank import Bank
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.profile import people_profile
from modelcast.station.banks import free_bank
from modelcast.station.receiver.ears import Ears
from modelcast.station.receiver.local_dynamic_map import Receipt
from modelcast.station.sender.sender import Sender, named_sender
from modelcast.station.station import Station

EASTWARDS = np.pi / 2
WIDE = Ears((Bank((ConstantTurnRateAcceleration(),)),))
"""A host that coasts plain messages of vehicles by turn and acceleration."""


def met(sender: str | Sender, kind: Kind, host: Station, *, until_s: float = 3.0) -> list[bytes]:
    """Messages of who goes east at 4 m/s and gains speed; the host hears them all."""
    station, said = Station(sender, temporary_id=1, kind=kind), list[bytes]()
    for step in range(round(until_s / 0.1)):
        t_s = 0.1 * step
        for one in station.sense(
            t_s,
            (4.0 * t_s + 0.25 * t_s**2, 0.0),
            speed_mps=4.0 + 0.5 * t_s,
            heading_rad=EASTWARDS,
            acceleration_mps2=0.5,
            yaw_rate_radps=0.0,
        ):
            said.append(one.octets)
            host.hear([one.octets], received_s=[one.send_s])
    return said


@pytest.mark.parametrize("kind", [Kind.VEHICLE, *PEOPLE])
@pytest.mark.parametrize("sender", ["baseline", "mbc", "bsm-10hz"])
def test_a_host_knows_the_kind_of_each_remote(sender: str, kind: Kind) -> None:
    host = Station("mbc", temporary_id=2)
    said = met(sender, kind, host)
    ids = {int.from_bytes(one[:2], "big") for one in said}
    assert (PERSONAL_SAFETY_MESSAGE in ids) is (kind in PEOPLE)
    around = host.believe(3.0)
    assert around.kind.tolist() == [kind]
    assert around.position_m[0, 0] == pytest.approx(4.0 * 3.0 + 0.25 * 9.0, abs=0.4)
    motions = believed_motions(around)
    assert (motions.length_m[0], motions.width_m[0]) == SIZES_M[kind]
    assert motions.kind is not None
    assert motions.kind.tolist() == [kind]


def test_plain_messages_of_people_without_acceleration_are_coasted_at_constant_velocity() -> None:
    """Whatever plain messages of vehicles are coasted by: the sender and its host hold the same."""
    believed = dict[Kind, float]()
    for kind in (Kind.VEHICLE, Kind.PEDESTRIAN):
        host = Station("mbc", temporary_id=2, ears=WIDE)
        met("bsm-10hz", kind, host)
        believed[kind] = float(host.believe(3.9).position_m[0, 0])
    held_m, held_mps = 4.0 * 2.9 + 0.25 * 2.9**2, 4.0 + 0.5 * 2.9
    assert believed[Kind.PEDESTRIAN] == pytest.approx(held_m + held_mps * 1.0, abs=0.03)
    assert believed[Kind.VEHICLE] == pytest.approx(held_m + held_mps * 1.0 + 0.25, abs=0.05)


def test_a_stated_acceleration_of_a_person_is_not_carried_on() -> None:
    """A foreign device may state one; who walks as fast as this gains no speed."""
    codes = person_codes(
        {
            "basic_type": 1, "message_count": 1, "temporary_id": 9, "second_of_minute_s": 1.0,
            "latitude_deg": 0.0, "longitude_deg": 0.0, "speed_mps": 2.0, "heading_rad": 0.0,
        }
    )  # fmt: skip
    octets = encode_psm(PersonalSafetyMessage(codes, acceleration=(150, 2001, -127, 0)))
    host = Station("mbc", temporary_id=2, ears=WIDE)
    host.hear([octets], received_s=[1.0])
    before, after = (host.believe(t_s).position_m[0, 1] for t_s in (1.0, 3.0))
    assert after - before == pytest.approx(4.0, abs=1e-6)


def way_m(speed_mps: float, change_mps2: float, after_s: float) -> float:
    """As docs/wire.md has it."""
    lasts_s = 0.0
    if speed_mps > 0.1 and change_mps2 != 0.0:
        ends_mps = 0.0 if change_mps2 < 0.0 else max(1.5, speed_mps)
        lasts_s = min((ends_mps - speed_mps) / change_mps2, 1.0)
    within_s = min(after_s, lasts_s)
    ends_mps = speed_mps + change_mps2 * lasts_s
    return within_s * (speed_mps + change_mps2 * within_s / 2.0) + (after_s - within_s) * ends_mps


@pytest.mark.parametrize("change_mps2", [-1.2, -0.5, 0.0, 0.4, 3.0])
@pytest.mark.parametrize("speed_mps", [0.0, 0.5, 1.4, 4.0])
def test_a_plain_message_means_a_second_of_its_acceleration_to_everybody(
    speed_mps: float, change_mps2: float
) -> None:
    codes = person_codes(
        {
            "basic_type": 1, "message_count": 1, "temporary_id": 9, "second_of_minute_s": 1.0,
            "latitude_deg": 0.0, "longitude_deg": 0.0, "speed_mps": speed_mps, "heading_rad": 0.0,
        }
    )  # fmt: skip
    octets = encode_psm(PersonalSafetyMessage(codes, acceleration=(round(100 * change_mps2), 2001, -127, 0)))
    host = Station("mbc", temporary_id=2, ears=WIDE)
    host.hear([octets], received_s=[1.0])
    north_m = [host.believe(t_s).position_m[0, 1] for t_s in (1.0, 1.4, 2.6, 4.0)]
    wanted_m = [way_m(speed_mps, change_mps2, after_s) for after_s in (0.0, 0.4, 1.6, 3.0)]
    assert np.subtract(north_m, north_m[0]) == pytest.approx(wanted_m, abs=1e-9)


def test_a_sender_of_peoples_bank_is_believed_by_hosts_that_hold_no_such_bank() -> None:
    """Somebody slows down to a stand: plain messages with the acceleration set, and the host is never off."""
    sender = named_sender("mbc", bank=people_profile().bank, threshold_m=0.2).of_kind(Kind.PEDESTRIAN)
    walker, host, lengths, worst_m = (
        Station(sender, temporary_id=1),
        Station("mbc", temporary_id=2),
        set(),
        0.0,
    )
    way, speed_mps = 0.0, 1.4
    for step in range(60):
        t_s = 0.1 * step
        now_mps = max(min(1.4, 1.4 - 0.8 * (t_s - 3.0)), 0.0)
        way, speed_mps = way + 0.05 * (speed_mps + now_mps), now_mps
        for one in walker.sense(t_s, (0.0, way), speed_mps=speed_mps, heading_rad=0.0):
            lengths.add(len(one.octets))
            host.hear([one.octets], received_s=[one.send_s])
        if step > 10:
            worst_m = max(worst_m, abs(float(host.believe(t_s).position_m[0, 1]) - way))
    assert lengths == {35}
    assert worst_m < 0.25


def test_messages_of_people_are_smaller_by_what_people_have_not() -> None:
    """Plain 29 octets for 40; of the sender's rule the frame on the air follows."""
    sizes = {kind: named_sender("baseline").of_kind(kind).update_bytes.tolist() for kind in Kind if kind < 4}
    assert sizes == {Kind.VEHICLE: [40], **{kind: [29] for kind in PEOPLE}}


@pytest.mark.parametrize("first", [Kind.VEHICLE, Kind.PEDESTRIAN])
def test_nobody_takes_the_temporary_id_of_another_kind(first: Kind) -> None:
    """A key for people alone must not turn a tracked vehicle into a person."""
    second = Kind.PEDESTRIAN if first == Kind.VEHICLE else Kind.VEHICLE
    host = Station("mbc", temporary_id=2)
    met("bsm-10hz", first, host, until_s=1.0)
    other = Station("bsm-10hz", temporary_id=1, kind=second)
    place = (4.0 * 1.1 + 0.25 * 1.1**2, 0.0)
    (sent,) = other.sense(1.1, place, speed_mps=4.55, heading_rad=EASTWARDS)
    assert host.hear([sent.octets], received_s=[sent.send_s]).tolist() == [Receipt.OTHER_KIND]
    assert host.believe(1.2).kind.tolist() == [first]
    assert host.believe(60.0).kind.size == 0
    (sent,) = other.sense(60.0, place, speed_mps=4.55, heading_rad=EASTWARDS)
    assert host.hear([sent.octets], received_s=[sent.send_s]).tolist() == [Receipt.ACCEPTED]
    assert host.believe(60.1).kind.tolist() == [second]


@pytest.mark.parametrize("ears", [WIDE, Ears(())])
def test_who_stands_and_states_no_heading_is_heard(ears: Ears) -> None:
    codes = person_codes(
        {
            "basic_type": 1, "message_count": 1, "temporary_id": 9, "second_of_minute_s": 1.0,
            "latitude_deg": 0.0, "longitude_deg": 0.0, "speed_mps": 0.0, "heading_rad": None,
        }
    )  # fmt: skip
    host = Station("mbc", temporary_id=2, ears=ears)
    assert host.hear([encode_psm(PersonalSafetyMessage(codes))], received_s=[1.0]).tolist() == [0]
    assert host.believe(3.0).position_m == pytest.approx(np.zeros((1, 2)), abs=1e-9)


def test_a_host_without_a_bank_coasts_vehicles_at_constant_velocity() -> None:
    believed = dict[Kind, float]()
    for kind in (Kind.VEHICLE, Kind.PEDESTRIAN):
        host = Station("bsm-10hz", temporary_id=2, ears=Ears(()))
        met("bsm-10hz", kind, host)
        believed[kind] = float(host.believe(3.9).position_m[0, 0])
    assert believed[Kind.VEHICLE] == pytest.approx(believed[Kind.PEDESTRIAN], abs=0.03)


@pytest.mark.parametrize("policy", ["free", "j2945-free"])
def test_free_policies_of_people_send_what_everybody_coasts_them_by(policy: str) -> None:
    bank = free_bank(None, Kind.CYCLIST)
    sender = named_sender(policy, bank=bank).of_kind(Kind.CYCLIST)
    assert (sender.plain, sender.update_bytes.tolist()) == ((True,), [35])


def test_who_renames_stays_of_its_kind() -> None:
    """A person's new id beside a silent vehicle's track does not end it, a vehicle's does."""
    for kind, left in ((Kind.VEHICLE, [3]), (Kind.CYCLIST, [1, 3])):
        host = Station("mbc", temporary_id=2)
        met("bsm-10hz", Kind.VEHICLE, host, until_s=1.0)
        other = Station("bsm-10hz", temporary_id=3, kind=kind)
        for t_s in (1.0, 1.1):
            place = (4.0 * t_s + 0.25 * t_s**2, 0.0)
            for one in other.sense(t_s, place, speed_mps=4.0 + 0.5 * t_s, heading_rad=EASTWARDS):
                host.hear([one.octets], received_s=[one.send_s])
        assert host.believe(1.2).vehicle.tolist() == left


def test_a_roadside_unit_states_no_motion() -> None:
    with pytest.raises(ValueError, match="states its motion"):
        Station("mbc", kind=Kind.ROADSIDE)
