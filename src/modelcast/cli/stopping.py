"""How what runs on until it is told to stop is stopped: by SIGTERM, by Ctrl-C, or after a time."""

import signal
import sys
from collections.abc import Generator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from modelcast.cli import signals

if TYPE_CHECKING:
    import asyncio

__all__ = ["stopped_by_signals"]


@contextmanager
def stopped_by_signals(duration_s: float) -> "Generator[asyncio.Event]":
    """Yield what is set by SIGTERM, by Ctrl-C, or after a time; to be entered in a running loop.

    SIGTERM is how a service is stopped, so that it ends well by that; Ctrl-C is noted, so that the command
    ends as interrupted. From then on, while the block closes what is open, another signal ends the process at
    once, also where the loop waits for something that does not end.

    Parameters
    ----------
    duration_s
        The time [s]; 0 for none.

    Raises
    ------
    ConfigError
        On Windows, whose event loop watches neither signals nor datagram sockets as nodes need it.
    """
    import asyncio

    from modelcast.core.exceptions import ConfigError

    if sys.platform == "win32":
        raise ConfigError("nodes and servers run on Linux and macOS, not on Windows")
    stop, loop = asyncio.Event(), asyncio.get_running_loop()
    before = {one: signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM)}

    def asked(number: int) -> None:
        unwatched()
        signals.close_by(number)
        stop.set()

    def unwatched() -> None:
        """Give the signals back from the loop, which hears of none while something holds it up."""
        # The loop leaves the system's handler behind, by which a second signal would end the process unsaid.
        held = signal.pthread_sigmask(signal.SIG_BLOCK, before)
        try:
            for one, handler in before.items():
                if loop.remove_signal_handler(one):
                    signal.signal(one, handler)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, held)

    for one in before:
        loop.add_signal_handler(one, asked, one)
    timer = loop.call_later(duration_s, stop.set) if duration_s else None
    try:
        yield stop
    finally:
        unwatched()
        if timer is not None:
            timer.cancel()
