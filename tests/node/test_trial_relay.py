"""Claims about an impaired air and hostile frames."""

import asyncio
import socket
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from modelcast.core.geodesy import Origin
from modelcast.node.envelope import Unsecured
from modelcast.node.multicast import MulticastTransport
from modelcast.node.trials.drive import Driven
from modelcast.node.trials.hostile import InventedVehicles, random_frames
from modelcast.node.trials.impairment import CLEAR, Impairment
from modelcast.node.trials.relay import Relay, altered
from modelcast.station.sender.sender import named_sender
from modelcast.station.station import Station

from .virtual_time import run_in_virtual_time

GROUPS = ("239.255.16.101", "239.255.16.102", "239.255.16.103")
HERE = Driven(
    latitude_deg=48.0,
    longitude_deg=11.0,
    speed_mps=0.0,
    heading_rad=0.0,
    acceleration_mps2=0.0,
    yaw_rate_radps=0.0,
)


def now_s() -> float:
    return asyncio.get_running_loop().time()


@contextmanager
def stations() -> Iterator[tuple[Relay, list[MulticastTransport]]]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = int(probe.getsockname()[1])
    relay = Relay(GROUPS, port, clock=now_s, rng=np.random.default_rng(1))
    own = [MulticastTransport(now_s, group=group, port=port) for group in GROUPS]
    relay.start()
    try:
        yield relay, own
    finally:
        relay.stop()
        for one in own:
            one.close()


def carried(how: Impairment, frames: int, *, waits_s: float = 0.0) -> tuple[list[list[bytes]], Relay]:
    """What each of three stations hears of frames that the first sends ten times a second."""

    async def main() -> tuple[list[list[bytes]], Relay]:
        with stations() as (relay, own):
            relay.impairment = how
            for number in range(frames):
                own[0].send(number.to_bytes(4, "big"), sent_s=0.0)
                await asyncio.sleep(0.1)
            await asyncio.sleep(waits_s + 0.1)
            return [[one.octets for one in place.receive(1e9)] for place in own], relay

    return run_in_virtual_time(main())


def test_everybody_hears_the_first_but_itself() -> None:
    (first, second, third), relay = carried(CLEAR, 50)
    assert first == []
    assert second == third == [number.to_bytes(4, "big") for number in range(50)]
    assert (relay.counts["heard"], relay.counts["given"]) == (50, 100)


def test_losses_are_of_the_share_that_is_asked_for_and_each_link_has_its_own() -> None:
    (_, second, third), relay = carried(Impairment(0.4), 400)
    assert second != third
    assert len(second) + len(third) + relay.counts["lost"] == 800
    assert relay.counts["lost"] / 800 == pytest.approx(0.4, abs=0.06)


def test_bursts_lose_frames_at_a_stretch() -> None:
    (_, second, _), _ = carried(Impairment(0.4, burst_s=1.0), 1500)
    numbers = np.array([int.from_bytes(one, "big") for one in second])
    assert numbers.size / 1500 == pytest.approx(0.6, abs=0.12)
    gaps = np.diff(numbers) - 1
    # Independent losses of 40 % would be 1.7 frames long at the mean; a second is ten.
    assert gaps[gaps > 0].mean() > 5.0


def test_copies_all_arrive_and_recorded_frames_come_again() -> None:
    (_, second, _), _ = carried(Impairment(copies=3), 10)
    assert second == [number.to_bytes(4, "big") for number in range(10) for _ in range(3)]
    (_, second, _), relay = carried(Impairment(again_s=2.0), 10, waits_s=2.0)
    assert sorted(second) == sorted([number.to_bytes(4, "big") for number in range(10)] * 2)
    assert relay.counts["again"] == 20


def test_frames_that_are_held_up_are_overtaken_and_none_is_lost() -> None:
    (_, second, _), _ = carried(Impairment(late_ratio=0.5, late_s=0.5), 100, waits_s=1.0)
    assert sorted(second) == [number.to_bytes(4, "big") for number in range(100)]
    assert second != sorted(second)


def test_the_parted_hear_each_other_alone() -> None:
    (_, second, third), _ = carried(Impairment(parted=frozenset({0, 1})), 10)
    assert (len(second), len(third)) == (10, 0)
    (_, second, third), _ = carried(Impairment(parted=frozenset({2})), 10)
    assert (len(second), len(third)) == (10, 0)


def test_an_altered_frame_differs_in_one_octet_and_all_are_met() -> None:
    frame, rng = bytes(range(40)), np.random.default_rng(2)
    places = set()
    for _ in range(1000):
        found = altered(frame, rng)
        (place,) = [at for at in range(40) if found[at] != frame[at]]
        places.add(place)
    assert len(places) == 40
    (_, second, _), _ = carried(Impairment(altered_ratio=1.0), 20)
    assert all(one != number.to_bytes(4, "big") for number, one in enumerate(second))
    with pytest.raises(ValueError, match="1 to 2304"):
        altered(b"", rng)


@pytest.mark.parametrize(
    "wrong",
    [{"loss_ratio": 1.1}, {"altered_ratio": -0.1}, {"late_s": -1.0}, {"again_s": np.inf}, {"copies": 0}],
)
def test_what_no_air_does_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Impairment(**wrong)


def test_invented_vehicles_are_taken_for_real_ones_and_the_map_holds_no_more_than_it_has_room_for() -> None:
    station = Station(named_sender("mbc"), temporary_id=1, dt_s=0.1, origin=Origin(48.0, 11.0, 0.0), seed=1)
    crowd = InventedVehicles(10_000, near=HERE, from_utc_s=0.0, rng=np.random.default_rng(1))
    envelope = Unsecured()
    heard_s = 1.0
    for first in range(0, 10_000, 1000):
        frames = crowd.frames(range(first, first + 1000), utc_s=heard_s)
        octets = [envelope.open(one, received_s=heard_s).octets for one in frames]
        receipts = station.hear([one for one in octets if one is not None], received_s=[heard_s] * 1000)
        assert not receipts.any()
        heard_s += 0.1
    around = station.believe(heard_s)
    assert 1900 < around.vehicle.size <= 2000
    assert set(around.vehicle.tolist()) <= set(crowd.names.tolist())


def test_invented_vehicles_go_on_being_believed() -> None:
    station = Station(named_sender("mbc"), temporary_id=1, dt_s=0.1, origin=Origin(48.0, 11.0, 0.0), seed=1)
    crowd = InventedVehicles(50, near=HERE, from_utc_s=0.0, rng=np.random.default_rng(1))
    for step in range(1, 50):
        octets = [
            Unsecured().open(one, received_s=0.1 * step).octets
            for one in crowd.frames(range(50), utc_s=0.1 * step)
        ]
        assert not station.hear([one for one in octets if one], received_s=[0.1 * step] * 50).any()


def test_random_octets_are_no_message() -> None:
    envelope = Unsecured()
    frames = random_frames(2000, np.random.default_rng(3))
    assert all(1 <= len(one) <= 300 for one in frames)
    assert all(envelope.open(one, received_s=0.0).octets is None for one in frames)
