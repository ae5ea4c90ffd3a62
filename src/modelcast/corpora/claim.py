"""The folder an ingest writes into: new, empty, or an unfinished corpus of the same plan; held by one run."""

import json
import shutil
from collections.abc import Generator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from filelock import BaseFileLock, FileLock, Timeout

from modelcast.core.exceptions import ConfigError
from modelcast.corpora.layout import CORPUS_FILE, UNFINISHED, is_corpus
from modelcast.io.output import atomic_file

__all__ = ["STAGING", "claimed", "cleared"]

STAGING = "staging"
"""Folder in an unfinished corpus of what was read and is not yet packed."""

_LOCK = "ingest.lock"
_OURS = (_LOCK, f".{UNFINISHED}.partial-")
"""How entries begin that a run leaves which is killed before it could say what it is."""


@contextmanager
def claimed(folder: Path, plan: Mapping[str, Any], *, shown: str) -> Generator[None]:
    """Hold a folder, with the plan of what it is to become in it.

    Parameters
    ----------
    folder
        The folder, with links followed.
    plan
        Plain values; an unfinished corpus of another plan is refused.
    shown
        What errors call the folder.

    Raises
    ------
    ConfigError
        Where the folder is a file, holds anything else, is a finished corpus or one of another plan, cannot
        be written, or another process holds it.
    """
    try:
        if folder.exists() and not folder.is_dir():
            raise ConfigError(f"{shown} is a file: name a folder")
        if folder.is_dir() and _foreign(folder):
            raise ConfigError(f"{shown} is not empty and no corpus: name another folder")
        folder.mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / _LOCK)
        lock.acquire(timeout=0)
    except Timeout as error:
        raise ConfigError(f"another ingest is writing to {shown}: wait for it") from error
    except OSError as error:
        raise ConfigError(f"{shown} cannot be written to: {error.strerror or error}") from error
    try:
        _require_plan(folder, plan, shown=shown)
        with atomic_file(folder / UNFINISHED) as file:
            file.write(json.dumps(plan).encode())
        yield
    except KeyboardInterrupt as error:
        if (folder / STAGING).is_dir():
            error.add_note(f"what is read is kept in {shown}: the same command goes on from there")
        raise
    finally:
        _given_up(lock, folder / _LOCK)
        with suppress(OSError):
            folder.rmdir()  # where nothing came of it


def cleared(folder: Path) -> None:
    """Remove what only an unfinished corpus needs.

    Parameters
    ----------
    folder
        The folder, held.
    """
    shutil.rmtree(folder / STAGING, ignore_errors=True)
    (folder / UNFINISHED).unlink(missing_ok=True)


def _given_up(lock: BaseFileLock, file: Path) -> None:
    """Remove a lock's file and release it, in this order.

    Else another run could take the lock in between, on a file that is then removed, and a third one on a new
    file.
    """
    try:
        file.unlink(missing_ok=True)
    except OSError:  # where an open file cannot be removed
        lock.release()
        with suppress(OSError):
            file.unlink(missing_ok=True)
    else:
        lock.release()


def _foreign(folder: Path) -> bool:
    """Whether a folder holds what no ingest has left there."""
    return not is_corpus(folder) and any(not one.name.startswith(_OURS) for one in folder.iterdir())


def _require_plan(folder: Path, plan: Mapping[str, Any], *, shown: str) -> None:
    """Refuse a folder that has become, or is to become, another corpus."""
    if (folder / CORPUS_FILE).is_file():
        cleared(folder)  # of a run that was killed when all was done
        raise ConfigError(
            f"{shown} is a finished corpus, which is never changed: name another folder, or remove it"
        )
    unfinished = folder / UNFINISHED
    if unfinished.is_file() and json.loads(unfinished.read_text(encoding="utf-8")) != plan:
        raise ConfigError(
            f"{shown} is an unfinished corpus of other sources or settings: name the same ones to go on "
            "with it, or another folder, or remove it"
        )
