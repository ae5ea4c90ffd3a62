"""The stand of a soak: nodes as processes, what they measure by, the air between them, and the truth.

Every node has a gpsd and a multicast group of its own: a relay carries frames between groups. One node has a
bus: python-can's ``udp_multicast`` hears all groups that anybody on the machine has joined, so there is one.
Everything is on the loopback interface; the bus's datagrams have a hop limit of 0.
"""

import asyncio
import socket
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

import can
import numpy as np

from modelcast.core.geodesy import Origin, geodetic_to_local, local_to_geodetic
from modelcast.node.demo import demo_trips
from modelcast.node.trials.bus_player import BUS_DBC, BUS_SIGNALS, BusPlayer
from modelcast.node.trials.drive import Drive
from modelcast.node.trials.gpsd_player import GpsdPlayer
from modelcast.node.trials.pacing import at_every
from modelcast.node.trials.relay import Relay
from soak_processes import NodeProcess, NodeView
from soak_record import Maps

__all__ = ["NAMES", "WITH_BUS", "Stand", "free_port"]

NAMES = ("leader", "second", "third", "crossing")
"""Vehicles of the stand; of `modelcast.node.demo`."""

WITH_BUS = "third"
"""The vehicle that has a bus."""

_ORIGIN_VIEWS = 10
_SETTLED_S = 1.0
"""Where a node says that it is counts from when it has had fixes and bus for so long."""
_MEMORY_S = 1.0
_FLOOD_S = 0.01
_MINUTE_S = 60.0


@dataclass(slots=True)
class _Known:
    """What is known of one node's life from outside."""

    ids: list[int] = field(default_factory=list)
    places: list[tuple[float, float]] = field(default_factory=list)
    origin: Origin | None = None
    inputs: str = ""
    inputs_since_s: float = 0.0


