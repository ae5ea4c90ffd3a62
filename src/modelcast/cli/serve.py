"""``modelcast serve``: the stations of another simulator's vehicles, over a socket of this machine."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from modelcast.node.serving.server import StepServer

__all__ = ["serve"]

_MOST_SESSIONS = 64


def serve(
    *,
    socket: Path | None = None,
    port: int | None = None,
    profile: str | None = None,
    sessions: int = 8,
    once: bool = False,
) -> int:
    """Serve stations to another simulator, in any language, step by step.

    For example: `modelcast serve --port 9031`

    The simulator tells where its vehicles are and what they received, and gets what they send, what they
    believe and what warns them (docs/serve.md). Only programs on this machine are served. Ends by SIGTERM or
    Ctrl-C.

    Parameters
    ----------
    socket
        Path of a local socket to listen at, which only this user may open.
    port
        Port of this machine to listen at instead; 0 for any that is free.
    profile
        File of the profile in use, or a shipped one's name, as for evaluate; people have that of people.
    sessions
        Clients at a time.
    once
        End after the first session.
    """
    import asyncio

    from modelcast.cli.banks import profile_in_use
    from modelcast.cli.terminal import complain
    from modelcast.core.exceptions import ConfigError
    from modelcast.node.serving.server import StepServer
    from modelcast.runtime.external.senders import sender_of

    if (socket is None) == (port is None):
        raise ConfigError("give --socket or --port, one of the two")
    if port is not None and not 0 <= port < 2**16:
        raise ConfigError(f"--port must be from 0 to 65535, got {port}")
    if not 1 <= sessions <= _MOST_SESSIONS:
        raise ConfigError(f"--sessions must be from 1 to {_MOST_SESSIONS}, got {sessions}")
    make = partial(sender_of, profile=profile_in_use(profile))
    server = StepServer(make, most=sessions, tell=complain)
    asyncio.run(_serve(server, None if socket is None else str(socket), port or 0, once=once))
    if socket is not None:
        socket.unlink(missing_ok=True)
    return 0


async def _serve(server: "StepServer", path: str | None, port: int, *, once: bool) -> None:
    """Serve until a signal, or until the first session has ended."""
    import asyncio

    from modelcast.cli.stopping import stopped_by_signals
    from modelcast.cli.terminal import say

    with stopped_by_signals(0.0) as stop:
        listening = await server.listen(path=path, port=port)
        place = path if path is not None else f"127.0.0.1:{listening.sockets[0].getsockname()[1]}"
        say(f"listening at {place}")
        ends: set[asyncio.Task[bool]] = {asyncio.create_task(stop.wait())}
        if once:
            ends.add(asyncio.create_task(server.served.wait()))
        await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
        listening.close()
        await server.close()
        for one in ends:
            one.cancel()
