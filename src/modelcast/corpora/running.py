"""A job run over a corpus: what is missing is worked on, wherever that is; what is done is kept.

One run at a time works on a results folder. A run that is interrupted or killed leaves the parts that it has
done, and the next goes on from there. A partition that fails, by an error or by workers that are lost again
and again, is named and stops no other; the next run tries it anew.
"""

import json
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from filelock import FileLock, Timeout

from modelcast.core.exceptions import ConfigError
from modelcast.corpora.executors.base import AbstractExecutor, Failed
from modelcast.corpora.job import AbstractJob
from modelcast.corpora.layout import Corpus
from modelcast.corpora.parts import Part, Task, do_task, drop_others, find_part

__all__ = ["Outcome", "Tally", "Watch", "claimed_results", "run_job", "watch_nothing"]

_MARK_FILE = "job.json"
_LOCK_FILE = ".lock"
_FORMAT = "modelcast job"


@dataclass(frozen=True, slots=True)
class Tally:
    """How far a run is.

    Parameters
    ----------
    done, partitions
        Partitions that are done or have failed, and all.
    rows, all_rows
        Samples of these.
    kept_rows
        Those of them that an earlier run had done.
    """

    done: int
    partitions: int
    rows: int
    all_rows: int
    kept_rows: int


Watch = Callable[[Tally], None]
"""Told how far a run is: at its start and after every partition."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What has come of a run.

    Parameters
    ----------
    parts
        What was found, by partition.
    failures
        Why a partition was not done, by its name.
    kept
        How many parts an earlier run had done.
    """

    parts: tuple[Part, ...]
    failures: Mapping[str, str]
    kept: int


def watch_nothing(tally: Tally) -> None:
    """Show nothing: a `Watch`."""
    del tally


def run_job(
    corpus: Corpus,
    job: AbstractJob,
    results: Path,
    executor: AbstractExecutor,
    *,
    watch: Watch = watch_nothing,
) -> Outcome:
    """Do a job with every partition of a corpus, and return what was found of each.

    Parameters
    ----------
    corpus
        The corpus.
    job
        What to do.
    results
        The results folder: new, empty, or of an earlier run of a job of this name.
    executor
        Where it is done.
    watch
        Told how far it is.

    Raises
    ------
    ConfigError
        Where the folder holds other files, another run works on it, or the executor has no fit worker.
    """
    with claimed_results(results, job.name):
        folder = results.resolve()
        tasks = [Task(corpus.path.resolve(), partition, job, folder) for partition in corpus.partitions]
        drop_others(folder, (task.partition.name for task in tasks))
        parts = {part.partition: part for task in tasks if (part := find_part(task)) is not None}
        kept, kept_rows = len(parts), sum(part.rows for part in parts.values())
        missing = [task for task in tasks if task.partition.name not in parts]
        # The largest first, so that no processor waits long for the last one.
        missing.sort(key=lambda task: (-task.partition.rows, task.partition.name))
        done_rows, all_rows = kept_rows, sum(partition.rows for partition in corpus.partitions)
        failures: dict[str, str] = {}
        watch(Tally(kept, len(tasks), done_rows, all_rows, kept_rows))
        if missing:
            with executor.start() as crew:
                crew.require_shared([corpus.path.resolve(), folder])
                for task, answer in crew.as_done(do_task, missing):
                    name = task.partition.name
                    if isinstance(answer, Failed):
                        failures[name] = answer.reason
                    else:
                        parts[name] = answer
                    done_rows += task.partition.rows
                    done = len(parts) + len(failures)
                    watch(Tally(done, len(tasks), done_rows, all_rows, kept_rows))
    order = [task.partition.name for task in tasks]
    return Outcome(
        tuple(parts[name] for name in order if name in parts),
        {name: failures[name] for name in order if name in failures},
        kept,
    )


@contextmanager
def claimed_results(results: Path, name: str) -> Generator[None]:
    """Hold a results folder, so that no other run works on it; it may be held twice by one.

    Parameters
    ----------
    results
        The folder; it is made where it is missing.
    name
        Of the job.

    Raises
    ------
    ConfigError
        Where it holds other files or the results of another job, or another run holds it.
    """
    try:
        _require_own(results, name)
        results.mkdir(parents=True, exist_ok=True)
        lock = FileLock(results.resolve() / _LOCK_FILE, is_singleton=True)
        lock.acquire(timeout=0)
    except Timeout as error:
        raise ConfigError(
            f"another modelcast {name} is writing to {results}: wait for it, or name another output folder"
        ) from error
    except OSError as error:
        raise ConfigError(f"{results} cannot be written into: {error.strerror or error}") from error
    try:
        mark = {"format": _FORMAT, "job": name}
        (results / _MARK_FILE).write_text(json.dumps(mark) + "\n", encoding="utf-8", newline="\n")
        yield
    finally:
        lock.release()


def _require_own(results: Path, name: str) -> None:
    """Refuse a folder that is not a job's."""
    if not results.exists() or (results.is_dir() and not set(results.iterdir()) - {results / _LOCK_FILE}):
        return
    mark: object = None
    with suppress(OSError, ValueError):
        mark = json.loads((results / _MARK_FILE).read_text(encoding="utf-8"))
    if mark != {"format": _FORMAT, "job": name}:
        raise ConfigError(
            f"{results} is no folder of unfinished work of modelcast {name}: move it away, or name another "
            "output folder"
        )
