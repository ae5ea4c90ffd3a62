"""A node put together from its configuration, and run until it is told to stop."""

import asyncio
import secrets
from collections.abc import AsyncGenerator, Callable, Coroutine
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from importlib.metadata import entry_points
from typing import Any

import numpy as np

from modelcast.apps.registry import get_application
from modelcast.core.exceptions import ConfigError
from modelcast.core.geodesy import Origin
from modelcast.dashboard.document import snapshot_text
from modelcast.node.clock import AbstractClock, SteeredClock, SystemClock
from modelcast.node.config import Air, NodeConfig, Page, Roadside
from modelcast.node.envelope import Unsecured
from modelcast.node.inputs.base import AbstractSource
from modelcast.node.inputs.motion import Motion
from modelcast.node.inputs.motion_source import MotionSource
from modelcast.node.inputs.opening import bus_source, gnss_source
from modelcast.node.inputs.replay import TripReplay
from modelcast.node.journal import Journal
from modelcast.node.lossy import LossyTransport
from modelcast.node.metrics import Metric, serve_metrics
from modelcast.node.multicast import MulticastTransport
from modelcast.node.node import Node, NodeState
from modelcast.node.pseudonyms import Pseudonyms
from modelcast.node.relaying import Relaying
from modelcast.node.run import Lateness, run_node
from modelcast.node.showing import Showing, figures_of
from modelcast.node.subscribers import Subscribers
from modelcast.runtime.transport.base import AbstractTransport
from modelcast.station.relay import RelayRule
from modelcast.station.sender.sender import Sender
from modelcast.station.station import Station

__all__ = ["LiveNode", "open_transport"]

_FOLLOW_S = 5.0
_UNWATCHED_STEPS = 10
"""Where nobody looks at the page, the road is still drawn, at every so many steps."""

_STOPPING_S = 0.5


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
    own: AbstractTransport = _opened(air, clock)
    return own if air.loss_ratio == 0.0 else LossyTransport(own, air.loss_ratio, secrets.randbits(63))


def _opened(air: Air, clock: AbstractClock) -> AbstractTransport:
    """The transport itself."""
    if air.transport == "multicast":
        return MulticastTransport(
            clock.now_s, group=air.group, port=air.port, interface=air.interface, hops=air.hops
        )
    found = {one.name: one for one in entry_points(group="modelcast.transports")}
    if air.transport not in found:
        known = ", ".join(("multicast", *sorted(found)))
        raise ConfigError(f"[air] transport {air.transport!r} is not installed; there are {known}")
    transport: object = found[air.transport].load()(air, clock)
    if not isinstance(transport, AbstractTransport):
        raise ConfigError(f"[air] transport {air.transport!r} is no AbstractTransport")
    return transport


@dataclass(slots=True)
class _Inputs:
    """Sources, and what aligns them."""

    sources: tuple[AbstractSource, ...]
    motion: MotionSource
    journal: Journal

    def at(self, now_s: float) -> Motion | None:
        """The own motion at a step's instant; what changed is written down."""
        for source in self.sources:
            self.motion.feed(source.take(now_s))
        found = self.motion.at(now_s)
        for change in self.motion.events():
            what = {"what": change.what, "before": change.before, "after": change.after, "why": change.why}
            self.journal.note("inputs", what)
        return found


def _nowhere(journal: Journal) -> _Inputs:
    """Inputs of a unit that does not move: none."""
    return _Inputs((), MotionSource(None, stale_s=1.0, dead_reckoning_s=0.0), journal)


