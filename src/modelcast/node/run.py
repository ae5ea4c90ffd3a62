"""A node in real time: its step on a clock, reception as frames arrive, frames out when they are due."""

import asyncio
import math
from collections.abc import Callable
from typing import final

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.node.clock import AbstractClock
from modelcast.node.inputs.motion import Motion
from modelcast.node.node import Node, NodeState

__all__ = ["Lateness", "run_node"]

_KEPT = 4096

_TOGETHER_S = 0.01
"""Frames that arrive this soon after others have been heard wait for each other at most [s]."""

_REST = 7.0
"""Times as long as a hearing took, what arrives next waits: hearing takes an eighth of the time at most."""


@final
class Lateness:
    """How late steps began, the newest 4,096 of them.

    Examples
    --------
    >>> late = Lateness()
    >>> for value_s in (0.001, 0.002, 0.003):
    ...     late.add(value_s)
    >>> late.quantile_s(0.5), late.count
    (0.002, 3)
    """

    def __init__(self) -> None:
        self._ring: FloatArray = np.zeros(_KEPT)
        self.count = 0
        """Steps so far."""
        self.skipped = 0
        """Steps left out since the one before had not ended."""

    def add(self, late_s: float) -> None:
        """Take in one step's lateness [s]."""
        self._ring[self.count % _KEPT] = late_s
        self.count += 1

    def quantile_s(self, share: float) -> float:
        """Return a quantile; not a number before the first step [s].

        Parameters
        ----------
        share
            0..1.
        """
        own = self._ring[: min(self.count, _KEPT)]
        return float(np.quantile(own, share)) if own.size else math.nan


async def run_node(
    node: Node,
    clock: AbstractClock,
    measure: Callable[[float], Motion | None],
    *,
    tick_s: float,
    stop: asyncio.Event,
    fileno: int | None = None,
    publish: Callable[[NodeState], None] | None = None,
    lateness: Lateness | None = None,
) -> None:
    """Run a node until it is told to stop.

    Steps are at whole multiples of the tick on the clock. One that cannot begin before the next is due is
    left out and counted: the station sees a gap, and nothing piles up.

    Parameters
    ----------
    node, clock
        What runs, and by which time.
    measure
        Gives the own motion at a step's instant.
    tick_s
        Time between steps [s].
    stop
        Set from outside.
    fileno
        Socket that frames arrive at, to hear them as they come, those of a flood together; None to
        hear at every step alone.
    publish
        Takes the state after every step.
    lateness
        Takes how late each began.
    """
    loop = asyncio.get_running_loop()
    late = Lateness() if lateness is None else lateness
    sender = _Sender(node, clock, loop)

    ear = None if fileno is None else _Ear(node, clock, loop, fileno)
    number = math.floor(clock.now_s() / tick_s) + 1
    try:
        while not await _until(clock, number * tick_s, stop):
            due = math.floor(clock.now_s() / tick_s)
            late.skipped += max(due - number, 0)
            number = max(due, number)
            late.add(clock.now_s() - number * tick_s)
            node.hear(clock.now_s())
            state = node.step(number * tick_s, measure(number * tick_s))
            sender.plan()
            if publish is not None:
                publish(state)
            number += 1
    finally:
        if ear is not None:
            ear.cancel()
        sender.cancel()


async def _until(clock: AbstractClock, due_s: float, stop: asyncio.Event) -> bool:
    """Wait for a time of the clock; True where it is told to stop before."""
    while (wait_s := due_s - clock.now_s()) > 0.0:
        try:
            async with asyncio.timeout(wait_s):
                await stop.wait()
        except TimeoutError:
            continue
        return True
    # Whoever has no time to wait still lets others run.
    await asyncio.sleep(0)
    return stop.is_set()


class _Ear:
    """Hears frames as they arrive, and in a flood those of some milliseconds together.

    A frame costs little beside a call: a hundred at once are ten times cheaper than one at a time.
    """

    def __init__(
        self, node: Node, clock: AbstractClock, loop: asyncio.AbstractEventLoop, fileno: int
    ) -> None:
        self._node, self._clock, self._loop, self._fileno = node, clock, loop, fileno
        self._handle: asyncio.TimerHandle | None = None
        self._listen()

    def _listen(self) -> None:
        self._handle = None
        self._loop.add_reader(self._fileno, self._hear)

    def _hear(self) -> None:
        begin_s = self._clock.now_s()
        if not self._node.hear(begin_s):
            return
        took_s = self._clock.now_s() - begin_s
        self._loop.remove_reader(self._fileno)
        self._handle = self._loop.call_later(min(_REST * took_s, _TOGETHER_S), self._listen)

    def cancel(self) -> None:
        """Hear no more."""
        if self._handle is not None:
            self._handle.cancel()
        else:
            self._loop.remove_reader(self._fileno)


class _Sender:
    """Hands frames over when they are due."""

    def __init__(self, node: Node, clock: AbstractClock, loop: asyncio.AbstractEventLoop) -> None:
        self._node, self._clock, self._loop = node, clock, loop
        self._handle: asyncio.TimerHandle | None = None

    def plan(self) -> None:
        """Send what is due, and wait for the next."""
        self.cancel()
        self._node.send(self._clock.now_s())
        wait_s = self._node.next_send_s - self._clock.now_s()
        if math.isfinite(wait_s):
            self._handle = self._loop.call_later(max(wait_s, 0.0), self.plan)

    def cancel(self) -> None:
        """Wait no more."""
        if self._handle is not None:
            self._handle.cancel()
            self._handle = None
