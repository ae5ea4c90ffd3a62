"""What ends a command from outside: Ctrl-C and SIGTERM. The first ends it in good order, a second at once.

The first becomes a `KeyboardInterrupt`, wherever the main thread is: blocks end, temporary files go, workers
are ended. Where a library swallows that it is sent again. A second one ends the process and its workers at
once; what is left half written then goes with the next run to the same place (`modelcast.io.partial`).
What runs on until it is told to stop closes what is open by the first instead (`modelcast.cli.stopping`).
"""

import os
import signal
import sys
import threading
import time
from types import FrameType
from typing import Any

__all__ = [
    "INTERRUPTED",
    "TERMINATED",
    "Terminated",
    "close_by",
    "finish",
    "heeded",
    "install",
    "take",
    "taken",
]

INTERRUPTED = 128 + 2
TERMINATED = 128 + 15

_TWIN_S = 0.3
"""A terminal and a program that stands between may each deliver one key press: these are one."""
_AGAIN_S = 0.05


class Terminated(KeyboardInterrupt):
    """SIGTERM, which ends a command as Ctrl-C does."""


class _Arrived:
    """The signal that arrived first, when, and what has come of it."""

    def __init__(self) -> None:
        self.first: int | None = None
        self.at_s = 0.0
        self.sent_again = self.heeded = self.ends_well = False


_arrived = _Arrived()


def install() -> None:
    """Have signals end this process so, as long as nothing in it handles them otherwise."""
    for one in (signal.SIGINT, signal.SIGTERM):
        signal.signal(one, _raised)
    sys.unraisablehook = _swallowed


def finish() -> None:
    """From now on a signal ends the process at once: all is done but leaving."""
    for one in (signal.SIGINT, signal.SIGTERM):
        signal.signal(one, _at_once)


def taken() -> int | None:
    """Return the signal that interrupts this process, None where none has arrived."""
    return None if _arrived.ends_well else _arrived.first


def close_by(number: int) -> None:
    """Note the signal by which what runs on is told to stop; one more ends the process at once.

    Parameters
    ----------
    number
        The signal. SIGTERM is how a service is stopped: the command ends well by it.
    """
    if take(number):
        _arrived.ends_well = number == signal.SIGTERM


def heeded() -> None:
    """Note that the command has ended by the signal: it is not sent again."""
    _arrived.heeded = True


def take(number: int) -> bool:
    """Note a signal, and return whether it is the first; a second one ends the process at once.

    Parameters
    ----------
    number
        The signal.
    """
    now_s = time.monotonic()
    if _arrived.first is None:
        _arrived.first, _arrived.at_s = number, now_s
        return True
    if _arrived.sent_again:
        _arrived.sent_again = False
        return not _arrived.heeded
    if now_s >= _arrived.at_s + _TWIN_S:
        _at_once(number, None)
    return False


def _raised(number: int, _: FrameType | None) -> None:
    """Raise the first signal where the main thread is."""
    if take(number):
        raise Terminated if number == signal.SIGTERM else KeyboardInterrupt


def _swallowed(problem: Any) -> None:
    """Send a signal again whose exception came where none can be raised, as in the end of an object."""
    if not (isinstance(problem.exc_type, type) and issubclass(problem.exc_type, KeyboardInterrupt)):
        sys.__unraisablehook__(problem)
        return
    if os.name == "posix":
        number = signal.SIGTERM if problem.exc_type is Terminated else signal.SIGINT
        again = threading.Timer(_AGAIN_S, _send_again, (number,))
        again.daemon = True
        again.start()


def _send_again(number: int) -> None:
    """Send a signal to this process, where the command has not ended by it in some other way."""
    if not _arrived.heeded:
        _arrived.sent_again = True
        os.kill(os.getpid(), number)


def _at_once(number: int, _: FrameType | None) -> None:
    """End the process and its workers without another step."""
    workers: Any = sys.modules.get("multiprocessing")
    for one in () if workers is None else workers.active_children():
        one.kill()
    shown: Any = sys.modules.get("modelcast.cli.board")
    if shown is not None:
        shown.board.abandon()
    late = "interrupted when all was done"
    again = "interrupted again, ended at once"
    sys.stderr.write(f"modelcast: {late if _arrived.first is None else again}\n")
    sys.stderr.flush()
    os._exit(128 + number)
