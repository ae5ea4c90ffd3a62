"""``modelcast replay``: a recording of a node, gone through again."""

from pathlib import Path

__all__ = ["replay"]


def replay(
    log: Path,
    *,
    on_air: bool = False,
    times: float = 1.0,
    group: str = "239.255.16.9",
    udp_port: int = 16090,
    interface: str = "127.0.0.1",
) -> int:
    """Make a recorded node again, take it through what it met, and compare its map bit for bit.

    For example: `modelcast replay log.mcap`

    Ends with 0 where every step gives what was recorded, with 1 where one does not: the first difference
    is printed.

    Parameters
    ----------
    log
        An MCAP that modelcast node recorded.
    on_air
        Send the recorded frames again as UDP multicast, at their times, so that another node hears them.
    times
        How many times as fast they are sent.
    group, udp_port, interface
        Where they are sent.
    """
    from modelcast.cli.node import sender_of_config
    from modelcast.cli.terminal import say
    from modelcast.node.recording.replay import replay_recording

    if on_air:
        return _emit(log, times, (group, udp_port, interface))
    found = replay_recording(log, sender_of_config)
    for topic, count in sorted(found.skipped.items()):
        say(f"{log}: {count} messages of {topic} are none of a recording")
    if found.cut_off:
        say(f"{log}: its end is missing; what is there was compared")
    taken = f"{found.steps} steps, {found.heard} frames heard, {found.sent} messages sent"
    if found.difference:
        say(f"{taken}, then a difference: {found.difference}")
        return 1
    say(f"{taken}: identical")
    return 0


def _emit(log: Path, times: float, place: tuple[str, int, str]) -> int:
    """Send the frames again."""
    import asyncio

    from modelcast.cli.stopping import stopped_by_signals
    from modelcast.cli.terminal import say
    from modelcast.core.exceptions import ConfigError
    from modelcast.node.clock import SystemClock
    from modelcast.node.multicast import MulticastTransport
    from modelcast.node.recording.on_air import emit_recording

    if not 0.0 < times < float("inf"):
        raise ConfigError(f"--times must be positive, got {times}")
    clock = SystemClock()
    group, port, interface = place

    async def run() -> int:
        transport = MulticastTransport(clock.now_s, group=group, port=port, interface=interface, hops=1)
        try:
            with stopped_by_signals(0.0) as stop:
                return await emit_recording(log, transport, clock, times_as_fast=times, stop=stop)
        finally:
            transport.close()

    say(f"{asyncio.run(run())} frames sent")
    return 0
