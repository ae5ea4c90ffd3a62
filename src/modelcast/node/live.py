"""A node put together from its configuration, and run until it is told to stop."""

import asyncio
import secrets
from collections.abc import AsyncGenerator, Callable, Coroutine
from contextlib import AsyncExitStack, ExitStack, asynccontextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from modelcast.core.exceptions import ConfigError
from modelcast.core.geodesy import Origin
from modelcast.core.open_group import OpenGroup
from modelcast.dashboard.document import snapshot_text
from modelcast.dashboard.snapshot import NOBODY, Snapshot
from modelcast.node.building import credentials_of, envelope_of, node_of
from modelcast.node.clock import AbstractClock, SteeredClock, SystemClock
from modelcast.node.config import Air, NodeConfig, Page
from modelcast.node.envelope import AbstractEnvelope
from modelcast.node.inputs.base import AbstractSource
from modelcast.node.inputs.motion import Motion
from modelcast.node.inputs.motion_source import MotionSource
from modelcast.node.inputs.opening import bus_source, gnss_source
from modelcast.node.inputs.replay import TripReplay
from modelcast.node.journal import Journal
from modelcast.node.lossy import LossyTransport
from modelcast.node.measuring import Measuring
from modelcast.node.metrics import Metric, serve_metrics
from modelcast.node.node import Node, NodeState
from modelcast.node.plane import HeldTransport, Plane, place_in
from modelcast.node.run import Lateness, run_node
from modelcast.node.showing import Showing, Truth, figures_of, figures_of_recorder
from modelcast.node.subscribers import Subscribers
from modelcast.runtime.transport.base import AbstractTransport
from modelcast.station.sender.sender import Sender

if TYPE_CHECKING:
    from modelcast.node.credentials import Credentials
    from modelcast.node.recording.recorder import Recorder

__all__ = ["TRANSPORTS", "LiveNode", "open_transport"]

TRANSPORTS = OpenGroup(
    "modelcast.transports",
    AbstractTransport,
    called="[air] transport",
    own={"multicast": "modelcast.node.multicast:open_multicast"},
)
"""Ways to the air: each is called with the node's table ``[air]`` and its clock."""

_FOLLOW_S = 5.0
_PATIENCE_S = 5.0
"""How long a node waits for its first fix before it says so."""
_UNWATCHED_STEPS = 10
"""Where nobody looks at the page, the road is still drawn, at every so many steps."""

_STOPPING_S = 0.5

_Taker = Callable[[Callable[[], Snapshot]], None]
"""Takes what makes a snapshot, and calls it if somebody looks."""


def open_transport(air: Air, clock: AbstractClock) -> AbstractTransport:
    """The transport that a configuration names.

    Parameters
    ----------
    air
        Its table.
    clock
        The node's.

    Raises
    ------
    ConfigError
        Where it cannot be opened, or nothing of that name is installed.
    """
    own = TRANSPORTS.made(air.transport, air, clock)
    return own if air.loss_ratio == 0.0 else LossyTransport(own, air.loss_ratio, secrets.randbits(63))


