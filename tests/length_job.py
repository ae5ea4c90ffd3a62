"""A job that workers of other processes know by name: the lengths of trips."""

import json
import os
import signal
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from modelcast.corpora.job import AbstractJob, TripFailures
from modelcast.corpora.running import Outcome
from modelcast.trips.trajectory import Trajectory

__all__ = ["LengthJob", "lengths"]


@dataclass(frozen=True)
class LengthJob(AbstractJob):
    """Samples of every trip; every run of it is noted in a folder.

    Parameters
    ----------
    runs
        Folder in which every partition that is worked on is noted by its first trip.
    version
        Part of the key.
    fails, dies
        A trip that fails, and one that ends the process the first time it is met.
    breaks
        A trip that costs its partition.
    """

    name: ClassVar[str] = "lengths"

    runs: Path
    version: str = "1"
    fails: str = ""
    dies: str = ""
    breaks: str = ""

    @property
    def key(self) -> str:
        """The version."""
        return self.version

    def run(self, trips: Iterator[Trajectory], folder: Path) -> None:
        """Write a line a trip."""
        failures = TripFailures()
        found = {trip.trip_id: samples for trip, samples in failures.each(self._met(trips), self._length)}
        (folder / "lengths.json").write_text(json.dumps(found))
        failures.write(folder)
        (self.runs / f"{next(iter(found)).replace('/', '-')}-{os.urandom(4).hex()}").touch()

    def _met(self, trips: Iterator[Trajectory]) -> Iterator[Trajectory]:
        for trip in trips:
            if trip.trip_id == self.dies and not (self.runs / "died").exists():
                (self.runs / "died").touch()
                os.kill(os.getpid(), signal.SIGKILL)
            if trip.trip_id == self.breaks:
                raise ValueError(f"{trip.trip_id} breaks its partition")
            yield trip

    def _length(self, trip: Trajectory) -> int:
        if trip.trip_id == self.fails:
            raise ValueError("too long")
        return len(trip)


def lengths(outcome: Outcome) -> dict[str, int]:
    """What was found, by trip."""
    found: dict[str, int] = {}
    for part in outcome.parts:
        own = json.loads((part.folder / "lengths.json").read_text())
        assert not set(own) & set(found)
        found |= own
    return dict(sorted(found.items()))
