"""What every place offers in which tasks run.

An executor is a description, a frozen value; its `start` gives the crew that works. What a task gives comes
back as soon as it is done, in whatever order; a task that raises, and one whose worker is lost again and
again, gives a `Failed` and stops no other. Take `HereExecutor` for one process, `ProcessExecutor` for one
machine, `ClusterExecutor` for several.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from modelcast.core.exceptions import ModelcastError
from modelcast.core.printable import printable

__all__ = ["TRIES", "AbstractCrew", "AbstractExecutor", "Failed", "LostWorkerError"]

Work = TypeVar("Work")
Found = TypeVar("Found")

TRIES = 3
"""How often a task is begun whose worker is lost: two losses may be another's fault, three are its own."""


class LostWorkerError(ModelcastError):
    """A task lost its worker each time it was begun.

    Parameters
    ----------
    tries
        How often that was.
    how
        How the last worker ended.
    """

    def __init__(self, tries: int, how: str) -> None:
        super().__init__(
            f"its worker was lost {tries} times, the last one {how}: most often the machine's memory, or "
            "--memory, is too small for it"
        )
        self.tries = tries
        self.how = how


@dataclass(frozen=True, slots=True)
class Failed:
    """What a task gives that did not end well.

    Parameters
    ----------
    error
        What it raised, or `LostWorkerError`.
    """

    error: Exception

    @property
    def reason(self) -> str:
        """Why, in one line."""
        text = str(self.error)
        if isinstance(self.error, MemoryError) and not text:
            text = "more than its process may take"
        return printable(
            text if isinstance(self.error, ModelcastError) else f"{type(self.error).__name__}: {text}"
        )


class AbstractCrew(ABC):
    """Workers that have been started."""

    @abstractmethod
    def as_done(
        self, function: Callable[[Work], Found], work: Iterable[Work]
    ) -> Iterator[tuple[Work, Found | Failed]]:
        """Each piece of work and what the function gives for it, as soon as it is done.

        Work that is under way is dropped where the iterator is closed before its end.

        Parameters
        ----------
        function
            Of one piece; workers know it by its name, so it is a function of a module, or a partial of one.
        work
            The pieces; they are taken one by one, as workers become free.
        """

    @abstractmethod
    def require_shared(self, folders: Sequence[Path]) -> None:
        """Refuse workers that do not see the same files as this process.

        Parameters
        ----------
        folders
            Existing folders that tasks read or write, as absolute paths.

        Raises
        ------
        ConfigError
            Where a worker does not see one.
        """


class AbstractExecutor(ABC):
    """A place in which tasks run."""

    @property
    def worker_bytes(self) -> int | None:
        """What one worker may take, so that tasks can make do with it; None where there is no bound."""
        return None

    @abstractmethod
    def start(self) -> AbstractContextManager[AbstractCrew]:
        """Start workers that end with the block, whatever they are doing then.

        Raises
        ------
        ConfigError
            Where there are none, or they are not of this version.
        """
