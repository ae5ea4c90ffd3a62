"""A node of kind roadside: it repeats octets as they came, once, and nothing that its map refused."""

from pathlib import Path

import numpy as np
import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.node.config import read_config
from modelcast.node.envelope import Unsecured
from modelcast.node.node import Node
from modelcast.node.relaying import Relaying
from modelcast.runtime.transport.base import AbstractTransport, Arrival
from modelcast.station.relay import RelayRule
from modelcast.station.station import Station


class Wire(AbstractTransport):
    """Holds what was sent, and hands over what is put on it."""

    def __init__(self) -> None:
        self.sent: list[tuple[float, bytes]] = []
        self.waiting: list[Arrival] = []

    def send(self, octets: bytes, *, sent_s: float) -> None:
        """Hold it."""
        self.sent.append((sent_s, octets))

    def receive(self, until_s: float) -> list[Arrival]:
        """Hand over what waits."""
        del until_s
        arrived, self.waiting = self.waiting, []
        return arrived


def driven(seconds: float, *, north_m: float = 20.0) -> list[tuple[float, bytes]]:
    """Messages of a car on a straight road past the unit."""
    car, sent = Station("bsm-10hz", temporary_id=1), list[tuple[float, bytes]]()
    for step in range(round(10 * seconds)):
        t_s = 0.1 * step
        place_m = (15.0 * t_s, north_m)
        for message in car.sense(t_s, place_m, speed_mps=15.0, heading_rad=np.pi / 2):
            sent.append((message.send_s, message.octets))
    return sent


def unit(relay: RelayRule | None = None) -> tuple[Node, Wire]:
    wire = Wire()
    relaying = None if relay is None else Relaying(relay, 0.1)
    return Node(Station(temporary_id=9), wire, Unsecured(), relaying=relaying), wire


def heard(node: Node, wire: Wire, frames: list[tuple[float, bytes]], until_s: float) -> list[bytes]:
    """Let a unit hear messages and step; what it sent, without the envelope."""
    for step in range(1, round(10 * until_s) + 1):
        now_s = 0.1 * step
        wire.waiting = [
            Arrival(Unsecured().wrap(octets, sent_s=at_s), at_s)
            for at_s, octets in frames
            if now_s - 0.1 <= at_s < now_s
        ]
        node.hear(now_s)
        node.step(now_s, None)
        node.send(now_s + 0.099)
    return [Unsecured().open(frame, received_s=0.0).octets or b"" for _, frame in wire.sent]


def test_a_unit_that_does_not_relay_hears_and_sends_nothing() -> None:
    node, wire = unit()
    assert heard(node, wire, driven(2.0), 2.0) == []
    assert node.station.believe(2.0).vehicle.tolist() == [1]


def test_a_relay_repeats_every_message_once_unchanged() -> None:
    node, wire = unit(RelayRule())
    frames = driven(2.0)
    assert heard(node, wire, frames, 2.3) == [octets for _, octets in frames]
    assert node.counts["relay: repeated"] == len(frames)


def test_what_another_relay_repeated_is_not_repeated() -> None:
    node, wire = unit(RelayRule())
    frames = driven(1.0)
    twice = sorted(frames + [(at_s + 0.001, octets) for at_s, octets in frames])
    assert heard(node, wire, twice, 1.3) == []
    assert node.counts["relay: by another"] == len(frames)


def test_nonsense_old_messages_and_those_of_far_vehicles_are_not_repeated() -> None:
    node, wire = unit(RelayRule())
    frames = driven(1.0)
    late = [(at_s + 1.0, octets) for at_s, octets in frames]
    assert heard(node, wire, [(0.05, b"\x00\x14\x01"), (0.06, b"")], 0.5) == []
    assert heard(node, wire, late, 2.5) == []
    assert node.counts["relay: too old"] == len(frames)
    node, wire = unit(RelayRule())
    assert heard(node, wire, driven(1.0, north_m=300.0), 1.3) == []
    assert node.counts["relay: too far"] == 10


def test_the_table_of_the_configuration(tmp_path: Path) -> None:
    path = tmp_path / "unit.toml"
    path.write_text("[roadside]\non = true\nlatitude_deg = 48.0\nlongitude_deg = 11.0\nrelay = true\n")
    found = read_config(path).roadside
    assert (found.on, found.relay, found.latitude_deg, found.antenna_m) == (True, True, 48.0, 6.0)
    path.write_text("[roadside]\nlatitude_deg = 91.0\n")
    with pytest.raises(DataFormatError, match="latitude_deg"):
        read_config(path)
