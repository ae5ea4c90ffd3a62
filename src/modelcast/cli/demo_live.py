"""``modelcast demo-live``: four nodes on this machine, and the page of one of them."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Mapping

    from modelcast.node.live import LiveNode

__all__ = ["demo_live"]

_TOLD_S = 2.0


def demo_live(
    *,
    duration: float = 60.0,
    loss: float = 0.3,
    policy: str = "mbc",
    headless: bool = False,
    port: int = 8700,
    udp_port: int = 16091,
) -> int:
    """Run four nodes on the loopback interface: a platoon of three whose leader brakes, and one that crosses.

    For example: `modelcast demo-live --duration 60`

    Everything is real but the drives: sockets, octets, clocks, maps. The page shows what the last of the
    platoon believes. A line every two seconds says the same, and how far it is from where the others are.

    Parameters
    ----------
    duration
        How long [s].
    loss
        Share of the frames that every node loses, 0 to 1.
    policy
        What all send, as for network.
    headless
        Serve no page.
    port
        Port of the page; 0 for any that is free.
    udp_port
        Port of the frames.
    """
    import asyncio
    import io

    from modelcast.cli.named_words import check_word
    from modelcast.cli.node import sender_of_config
    from modelcast.cli.prepare import rehearsed
    from modelcast.cli.progress import watching
    from modelcast.cli.terminal import say
    from modelcast.core.exceptions import ConfigError
    from modelcast.node.clock import SystemClock
    from modelcast.node.config import Air, NodeConfig, Page, Sending, Vehicle
    from modelcast.node.demo import DEMO_S, demo_trips, place_at
    from modelcast.node.inputs.replay import TripReplay
    from modelcast.node.journal import Journal
    from modelcast.node.live import LiveNode
    from modelcast.station.sender.names import check_sender

    if not 0.0 < duration <= DEMO_S:
        raise ConfigError(f"--duration must be above 0 and up to {DEMO_S:g}, got {duration}")
    if not 0.0 <= loss <= 1.0:
        raise ConfigError(f"--loss must be from 0 to 1, got {loss}")
    check_word("--policy", check_sender, policy)
    if not (0 <= port < 2**16 and 0 < udp_port < 2**16):
        raise ConfigError(f"--port and --udp-port must be from 0 to 65535, got {port} and {udp_port}")
    sender = sender_of_config(NodeConfig(sending=Sending(policy=policy)))
    with watching("getting ready") as announce:
        rehearsed(NodeConfig(), sender, announce=announce)
    clock = SystemClock()
    begin_s = clock.now_s() + 1.0
    nodes: dict[str, LiveNode] = {}
    trips = demo_trips()

    def truth_m(t_s: float) -> dict[int, tuple[float, float]]:
        """Where the drives are: all have one plane."""
        return {
            node.state.temporary_id: place_at(trips[name], t_s - begin_s)
            for name, node in nodes.items()
            if node.state is not None
        }

    for name, trip in trips.items():
        config = NodeConfig(
            vehicle=Vehicle(name=name),
            sending=Sending(policy=policy),
            air=Air(port=udp_port, loss_ratio=loss),
            page=Page(on=name == "third" and not headless, port=port),
        )
        nodes[name] = LiveNode(
            config,
            sender,
            Journal(io.StringIO(), lambda: 0.0),
            clock=clock,
            gnss=TripReplay(trip, begin_s=begin_s),
            show=say,
            truth_m=truth_m,
        )
    asyncio.run(_run_all(nodes, duration))
    return 0


async def _run_all(nodes: "Mapping[str, LiveNode]", duration_s: float) -> None:
    """Run all nodes until the time is over or a signal comes, and tell what the third believes."""
    import asyncio

    from modelcast.cli.stopping import stopped_by_signals

    with stopped_by_signals(duration_s) as stop:
        telling = asyncio.create_task(_tell(nodes, stop))
        try:
            await asyncio.gather(*(node.run(stop) for node in nodes.values()))
        finally:
            stop.set()
            await telling


async def _tell(nodes: "Mapping[str, LiveNode]", stop: "asyncio.Event") -> None:
    import asyncio

    from modelcast.cli.terminal import say

    while not stop.is_set():
        try:
            async with asyncio.timeout(_TOLD_S):
                await stop.wait()
        except TimeoutError:
            say(_line(nodes))
    say(_line(nodes))


def _line(nodes: "Mapping[str, LiveNode]") -> str:
    """What the third believes now, and how wrong it is."""
    import numpy as np

    from modelcast.core.geodesy import geodetic_to_local

    host = nodes["third"]
    state = host.state
    if state is None or state.motion is None or host.node is None or host.origin is None:
        return "third: knows no place yet"
    names = {one.node.station.temporary_id: name for name, one in nodes.items() if one.node is not None}
    parts: list[str] = []
    for vehicle, place_m in zip(state.around.vehicle.tolist(), state.around.position_m, strict=True):
        name = names.get(vehicle, "a name of before")
        other = nodes[name].state if name in nodes else None
        if other is None or other.motion is None or abs(other.t_s - state.t_s) > 1e-6:
            parts.append(name)
            continue
        true_m = geodetic_to_local(np.array([other.motion.place_deg]), host.origin)[0]
        parts.append(f"{name} {np.hypot(*(place_m - true_m)):.2f} m off")
    warnings = [
        f"{one.application} {one.level.name.lower()} of {names.get(one.vehicle, 'somebody')}"
        for one in state.warnings
    ]
    counters = host.node.meter.counters(state.t_s)
    rates = f"{counters.sent_per_s:.1f} out, {counters.received_per_s:.1f} in a second"
    return "; ".join(["third: " + (", ".join(parts) or "nobody"), rates, *warnings])
