"""Temporary files and folders beside an output, and what killed runs leave of them.

A run that writes ``NAME`` fills ``.NAME.partial-TOKEN`` in the same folder, with a random token; an old
output folder is called ``.NAME.old-TOKEN`` for the moment in which the new one takes its place. The kernel
holds a lock (flock) on the partial for as long as its process lives. So a partial whose lock can be had
belongs to a run that is dead, and the next run to the same place removes it, or puts the old folder back
where the killed run had just moved it away. Nothing else is touched: no other name, no link, no file of
another user, nothing where locks are not to be had (some network file systems, Windows).
"""

import os
import re
import secrets
import shutil
import stat
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path

from modelcast.io.manifest import foreign_files

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

__all__ = ["clean_leftovers", "old_sibling", "partial_file", "partial_folder"]

_TOKEN_BYTES = 8
_PARTIAL, _OLD = "partial", "old"
_NEW_FILE = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
_SEEN = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)


@contextmanager
def partial_folder(target: Path) -> Generator[Path]:
    """Yield a new empty folder beside `target`; it is removed at the end where it has not been renamed.

    Parameters
    ----------
    target
        The output folder; missing parents are made.
    """
    while True:
        path = _sibling(target, _PARTIAL, secrets.token_hex(_TOKEN_BYTES))
        target.parent.mkdir(parents=True, exist_ok=True)
        with suppress(FileExistsError):
            try:
                path.mkdir()
            except FileNotFoundError:
                if target.parent.is_dir():  # it is there and takes no folder, as in /proc
                    raise
                continue
            lock = _locked_folder(path)
            if lock is not None:
                break
    try:
        yield path
    finally:
        shutil.rmtree(path, ignore_errors=True)
        if lock >= 0:
            os.close(lock)


@contextmanager
def partial_file(target: Path) -> Generator[tuple[Path, int]]:
    """Yield a new empty file beside `target` and its descriptor; it is removed where it was not renamed.

    Parameters
    ----------
    target
        The output file; its folder exists.
    """
    while True:
        path = _sibling(target, _PARTIAL, secrets.token_hex(_TOKEN_BYTES))
        try:
            descriptor = os.open(path, _NEW_FILE, 0o666)
        except FileExistsError:
            continue
        _lock(descriptor, wait=True)
        if _is_at(path, descriptor):
            break
        os.close(descriptor)
    try:
        yield path, descriptor
    finally:
        with suppress(OSError):
            if _is_at(path, descriptor):
                path.unlink()
        with suppress(OSError):
            os.close(descriptor)


def old_sibling(partial: Path) -> Path:
    """Return where the old output stands while the partial takes its place.

    Parameters
    ----------
    partial
        The temporary folder.
    """
    head, _, token = partial.name.rpartition(f".{_PARTIAL}-")
    return partial.with_name(f"{head}.{_OLD}-{token}")


def clean_leftovers(target: Path) -> None:
    """Remove what killed runs left beside an output, and put an old folder back where it is missing.

    Parameters
    ----------
    target
        The output file or folder, with links followed.
    """
    name = re.compile(rf"\.{re.escape(target.name)}\.(?:{_PARTIAL}|{_OLD})-([0-9a-f]{{{2 * _TOKEN_BYTES}}})")
    with suppress(OSError):
        found = (name.fullmatch(entry.name) for entry in os.scandir(target.parent))
        for token in {match[1] for match in found if match}:
            _clean(target, _sibling(target, _PARTIAL, token), _sibling(target, _OLD, token))


def _clean(target: Path, partial: Path, old: Path) -> None:
    """Clean after one run, where it is dead."""
    with _dead(partial) as ours:
        if not ours:
            return
        if _is_own_folder(old):
            if not target.exists():
                with suppress(OSError):
                    old.rename(target)
            elif not foreign_files(old):
                shutil.rmtree(old, ignore_errors=True)
        if partial.is_dir():
            shutil.rmtree(partial, ignore_errors=True)
        else:
            partial.unlink(missing_ok=True)


@contextmanager
def _dead(partial: Path) -> Generator[bool]:
    """Yield whether no run holds a partial any more; nobody can take it meanwhile."""
    try:
        descriptor = os.open(partial, _SEEN)
    except FileNotFoundError:
        yield fcntl is not None  # the run renamed it, then died
        return
    except OSError:
        yield False
        return
    try:
        mode = os.fstat(descriptor).st_mode
        plain = stat.S_ISREG(mode) or stat.S_ISDIR(mode)
        yield (
            plain and _is_own(descriptor) and _lock(descriptor, wait=False) and _is_at(partial, descriptor)
        )
    finally:
        os.close(descriptor)


def _sibling(target: Path, purpose: str, token: str) -> Path:
    return target.with_name(f".{target.name}.{purpose}-{token}")


def _locked_folder(path: Path) -> int | None:
    """Return a descriptor that holds the folder's lock, -1 where there are none, None where it is gone."""
    if fcntl is None:
        return -1
    descriptor = os.open(path, _SEEN)
    _lock(descriptor, wait=True)
    if _is_at(path, descriptor):
        return descriptor
    os.close(descriptor)
    return None


def _lock(descriptor: int, *, wait: bool) -> bool:
    """Take the lock of an open file, which ends with the process; return whether it was to be had."""
    if fcntl is None:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except OSError:
        return False
    return True


def _is_at(path: Path, descriptor: int) -> bool:
    """Return whether a path still names an open file."""
    try:
        return os.path.samestat(path.stat(follow_symlinks=False), os.fstat(descriptor))
    except OSError:
        return False


def _is_own(descriptor: int) -> bool:
    return not hasattr(os, "getuid") or os.fstat(descriptor).st_uid == os.getuid()


def _is_own_folder(path: Path) -> bool:
    """Return whether a path is a folder of this user's, and no link."""
    try:
        descriptor = os.open(path, _SEEN)
    except OSError:
        return False
    try:
        return stat.S_ISDIR(os.fstat(descriptor).st_mode) and _is_own(descriptor)
    finally:
        os.close(descriptor)
