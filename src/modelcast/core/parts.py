"""Work in parts: the same whatever the number of threads that share them."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TypeVar

__all__ = ["WHOLE", "Parts"]

Result = TypeVar("Result")


@dataclass(frozen=True, slots=True)
class Parts:
    """So many parts of something, and who works on them.

    Parameters
    ----------
    number
        Of parts.
    pool
        Threads that share them; None for one part after another.
    """

    number: int
    pool: ThreadPoolExecutor | None = None

    def each(self, work: Callable[[int], Result]) -> list[Result]:
        """Do the same work on every part, which it is given the number of; what it returned, in order.

        Parameters
        ----------
        work
            Writes to no array that another part reads or writes.
        """
        parts = range(self.number)
        return [work(part) for part in parts] if self.pool is None else list(self.pool.map(work, parts))


WHOLE = Parts(1)
"""Undivided."""
