"""What can be done with a corpus partition by partition, by any worker, in any order.

A job writes its findings of one partition's trips into a folder (`AbstractJob.run`).
`modelcast.corpora.running` sees to the rest: which partitions are missing, where they are worked on, and that
a folder appears whole or not at all. What comes of all partitions together is put in order by whoever asked
for it, by trip and never by partition: so it is the same whatever the partitions, the workers and the order
in which they end.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import ClassVar, TypeVar

from modelcast.core.exceptions import ConfigError
from modelcast.core.json_text import parse_json
from modelcast.core.rules import Table, Text, check
from modelcast.corpora.executors.base import Failed, LostWorkerError
from modelcast.io.documents import document_text
from modelcast.trips.trajectory import Trajectory

__all__ = ["FAILURES_FILE", "AbstractJob", "TripFailures", "read_failures"]

Found = TypeVar("Found")

FAILURES_FILE = "failures.json"
"""Reasons by trip, in the folder of a partition."""

_FAILURES = Table(Text(10_000), 10_000_000)


class AbstractJob(ABC):
    """Something to be done with every partition of a corpus: a frozen dataclass that pickles."""

    name: ClassVar[str]
    """The command's name."""

    @property
    @abstractmethod
    def key(self) -> str:
        """Hash of everything that its findings depend on beside the partition.

        Settings, the contents of files that are read, and the version of modelcast. What was found with
        another key is found anew.
        """

    @abstractmethod
    def run(self, trips: Iterator[Trajectory], folder: Path) -> None:
        """Write what is found of a partition.

        Parameters
        ----------
        trips
            Its trips, one at a time, in order of identifier.
        folder
            An empty folder. A trip that cannot be worked on is noted in `FAILURES_FILE` (`TripFailures`) and
            does not stop the rest; an error that is raised costs the whole partition.
        """


class TripFailures:
    """Trips that could not be worked on, and why."""

    def __init__(self) -> None:
        self.reasons: dict[str, str] = {}

    def each(
        self, trips: Iterable[Trajectory], work: Callable[[Trajectory], Found]
    ) -> Iterator[tuple[Trajectory, Found]]:
        """Each trip with what a function gives for it; without those for which it raises, which are noted.

        Parameters
        ----------
        trips
            Trips; what raises while they are read is raised here too.
        work
            Of one trip.

        Raises
        ------
        MemoryError, LostWorkerError
            As the function does: they are faults of the place and not of the trip, so the whole partition is
            to be tried again.
        """
        for trip in trips:
            try:
                found = work(trip)
            except (MemoryError, LostWorkerError):
                raise
            except Exception as error:  # noqa: BLE001 - whatever it is, it costs this trip alone
                self.reasons[trip.trip_id] = Failed(error).reason
            else:
                yield trip, found

    def write(self, folder: Path) -> None:
        """Write them into the folder of a partition.

        Parameters
        ----------
        folder
            As for `AbstractJob.run`.
        """
        (folder / FAILURES_FILE).write_text(document_text(self.reasons), encoding="utf-8", newline="\n")


def read_failures(folder: Path) -> dict[str, str]:
    """Return the trips of a partition that could not be worked on, with reasons.

    Parameters
    ----------
    folder
        Of the partition; none are noted where the file is missing.

    Raises
    ------
    ConfigError
        Where the file is damaged.
    """
    path = folder / FAILURES_FILE
    try:
        reasons = parse_json(path.read_text(encoding="utf-8"))
        check(reasons, _FAILURES)
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise ConfigError(f"{path} is damaged: {error}: remove its folder and run again") from error
    return reasons
