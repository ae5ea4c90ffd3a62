"""What a job has found of single partitions, kept on disk: ``parts/0017/`` in its results folder.

A part's folder holds what the job wrote and `DONE_FILE`: whose part it is, and how much went in. It appears
whole or not at all. So a part that is there need not be done again, whoever wrote it, and is counted once; a
part of other settings, or of a partition that has changed, is no part.
"""

import json
import shutil
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from modelcast.core.json_text import parse_json
from modelcast.core.rules import Keys, Text, Whole, check
from modelcast.corpora.job import AbstractJob
from modelcast.corpora.layout import Corpus, Partition, open_corpus
from modelcast.io.output import atomic_folder
from modelcast.trips.trajectory import Trajectory

__all__ = ["DONE_FILE", "PARTS_FOLDER", "Part", "Task", "do_task", "drop_others", "find_part"]

PARTS_FOLDER = "parts"
"""Where the parts are, in a results folder."""

DONE_FILE = "done.json"
"""The mark of a part."""

_FORMAT = "modelcast part"
_MOST = 2**53
_DONE = Keys(
    {
        "format": Text(64),
        "job": Text(64),
        "key": Text(1000),
        "partition": Text(64),
        "digest": Text(1000),
        "trips": Whole(0, _MOST),
        "rows": Whole(0, _MOST),
    }
)


@dataclass(frozen=True, slots=True)
class Part:
    """What a job found of one partition.

    Parameters
    ----------
    partition
        Its name.
    folder
        What the job wrote.
    trips, rows
        Trips that the job was given, and their samples.
    """

    partition: str
    folder: Path
    trips: int
    rows: int


@dataclass(frozen=True, slots=True)
class Task:
    """One partition to be worked on, as it is sent to a worker.

    Parameters
    ----------
    corpus
        The corpus' folder.
    partition
        The partition.
    job
        What to do.
    results
        The results folder.
    """

    corpus: Path
    partition: Partition
    job: AbstractJob
    results: Path

    @property
    def folder(self) -> Path:
        """Where the part is to be."""
        return self.results / PARTS_FOLDER / self.partition.name


def find_part(task: Task) -> Part | None:
    """Return the part that a task gives, None where it is not done.

    Parameters
    ----------
    task
        The task.
    """
    try:
        done: Any = parse_json((task.folder / DONE_FILE).read_text(encoding="utf-8"))
        check(done, _DONE)
    except (OSError, ValueError):
        return None
    found = cast("dict[str, Any]", done)
    if any(found[name] != value for name, value in _mark(task).items()):
        return None
    return Part(task.partition.name, task.folder, found["trips"], found["rows"])


def do_task(task: Task) -> Part:
    """Work on one partition, where that is not done yet.

    A worker that was lost may have done it before it was: then it is not done again.

    Parameters
    ----------
    task
        The task.

    Raises
    ------
    DataFormatError
        Where the corpus is damaged.
    ConfigError
        Where the results cannot be written.
    """
    found = find_part(task)
    if found is not None:
        return found
    trips = _Counted(open_corpus(task.corpus), task.partition)
    with atomic_folder(task.folder, command=_FORMAT) as folder:
        task.job.run(iter(trips), folder)
        done = {**_mark(task), "trips": trips.trips, "rows": trips.rows}
        (folder / DONE_FILE).write_text(json.dumps(done, indent=2) + "\n", encoding="utf-8", newline="\n")
    return Part(task.partition.name, task.folder, trips.trips, trips.rows)


def drop_others(results: Path, partitions: Iterable[str]) -> None:
    """Remove parts of partitions that a corpus no longer has.

    Parameters
    ----------
    results
        The results folder.
    partitions
        Names of those it has.
    """
    kept = set(partitions)
    with suppress(FileNotFoundError):
        for path in sorted((results / PARTS_FOLDER).iterdir()):
            if path.name not in kept and not path.name.startswith("."):  # those belong to a writer
                shutil.rmtree(path, ignore_errors=True)


def _mark(task: Task) -> dict[str, str]:
    """Whose part it is."""
    return {
        "format": _FORMAT,
        "job": task.job.name,
        "key": task.job.key,
        "partition": task.partition.name,
        "digest": task.partition.digest,
    }


class _Counted:
    """A partition's trips, counted as they are taken.

    Parameters
    ----------
    corpus, partition
        Whose.
    """

    def __init__(self, corpus: Corpus, partition: Partition) -> None:
        self._corpus = corpus
        self._partition = partition
        self.trips = 0
        self.rows = 0

    def __iter__(self) -> Iterator[Trajectory]:
        for trip in self._corpus.trips(self._partition):
            self.trips += 1
            self.rows += len(trip)
            yield trip
