"""Processes that a terminal's Ctrl-C does not reach: the one that started them ends them."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Generator
from contextlib import contextmanager
from multiprocessing import resource_tracker

__all__ = ["end_with_parent", "undisturbed"]


@contextmanager
def undisturbed() -> Generator[None]:
    """Processes and threads that are started in the block never get SIGINT, from their first moment on.

    What arrives meanwhile arrives when the block ends.
    """
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


def end_with_parent() -> None:
    """Have this worker process end as soon as the one that started it is gone, whatever it is doing."""
    parent = multiprocessing.parent_process()
    if parent is None:
        return

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, name="parent", daemon=True).start()
