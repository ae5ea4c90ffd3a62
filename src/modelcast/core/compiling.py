"""Who is told that functions are being compiled, here and in worker processes."""

import os
import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

__all__ = ["Compiling", "Listener", "announced", "hear", "interrupts_raised", "tell", "watch"]


@dataclass(frozen=True, slots=True)
class Compiling:
    """A function that is about to be compiled, or the end of that.

    Parameters
    ----------
    label
        Its module and name; empty where what was called is ready.
    left
        Functions still to be compiled before what was called is ready, this one among them.
    process
        The process that compiles.
    """

    label: str
    left: int
    process: int


Listener = Callable[[Compiling], None]
"""Told of each function before it is compiled, and when what was called is ready."""


class _Announcing:
    """What is being compiled, and who is told."""

    def __init__(self) -> None:
        self.listener: Listener | None = None
        self.depth = self.left = 0
        self.told: set[str] = set()


_announcing = _Announcing()


def watch(listener: Listener | None) -> Listener | None:
    """Have compilation announced, and return whom it was announced to.

    Parameters
    ----------
    listener
        Who is told; None for the one line that a terminal gets otherwise.
    """
    before, _announcing.listener = _announcing.listener, listener
    return before


def hear(one: Compiling) -> None:
    """Pass on what this process or a worker has to say.

    Parameters
    ----------
    one
        What is being compiled.
    """
    if _announcing.listener is not None:
        _announcing.listener(one)
    elif one.label and sys.stderr is not None and sys.stderr.isatty():
        tell("compiling for this machine, once; the next run starts at once")


def tell(text: str) -> None:
    """Write a line to the standard error, once a process.

    Parameters
    ----------
    text
        The line.
    """
    if text not in _announcing.told:
        _announcing.told.add(text)
        sys.stderr.write(f"modelcast: {text}\n")


@contextmanager
def announced(label: str, count: Callable[[], int]) -> Generator[None]:
    """Announce one compilation; others happen inside it.

    Parameters
    ----------
    label
        Module and name.
    count
        How many functions have to be compiled for it, itself among them; asked where it is the outermost.
    """
    state = _announcing
    state.left = max(state.left - 1, 1) if state.depth else count()
    state.depth += 1
    hear(Compiling(label, state.left, os.getpid()))
    try:
        yield
    finally:
        state.depth -= 1
        if not state.depth:
            hear(Compiling("", 0, os.getpid()))


@contextmanager
def interrupts_raised() -> Generator[None]:
    """Raise an interrupt that comes where Python passes it over, as soon as the block ends.

    LLVM hands over what it made by calling back. A signal that arrived while it worked is handled there, and
    what its handler raises goes to ``sys.unraisablehook`` instead of the caller; the code is lost with it.
    """
    passed_over: list[type[KeyboardInterrupt]] = []
    before = sys.unraisablehook

    def note(problem: Any) -> None:
        if isinstance(problem.exc_type, type) and issubclass(problem.exc_type, KeyboardInterrupt):
            passed_over.append(problem.exc_type)
        else:
            before(problem)

    sys.unraisablehook = note
    try:
        yield
    finally:
        sys.unraisablehook = before
        if passed_over:
            raise passed_over[0]
