"""Runs that are done before their command is: kept beside its output folder until that appears.

An output folder appears whole or not at all, but a sweep may take hours. So each run is written, as soon as
it is done, into the folder ``.NAME.runs`` beside the output folder ``NAME``. The next call takes up what it
finds there and in the output folder; when a call has ended well the folder goes. One call at a time works on
an output folder: the kernel holds a lock for as long as the process lives.
"""

import os
import shutil
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Generator, Iterable, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from glob import escape
from pathlib import Path
from typing import Any, Generic, TypeVar, cast

from filelock import FileLock, Timeout

from modelcast.core.exceptions import ConfigError
from modelcast.core.printable import printable
from modelcast.core.rules import Table, Text, check
from modelcast.io.documents import document_text

__all__ = ["AbstractRunFiles", "RunStore", "run_store", "write_run_file", "written_inputs"]

Case = TypeVar("Case")
Result = TypeVar("Result")

_RUNS = "runs"
_LOCK = "lock"


class AbstractRunFiles(ABC, Generic[Case, Result]):
    """How the runs of a command are written, and read again where nothing they depend on has changed."""

    @abstractmethod
    def path(self, case: Case, folder: Path) -> Path:
        """Where a run is; what it depends on is part of the name.

        Parameters
        ----------
        case, folder
            The run, and the folder of all.
        """

    @abstractmethod
    def read(self, case: Case, folder: Path) -> Result | None:
        """What a run gave, None where it is not done.

        Parameters
        ----------
        case, folder
            As for `path`.

        Raises
        ------
        ConfigError
            Where the file is damaged, or of a run with other options.
        """

    @abstractmethod
    def write(self, case: Case, result: Result, folder: Path) -> None:
        """Write what a run gave; the file appears whole or not at all.

        Parameters
        ----------
        case, result, folder
            The run, its result, and an existing folder.
        """

    @abstractmethod
    def inputs(self, case: Case) -> Mapping[str, str]:
        """What a run depends on beside its options: a hash or version each, by name.

        Parameters
        ----------
        case
            The run.
        """

    @abstractmethod
    def inputs_in(self, path: Path) -> Mapping[str, str]:
        """The same of the run in a file, as it was written.

        Parameters
        ----------
        path
            The file.

        Raises
        ------
        ConfigError
            Where it is damaged.
        """


@dataclass(frozen=True, slots=True)
class RunStore(Generic[Case, Result]):
    """Where the runs of one output folder are.

    Parameters
    ----------
    done
        The runs of the output folder.
    unfinished
        Those that no finished call has taken over.
    files
        How they are written and read.
    """

    done: Path
    unfinished: Path
    files: AbstractRunFiles[Case, Result]

    def find(self, case: Case) -> Result | None:
        """Return what a run gave that is done, None where it is not.

        Of runs whose call never ended, those with other options or damaged are dropped.

        Parameters
        ----------
        case
            The run.

        Raises
        ------
        ConfigError
            Where the output folder holds it with other options, or damaged.
        """
        found = self.files.read(case, self.done)
        if found is not None:
            return found
        with suppress(ConfigError):
            return self.files.read(case, self.unfinished)
        return None

    def outdated(self, cases: Iterable[Case]) -> list[str]:
        """Why runs are not taken up that were done before, one line a reason.

        Parameters
        ----------
        cases
            Those that have to be run.
        """
        reasons = Counter(reason for case in cases if (reason := self._changed(case)))
        return [
            f"{count} {'run is' if count == 1 else 'runs are'} not taken up again: {reason}"
            for reason, count in reasons.items()
        ]

    def _changed(self, case: Case) -> str:
        """In what a run differs from that of its name that is most like it; empty where there is none."""
        wanted, now = self.files.path(case, self.done), self.files.inputs(case)
        pattern = escape(wanted.name.rpartition("-")[0]) + "-*.json"
        found: list[list[str]] = []
        for path in sorted((*self.done.glob(pattern), *self.unfinished.glob(pattern))):
            with suppress(ConfigError):
                before = self.files.inputs_in(path)
                names = dict.fromkeys((*now, *before))
                changed = [name for name in names if before.get(name) != now.get(name)]
                found.append([_change(name, before, now) for name in changed])
        return "; ".join(min(found, key=len)) if found else ""

    def keep(self, case: Case, result: Result) -> None:
        """Write a run that has just been done.

        Parameters
        ----------
        case, result
            The run and what it gave.
        """
        self.files.write(case, result, self.unfinished)

    def publish(self, results: Mapping[Case, Result], folder: Path) -> None:
        """Write runs into an output folder that is about to appear, beside those of earlier calls.

        Parameters
        ----------
        results
            The runs of this call.
        folder
            An existing folder.
        """
        runs = folder / _RUNS
        runs.mkdir()
        if self.done.is_dir():
            for path in sorted(self.done.glob("*.json")):
                if path.is_file():
                    shutil.copy2(path, runs / path.name)
        for case, result in results.items():
            if not self.files.path(case, runs).exists():
                self.files.write(case, result, runs)


