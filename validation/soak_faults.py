"""The faults of a soak: what is done, whose maps are looked at, and what must hold."""

import asyncio
import math
import os
import time
from collections.abc import AsyncGenerator, Callable, Mapping
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import KW_ONLY, dataclass, field

from modelcast.messages.security.time64 import since_2004_s
from modelcast.node.credentials import make_credentials
from modelcast.node.envelope import Unsecured
from modelcast.node.signed import Signed
from modelcast.node.trials.bus_player import BusGives
from modelcast.node.trials.gpsd_player import Gives
from modelcast.node.trials.hostile import InventedVehicles, random_frames
from modelcast.node.trials.impairment import CLEAR, Impairment
from modelcast.node.trials.relay import altered
from soak_stand import NAMES, WITH_BUS, Stand

__all__ = ["FAULTS", "SHORT", "Bounds", "Fault", "Seen"]

NOMINAL_PER_S = 1000
"""Frames of a busy channel: 100 vehicles within reach at 10 Hz; ten times as many is more than a channel of
10 MHz carries."""

MANY_NAMES = 10_000
_ROOM_MB = 0.1
_FORGED, _WEEK_S = 100, 7 * 86_400
_ENDS = {"all closed after, s": 1.0, "process gone after, s": 5.0}
"""An interpreter takes a while to go after the node has closed everything, on a busy machine seconds."""

_STARTS_S = 55.0
"""A start is Python's and that of compiled code: some seconds, on a machine busy with others many."""

_OTHERS = tuple(name for name in NAMES if name != WITH_BUS)


@dataclass(frozen=True, slots=True)
class Bounds:
    """What must hold of a fault.

    Parameters
    ----------
    tracked_ratio
        Least share of remotes tracked while it lasts.
    error_p95_m
        Largest error of their places then [m].
    recovery_s
        Longest until all is right again [s].
    strangers
        Most remotes in a map that nobody is.
    seen
        Upper bounds of what else is seen, by its name.
    """

    tracked_ratio: float = 0.0
    error_p95_m: float = math.inf
    recovery_s: float = 2.0
    _: KW_ONLY
    strangers: float = math.inf
    seen: Mapping[str, float] = field(default_factory=dict[str, float])


