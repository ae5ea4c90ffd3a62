"""Work in parts: the same whatever the number of threads that share them."""

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from threading import Event
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
    then does what was put off: work on other arrays, whose result nobody needs before `finish`. It is done in
    the order in which it was put off, part by part: later work on a part finds what earlier work on it wrote,
    and what is handed over as one finds all before it done.
    """

    number: int
    pool: ThreadPoolExecutor | None = None
    _off: deque[tuple[int, Callable[[int], object]]] = field(
        default_factory=deque[tuple[int, Callable[[int], object]]], init=False, repr=False, compare=False
    )
    _open: Event = field(default_factory=Event, init=False, repr=False, compare=False)
    _others: list[Future[None]] = field(
        default_factory=list[Future[None]], init=False, repr=False, compare=False
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
            As for `each`; nor does anything in between write what it reads, or read what it writes, but what
            was put off as well.
        """
        if self.pool is None:
            self.each(work)
            return
        self._off.extend((part, work) for part in range(self.number))

    def hand_over(self, work: Callable[[], object]) -> None:
        """Put one thing off; within `beside`, have the other thread go on if it has come to an end.

        Parameters
        ----------
        work
            As for `put_off`; done as one, after all that was put off before. It may itself put more off.
        """
        if self.pool is None:
            work()
            return
        self._off.append((_AS_ONE, lambda _: work()))
        if self._open.is_set():
            self._let_another()

    def beside(self, work: Callable[[], Result]) -> Result:
        """Do one thing in this thread, and meanwhile what is put off in one other; what the first returned.

        What the other has not begun by then is left to `finish`.
        """
        if self.pool is None:
            return work()
        self._open.set()
        self._let_another()
        try:
            return work()
        finally:
            self._open.clear()
            others = list(self._others)
            self._others.clear()
            for other in others:
                other.result()

    def finish(self) -> None:
        """Do all that is left of what was put off: parts side by side, each in its order."""
        while self._off and self.pool is not None:
            left: dict[int, list[Callable[[int], object]]] = {}
            while self._off and self._off[0][0] != _AS_ONE:
                part, work = self._off.popleft()
                left.setdefault(part, []).append(work)
            for _ in self.pool.map(_do_in_order, left, left.values()):
                pass
            if self._off:
                part, work = self._off.popleft()
                work(part)

    def _let_another(self) -> None:
        """Have another thread at work on what was put off, unless one is or there is nothing."""
        if self._off and self.pool is not None and (not self._others or self._others[-1].done()):
            self._others.append(self.pool.submit(self._do_put_off))

    def _do_put_off(self) -> None:
        while self._open.is_set():
            try:
                part, work = self._off.popleft()
            except IndexError:
                return
            work(part)


_AS_ONE = -1
"""In place of a part's number: work that is done as one."""


def _do_in_order(part: int, works: list[Callable[[int], object]]) -> None:
    for work in works:
        work(part)


WHOLE = Parts(1)
"""Undivided."""
