"""Frames as UDP datagrams to a multicast group: stations of one machine or one network hear each other.

What a radio does with a broadcast, as far as a network can: everybody who has joined the group gets each
datagram once, or not at all. Nothing leaves the machine unless an interface is named.
"""

import socket
import struct
from collections.abc import Callable
from ipaddress import AddressValueError, IPv4Address
from typing import TYPE_CHECKING, Self

from modelcast.core.exceptions import ConfigError
from modelcast.runtime.transport.base import MOST_OCTETS, AbstractTransport, Arrival

if TYPE_CHECKING:
    from modelcast.node.clock import AbstractClock
    from modelcast.node.config import Air

__all__ = ["GROUP", "LOOPBACK", "PORT", "MulticastTransport", "open_multicast"]

GROUP, PORT = "239.255.16.9", 16090
"""Group and port where none are named; the group is of the block for one site (RFC 2365)."""

LOOPBACK = "127.0.0.1"
"""Interface that keeps everything on this machine."""

_MOST_AT_ONCE = 4096
"""Datagrams that one call takes: whoever floods must not keep the station from its own step."""

_BUFFER_OCTETS = 4 * 2**20
_NO_ROOM = 1
"""One octet more than any frame: longer datagrams are seen to be so."""


class MulticastTransport(AbstractTransport):
    """One station's place in a multicast group; close it, or use it as a context.

    Parameters
    ----------
    clock
        Gives the time at which a datagram is taken up [s].
    group, port
        Where frames go.
    interface
        Address of the interface; `LOOPBACK` keeps everything on this machine.
    hops
        Routers that a frame may pass, and one: 1 stays on the network of the interface.

    Raises
    ------
    ConfigError
        Where an address is none, the group is no multicast group, a number is out of its range, or the
        operating system refuses the group on that interface.
    """

    def __init__(
        self,
        clock: Callable[[], float],
        *,
        group: str = GROUP,
        port: int = PORT,
        interface: str = LOOPBACK,
        hops: int = 1,
    ) -> None:
        if not _address("group", group).is_multicast:
            raise ConfigError(f"group must be a multicast address, 224.0.0.0 to 239.255.255.255, got {group}")
        _ = _address("interface", interface)
        if not 1 <= port < 2**16:
            raise ConfigError(f"port must be 1 to 65535, got {port}")
        if not 0 <= hops < 2**8:
            raise ConfigError(f"hops must be 0 to 255, got {hops}")
        self._clock, self._to = clock, (group, port)
        self.refused = 0
        """Datagrams that no frame has: empty, or too long."""
        self.unsent = 0
        """Frames that the operating system did not take."""
        self._out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._in = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            here = socket.inet_aton(interface)
            self._out.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, here)
            self._out.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, hops)
            self._out.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 1)
            self._out.bind((interface, 0))
            self._own = self._out.getsockname()
            self._in.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self._in.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_OCTETS)
            # The group's address, not every one: datagrams to this port alone are none of ours.
            self._in.bind((group, port))
            joined = struct.pack("4s4s", socket.inet_aton(group), here)
            self._in.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, joined)
            for one in (self._in, self._out):
                one.setblocking(False)
        except OSError as error:
            self.close()
            raise ConfigError(
                f"cannot join {group}:{port} on {interface}: {error.strerror or error}; name the address "
                f"of an interface of this machine, or {LOOPBACK}"
            ) from error

    def fileno(self) -> int:
        """Number of the socket that frames arrive at, for an event loop to wait on."""
        return self._in.fileno()

    def send(self, octets: bytes, *, sent_s: float) -> None:  # noqa: ARG002 - it leaves now
        """Broadcast one frame, now; one that the operating system cannot take is counted in `unsent`."""
        if not 1 <= len(octets) <= MOST_OCTETS:
            raise ValueError(f"a frame must have 1 to {MOST_OCTETS} octets, got {len(octets)}")
        try:
            self._out.sendto(octets, self._to)
        except OSError:
            self.unsent += 1

    def receive(self, until_s: float) -> list[Arrival]:  # noqa: ARG002 - what is there has arrived
        """Return what has arrived and was not returned before, at most 4,096; own frames are left out."""
        found: list[Arrival] = []
        for _ in range(_MOST_AT_ONCE):
            try:
                octets, sender = self._in.recvfrom(MOST_OCTETS + _NO_ROOM)
            except OSError:  # nothing there, or closed
                break
            if sender == self._own:
                continue
            if not 1 <= len(octets) <= MOST_OCTETS:
                self.refused += 1
                continue
            found.append(Arrival(octets, self._clock()))
        return found

    def close(self) -> None:
        """Leave the group."""
        self._in.close()
        self._out.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def open_multicast(air: "Air", clock: "AbstractClock") -> MulticastTransport:
    """Return the transport of a configuration's table ``[air]``.

    Raises
    ------
    ConfigError
        As `MulticastTransport`.
    """
    return MulticastTransport(
        clock.now_s, group=air.group, port=air.port, interface=air.interface, hops=air.hops
    )


def _address(name: str, text: str) -> IPv4Address:
    try:
        return IPv4Address(text)
    except AddressValueError as error:
        raise ConfigError(f"{name} must be an IPv4 address, got {text!r}") from error
