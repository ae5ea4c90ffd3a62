"""``modelcast view``: a recorded log, or a drive to try, on the page."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from modelcast.dashboard.feed import AbstractFeed, LiveFeed

__all__ = ["view"]

_DRIVE_S = 600.0
"""Length of one drive of the demo."""


def view(
    log: Path | None = None,
    *,
    demo: bool = False,
    truth: tuple[Path, ...] = (),
    host: str = "127.0.0.1",
    port: int = 8700,
    name: tuple[str, ...] = (),
) -> int:
    """Show what a host believed on a page in the browser: a recording, a log of snapshots, or a made drive.

    For example: `modelcast view --demo`

    Parameters
    ----------
    log
        A recording of modelcast node (MCAP), or a log of snapshots (lines of JSON).
    demo
        Show a simulated drive instead, at its own pace, until interrupted.
    truth
        Recordings of other nodes, which say where those were: the page shows the errors then.
    host
        Address to listen on. Where other machines can reach it, the page asks for a token, which is printed.
    port
        Port to listen on; 0 for any free one.
    name
        Names by which browsers may ask for the page, beside addresses and localhost.
    """
    import asyncio
    from contextlib import ExitStack

    from modelcast.cli.terminal import say
    from modelcast.core.exceptions import ConfigError
    from modelcast.dashboard.feed import LiveFeed
    from modelcast.dashboard.log import SnapshotLog

    if (log is None) != demo:
        raise ConfigError("give a log, or --demo")
    if not 0 <= port < 2**16:
        raise ConfigError(f"--port must be from 0 to 65535, got {port}")
    with ExitStack() as open_files:
        feed: AbstractFeed = LiveFeed("demo")
        if log is not None and _is_recording(log):
            from modelcast.node.recording.feed import RecordingFeed

            feed = open_files.enter_context(RecordingFeed(log, truth))
            if feed.cut_off:
                say(f"{log}: its end is missing")
        elif truth:
            raise ConfigError("--truth goes with a recording of modelcast node (MCAP)")
        elif log is not None:
            feed = open_files.enter_context(SnapshotLog(log))
        asyncio.run(_serve(feed, host, port, name))
    return 0


def _is_recording(log: Path) -> bool:
    """Whether a file begins as an MCAP does."""
    with log.open("rb") as file:
        return file.read(8) == b"\x89MCAP0\r\n"


async def _serve(feed: "AbstractFeed", host: str, port: int, names: tuple[str, ...]) -> None:
    """Serve until interrupted."""
    import asyncio
    import secrets

    from modelcast.cli.terminal import say
    from modelcast.dashboard.feed import LiveFeed
    from modelcast.dashboard.gate import Gate, is_loopback
    from modelcast.dashboard.server import listen, page_server

    gate = Gate("" if is_loopback(host) else secrets.token_urlsafe(24), names)
    with listen(host, port, gate) as place:
        found = place.getsockname()
        shown = f"[{found[0]}]" if ":" in found[0] else found[0]
        say(f"http://{shown}:{found[1]}/" + (f"?token={gate.token}" if gate.token else ""))
        server = page_server(feed, gate)
        driving = asyncio.create_task(_drive(feed)) if isinstance(feed, LiveFeed) else None
        if driving is not None:
            driving.add_done_callback(lambda _: setattr(server, "should_exit", True))
        try:
            await server.serve(sockets=[place])
        finally:
            if driving is not None and not driving.cancel():
                await driving  # it ended by itself, so by an error


async def _drive(feed: "LiveFeed") -> None:
    """Publish the demo's snapshots at their times, one drive after another, while the server goes on."""
    import asyncio
    import time
    from dataclasses import replace
    from itertools import count

    from modelcast.dashboard.demo import DemoDrive

    begun_s: float | None = None
    for seed in count():
        offset_s = _DRIVE_S * seed
        drive = DemoDrive(seed=seed).snapshots(_DRIVE_S)
        while (snapshot := await asyncio.to_thread(next, drive, None)) is not None:
            t_s = snapshot.t_s + offset_s
            feed.publish(replace(snapshot, t_s=t_s))
            begun_s = time.monotonic() if begun_s is None else begun_s
            await asyncio.sleep(max(begun_s + t_s - time.monotonic(), 0.0))
