"""Claims about octets between stations: what one states the other holds, whatever comes between."""

import math
from dataclasses import replace

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.core.kinds import Kind
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.kinematic import ConstantAcceleration
from modelcast.station.banks import profile_number_of
from modelcast.station.policy.neighbours import neighbour_tables
from modelcast.station.policy.neighbours_kernels import find
from modelcast.station.receiver import slot_kernels as slots
from modelcast.station.receiver.ears import Ears
from modelcast.station.receiver.local_dynamic_map import MapState, Receipt
from modelcast.station.receiver.track_kernels import HELD_FIT_S, HELD_MEMBER
from modelcast.station.sender.octets import SentMessages, StationOctets
from modelcast.station.sensing.sensing import NOWHERE

BANK = Bank((ConstantAcceleration(), ConstantVelocity()))
EARS = Ears((BANK,), plausibility=None)
NUMBER = profile_number_of(BANK)
PLACE_M, SPEED_MPS, ANGLE_RAD, RATE = 0.012, 0.011, 3e-4, 0.011
"""Half a code of a place, and a code of the others."""

SAMPLES = np.array(
    [
        [120.0, -40.0, 9.0, 12.0, 1.5, 0.2, 0.0],
        [-30.0, 70.0, -8.0, 6.0, -2.0, -0.3, 0.0],
        [5.0, 6.0, -0.1, -0.2, 0.3, 0.1, 0.0],
    ]
)
"""The last is slower than what a course is taken from."""


def sent(identify: str = "never") -> tuple[StationOctets, SentMessages]:
    """Three updates of three stations, and an identification of the second's."""
    rows = np.array([0, 1, 2, 1])
    parameters = np.array(
        [[9.0, 12.0, 1.5, 9.0, 12.0], [-8.0, 6.0, -2.0, -8.0, 6.0], [0.0, 0.0, 0.0, -0.1, -0.2]]
    )
    messages = SentMessages(
        np.array([1, 1, 1, 2]),
        np.array([5, 300, 7, 301]),
        vehicle=np.array([11, 2**32 - 2, 13, 2**32 - 2]),
        t_s=np.array([20.0, 20.1, 20.1, 20.4]),
        sample=SAMPLES[rows],
        stated_m=SAMPLES[rows, :2],
        in_use=np.array([0, 0, 1, 1]),
        parameters=parameters[rows],
        update=np.array([5, 300, 7, 300]),
        fit_s=np.array([20.0, 20.1, 20.1, 20.1]),
    )
    return StationOctets.of(BANK, NUMBER, identify, NOWHERE), messages


def slot_of(state: MapState, vehicle: int) -> int:
    return int(slots.find_slot(state.slots, vehicle))


def heard(octets: list[bytes], received_s: list[float]) -> tuple[list[Receipt], MapState]:
    receipts, state = EARS.hear(EARS.init(), octets, received_s, origin=NOWHERE)
    return [Receipt(one) for one in receipts.tolist()], state


@pytest.mark.parametrize("identify", ["never", "best"])
def test_an_update_tells_place_motion_and_model(identify: str) -> None:
    writer, messages = sent(identify)
    receipts, state = heard(writer.encode(messages)[:3], [20.05, 20.15, 20.2])
    assert receipts == [Receipt.ACCEPTED] * 3
    for row, vehicle in enumerate(messages.vehicle[:3].tolist()):
        slot, sample = slot_of(state, vehicle), SAMPLES[row]
        told = state.told[slot]
        assert told[:2] == pytest.approx(sample[:2], abs=PLACE_M)
        speed = math.hypot(sample[2], sample[3])
        heading = math.atan2(sample[2], sample[3]) % (2.0 * math.pi)
        assert told[slots.TOLD_SPEED] == pytest.approx(speed, abs=SPEED_MPS)
        assert told[slots.TOLD_HEADING] == pytest.approx(heading, abs=ANGLE_RAD)
        assert told[slots.TOLD_ACCELERATION] == pytest.approx(sample[4], abs=RATE)
        assert told[slots.TOLD_YAW_RATE] == pytest.approx(sample[5], abs=RATE)
        assert np.isnan(told[[slots.TOLD_LENGTH, slots.TOLD_WIDTH]]).all()
        in_use = int(messages.in_use[row])
        plain = identify == "never" and in_use == 0  # Part I says it all, and the bank coasts it by that
        assert state.facts[slot, slots.FACT_PROFILE] == (-1 if plain else 0)
        assert state.facts[slot, slots.FACT_USER] == Kind.VEHICLE
        assert state.held[slot, HELD_FIT_S] == pytest.approx(messages.t_s[row], abs=1e-3)
        assert state.held[slot, HELD_MEMBER] == (0 if plain else in_use)
        own = slice(0, 3) if in_use == 0 else slice(3, 5)
        held = state.parameters[slot, own]
        assert held == pytest.approx(messages.parameters[row, own], abs=0.03)