class LiveNode:
    """A node on a real clock.

    Parameters
    ----------
    config
        What it is asked to be.
    sender
        What it sends, and when.
    journal
        Takes what happens.
    clock
        None for the machine's.
    gnss
        Where places come from, instead of the configuration's source.
    show
        Takes the address of the page, once.
    truth_m
        As in `modelcast.node.showing.Showing`.
    """

    def __init__(
        self,
        config: NodeConfig,
        sender: Sender,
        journal: Journal,
        *,
        clock: SteeredClock | None = None,
        gnss: AbstractSource | None = None,
        show: Callable[[str], None] | None = None,
        truth_m: Truth | None = None,
    ) -> None:
        self._config, self._sender, self._journal, self._show = config, sender, journal, show
        self._clock = SystemClock() if clock is None else clock
        self._gnss, self._truth_m = gnss, truth_m
        self._takers: list[_Taker] = []
        self._roads: list[Callable[[], None]] = []
        self.late = Lateness()
        """How late steps began."""
        self.state: NodeState | None = None
        """After the last step."""
        self.node: Node | None = None
        """None until its plane begins (`modelcast.node.plane`); another one where it begins anew."""
        self.origin: Origin | None = None
        """Of its plane; None until then."""
        self._recorded: Recorder | None = None
        self._credentials: Credentials | None = None

    async def run(self, stop: asyncio.Event) -> None:
        """Run until told to stop; everything that was opened is closed then.

        Parameters
        ----------
        stop
            Set from outside.

        Raises
        ------
        ConfigError, DataFormatError, MissingExtraError
            Where something cannot be opened as the configuration says.
        """
        config, clock = self._config, self._clock
        self._credentials = credentials_of(config.security)
        async with AsyncExitStack() as stack:
            transport = HeldTransport(open_transport(config.air, clock))
            stack.callback(transport.close)
            inputs = Measuring({}, MotionSource(None), self._journal)
            if not config.roadside.on:
                inputs = await stack.enter_async_context(self._inputs())
            if isinstance(clock, SystemClock):
                await stack.enter_async_context(_running(_follow(clock)))
            if config.metrics.port:
                try:
                    server = await serve_metrics(
                        lambda: self._figures(inputs), host=config.metrics.host, port=config.metrics.port
                    )
                except OSError as error:
                    place = f"{config.metrics.host}:{config.metrics.port}"
                    raise ConfigError(f"[metrics] cannot listen on {place}: {error.strerror}") from error
                await stack.enter_async_context(server)
            what = "roadside" if config.roadside.on else config.sending.policy
            about = {"name": config.vehicle.name, "kind": config.station.kind, "policy": what}
            if not config.roadside.on:
                about["gnss"] = config.gnss.source
            self._journal.note("start", about)
            if config.page.on:
                self._takers.append(await stack.enter_async_context(self._page(config.page)))
            if config.subscribe.path:
                self._takers.append(await stack.enter_async_context(_subscribers(config.subscribe.path)))
            while not stop.is_set() and (plane := await self._placed(inputs, transport, stop)) is not None:
                await self._go(inputs, transport, stop, plane)
            self._journal.note("stop", dict(self.node.counts) if self.node is not None else {})

    @asynccontextmanager
    async def _inputs(self) -> AsyncGenerator[Measuring]:
        config, clock = self._config, self._clock
        sources = {
            "gnss": gnss_source(
                config.gnss.source,
                now_s=clock.now_s,
                utc_at_zero_s=clock.minute_utc_s,
                times_as_fast=config.gnss.speed,
            )
            if self._gnss is None
            else self._gnss
        }
        if config.can.interface:
            sources["can"] = bus_source(
                interface=config.can.interface,
                channel=config.can.channel,
                dbc=config.can.dbc,
                signals=config.can.signals,
                now_s=clock.now_s,
            )
        # A recorded trip is driven again on its own plane: its places are the recorded ones to the bit.
        fixes = sources["gnss"]
        origin = fixes.origin if isinstance(fixes, TripReplay) else None
        motion = MotionSource(
            origin, stale_s=config.gnss.stale_s, dead_reckoning_s=config.gnss.dead_reckoning_s
        )
        started: list[AbstractSource] = []
        try:
            for source in sources.values():
                await source.start()
                started.append(source)
            yield Measuring(sources, motion, self._journal)
        finally:
            for source in started:
                await source.stop()

    async def _placed(self, inputs: Measuring, transport: HeldTransport, stop: asyncio.Event) -> Plane | None:
        """Wait for a place that the plane of the map begins at; None where it is told to stop."""
        begun_s, told = self._clock.now_s(), False
        while not stop.is_set():
            now_s = self._clock.now_s()
            if not told and now_s - begun_s >= _PATIENCE_S:
                why = "no fix yet, and nobody heard: nothing is sent before"
                self._journal.note("waiting", {"gnss": self._config.gnss.source, "why": why})
                told = True
            site = self._config.roadside
            plane = (
                Plane(Origin(site.latitude_deg, site.longitude_deg), "configured")
                if site.on
                else self._plane(inputs, transport, now_s)
            )
            if plane is not None:
                where = {
                    "latitude_deg": plane.origin.latitude_deg,
                    "longitude_deg": plane.origin.longitude_deg,
                }
                self._journal.note("plane", {**where, "found": plane.found})
                return plane
            self._show_all(lambda at_s=now_s: Snapshot(at_s, None, remotes=NOBODY))
            try:
                async with asyncio.timeout(self._config.sending.tick_s):
                    await stop.wait()
            except TimeoutError:
                continue
        return None

    def _plane(self, inputs: Measuring, transport: HeldTransport, now_s: float) -> Plane | None:
        """Where the plane begins, if any place is known."""
        gnss, motion = self._config.gnss, inputs.motion
        if motion.origin is not None and self.node is None:
            return Plane(motion.origin, "trip")
        placed = inputs.at(now_s) is not None
        if placed and motion.origin is not None:
            return Plane(motion.origin, "own")
        if self.node is None and gnss.latitude_deg is not None and gnss.longitude_deg is not None:
            return Plane(Origin(gnss.latitude_deg, gnss.longitude_deg), "configured")
        if self._config.security.mode == "signed" and self._config.security.required:
            return None  # a place that nobody vouches for is nothing to begin at
        for arrival in transport.peek(now_s):
            if (place := place_in(arrival.octets)) is not None:
                return Plane(place, "heard")
        return None

    async def _go(
        self, inputs: Measuring, transport: AbstractTransport, stop: asyncio.Event, plane: Plane
    ) -> None:
        """Run on a plane until told to stop, or until the own first place is far from where it begins."""
        self.origin = inputs.motion.origin = plane.origin
        with ExitStack() as stack:
            node = self._made(plane, transport, stack)
            inputs.record = self._recorded
            if self.node is not None:
                node.counts.update(self.node.counts)
                for forget in self._roads:
                    forget()
            self.node = node
            await self._drive(node, inputs, transport, stop, plane)
            inputs.record = None

    def _made(self, plane: Plane, transport: AbstractTransport, stack: ExitStack) -> Node:
        """The node for a plane, and what writes down what it does."""
        seeds = secrets.randbits(128), secrets.randbits(63)
        self._recorded = self._recorder(plane.origin, *seeds)
        if self._recorded is not None:
            stack.enter_context(self._recorded)
        return node_of(
            self._config, self._sender, transport, self._envelope(seeds[0]), origin=plane.origin,
            names_seed=seeds[0], station_seed=seeds[1], watch=self._journal.note, record=self._recorded,
        )  # fmt: skip

    def _envelope(self, names_seed: int) -> AbstractEnvelope:
        return envelope_of(
            self._credentials,
            self._config.security,
            utc_at_zero_s=self._clock.minute_utc_s,
            names_seed=names_seed,
            kind=self._config.station.speaks,
        )

    async def _drive(
        self,
        node: Node,
        inputs: Measuring,
        transport: AbstractTransport,
        stop: asyncio.Event,
        plane: Plane,
    ) -> None:
        showing = Showing(node, self._truth_m)
        written = None if self._recorded is None else _written(self._recorded, self._journal)
        ended, settled = asyncio.Event(), False

        def measure(now_s: float) -> Motion | None:
            nonlocal settled
            motion = inputs.at(now_s)
            if motion is not None and not settled:
                settled = True
                if plane.is_far(motion.position_m):
                    inputs.motion.origin = None
                    ended.set()
                    return None
            return motion

        def publish(state: NodeState) -> None:
            self.state = state
            snapshot = cache(lambda: showing.snapshot(state))
            self._show_all(snapshot)
            if written is not None:
                written(snapshot)

        async with _running(_passed_on(stop, ended)):
            await run_node(
                node, self._clock, measure, tick_s=self._config.sending.tick_s, stop=ended,
                fileno=transport.fileno(), publish=publish, lateness=self.late,
            )  # fmt: skip

    def _show_all(self, make: Callable[[], Snapshot]) -> None:
        for take in self._takers:
            take(make)

    def _figures(self, inputs: Measuring) -> list[Metric]:
        recorded = [] if self._recorded is None else list(figures_of_recorder(self._recorded))
        return [*figures_of(self.node, self.state, self.late), *inputs.figures(), *recorded]

    def _recorder(self, origin: Origin, names_seed: int, station_seed: int) -> "Recorder | None":
        """What the configuration says is written down."""
        own, clock = self._config.record, self._clock
        if not own.folder:
            return None
        from modelcast.node.recording.making import about_node  # noqa: PLC0415 - the extra is needed here
        from modelcast.node.recording.recorder import Recorder  # noqa: PLC0415

        about = about_node(
            self._config,
            self._sender,
            utc_at_zero_s=clock.minute_utc_s,
            origin=origin,
            names_seed=names_seed,
            station_seed=station_seed,
            credentials=self._credentials,
        )
        try:
            self._recorded = Recorder(
                Path(own.folder), about, begin_s=clock.now_s(), most_octets=1e6 * own.most_mb
            )
        except OSError as error:
            raise ConfigError(f"[record] cannot write in {own.folder}: {error.strerror or error}") from error
        self._journal.note("recording", {"file": str(self._recorded.path)})
        return self._recorded

    @asynccontextmanager
    async def _page(self, page: Page) -> AsyncGenerator[_Taker]:
        """Serve the page; gives what takes snapshots."""
        from modelcast.dashboard.feed import LiveFeed  # noqa: PLC0415 - the extra is needed here
        from modelcast.dashboard.gate import Gate, is_loopback  # noqa: PLC0415
        from modelcast.dashboard.server import listen, page_server  # noqa: PLC0415

        if not is_loopback(page.host) and not page.token:
            raise ConfigError(
                f"[page] host {page.host} is reached by other machines: give a token of 16 characters or more"
            )
        gate = Gate(page.token if not is_loopback(page.host) else "")
        feed = LiveFeed(self._config.vehicle.name)
        self._roads.append(feed.forget_road)

        def publish(make: Callable[[], Snapshot]) -> None:
            if feed.watched or self.late.count % _UNWATCHED_STEPS == 0:
                feed.publish(make())

        with listen(page.host, page.port, gate) as place:
            host, port = place.getsockname()[:2]
            if self._show is not None:
                self._show(f"http://{host}:{port}/" + (f"?token={gate.token}" if gate.token else ""))
            server = page_server(feed, gate, heeds_signals=False)
            async with _running(server.serve(sockets=[place]), ends_s=_STOPPING_S):
                try:
                    yield publish
                finally:
                    server.should_exit = True


