"""A medium in memory: stations that join it hear each other, with losses, delay and jitter from a seed."""

import heapq
import math
from itertools import count

import numpy as np

from modelcast.channel.base import AbstractChannel
from modelcast.channel.erasure import Ideal
from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.core.chance import child_generator
from modelcast.runtime.transport.base import MOST_OCTETS, AbstractTransport, Arrival

__all__ = ["VirtualMedium", "VirtualTransport"]

_BLOCK = 1024
"""Instants whose fate is drawn at once."""


class VirtualMedium:
    """What stations share: each frame reaches every other one, unless the channel loses it.

    The fate of a link is drawn for every instant, as in an evaluation, whether anything is sent there or not:
    the same seed gives the same losses whatever is sent, in whatever order. Frames that leave within one
    instant share its fate. A burst ends with its block of 1,024 instants.

    Parameters
    ----------
    channel
        What a link loses; each pair of stations has its own course of it, each way.
    delay_s
        From leaving to arriving [s].
    jitter_s
        At most this much more, evenly drawn: frames may overtake each other [s].
    instant_s
        Time between instants [s].
    seed
        Of all losses and jitters.

    Raises
    ------
    ValueError
        Where a time is out of its range.

    Examples
    --------
    >>> from modelcast.channel.erasure import IndependentErasure
    >>> medium = VirtualMedium(IndependentErasure(0.4), delay_s=0.02, seed=1)
    >>> one, other = medium.join(), medium.join()
    >>> for step in range(1000):
    ...     one.send(b"hello", sent_s=0.1 * step)
    >>> heard = other.receive(100.0)
    >>> len(heard) == medium.delivered == medium.sent - medium.lost, round(medium.lost / medium.sent, 1)
    (True, 0.4)
    """

    def __init__(
        self,
        channel: AbstractChannel | None = None,
        *,
        delay_s: float = 0.0,
        jitter_s: float = 0.0,
        instant_s: float = 0.1,
        seed: int = 0,
    ) -> None:
        for name, value, low in (("delay_s", delay_s, 0.0), ("jitter_s", jitter_s, 0.0)):
            if not low <= value < math.inf:
                raise ValueError(f"{name} must be finite and not negative, got {value}")
        if not 0.0 < instant_s < math.inf:
            raise ValueError(f"instant_s must be finite and positive, got {instant_s}")
        self._channel = Ideal() if channel is None else channel
        self._delay_s, self._jitter_s, self._instant_s, self._seed = delay_s, jitter_s, instant_s, seed
        self._inboxes: list[list[tuple[float, int, bytes]]] = []
        self._order = count()
        self._fates: dict[tuple[int, int], tuple[int, BoolArray, FloatArray]] = {}
        self.sent = 0
        """Frames handed over by all stations."""
        self.delivered = 0
        """Receptions, those not yet asked for too."""
        self.lost = 0
        """Receptions that did not come to be."""

    def join(self) -> "VirtualTransport":
        """Add a station; it hears what is sent from now on."""
        self._inboxes.append([])
        return VirtualTransport(self, len(self._inboxes) - 1)

    def carry(self, sender: int, octets: bytes, sent_s: float) -> None:
        """Bring a frame to everybody but its sender; `VirtualTransport.send` calls it.

        Parameters
        ----------
        sender
            Number of the station, in the order of joining.
        octets, sent_s
            As in `AbstractTransport.send`.

        Raises
        ------
        ValueError
            As for `AbstractTransport.send`.
        """
        if not 1 <= len(octets) <= MOST_OCTETS:
            raise ValueError(f"a frame must have 1 to {MOST_OCTETS} octets, got {len(octets)}")
        if not math.isfinite(sent_s):
            raise ValueError(f"sent_s must be finite, got {sent_s}")
        self.sent += 1
        for receiver, inbox in enumerate(self._inboxes):
            if receiver != sender:
                lost, later_s = self._fate(sender, receiver, sent_s)
                self.lost += int(lost)
                self.delivered += int(not lost)
                if not lost:
                    heapq.heappush(inbox, (sent_s + self._delay_s + later_s, next(self._order), octets))

    def arrived(self, receiver: int, until_s: float) -> list[Arrival]:
        """Take what has reached a station by a time; `VirtualTransport.receive` calls it.

        Parameters
        ----------
        receiver
            Number of the station.
        until_s
            Now [s].
        """
        inbox, found = self._inboxes[receiver], list[Arrival]()
        while inbox and inbox[0][0] <= until_s:
            received_s, _, octets = heapq.heappop(inbox)
            found.append(Arrival(octets, received_s))
        return found

    def _fate(self, sender: int, receiver: int, sent_s: float) -> tuple[bool, float]:
        """Whether a link loses what leaves now, and how much later than usual it would arrive [s]."""
        block, place = divmod(round(sent_s / self._instant_s), _BLOCK)
        known = self._fates.get((sender, receiver))
        if known is None or known[0] != block:
            t_s = (block * _BLOCK + np.arange(_BLOCK, dtype=np.float64)) * self._instant_s
            key = (sender, receiver, abs(block), int(block < 0))
            lost = self._channel.losses(t_s, child_generator(self._seed, *key, "loss"))
            later_s = child_generator(self._seed, *key, "jitter").random(_BLOCK) * self._jitter_s
            self._fates[sender, receiver] = known = (block, lost, later_s)
        return bool(known[1][place]), float(known[2][place])


class VirtualTransport(AbstractTransport):
    """One station's place on a `VirtualMedium`; made by `VirtualMedium.join`."""

    def __init__(self, medium: VirtualMedium, number: int) -> None:
        self._medium, self._number = medium, number

    def send(self, octets: bytes, *, sent_s: float) -> None:
        """Broadcast one frame to all other stations of the medium."""
        self._medium.carry(self._number, octets, sent_s)

    def receive(self, until_s: float) -> list[Arrival]:
        """Return what has arrived by a time, in order of arrival."""
        return self._medium.arrived(self._number, until_s)
