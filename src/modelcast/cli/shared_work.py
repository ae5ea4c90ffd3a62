"""Work shared out among workers, where one failure ends it all; its results in the order of the work."""

from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import TypeVar, cast

from modelcast.corpora.executors.base import AbstractCrew, AbstractExecutor, Failed
from modelcast.corpora.executors.here import HereExecutor
from modelcast.corpora.executors.processes import ProcessExecutor

__all__ = ["Workers", "jobs_in_use", "workers", "workers_of"]

Work = TypeVar("Work")
Found = TypeVar("Found")


@dataclass(frozen=True, slots=True)
class Workers:
    """Workers that have been started.

    Parameters
    ----------
    crew
        Whom work is handed to.
    """

    crew: AbstractCrew

    def each(self, function: Callable[[Work], Found], work: Iterable[Work]) -> Iterator[Found]:
        """What a function gives for each piece of work, in its order, like `map`.

        Parameters
        ----------
        function
            Of one piece; other processes know it by its name.
        work
            The pieces.
        """
        found: dict[int, Found] = {}
        following = 0
        for (at, _), one in self.as_done(partial(_of_numbered, function), enumerate(work)):
            found[at] = one
            while following in found:
                yield found.pop(following)
                following += 1

    def as_done(
        self, function: Callable[[Work], Found], work: Iterable[Work]
    ) -> Iterator[tuple[Work, Found]]:
        """Each piece of work and what a function gives for it, as soon as it is done.

        Parameters
        ----------
        function, work
            As for `each`. What the function raises is raised here, and the rest is not done.
        """
        for one, answer in self.crew.as_done(function, work):
            if isinstance(answer, Failed):
                raise answer.error
            yield one, cast("Found", answer)


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
    return ProcessExecutor(jobs).count


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
    with (HereExecutor() if count == 1 else ProcessExecutor(count)).start() as crew:
        yield Workers(crew)


@contextmanager
def workers_of(executor: AbstractExecutor, pieces: int) -> Generator[Workers]:
    """Yield the workers of an executor; where there is at most one piece of work, none but this process.

    Parameters
    ----------
    executor
        Where work is done.
    pieces
        How many there are.
    """
    with (executor if pieces > 1 else HereExecutor()).start() as crew:
        yield Workers(crew)


def _of_numbered(function: Callable[[Work], Found], numbered: tuple[int, Work]) -> Found:
    """What a function gives for a piece of work that has a number."""
    return function(numbered[1])