Seen = dict[str, float]
"""Other figures of a fault, by name with unit."""


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing that goes wrong.

    Parameters
    ----------
    name
        For the table.
    during
        Does it for as long as the context is open; what it gives is filled in by its end.
    lasts_s, after_s
        How long it is done, and how long is looked on at most then [s].
    bounds
        What must hold.
    hosts, remotes
        Whose maps count, and of whom; all where empty.
    skip
        Why it cannot be done here; nothing where it can.
    """

    name: str
    during: Callable[[Stand], AbstractAsyncContextManager[Seen]]
    lasts_s: float
    after_s: float
    bounds: Bounds
    _: KW_ONLY
    hosts: tuple[str, ...] = ()
    remotes: tuple[str, ...] = ()
    skip: str = ""


def _air(impairment: Impairment) -> Callable[[Stand], AbstractAsyncContextManager[Seen]]:
    """The air is impaired."""

    @asynccontextmanager
    async def during(stand: Stand) -> AsyncGenerator[Seen]:
        stand.relay.impairment = impairment
        try:
            yield {}
        finally:
            stand.relay.impairment = CLEAR

    return during


@asynccontextmanager
async def _nothing(_stand: Stand) -> AsyncGenerator[Seen]:
    yield {}


def _gnss(
    gives: Gives, *, silent_within_s: float = math.inf
) -> Callable[[Stand], AbstractAsyncContextManager[Seen]]:
    """The receiver of the node with the bus gives something else."""

    @asynccontextmanager
    async def during(stand: Stand) -> AsyncGenerator[Seen]:
        seen: Seen = {}
        begin_s = time.time()
        stand.gpsd[WITH_BUS].gives = gives
        try:
            yield seen
        finally:
            mode, since_s = stand.inputs(WITH_BUS)
            if silent_within_s < math.inf:
                seen["silent after, s"] = since_s - begin_s if mode == "silent" else math.inf
            stand.gpsd[WITH_BUS].gives = "fixes"

    return during


def _bus(gives: BusGives) -> Callable[[Stand], AbstractAsyncContextManager[Seen]]:
    """The bus gives something else."""

    @asynccontextmanager
    async def during(stand: Stand) -> AsyncGenerator[Seen]:
        assert stand.bus is not None
        seen: Seen = {}
        begin_s = time.time()
        stand.bus.gives = gives
        try:
            yield seen
        finally:
            if gives == "nothing":
                mode, since_s = stand.inputs(WITH_BUS)
                seen["by fixes alone after, s"] = since_s - begin_s if mode == "gnss" else math.inf
            else:
                told_s = [
                    at_s - begin_s
                    for at_s, event in stand.nodes[WITH_BUS].events
                    if at_s >= begin_s and event.get("what") == "frozen" and "speed_mps" in event["after"]
                ]
                seen["found frozen after, s"] = min(told_s, default=math.inf)
            stand.bus.gives = "values"

    return during


@asynccontextmanager
async def _gpsd_restarted(stand: Stand) -> AsyncGenerator[Seen]:
    gpsd, seen = stand.gpsd[WITH_BUS], Seen()
    before = gpsd.connections
    await gpsd.stop()
    await asyncio.sleep(1.0)
    await gpsd.start()
    begin_s = time.time()
    yield seen
    came = gpsd.connections > before
    seen["connected again after, s"] = gpsd.last_connection_utc_s - begin_s if came else math.inf


@asynccontextmanager
async def _gpsd_half_open(stand: Stand) -> AsyncGenerator[Seen]:
    """Not an octet comes on the connection that is there; a new one is served."""
    gpsd, seen = stand.gpsd[WITH_BUS], Seen()
    before, begin_s = gpsd.connections, time.time()
    gpsd.gives = "nothing"
    await stand.until(lambda: gpsd.connections > before, at_most_s=8.0)
    gpsd.gives = "fixes"  # a new process would serve whoever comes anew
    seen["connected again after, s"] = gpsd.last_connection_utc_s - begin_s
    yield seen


@asynccontextmanager
async def _gpsd_splits(stand: Stand) -> AsyncGenerator[Seen]:
    stand.gpsd[WITH_BUS].splits = True
    yield {}
    stand.gpsd[WITH_BUS].splits = False


@asynccontextmanager
async def _killed(stand: Stand) -> AsyncGenerator[Seen]:
    await stand.nodes["leader"].kill()
    yield {}
    await stand.restart("leader")


@asynccontextmanager
async def _terminated(stand: Stand) -> AsyncGenerator[Seen]:
    seen = await _stopped(stand, "second")
    yield seen
    await stand.restart("second")


@asynccontextmanager
async def _stalled(stand: Stand) -> AsyncGenerator[Seen]:
    """The process gets no time at all."""
    stand.nodes["crossing"].pause()
    yield {}
    stand.nodes["crossing"].resume()


def _clock(offset_s: float) -> Callable[[Stand], AbstractAsyncContextManager[Seen]]:
    """The clock of one node steps by so much, and back at the end."""

    @asynccontextmanager
    async def during(stand: Stand) -> AsyncGenerator[Seen]:
        node, seen = stand.nodes[WITH_BUS], Seen()
        begin_s = time.time()
        node.tell_clock(offset_s)
        try:
            yield seen
        finally:
            mode, since_s = stand.inputs(WITH_BUS)
            seen["silent after, s"] = since_s - begin_s if mode == "silent" else math.inf
            node.tell_clock(0.0)

    return during


@asynccontextmanager
async def _clock_given(stand: Stand) -> AsyncGenerator[Seen]:
    """The node is started anew, with a clock that can be told."""
    seen = await _stopped(stand, WITH_BUS)
    await stand.restart(WITH_BUS, told_clock=True)
    yield seen


async def _stopped(stand: Stand, name: str) -> Seen:
    """End a node by SIGTERM: when it says that all is closed, and when its process is gone."""
    node, begin_s = stand.nodes[name], time.time()
    gone_s = await node.stop()
    told_s = [
        at_s - begin_s for at_s, event in node.events if at_s >= begin_s and event.get("event") == "stop"
    ]
    return {"all closed after, s": min(told_s, default=math.inf), "process gone after, s": gone_s}


@asynccontextmanager
async def _disk_full(stand: Stand) -> AsyncGenerator[Seen]:
    """A node is started anew to record into a folder that has next to no room."""
    node, seen = stand.nodes["crossing"], Seen()
    await node.stop()
    folder = stand.folder / "recordings"
    stand.configure("crossing", f'[record]\nfolder = "{folder}"\nmost_mb = {_ROOM_MB}\n')
    await stand.restart("crossing")
    await stand.until(lambda: any(folder.rglob("*.mcap")), at_most_s=_STARTS_S)
    yield seen
    figures = await node.figures()
    seen["recording goes on"] = figures.get(("modelcast_recording", ""), math.inf)
    seen["recorded, MB"] = sum(one.stat().st_size for one in folder.rglob("*") if one.is_file()) / 1e6


@asynccontextmanager
async def _random(stand: Stand) -> AsyncGenerator[Seen]:
    def make(count: int, _now_s: float) -> list[bytes]:
        return random_frames(count, stand.rng)

    async with stand.flood(WITH_BUS, NOMINAL_PER_S, make) as flood:
        seen: Seen = {}
        yield seen
    seen["frames"] = flood.sent


@asynccontextmanager
async def _keys(stand: Stand) -> AsyncGenerator[Seen]:
    """All are started anew, each with keys of one authority."""
    start_s, authority = int(since_2004_s(time.time())) - 60, None
    for name in stand.names:
        await stand.nodes[name].stop()
        folder = stand.folder / f"keys-{name}"
        make_credentials(
            folder, count=3, start_s=start_s, duration_s=_WEEK_S, random=os.urandom, authority=authority
        )
        authority = authority or folder / "authority"
        stand.configure(name, f'[security]\nmode = "signed"\nfolder = "{folder}"\n')
        await stand.restart(name)
    yield {}


@asynccontextmanager
async def _forged(stand: Stand) -> AsyncGenerator[Seen]:
    """A hundred names a second: unsigned, signed under an authority of the forger, true frames altered."""
    near, start_s = stand.drives[WITH_BUS].at(time.time()), int(since_2004_s(time.time())) - 60
    crowd = InventedVehicles(_FORGED, near=near, from_utc_s=time.time(), rng=stand.rng)
    own = make_credentials(
        stand.folder / "forger", count=1, start_s=start_s, duration_s=_WEEK_S, random=os.urandom
    )
    envelope, plain = Signed(own.trusted, own.own, utc_at_zero_s=0.0), Unsecured()
    sent = 0

    def make(count: int, now_s: float) -> list[bytes]:
        nonlocal sent
        first, sent = sent, sent + count
        found: list[bytes] = []
        for number in range(first, sent):
            (frame,) = crowd.frames(range(number % _FORGED, number % _FORGED + 1), utc_s=now_s)
            message = plain.open(frame, received_s=now_s).octets
            signed = envelope.wrap(message or b"", sent_s=now_s)
            true = altered(stand.frames[-1][1], stand.rng)
            found.append((frame, signed or frame, true)[number % 3])
        return found

    async with stand.flood(WITH_BUS, float(_FORGED), make) as flood:
        seen: Seen = {}
        yield seen
    seen["frames"] = flood.sent


def _crowd(names: int, per_s: float) -> Callable[[Stand], AbstractAsyncContextManager[Seen]]:
    """So many vehicles that are not there, one after another, at so many frames a second."""

    @asynccontextmanager
    async def during(stand: Stand) -> AsyncGenerator[Seen]:
        near = stand.drives[WITH_BUS].at(time.time())
        crowd = InventedVehicles(names, near=near, from_utc_s=time.time(), rng=stand.rng)
        sent = 0

        def make(count: int, now_s: float) -> list[bytes]:
            nonlocal sent
            count = min(count, round(per_s / 10.0))
            rows = [range(sent % names, min(sent % names + count, names))]
            rows.append(range(count - len(rows[0])))
            sent += count
            return [one for part in rows if len(part) for one in crowd.frames(part, utc_s=now_s)]

        async with stand.flood(WITH_BUS, per_s, make) as flood:
            seen: Seen = {}
            yield seen
        seen["frames a second"] = flood.sent / max(time.time() - flood.begin_s, 1e-3)

    return during


def _losses(ratio: float, bounds: Bounds, lasts_s: float = 15.0) -> Fault:
    return Fault(f"{100 * ratio:g} % of the frames lost", _air(Impairment(ratio)), lasts_s, 8.0, bounds)


FAULTS: tuple[Fault, ...] = (
    Fault("nothing, for comparison", _nothing, 20.0, 2.0, Bounds(1.0, 1.0, 0.0, strangers=0)),
    _losses(0.3, Bounds(0.99, 1.5)),
    _losses(0.6, Bounds(0.95, 12.0)),
    _losses(0.9, Bounds(0.6, 30.0, 3.0)),
    Fault(
        "30 % lost in bursts of 1 s on average",
        _air(Impairment(0.3, burst_s=1.0)), 20.0, 8.0, Bounds(0.9, 10.0, 3.0),
    ),
    Fault("every frame three times", _air(Impairment(copies=3)), 10.0, 3.0, Bounds(1.0, 1.0, 0.5)),
    Fault(
        "half held up by up to 0.3 s, overtaken",
        _air(Impairment(late_ratio=0.5, late_s=0.3)), 12.0, 3.0, Bounds(0.99, 2.0, 2.0),
    ),
    Fault(
        "every frame once more after 5 s",
        _air(Impairment(again_s=5.0)), 12.0, 6.0, Bounds(1.0, 1.0, 0.5),
    ),
    Fault(
        "one octet altered in half of the frames",
        _air(Impairment(altered_ratio=0.5)), 15.0, 10.0, Bounds(0.8, 30.0, 8.0),
    ),
    Fault(
        "two and two parted for 5 s",
        _air(Impairment(parted=frozenset({0, 1}))), 5.0, 8.0, Bounds(0.3, 60.0, 3.0),
    ),
    Fault(
        "no fixes for 4 s, the bus goes on",
        _gnss("no fix"), 4.0, 6.0, Bounds(1.0, 2.0, 1.0), hosts=_OTHERS, remotes=(WITH_BUS,),
    ),
    Fault(
        "no fixes for 12 s",
        _gnss("no fix", silent_within_s=8.0), 12.0, 8.0,
        Bounds(0.5, 60.0, 3.0, seen={"silent after, s": 6.5}), hosts=_OTHERS, remotes=(WITH_BUS,),
    ),
    Fault(
        "the receiver hangs: one place, new times",
        _gnss("same fix"), 4.5, 8.0, Bounds(1.0, 6.0, 3.0), hosts=_OTHERS, remotes=(WITH_BUS,),
    ),
    Fault(
        "no bus for 8 s",
        _bus("nothing"), 8.0, 6.0, Bounds(1.0, 2.0, 1.0, seen={"by fixes alone after, s": 2.0}),
        hosts=_OTHERS, remotes=(WITH_BUS,),
    ),
    Fault(
        "the bus hangs: the same values on and on",
        _bus("same values"), 32.0, 6.0,
        Bounds(1.0, 20.0, 3.0, seen={"found frozen after, s": 32.0}), hosts=_OTHERS, remotes=(WITH_BUS,),
    ),
    Fault(
        "gpsd ended, and started after 1 s",
        _gpsd_restarted, 3.0, 6.0, Bounds(1.0, 2.0, 2.0, seen={"connected again after, s": 2.0}),
        hosts=_OTHERS, remotes=(WITH_BUS,),
    ),
    Fault(
        "gpsd's connection half open",
        _gpsd_half_open, 2.0, 6.0, Bounds(1.0, 3.0, 2.0, seen={"connected again after, s": 3.5}),
        hosts=_OTHERS, remotes=(WITH_BUS,),
    ),
    Fault(
        "every report of gpsd's in two pieces", _gpsd_splits, 6.0, 3.0, Bounds(1.0, 2.0, 1.0),
        hosts=_OTHERS, remotes=(WITH_BUS,),
    ),
    Fault(
        "a node stopped for 2 s (SIGSTOP)", _stalled, 2.0, 10.0, Bounds(1.0, 60.0, 6.0),
        hosts=NAMES, remotes=("crossing",),
    ),
    Fault("`kill -9` of a node, started again after 2 s", _killed, 2.0, 60.0, Bounds(0.4, 60.0, _STARTS_S)),
    Fault(
        "SIGTERM of a node, started again after 2 s", _terminated, 2.0, 60.0,
        Bounds(0.4, 60.0, _STARTS_S, seen=_ENDS),
    ),
    Fault(
        "SIGTERM of a node, started again at once with a clock that can be told", _clock_given, 1.0, 60.0,
        Bounds(0.4, 60.0, _STARTS_S, seen=_ENDS),
    ),
    Fault(
        "a clock 1 s ahead, then right again", _clock(1.0), 10.0, 10.0,
        Bounds(0.3, 60.0, 6.0, seen={"silent after, s": 7.0}), hosts=_OTHERS, remotes=(WITH_BUS,),
    ),
    Fault(
        "a clock 1 s behind, then right again", _clock(-1.0), 10.0, 10.0,
        Bounds(0.3, 60.0, 6.0, seen={"silent after, s": 8.5}), hosts=_OTHERS, remotes=(WITH_BUS,),
    ),
    Fault(
        "a full disk: a recording with room for 0.1 MB", _disk_full, 25.0, 5.0,
        Bounds(0.4, 60.0, _STARTS_S, seen={"recording goes on": 0.0, "recorded, MB": _ROOM_MB}),
    ),
    Fault(
        "random octets, 1,000 frames a second to one node",
        _random, 8.0, 3.0, Bounds(1.0, 2.0, 1.0, strangers=0), hosts=(WITH_BUS,),
    ),
    Fault(
        "ten times the nominal flood: 1,000 invented vehicles at 10 Hz each",
        _crowd(10 * NOMINAL_PER_S // 10, 10 * NOMINAL_PER_S), 10.0, 12.0, Bounds(0.9, 5.0, 6.0),
        hosts=(WITH_BUS,),
    ),
    Fault(
        "10,000 temporary ids in 5 s, and once more",
        _crowd(MANY_NAMES, MANY_NAMES / 5.0), 10.0, 10.0, Bounds(0.3, 5.0, 6.0), hosts=(WITH_BUS,),
    ),
    Fault(
        "all ended, and started again with keys, which they require", _keys, 5.0, _STARTS_S,
        Bounds(recovery_s=_STARTS_S),
    ),
    Fault(
        "100 forged senders a second where keys are required",
        _forged, 8.0, 3.0, Bounds(1.0, 2.0, 1.0, strangers=0), hosts=(WITH_BUS,),
    ),
)  # fmt: skip
"""In the order in which they are done."""

SHORT = (
    "60 % of the frames lost",
    "one octet altered in half of the frames",
    "two and two parted for 5 s",
    "gpsd ended, and started after 1 s",
    "`kill -9` of a node, started again after 2 s",
    "10,000 temporary ids in 5 s, and once more",
)
"""Names of those of the short form."""
