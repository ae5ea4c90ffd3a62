"""All that a node runs, once before it matters: what is not compiled yet is compiled, the rest is loaded.

Compiled code is loaded, or made, when it is first called (`modelcast.core.kernel`). In a vehicle that would
be at the first step, which would begin many seconds late. So the drives of `modelcast.node.demo` are driven
for a few seconds on a made-up clock, with a transport in memory: a node that sends and hears as it will on
the road, and others that send it whatever it may meet.
"""

import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from modelcast.apps.base import AbstractApplication
from modelcast.channel.erasure import IndependentErasure
from modelcast.core.compiling import Compiling, watch
from modelcast.core.kernel import COMPILES, kernels
from modelcast.node.demo import demo_trips
from modelcast.node.envelope import Unsecured
from modelcast.node.inputs.motion_source import MotionSource
from modelcast.node.inputs.replay import TripReplay
from modelcast.node.node import Node, NodeState
from modelcast.node.pseudonyms import Pseudonyms
from modelcast.node.showing import Showing
from modelcast.runtime.transport.virtual import VirtualMedium
from modelcast.station.sender.sender import Sender, named_sender
from modelcast.station.station import Station

__all__ = ["Rehearsed", "rehearse"]

_LASTS_S = 4.0
"""Every kernel is called by then that is called in ten minutes of the same drives."""
_LOSS_RATIO = 0.3
_RENAMED_S = (2.0, 2.5)


@dataclass(frozen=True, slots=True)
class Rehearsed:
    """What a rehearsal met.

    Parameters
    ----------
    ready
        Kernels that a node calls, all of them ready now.
    compiled
        Names of the kernels that had to be compiled, with those that they take in.
    unkept
        Names of those ready ones that are not in the cache, so that every process compiles them anew.
    took_s
        Time [s].
    """

    ready: int
    compiled: tuple[str, ...]
    unkept: tuple[str, ...]
    took_s: float


def rehearse(
    sender: Sender,
    *,
    applications: Mapping[str, AbstractApplication],
    clock_s: Callable[[], float],
    tick_s: float = 0.1,
    announce: Callable[[str], None] | None = None,
) -> Rehearsed:
    """Run everything that a node runs.

    Parameters
    ----------
    sender
        What it sends, and when.
    applications
        What it warns of, by name.
    clock_s
        Tells how long it takes [s].
    tick_s
        Time between its steps [s].
    announce
        Takes the name of each kernel that is about to be compiled.

    Examples
    --------
    >>> from modelcast.apps.registry import get_application
    >>> met = rehearse(
    ...     named_sender("mbc"), applications={"fcw": get_application("fcw")}, clock_s=lambda: 0.0
    ... )
    >>> met.ready > 20 or not COMPILES
    True
    """
    compiled: list[str] = []

    def listen(one: Compiling) -> None:
        if one.label:
            compiled.append(one.label)
            if announce is not None:
                announce(one.label)
        if before is not None:
            before(one)

    begun_s = clock_s()
    before = watch(listen)
    try:
        _drive(sender, applications, tick_s)
    finally:
        watch(before)
    own = [one for one in kernels() if one.is_ready] if COMPILES else []
    return Rehearsed(
        len(own),
        tuple(compiled),
        tuple(one.label for one in own if not one.is_kept),
        clock_s() - begun_s,
    )


def _drive(sender: Sender, applications: Mapping[str, AbstractApplication], tick_s: float) -> None:
    """Drive the node to be behind two others, while somebody crosses."""
    medium = VirtualMedium(IndependentErasure(_LOSS_RATIO), instant_s=tick_s)
    trips = demo_trips()
    cast: Sequence[tuple[str, Sender, TripReplay]] = (
        ("leader", named_sender("mbc"), TripReplay(trips["leader"])),
        ("second", sender, TripReplay(trips["second"], with_bus=False, latency_s=0.5 * tick_s)),
        ("crossing", named_sender("bsm-10hz"), TripReplay(trips["crossing"])),
        ("third", sender, TripReplay(trips["third"])),
    )
    nodes = [
        (
            _node(one, medium, replay, applications if name == "third" else {}, tick_s),
            replay,
            MotionSource(None if name == "second" else replay.origin),
        )
        for name, one, replay in cast
    ]
    showing = Showing(nodes[-1][0])
    for step in range(1, round(_LASTS_S / tick_s)):
        now_s = tick_s * step
        states: list[NodeState] = []
        for node, replay, source in nodes:
            node.hear(now_s)
            source.feed(replay.take(now_s))
            states.append(node.step(now_s, source.at(now_s)))
            node.send(now_s + 0.5 * tick_s)
        showing.snapshot(states[-1])


def _node(
    sender: Sender,
    medium: VirtualMedium,
    replay: TripReplay,
    applications: Mapping[str, AbstractApplication],
    tick_s: float,
) -> Node:
    names = Pseudonyms(*_RENAMED_S, np.random.default_rng(zlib.crc32(replay.trip.trip_id.encode())))
    station = Station(sender, temporary_id=names.temporary_id, dt_s=tick_s, origin=replay.origin)
    return Node(station, medium.join(), Unsecured(), applications=applications, pseudonyms=names)
