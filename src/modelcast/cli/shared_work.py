"""Work shared out among processes, its results in the order of the work."""

import multiprocessing
import os
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TypeVar

from modelcast.core.exceptions import ConfigError

__all__ = ["Workers", "workers"]

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
    if jobs < 0:
        raise ConfigError(f"--jobs must be 0 (one a processor) or more, got {jobs}")
    count = jobs or os.cpu_count() or 1
    if count == 1:
        yield Workers(None)
        return
    with ProcessPoolExecutor(count, mp_context=multiprocessing.get_context("spawn")) as pool:
        yield Workers(pool)
