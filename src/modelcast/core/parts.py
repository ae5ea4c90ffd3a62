"""Work in parts: the same whatever the number of threads that share them."""

from collections import deque
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
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

    Notes
    -----
    What can only be done by one thread, such as events one after another, leaves the others idle. One of them
    then does what was put off: work on other arrays, whose result nobody needs before `finish`.
    """

    number: int
    pool: ThreadPoolExecutor | None = None
    _off: deque[Callable[[], object]] = field(
        default_factory=deque[Callable[[], object]], init=False, repr=False, compare=False
    )

    def each(self, work: Callable[[int], Result]) -> list[Result]:
        """Do the same work on every part, which it is given the number of; what it returned, in order.

        Parameters
        ----------
        work
            Writes to no array that another part reads or writes.
        """
        parts = range(self.number)
        return [work(part) for part in parts] if self.pool is None else list(self.pool.map(work, parts))

    def put_off(self, work: Callable[[int], object]) -> None:
        """Do the same work on every part before `finish` returns; at once where no threads share it.

        Parameters
        ----------
        work
            As for `each`; nor does anything in between write what it reads, or read what it writes.
        """
        if self.pool is None:
            self.each(work)
            return
        for part in range(self.number):
            self._off.append(partial(work, part))

    def beside(self, work: Callable[[], Result]) -> Result:
        """Do one thing in this thread, and what was put off in one other; what the first returned."""
        if self.pool is None or not self._off:
            return work()
        other = self.pool.submit(self._do_put_off)
        try:
            return work()
        finally:
            other.result()

    def finish(self) -> None:
        """Do all that is left of what was put off."""
        if self._off and self.pool is not None:
            for one in [self.pool.submit(self._do_put_off) for _ in range(len(self._off))]:
                one.result()

    def _do_put_off(self) -> None:
        while True:
            try:
                work = self._off.popleft()
            except IndexError:
                return
            work()


WHOLE = Parts(1)
"""Undivided."""