def _written(recorder: "Recorder", journal: Journal) -> _Taker:
    """What writes the page's snapshots into a recording, and says when it ended."""
    told = False

    def take(make: Callable[[], Snapshot]) -> None:
        nonlocal told
        if recorder.wants_page:
            recorder.shown(make())
        if recorder.ended and not told:
            told = True
            journal.note("recording ended", {"why": recorder.ended, "octets": recorder.octets})

    return take


@asynccontextmanager
async def _subscribers(path: str) -> AsyncGenerator[_Taker]:
    """Serve the map to other programs; gives what takes snapshots."""
    subscribers = Subscribers()
    try:
        server = await subscribers.serve(path)
    except OSError as error:
        raise ConfigError(f"[subscribe] cannot listen at {path}: {error.strerror or error}") from error

    def publish(make: Callable[[], Snapshot]) -> None:
        if subscribers.watched:
            subscribers.publish(snapshot_text(make()))

    async with server:
        try:
            yield publish
        finally:
            server.close()
            await subscribers.close()


async def _follow(clock: SystemClock) -> None:
    """Steer the clock by the machine's, for ever."""
    while True:
        await asyncio.sleep(_FOLLOW_S)
        clock.follow_system()


async def _passed_on(stop: asyncio.Event, ended: asyncio.Event) -> None:
    """Let one event set another."""
    await stop.wait()
    ended.set()


@asynccontextmanager
async def _running(work: Coroutine[Any, Any, None], *, ends_s: float = 0.0) -> AsyncGenerator[None]:
    """Something that runs beside; at the end of the context it has a while to end by itself."""
    task = asyncio.create_task(work)
    try:
        yield
    finally:
        if ends_s:
            await asyncio.wait({task}, timeout=ends_s)
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
