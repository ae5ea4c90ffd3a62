"""An impaired air: carries frames between multicast groups, one station in each.

Stations need not know of it: each has a group of its own, and what it sends there is heard in all others'
groups, as far as an `Impairment` lets it.
"""

import asyncio
import math
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import final

import numpy as np

from modelcast.channel.erasure import GilbertElliott
from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.node.multicast import MulticastTransport
from modelcast.node.trials.impairment import CLEAR, Impairment
from modelcast.runtime.transport.base import MOST_OCTETS

__all__ = ["Relay", "altered"]

_GRID_S, _GRID_STEPS = 0.01, 60_000
"""Bursts are drawn for ten minutes beforehand, and come again then."""


@final
class Relay:
    """Stations' groups, and what happens between them.

    Parameters
    ----------
    groups
        Address of each station's group.
    port
        Of all.
    clock
        Gives the time, for bursts [s].
    rng
        Draws.

    Raises
    ------
    ConfigError
        Where a group cannot be joined.
    """

    def __init__(
        self, groups: Sequence[str], port: int, *, clock: Callable[[], float], rng: np.random.Generator
    ) -> None:
        self._clock, self._rng = clock, rng
        self.counts: Counter[str] = Counter()
        """``heard``, ``given``, ``lost``, ``altered``, ``late``, ``again``."""
        self._open = ExitStack()
        self._places: list[MulticastTransport] = []
        try:
            for group in groups:
                place = MulticastTransport(clock, group=group, port=port, hops=0)
                self._open.callback(place.close)
                self._places.append(place)
        except BaseException:
            self._open.close()
            raise
        self._bad: dict[tuple[int, int], BoolArray] = {}
        self._loop: asyncio.AbstractEventLoop | None = None
        self._impairment = CLEAR
        self.watch: Callable[[int, bytes], None] | None = None
        """Takes every frame that a station sent, with the station."""

    @property
    def impairment(self) -> Impairment:
        """How badly frames are carried."""
        return self._impairment

    @impairment.setter
    def impairment(self, impairment: Impairment) -> None:
        self._impairment = impairment
        self._bad.clear()
        if impairment.burst_s:
            times_s: FloatArray = _GRID_S * np.arange(_GRID_STEPS, dtype=np.float64)
            channel = GilbertElliott(impairment.loss_ratio, impairment.burst_s)
            links = [(one, other) for one in range(len(self._places)) for other in range(len(self._places))]
            self._bad = {link: channel.losses(times_s, self._rng) for link in links if link[0] != link[1]}

    def start(self) -> None:
        """Begin to carry, in the running loop."""
        self._loop = asyncio.get_running_loop()
        for number, place in enumerate(self._places):
            self._loop.add_reader(place.fileno(), self.carry, number)

    def stop(self) -> None:
        """End, and leave the groups; what is held up is lost."""
        loop, self._loop = self._loop, None
        if loop is not None:
            for place in self._places:
                loop.remove_reader(place.fileno())
        self._open.close()

    def carry(self, station: int) -> None:
        """Take up what a station has sent, and give it to the others.

        Parameters
        ----------
        station
            Its place among the groups.
        """
        for one in self._places[station].receive(math.inf):
            self.counts["heard"] += 1
            if self.watch is not None:
                self.watch(station, one.octets)
            for other in range(len(self._places)):
                if other != station:
                    self._pass_on(station, other, one.octets)

    def give(self, station: int, octets: bytes) -> None:
        """Send a frame into a station's group, as if it had come over the air.

        Parameters
        ----------
        station
            Its place among the groups.
        octets
            1 to 2,304 of them.
        """
        if self._loop is not None:
            self.counts["given"] += 1
            self._places[station].send(octets, sent_s=self._clock())

    def _pass_on(self, station: int, other: int, octets: bytes) -> None:
        how, rng = self._impairment, self._rng
        if self._lost(station, other):
            self.counts["lost"] += 1
            return
        if how.altered_ratio and rng.random() < how.altered_ratio:
            self.counts["altered"] += 1
            octets = altered(octets, rng)
        for _ in range(how.copies):
            if how.late_ratio and rng.random() < how.late_ratio:
                self.counts["late"] += 1
                self._later(rng.uniform(0.0, how.late_s), other, octets)
            else:
                self.give(other, octets)
        if how.again_s:
            self.counts["again"] += 1
            self._later(how.again_s, other, octets)

    def _lost(self, station: int, other: int) -> bool:
        how = self._impairment
        if (station in how.parted) != (other in how.parted):
            return True
        if self._bad:
            step = math.floor(self._clock() / _GRID_S) % _GRID_STEPS
            return bool(self._bad[station, other][step])
        return bool(how.loss_ratio and self._rng.random() < how.loss_ratio)

    def _later(self, after_s: float, other: int, octets: bytes) -> None:
        if self._loop is not None:
            self._loop.call_later(after_s, self.give, other, octets)


def altered(octets: bytes, rng: np.random.Generator) -> bytes:
    """Return a frame of which one octet, drawn evenly, is another one.

    Parameters
    ----------
    octets
        1 to 2,304 of them.
    rng
        Draws.

    Raises
    ------
    ValueError
        Where there is no octet, or one too many.

    Examples
    --------
    >>> sum(one != other for one, other in zip(altered(bytes(9), np.random.default_rng(1)), bytes(9)))
    1
    """
    if not 1 <= len(octets) <= MOST_OCTETS:
        raise ValueError(f"a frame must have 1 to {MOST_OCTETS} octets, got {len(octets)}")
    found = bytearray(octets)
    found[int(rng.integers(len(octets)))] ^= int(rng.integers(1, 256))
    return bytes(found)
