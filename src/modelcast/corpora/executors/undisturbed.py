"""Processes that a terminal's Ctrl-C does not reach: the one that started them ends them."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Generator
from contextlib import contextmanager
from multiprocessing import resource_tracker
from types import FrameType

__all__ = ["end_with_parent", "undisturbed"]


@contextmanager
def undisturbed() -> Generator[None]:
    """Processes and threads that are started in the block never get SIGINT, from their first moment on.

    What the main thread would get meanwhile, SIGINT or SIGTERM, it gets when the block ends.
    """
    with _held_back():
        if not hasattr(signal, "pthread_sigmask"):  # Windows
            yield
            return
        # It would be started with the first process, and SIGINT be let through again before that is.
        resource_tracker.ensure_running()
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            yield
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _held_back() -> Generator[None]:
    """Have handlers of the main thread wait for the end of the block.

    The mask of a thread is not enough: what it holds off, the kernel gives to another thread, and Python has
    the main thread handle it all the same.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    held: list[int] = []

    def note(number: int, _: FrameType | None) -> None:
        held.append(number)

    found = {one: signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM)}
    before = {one: handler for one, handler in found.items() if callable(handler)}
    try:
        for one in before:
            signal.signal(one, note)
        yield
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)
        if held:
            before[signal.Signals(held[0])](held[0], None)


def end_with_parent() -> None:
    """Have this worker process end as soon as the one that started it is gone, whatever it is doing."""
    parent = multiprocessing.parent_process()
    if parent is None:
        return

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, name="parent", daemon=True).start()