def _relaying(site: Roadside, tick_s: float) -> Relaying:
    """What a unit repeats."""
    rule = RelayRule(rate_hz=site.relay_rate_hz, within_m=site.relay_within_m, max_age_s=site.relay_age_s)
    return Relaying(rule, tick_s)


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
    ) -> None:
        self._config, self._sender, self._journal, self._show = config, sender, journal, show
        self._clock = SystemClock() if clock is None else clock
        self._gnss = gnss
        self.late = Lateness()
        """How late steps began."""
        self.state: NodeState | None = None
        """After the last step."""
        self.node: Node | None = None
        """None until it knows where it is."""
        self.origin: Origin | None = None
        """Of its plane; None until then."""

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
        async with AsyncExitStack() as stack:
            transport = open_transport(config.air, clock)
            stack.callback(transport.close)
            inputs = _nowhere(self._journal)
            if not config.roadside.on:
                inputs = await stack.enter_async_context(self._inputs())
            if isinstance(clock, SystemClock):
                await stack.enter_async_context(_running(_follow(clock)))
            if config.metrics.port:
                try:
                    server = await serve_metrics(
                        self._figures, host=config.metrics.host, port=config.metrics.port
                    )
                except OSError as error:
                    place = f"{config.metrics.host}:{config.metrics.port}"
                    raise ConfigError(f"[metrics] cannot listen on {place}: {error.strerror}") from error
                await stack.enter_async_context(server)
            what = "roadside" if config.roadside.on else config.sending.policy
            self._journal.note("start", {"name": config.vehicle.name, "policy": what})
            if await self._placed(inputs, stop):
                await self._go(inputs, transport, stop, stack)
            self._journal.note("stop", dict(self.node.counts) if self.node is not None else {})

    @asynccontextmanager
    async def _inputs(self) -> AsyncGenerator[_Inputs]:
        config, clock = self._config, self._clock
        sources = [
            gnss_source(
                config.gnss.source,
                now_s=clock.now_s,
                utc_at_zero_s=clock.minute_utc_s,
                times_as_fast=config.gnss.speed,
            )
            if self._gnss is None
            else self._gnss
        ]
        if config.can.interface:
            sources.append(
                bus_source(
                    interface=config.can.interface,
                    channel=config.can.channel,
                    dbc=config.can.dbc,
                    signals=config.can.signals,
                    now_s=clock.now_s,
                )
            )
        # A recorded trip is driven again on its own plane: its places are the recorded ones to the bit.
        origin = sources[0].origin if isinstance(sources[0], TripReplay) else None
        motion = MotionSource(
            origin, stale_s=config.gnss.stale_s, dead_reckoning_s=config.gnss.dead_reckoning_s
        )
        started: list[AbstractSource] = []
        try:
            for source in sources:
                await source.start()
                started.append(source)
            yield _Inputs(tuple(sources), motion, self._journal)
        finally:
            for source in started:
                await source.stop()

    async def _placed(self, inputs: _Inputs, stop: asyncio.Event) -> bool:
        """Wait for the first place, which the plane of the map begins at; False where it is told to stop."""
        if self._config.roadside.on:
            return True
        while not stop.is_set():
            if inputs.at(self._clock.now_s()) is not None:
                return True
            try:
                async with asyncio.timeout(self._config.sending.tick_s):
                    await stop.wait()
            except TimeoutError:
                continue
        return False

    async def _go(
        self, inputs: _Inputs, transport: AbstractTransport, stop: asyncio.Event, stack: AsyncExitStack
    ) -> None:
        config = self._config
        site = config.roadside
        origin = Origin(site.latitude_deg, site.longitude_deg) if site.on else inputs.motion.origin
        assert origin is not None  # noqa: S101 - a place was found
        self.origin = origin
        rng = np.random.default_rng(secrets.randbits(128))
        names = Pseudonyms(config.pseudonyms.least_s, config.pseudonyms.most_s, rng)
        station = Station(
            self._sender,
            temporary_id=names.temporary_id,
            dt_s=config.sending.tick_s,
            origin=origin,
            seed=secrets.randbits(63),
        )
        self.node = node = Node(
            station,
            transport,
            Unsecured(),
            applications={name: get_application(name) for name in config.applications.names},
            size_m=(config.vehicle.length_m, config.vehicle.width_m),
            pseudonyms=None if site.on else names,
            relaying=_relaying(site, config.sending.tick_s) if site.on and site.relay else None,
            watch=self._journal.note,
        )
        takers: list[Callable[[NodeState], None]] = [self._keep]
        if config.page.on:
            takers.append(await stack.enter_async_context(self._page(node, config.page)))
        if config.subscribe.path:
            takers.append(await stack.enter_async_context(_subscribers(node, config.subscribe.path)))

        def publish(state: NodeState) -> None:
            for take in takers:
                take(state)

        await run_node(
            node, self._clock, inputs.at, tick_s=config.sending.tick_s, stop=stop,
            fileno=transport.fileno(), publish=publish, lateness=self.late,
        )  # fmt: skip

    def _keep(self, state: NodeState) -> None:
        self.state = state

    def _figures(self) -> list[Metric]:
        return [] if self.node is None else list(figures_of(self.node, self.state, self.late))

    @asynccontextmanager
    async def _page(self, node: Node, page: Page) -> AsyncGenerator[Callable[[NodeState], None]]:
        """Serve the page; gives what takes states."""
        from modelcast.dashboard.feed import LiveFeed  # noqa: PLC0415 - the extra is needed here
        from modelcast.dashboard.gate import Gate, is_loopback  # noqa: PLC0415
        from modelcast.dashboard.server import listen, page_server  # noqa: PLC0415

        if not is_loopback(page.host) and not page.token:
            raise ConfigError(
                f"[page] host {page.host} is reached by other machines: give a token of 16 characters or more"
            )
        gate = Gate(page.token if not is_loopback(page.host) else "")
        feed, showing = LiveFeed(self._config.vehicle.name), Showing(node)

        def publish(state: NodeState) -> None:
            if feed.watched or self.late.count % _UNWATCHED_STEPS == 0:
                feed.publish(showing.snapshot(state))

        with listen(page.host, page.port, gate) as place:
            host, port = place.getsockname()[:2]
            if self._show is not None:
                self._show(f"http://{host}:{port}/" + (f"?token={gate.token}" if gate.token else ""))
            server = page_server(feed, gate)
            async with _running(server.serve(sockets=[place]), ends_s=_STOPPING_S):
                try:
                    yield publish
                finally:
                    server.should_exit = True


@asynccontextmanager
async def _subscribers(node: Node, path: str) -> AsyncGenerator[Callable[[NodeState], None]]:
    """Serve the map to other programs; gives what takes states."""
    subscribers, showing = Subscribers(), Showing(node)
    try:
        server = await subscribers.serve(path)
    except OSError as error:
        raise ConfigError(f"[subscribe] cannot listen at {path}: {error.strerror or error}") from error

    def publish(state: NodeState) -> None:
        if subscribers.watched:
            subscribers.publish(snapshot_text(showing.snapshot(state)))

    async with server:
        yield publish


async def _follow(clock: SystemClock) -> None:
    """Steer the clock by the machine's, for ever."""
    while True:
        await asyncio.sleep(_FOLLOW_S)
        clock.follow_system()


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
