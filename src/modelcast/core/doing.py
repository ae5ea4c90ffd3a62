"""What is at hand: long work names its steps in passing, and whoever shows progress hears them."""

from collections.abc import Callable, Generator
from contextlib import contextmanager

__all__ = ["doing", "heard"]

_listeners: list[Callable[[str], None]] = []


def doing(what: str) -> None:
    """Name what is done next.

    Parameters
    ----------
    what
        A few words.
    """
    if _listeners:
        _listeners[-1](what)


@contextmanager
def heard(listener: Callable[[str], None]) -> Generator[None]:
    """Have a listener told what is at hand, for as long as the block lasts.

    Parameters
    ----------
    listener
        Takes a few words.

    Examples
    --------
    >>> with heard(print):
    ...     doing("figure 1")
    figure 1
    """
    _listeners.append(listener)
    try:
        yield
    finally:
        _listeners.pop()
