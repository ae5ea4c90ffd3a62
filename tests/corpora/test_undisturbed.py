"""Claims about blocks that no interrupt cuts in two, whichever thread gets the signal."""

import signal
import threading
from types import FrameType

import pytest

from modelcast.corpora.executors.undisturbed import undisturbed


def pressed(number: int) -> tuple[threading.Event, threading.Thread]:
    """A thread from before the block, whose mask lets everything through, and what has it get a signal."""
    go = threading.Event()

    def press() -> None:
        go.wait()
        signal.raise_signal(number)

    thread = threading.Thread(target=press)
    thread.start()
    return go, thread


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_that_another_thread_gets_is_handled_when_the_block_ends(number: signal.Signals) -> None:
    steps: list[str] = []

    def handle(_: int, __: FrameType | None) -> None:
        steps.append("handled")
        raise KeyboardInterrupt

    before = signal.signal(number, handle)
    try:
        go, thread = pressed(number)

        def block() -> None:
            with undisturbed():
                go.set()
                thread.join()
                steps.append("block")

        with pytest.raises(KeyboardInterrupt):
            block()
        assert steps == ["block", "handled"]
        assert signal.getsignal(number) is handle
    finally:
        signal.signal(number, before)


def test_a_block_of_another_thread_leaves_the_handlers_alone() -> None:
    found: list[object] = []

    def block() -> None:
        with undisturbed():
            found.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=block)
    thread.start()
    thread.join()
    assert found == [signal.getsignal(signal.SIGINT)]