_SHA256_LENGTH = 64
_LONGEST_INPUT, _MOST_INPUTS = 1000, 100_000


_INPUTS = Table(Text(_LONGEST_INPUT), _MOST_INPUTS)


def written_inputs(path: Path, version: object, inputs: object) -> dict[str, str]:
    """Return checked inputs that a run's file holds, the version of modelcast among them.

    Parameters
    ----------
    path
        The file, for errors.
    version, inputs
        As read.

    Raises
    ------
    ConfigError
        Where they are none.
    """
    try:
        check(version, Text(_LONGEST_INPUT), "modelcast")
        check(inputs, _INPUTS, "inputs")
    except ValueError as error:
        raise ConfigError(f"{path} is no run of modelcast: {error}: remove it") from error
    return {"modelcast": cast("str", version), **cast("dict[str, str]", inputs)}


def _change(name: str, before: Mapping[str, str], now: Mapping[str, str]) -> str:
    """How an input differs, as a user reads it: versions by what they are, hashes not."""
    was, found = (printable(given[name]) if name in given else "none" for given in (before, now))
    shown = printable(name)
    if _SHA256_LENGTH in {len(was), len(found)}:
        return f"{shown} has changed"
    return f"{shown} was {was}, is {found}"


def write_run_file(document: Mapping[str, Any], path: Path) -> None:
    """Write what a run gave; the file appears whole or not at all.

    Parameters
    ----------
    document
        Its content, as plain values.
    path
        Where to, in an existing folder; what an interrupted call leaves there goes with the next.
    """
    partial = path.with_suffix(f".partial-{os.getpid()}")
    try:
        partial.write_text(document_text(document), encoding="utf-8", newline="\n")
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


@contextmanager
def run_store(
    out: str | Path, files: AbstractRunFiles[Case, Result], *, command: str
) -> Generator[RunStore[Case, Result]]:
    """Yield the runs of an output folder; what the call wrote for later goes when the block ends well.

    Parameters
    ----------
    out
        The output folder.
    files
        How runs are written and read.
    command
        Who writes them, as in ``modelcast network``.

    Raises
    ------
    ConfigError
        Where another call works on the same folder.
    """
    target = Path(out).resolve()
    unfinished = target.with_name(f".{target.name}.runs")
    unfinished.mkdir(parents=True, exist_ok=True)
    lock = FileLock(unfinished / _LOCK)
    try:
        lock.acquire(timeout=0)
    except Timeout as error:
        raise ConfigError(
            f"another modelcast {command} is writing to {out}: wait for it, or name another output folder"
        ) from error
    try:
        for partial in unfinished.glob("*.partial-*"):
            partial.unlink(missing_ok=True)
        yield RunStore(target / _RUNS, unfinished, files)
        for path in unfinished.glob("*.json"):
            path.unlink(missing_ok=True)
    except KeyboardInterrupt as error:
        kept = sum(1 for _ in unfinished.glob("*.json"))
        if kept:
            runs = "1 run is" if kept == 1 else f"{kept} runs are"
            error.add_note(f"{runs} kept: the same command goes on from there")
        raise
    finally:
        # Where runs are left they wait for the next call.
        with suppress(OSError):
            if not any(unfinished.glob("*.json")):
                (unfinished / _LOCK).unlink(missing_ok=True)
                unfinished.rmdir()
        lock.release()