def test_an_identification_takes_its_age_from_the_update_before_it() -> None:
    """In one call as in two, and of an update not held it changes nothing."""
    writer, messages = sent("best")
    octets = writer.encode(messages)
    received_s = [20.05, 20.15, 20.2, 20.45]
    receipts, state = heard(octets, received_s)
    assert receipts == [Receipt.ACCEPTED] * 4
    beliefs = EARS.map.believe(state, 20.5)
    assert beliefs.in_use[beliefs.vehicle == 2**32 - 2].tolist() == [1]
    again, _ = EARS.hear(state, octets[3:], [20.5], origin=NOWHERE)
    assert again.tolist() == [Receipt.OLDER]
    assert heard([octets[0], octets[3]], [20.05, 20.45])[0] == [Receipt.ACCEPTED, Receipt.UNKNOWN_UPDATE]


def test_any_octets_between_are_malformed_and_counted_in_their_place() -> None:
    writer, messages = sent("best")
    one, two, _, named = writer.encode(messages)
    octets = [b"", one, b"\x00", named[:-2], two, one[:20], named, b"\xff" * 60]
    times = [20.05, 20.05, 20.1, 20.12, 20.15, 20.3, 20.45, 20.5]
    receipts, state = heard(octets, times)
    bad, good = Receipt.MALFORMED, Receipt.ACCEPTED
    assert receipts == [bad, good, bad, bad, good, bad, good, bad]
    assert state.by_receipt == {good: 3, bad: 5}


def test_a_host_without_the_profile_takes_part_i() -> None:
    writer, messages = sent()
    deaf = Ears((), plausibility=None)
    receipts, state = deaf.hear(deaf.init(), writer.encode(messages)[:2], [20.05, 20.15], origin=NOWHERE)
    assert receipts.tolist() == [Receipt.ACCEPTED] * 2
    assert (state.by_part_i, EARS.init().by_part_i) == (2, 0)
    ids, places = deaf.map.positions(state, 21.0)
    assert ids.tolist() == [11, 2**32 - 2]
    moved: FloatArray = SAMPLES[:2, :2] + SAMPLES[:2, 2:4] * np.array([[1.0], [0.9]])
    np.testing.assert_allclose(places, moved, atol=0.05)


def test_two_profiles_each_read_their_own() -> None:
    """The same station under either number; what is plain to both names neither, and the first is asked."""
    other = Bank((ConstantVelocity(), ConstantAcceleration()))
    both = Ears((other, BANK), plausibility=None)
    writer, messages = sent()
    octets = writer.encode(messages)
    receipts, state = both.hear(both.init(), [octets[2]], [20.15], origin=NOWHERE)
    assert receipts.tolist() == [Receipt.ACCEPTED]
    slot = slot_of(state, 13)
    assert (state.facts[slot, slots.FACT_PROFILE], state.held[slot, HELD_MEMBER]) == (1, 1)
    for ears, speed in ((both, 12.0), (EARS, 12.0 + 1.5 * 0.8)):  # of 15 m/s, 12 go north
        _, state = ears.hear(ears.init(), octets[:1], [20.05], origin=NOWHERE)
        assert state.facts[slot_of(state, 11), slots.FACT_PROFILE] == -1
        assert ears.map.believe(state, 21.0).velocity_mps[0, 1] == pytest.approx(speed, abs=0.02)
    turned = StationOctets.of(other, profile_number_of(other), "never", NOWHERE)
    swapped = replace(
        messages, parameters=messages.parameters[:, [3, 4, 0, 1, 2]], in_use=1 - messages.in_use
    )
    receipts, state = both.hear(both.init(), turned.encode(swapped)[:1], [20.05], origin=NOWHERE)
    slot = slot_of(state, 11)
    assert (state.facts[slot, slots.FACT_PROFILE], state.held[slot, HELD_MEMBER]) == (0, 1)


def test_whose_position_was_believed_counts_as_neighbour() -> None:
    """Updates by the lower 31 bits of the id, once each; no identification, no copy, nothing refused."""
    writer, messages = sent("best")
    one, two, three, named = writer.encode(messages)
    tables = neighbour_tables(2, 8)
    EARS.hear(
        EARS.init(),
        [one, one, two, named, three[:30], three],
        [20.05, 20.06, 20.15, 20.45, 20.46, 30.5],
        origin=NOWHERE,
        tables=tables,
        host=1,
    )
    assert tables.hosts["used"].tolist() == [0, 2]
    counted = {one: find(tables.slots, tables.lookup, 1, one) for one in (11, 2**31 - 2, 13)}
    assert [slot >= 0 for slot in counted.values()] == [True, True, False]
    first, second = (tables.slots[1, counted[one]] for one in (11, 2**31 - 2))
    assert (first["received"].sum(), second["received"].sum()) == (1, 1)
    assert (first["heard_s"], second["heard_s"]) == (20.05, 20.15)
    assert [float(first["east_m"]), float(first["north_m"])] == pytest.approx([120.0, -40.0], abs=PLACE_M)
    assert second["first"].max() == 300 % 128


def test_times_and_frames_go_together() -> None:
    with pytest.raises(ValueError, match=r"received_s must be \(2,\), one a frame, got \(1,\)"):
        heard([b"", b""], [1.0])
