"""Runs that are done before their command is: kept beside its output folder until that appears.

An output folder appears whole or not at all, but a sweep may take hours. So each run is written, as soon as
it is done, into the folder ``.NAME.runs`` beside the output folder ``NAME``. The next call takes up what it
finds there and in the output folder; when a call has ended well the folder goes. One call at a time works on
an output folder: the kernel holds a lock for as long as the process lives.
"""

import shutil
from collections.abc import Generator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from modelcast.core.exceptions import ConfigError
from modelcast.io.network_runs import RunKey, read_case, run_path, write_case
from modelcast.study.network.rows import CaseResult, NetworkCase

__all__ = ["RunStore", "run_store"]

_RUNS = "runs"
_LOCK = "lock"


@dataclass(frozen=True, slots=True)
class RunStore:
    """Where the runs of one output folder are.

    Parameters
    ----------
    done
        The runs of the output folder.
    unfinished
        Those that no finished call has taken over.
    options, key
        What they are run with.
    """

    done: Path
    unfinished: Path
    options: Mapping[str, Any]
    key: RunKey

    def find(self, case: NetworkCase) -> CaseResult | None:
        """Return the rows of a run that is done, None where it is not.

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
        found = read_case(case, self.options, self.key, self.done)
        if found is not None:
            return found
        with suppress(ConfigError):
            return read_case(case, self.options, self.key, self.unfinished)
        return None

    def keep(self, case: NetworkCase, result: CaseResult) -> None:
        """Write a run that has just been done.

        Parameters
        ----------
        case, result
            The run and its rows.
        """
        write_case(result, case, self.options, self.key, self.unfinished)

    def publish(self, results: Mapping[NetworkCase, CaseResult], folder: Path) -> None:
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
            if not run_path(case, self.key, runs).exists():
                write_case(result, case, self.options, self.key, runs)


@contextmanager
def run_store(out: str | Path, options: Mapping[str, Any], key: RunKey) -> Generator[RunStore]:
    """Yield the runs of an output folder; what the call wrote for later goes when the block ends well.

    Parameters
    ----------
    out
        The output folder.
    options, key
        What runs are run with.

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
            f"another modelcast network is writing to {out}: wait for it, or name another output folder"
        ) from error
    try:
        for partial in unfinished.glob("*.partial-*"):
            partial.unlink(missing_ok=True)
        yield RunStore(target / _RUNS, unfinished, options, key)
        for path in unfinished.glob("*.json"):
            path.unlink(missing_ok=True)
    finally:
        # Where runs are left they wait for the next call.
        with suppress(OSError):
            if not any(unfinished.glob("*.json")):
                (unfinished / _LOCK).unlink(missing_ok=True)
                unfinished.rmdir()
        lock.release()
