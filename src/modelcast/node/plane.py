"""Where a node's plane begins, and what it hears before it knows that.

A map is kept on a plane that touches the Earth somewhere near. A node begins it at the first place it knows:

==============  =====================================================================================
``trip``        the plane of a recorded trip that is driven again
``configured``  the place that its configuration names
``own``         its own first place
``heard``       the place in the first message that it hears
==============  =====================================================================================

Nobody vouches for a place that was heard, and one that was configured may be of yesterday. So where the own
first place is more than `FAR_M` from the origin of such a plane, the node begins anew on one of its own.
"""

import math
from collections import deque
from dataclasses import dataclass
from typing import Literal, final

import numpy as np

from modelcast.core.exceptions import CodecError
from modelcast.core.geodesy import Origin
from modelcast.io.spmd import valid_position
from modelcast.messages.message_heads import decode_safety, part_one_of
from modelcast.node.envelope import Unsecured
from modelcast.runtime.transport.base import AbstractTransport, Arrival

__all__ = ["FAR_M", "HeldTransport", "Plane", "place_in"]

FAR_M = 20_000.0
"""Farther than any radio of this kind is heard."""

_MOST_HELD = 1024

_OPENER = Unsecured()


@dataclass(frozen=True, slots=True)
class Plane:
    """Where a node's plane begins.

    Parameters
    ----------
    origin
        The place.
    found
        What it is the place of.
    """

    origin: Origin
    found: Literal["trip", "configured", "own", "heard"]

    def is_far(self, position_m: tuple[float, float]) -> bool:
        """Whether an own place is too far off for a plane that nobody vouches for.

        Parameters
        ----------
        position_m
            East and north on it; not a number where it is off the plane [m].

        Examples
        --------
        >>> Plane(Origin(48.0, 11.0), "heard").is_far((30_000.0, 0.0))
        True
        >>> Plane(Origin(48.0, 11.0), "own").is_far((30_000.0, 0.0))
        False
        """
        return self.found in {"configured", "heard"} and not math.hypot(*position_m) <= FAR_M


def place_in(frame: bytes) -> Origin | None:
    """The place that a frame's safety message states, nothing verified; None where it states none.

    Parameters
    ----------
    frame
        As it arrived.

    Examples
    --------
    >>> place_in(b"no frame") is None
    True
    """
    opened = _OPENER.open(frame, received_s=0.0)
    if opened.octets is None:
        return None
    try:
        values = part_one_of(decode_safety(opened.octets)).values()
    except CodecError:
        return None
    latitude_deg, longitude_deg = values["latitude_deg"], values["longitude_deg"]
    if latitude_deg is None or longitude_deg is None:
        return None
    if not valid_position(np.array([latitude_deg]), np.array([longitude_deg]))[0]:
        return None
    return Origin(latitude_deg, longitude_deg)


@final
class HeldTransport(AbstractTransport):
    """A transport whose frames can be looked at before they are received.

    Parameters
    ----------
    transport
        What carries them. At most 1,024 frames are held; where one more comes the oldest goes.

    Examples
    --------
    >>> from modelcast.runtime.transport.virtual import VirtualMedium
    >>> medium = VirtualMedium()
    >>> one, other = medium.join(), HeldTransport(medium.join())
    >>> one.send(b"hello", sent_s=1.0)
    >>> [len(other.peek(2.0)), len(other.peek(2.0)), len(other.receive(2.0)), len(other.receive(2.0))]
    [1, 0, 1, 0]
    """

    def __init__(self, transport: AbstractTransport) -> None:
        self._transport = transport
        self._held: deque[Arrival] = deque(maxlen=_MOST_HELD)

    def send(self, octets: bytes, *, sent_s: float) -> None:
        """Broadcast one frame."""
        self._transport.send(octets, sent_s=sent_s)

    def fileno(self) -> int | None:
        """That of the transport."""
        return self._transport.fileno()

    def close(self) -> None:
        """Close the transport."""
        self._transport.close()

    def peek(self, until_s: float) -> list[Arrival]:
        """Return what has arrived by a time and was not looked at before; it can still be received.

        Parameters
        ----------
        until_s
            Now [s].
        """
        arrived = self._transport.receive(until_s)
        self._held.extend(arrived)
        return arrived

    def receive(self, until_s: float) -> list[Arrival]:
        """Return what is held, and what has arrived since."""
        held = list(self._held)
        self._held.clear()
        return held + self._transport.receive(until_s)