class Stand:
    """Nodes and everything around them.

    Parameters
    ----------
    folder
        For configurations and sockets; new.
    lasts_s
        How long vehicles drive [s].
    rng
        Draws groups, losses, names.
    names
        Vehicles, of `NAMES`.
    relayed
        Whether each has a group of its own, and a relay between them; else they share one.
    """

    def __init__(
        self,
        folder: Path,
        *,
        lasts_s: float,
        rng: np.random.Generator,
        names: Sequence[str] = NAMES,
        relayed: bool = True,
    ) -> None:
        self.names, self.rng, self.folder = tuple(names), rng, folder
        self.maps = Maps()
        self.memory: dict[str, list[tuple[float, float, float]]] = {name: [] for name in names}
        """Of each node: when [UTC, s], resident now and at most [MB]."""
        self.frames: list[tuple[float, bytes]] = []
        """When the newest frames were sent [UTC, s], and their octets; at most 100."""
        begin_utc_s = np.floor(time.time()) + 2.05
        trips = demo_trips(lasts_s)
        self.drives: Mapping[str, Drive] = {
            name: Drive(trips[name], begin_utc_s=float(begin_utc_s)) for name in names
        }
        self.gpsd = {name: GpsdPlayer(self.drives[name], time.time) for name in names}
        self.bus: BusPlayer | None = None
        self.nodes: dict[str, NodeProcess] = {}
        net = f"239.255.{int(rng.integers(32, 255))}"
        self._bus_group = f"{net}.100"
        self._groups = [f"{net}.{1 + at * relayed}" for at in range(len(names))]
        self._port = free_port(socket.SOCK_DGRAM)
        self.relay = Relay(self._groups if relayed else (), self._port, clock=time.time, rng=rng)
        self._known = {name: _Known() for name in names}
        self._all_ids: dict[int, str] = {}
        self._tasks: list[asyncio.Task[None]] = []

    async def start(self) -> None:
        """Start everything."""
        self.folder.mkdir(parents=True, exist_ok=True)
        (self.folder / "bus.dbc").write_text(BUS_DBC, encoding="ascii")
        self.relay.watch = self._keep_frame
        self.relay.start()
        for at, name in enumerate(self.names):
            await self.gpsd[name].start()
            self.nodes[name] = self._node(at, name)
        if WITH_BUS in self.names:
            bus = can.Bus(interface="udp_multicast", channel=self._bus_group, hop_limit=0)
            self.bus = BusPlayer(bus, self.drives[WITH_BUS], time.time)
            self.bus.start()
        for name in self.names:
            await self.nodes[name].start()
        self._tasks.append(asyncio.create_task(at_every(_MEMORY_S, time.time, self._weigh)))

    async def stop(self) -> list[float]:
        """End everything; returns how long each node took [s]."""
        took_s = [await node.stop() for node in self.nodes.values()]
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self.relay.stop()
        for name in self.names:
            await self.gpsd[name].stop()
        if self.bus is not None:
            await self.bus.stop()
        return took_s

    def pairs(self, hosts: Sequence[str] = (), remotes: Sequence[str] = ()) -> frozenset[tuple[int, int]]:
        """Hosts and remotes as `Maps` counts them; all where none are named."""
        return frozenset(
            (self.names.index(host), self.names.index(remote))
            for host in hosts or self.names
            for remote in remotes or self.names
            if host != remote
        )

    def configure(self, name: str, tables: str) -> None:
        """Add tables to a node's configuration, for its next start.

        Parameters
        ----------
        name
            The node's.
        tables
            TOML.
        """
        path = self.folder / f"{name}.toml"
        path.write_text(path.read_text(encoding="utf-8") + tables, encoding="utf-8")

    async def restart(self, name: str, *, told_clock: bool = False) -> None:
        """Start a node that has ended."""
        self._known[name] = _Known()
        await self.nodes[name].start(told_clock=told_clock)

    def origin(self, name: str) -> Origin | None:
        """Where a node's plane begins, as its map shows; None before that is known."""
        return self._known[name].origin

    def inputs(self, name: str) -> tuple[str, float]:
        """What a node's motion is made of, as its map says, and since when [s]; ``silent`` for nothing."""
        known = self._known[name]
        return known.inputs, known.inputs_since_s

    async def until(self, true: Callable[[], bool], *, at_most_s: float, each_s: float = 0.02) -> float:
        """Wait until something is true; returns how long that took, infinite where it did not come [s]."""
        begin_s = time.monotonic()
        while not true():
            if time.monotonic() - begin_s > at_most_s:
                return np.inf
            await asyncio.sleep(each_s)
        return time.monotonic() - begin_s

    async def counts(self) -> Counter[str]:
        """Refusals by reason and steps left out, of all nodes."""
        found: Counter[str] = Counter()
        for node in self.nodes.values():
            found += await node.counts()
        return found

    @property
    def crashes(self) -> int:
        """Nodes that ended without being asked to, and errors that were not met."""
        return sum(node.crashes + bool(node.noise) for node in self.nodes.values())

    def flood(
        self, victim: str, frames_per_s: float, make: Callable[[int, float], Sequence[bytes]]
    ) -> "Flood":
        """Frames by the thousand to one node.

        Parameters
        ----------
        victim
            Whom.
        frames_per_s
            How many.
        make
            Gives so many frames for a time [s].
        """
        return Flood(self.relay, self.names.index(victim), frames_per_s, make)

    def _node(self, at: int, name: str) -> NodeProcess:
        socket_path, metrics_port = self.folder / f"{name}.sock", free_port(socket.SOCK_STREAM)
        path = self.folder / f"{name}.toml"
        bus = (
            f'[can]\ninterface = "udp_multicast"\nchannel = "{self._bus_group}"\n'
            f'dbc = "{self.folder / "bus.dbc"}"\nsignals = "{BUS_SIGNALS}"\n'
        )
        path.write_text(
            f'[vehicle]\nname = "{name}"\n'
            f'[gnss]\nsource = "gpsd://127.0.0.1:{self.gpsd[name].port}"\n'
            f"{bus if name == WITH_BUS else ''}"
            f'[air]\ngroup = "{self._groups[at]}"\nport = {self._port}\n'
            f"[pseudonyms]\nleast_s = 0.0\nmost_s = 0.0\n"
            f"[metrics]\nport = {metrics_port}\n"
            f'[subscribe]\npath = "{socket_path}"\n',
            encoding="utf-8",
        )
        return NodeProcess(
            name, path, socket_path=socket_path, metrics_port=metrics_port, take=self._take_view
        )

    def _weigh(self, now_s: float) -> None:
        for name, node in self.nodes.items():
            memory = node.memory()
            if memory is not None:
                self.memory[name].append((now_s, memory.now_mb, memory.peak_mb))

    def _keep_frame(self, _station: int, octets: bytes) -> None:
        self.frames = [*self.frames[-99:], (time.time(), octets)]

    def _take_view(self, name: str, view: NodeView) -> None:
        document, known = view.document, self._known[name]
        own, t_s = document["host"], float(document["t_s"])
        utc_s = t_s + _MINUTE_S * round((view.arrived_utc_s - t_s) / _MINUTE_S)
        inputs = "silent" if own is None else str(own["inputs"])
        if inputs != known.inputs:
            known.inputs, known.inputs_since_s = inputs, view.arrived_utc_s
        if own is not None:
            if own["id"] not in known.ids:
                known.ids.append(own["id"])
                self._all_ids[own["id"]] = name
            settled = inputs.startswith("gnss") and view.arrived_utc_s - known.inputs_since_s > _SETTLED_S
            if known.origin is None and settled:
                self._find_origin(name, utc_s, np.array([own["east_cm"], own["north_cm"]]) / 100.0)
        if known.origin is None:
            return
        remotes = document["remotes"]
        ids = remotes["id"]
        errors_m: dict[int, float] = {}
        for at, other in enumerate(self.names):
            now_called = self._known[other].ids
            if other == name or not now_called:
                continue
            if now_called[-1] not in ids:
                errors_m[at] = np.nan
                continue
            row, there = ids.index(now_called[-1]), self.drives[other].at(utc_s)
            true_m = geodetic_to_local(np.array([[there.latitude_deg, there.longitude_deg]]), known.origin)[0]
            believed_m = np.array([remotes["east_cm"][row], remotes["north_cm"][row]]) / 100.0
            errors_m[at] = float(np.hypot(*(believed_m - true_m)))
        strangers = sum(one not in self._all_ids for one in ids)
        self.maps.add(view.arrived_utc_s, self.names.index(name), errors_m, strangers=strangers)

    def _find_origin(self, name: str, utc_s: float, own_m: np.ndarray) -> None:
        """The plane of a node begins at its first fix; it follows from where it says that it is."""
        here, known = self.drives[name].at(utc_s), self._known[name]
        at_car = Origin(here.latitude_deg, here.longitude_deg, 0.0)
        latitude, longitude = local_to_geodetic(-own_m[None], at_car)[0].tolist()
        known.places.append((latitude, longitude))
        if len(known.places) == _ORIGIN_VIEWS:
            latitude, longitude = np.median(np.array(known.places), axis=0).tolist()
            known.origin = Origin(latitude, longitude, 0.0)


class Flood:
    """Frames by the thousand to one node, while the context is open."""

    def __init__(
        self, relay: Relay, station: int, frames_per_s: float, make: Callable[[int, float], Sequence[bytes]]
    ) -> None:
        self._relay, self._station, self._per_s, self._make = relay, station, frames_per_s, make
        self.sent = 0
        """Frames so far."""
        self.begin_s = 0.0
        """When it began, UTC [s]."""
        self._task: asyncio.Task[None] | None = None

    async def __aenter__(self) -> Self:
        self.begin_s = time.time()
        self._task = asyncio.create_task(at_every(_FLOOD_S, time.time, self._give))
        return self

    async def __aexit__(self, *_: object) -> None:
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)

    def _give(self, _due_s: float) -> None:
        now_s = time.time()
        for one in self._make(round((now_s - self.begin_s) * self._per_s) - self.sent, now_s):
            self._relay.give(self._station, one)
            self.sent += 1


def free_port(kind: int) -> int:
    """A port that nobody has now, of `socket.SOCK_STREAM` or `socket.SOCK_DGRAM`."""
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
