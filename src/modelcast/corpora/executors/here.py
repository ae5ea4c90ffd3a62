"""Tasks in this process, one after another."""

from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from modelcast.corpora.executors.base import AbstractCrew, AbstractExecutor, Failed

__all__ = ["HereCrew", "HereExecutor"]

Work = TypeVar("Work")
Found = TypeVar("Found")


@dataclass(frozen=True, slots=True)
class HereExecutor(AbstractExecutor):
    """The calling process; nothing is started, and a task that ends the process ends all."""

    @contextmanager
    def start(self) -> Generator[AbstractCrew]:
        """Nothing is started."""
        yield HereCrew()


class HereCrew(AbstractCrew):
    """The calling process."""

    def as_done(
        self, function: Callable[[Work], Found], work: Iterable[Work]
    ) -> Iterator[tuple[Work, Found | Failed]]:
        """In the order of the work."""
        for one in work:
            try:
                answer = function(one)
            except Exception as error:  # noqa: BLE001 - whatever it is, it costs this task alone
                answer = Failed(error)
            yield one, answer

    def require_shared(self, folders: Sequence[Path]) -> None:
        """It sees what it sees."""
