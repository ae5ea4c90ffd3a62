"""Work shared out among processes, its results in the order of the work."""

import multiprocessing
import os
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TypeVar

from modelcast.core.exceptions import ConfigError

__all__ = ["Workers", "jobs_in_use", "workers"]

Work = TypeVar("Work")
Found = TypeVar("Found")


@dataclass(frozen=True, slots=True)
class Workers:
    """Processes that take work, or none but this one.

    Parameters
    ----------
    executor
        Whom work is handed to; None for this process.
    """

    executor: Executor | None

    def each(self, function: Callable[[Work], Found], work: Iterable[Work]) -> Iterable[Found]:
        """What a function gives for each piece of work, in its order, like `map`.

        Parameters
        ----------
        function
            Of one piece; where there are processes it is sent to them by name.
        work
            The pieces.
        """
        return map(function, work) if self.executor is None else self.executor.map(function, work)

    def as_done(
        self, function: Callable[[Work], Found], work: Iterable[Work]
    ) -> Iterator[tuple[Work, Found]]:
        """Each piece of work and what a function gives for it, as soon as it is done.

        Parameters
        ----------
        function, work
            As for `each`.
        """
        if self.executor is None:
            for one in work:
                yield one, function(one)
            return
        waiting = {self.executor.submit(function, one): one for one in work}
        for future in as_completed(waiting):
            yield waiting[future], future.result()


def jobs_in_use(jobs: int) -> int:
    """How many processes are meant: those named, or one a processor where that is 0.

    Parameters
    ----------
    jobs
        As users name them.

    Raises
    ------
    ConfigError
        Where it is negative.
    """
    if jobs < 0:
        raise ConfigError(f"--jobs must be 0 (one a processor) or more, got {jobs}")
    return jobs or os.cpu_count() or 1


@contextmanager
def workers(jobs: int) -> Generator[Workers]:
    """Yield processes that end with the block.

    Parameters
    ----------
    jobs
        How many; 0 for one a processor, 1 for none but this.

    Raises
    ------
    ConfigError
        Where it is negative.
    """
    count = jobs_in_use(jobs)
    if count == 1:
        yield Workers(None)
        return
    with ProcessPoolExecutor(count, mp_context=multiprocessing.get_context("spawn")) as pool:
        yield Workers(pool)
