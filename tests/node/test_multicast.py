"""Claims about frames as datagrams of a multicast group, on this machine alone."""

import select
import socket
from collections.abc import Iterator
from contextlib import ExitStack

import pytest

from modelcast.core.exceptions import ConfigError
from modelcast.node.multicast import LOOPBACK, MulticastTransport
from modelcast.runtime.transport.base import MOST_OCTETS, Arrival

GROUP = "239.255.16.77"
WAIT_S = 10.0


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind((LOOPBACK, 0))
        return int(probe.getsockname()[1])


@pytest.fixture
def stations() -> Iterator[list[MulticastTransport]]:
    port, times = free_port(), iter(range(1, 10_000_000))
    with ExitStack() as stack:
        yield [
            stack.enter_context(MulticastTransport(lambda: float(next(times)), group=GROUP, port=port))
            for _ in range(3)
        ]


def arrived(station: MulticastTransport, count: int) -> list[Arrival]:
    """Frames of a station, once so many are there; what the operating system holds is waited for."""
    found: list[Arrival] = []
    while len(found) < count:
        ready, _, _ = select.select([station.fileno()], [], [], WAIT_S)
        assert ready, f"{len(found)} of {count} frames arrived"
        found += station.receive(0.0)
    return found


def test_everybody_else_hears_each_frame_once_and_in_order(stations: list[MulticastTransport]) -> None:
    one, *others = stations
    frames = [bytes([number]) * (number + 1) for number in range(50)]
    for frame in frames:
        one.send(frame, sent_s=0.0)
    for other in others:
        found = arrived(other, len(frames))
        assert [arrival.octets for arrival in found] == frames
        times = [arrival.received_s for arrival in found]
        assert times == sorted(times)
        assert other.receive(0.0) == []
    # What came back of its own is dropped: it is not heard though it was there.
    others[0].send(b"last", sent_s=0.0)
    assert [arrival.octets for arrival in arrived(one, 1)] == [b"last"]


def test_the_longest_frame_arrives_and_a_longer_datagram_is_counted(
    stations: list[MulticastTransport],
) -> None:
    one, other, _ = stations
    port = other._in.getsockname()[1]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as foreign:
        foreign.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(LOOPBACK))
        for octets in (bytes(MOST_OCTETS + 1), bytes(9000), b""):
            foreign.sendto(octets, (GROUP, port))
    one.send(bytes(MOST_OCTETS), sent_s=0.0)
    assert [len(arrival.octets) for arrival in arrived(other, 1)] == [MOST_OCTETS]
    assert other.refused == 3


@pytest.mark.parametrize("octets", [b"", bytes(MOST_OCTETS + 1)])
def test_a_frame_of_no_possible_length_is_refused(octets: bytes, stations: list[MulticastTransport]) -> None:
    with pytest.raises(ValueError, match="1 to 2304 octets"):
        stations[0].send(octets, sent_s=0.0)


def test_a_frame_that_cannot_leave_is_counted(stations: list[MulticastTransport]) -> None:
    stations[0].close()
    stations[0].send(b"frame", sent_s=0.0)
    assert stations[0].unsent == 1
    assert stations[0].receive(0.0) == []


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"group": "10.0.0.1"}, "must be a multicast address"),
        ({"group": "here"}, "group must be an IPv4 address"),
        ({"interface": "lo"}, "interface must be an IPv4 address"),
        ({"interface": "203.0.113.9"}, "cannot join .* on 203.0.113.9"),
        ({"port": 0}, "port must be 1 to 65535"),
        ({"hops": 256}, "hops must be 0 to 255"),
    ],
)
def test_what_cannot_be_joined_is_told(changed: dict[str, object], told: str) -> None:
    with pytest.raises(ConfigError, match=told):
        MulticastTransport(lambda: 0.0, **changed)  # type: ignore[arg-type]
