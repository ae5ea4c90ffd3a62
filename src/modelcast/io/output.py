"""Output folders that appear whole or not at all.

A command writes into a temporary folder beside the one the user named; only a command that succeeds renames
it. A list of the files written, `MANIFEST`, goes with it: a later run replaces a folder only where that list
names every file in it, so a file the user put there is never lost.
"""

import os
import shutil
import tempfile
from collections.abc import Generator
from contextlib import contextmanager
from itertools import count
from pathlib import Path

from modelcast.core.exceptions import ConfigError

__all__ = ["MANIFEST", "atomic_folder", "claimed_file"]

MANIFEST = "MANIFEST.txt"
"""Name of the file that lists what modelcast wrote into a folder, one relative path a line."""

_SHOWN = 3


@contextmanager
def atomic_folder(path: str | Path) -> Generator[Path]:
    """Yield a temporary folder that takes the place of `path` when the block ends without an error.

    Parameters
    ----------
    path
        The output folder. Missing parents are created. An empty folder, or one an earlier run wrote, is
        replaced.

    Yields
    ------
    Path
        The folder to write into, beside `path`.

    Raises
    ------
    ConfigError
        Where `path` is a file, is the working folder, or holds files that modelcast did not write. It is
        raised before the block runs, and again after it if such a file has appeared meanwhile.

    Notes
    -----
    An error or an interrupt in the block removes the temporary folder and leaves the old output as it was.

    Examples
    --------
    >>> import tempfile
    >>> target = Path(tempfile.mkdtemp()) / "out"
    >>> with atomic_folder(target) as folder:
    ...     _ = (folder / "a.txt").write_text("a")
    >>> sorted(item.name for item in target.iterdir())
    ['MANIFEST.txt', 'a.txt']
    """
    # A link is followed, so that its target is replaced and not the link.
    target = Path(path).resolve()
    _require_replaceable(target, shown=str(path))
    target.parent.mkdir(parents=True, exist_ok=True)
    partial = _new_sibling(target, "partial")
    try:
        yield partial
        names = _files(partial)
        (partial / MANIFEST).write_text(
            "".join(f"{name}\n" for name in names), encoding="utf-8", newline="\n"
        )
        _require_replaceable(target, shown=str(path))
        _swap(partial, target)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


@contextmanager
def claimed_file(path: str | Path) -> Generator[Path]:
    """Yield a temporary file that takes the place of `path` when the block ends without an error.

    Parameters
    ----------
    path
        The output file; a link is followed, so that its target is replaced.

    Yields
    ------
    Path
        The file to write into, beside `path`; it is there already, so what cannot be written is known before
        the work is done.

    Raises
    ------
    ConfigError
        Where `path` is a folder or another thing that is no ordinary file, its folder does not exist, or
        nothing can be written there.
    """
    target = Path(path).resolve()
    if target.is_dir():
        raise ConfigError(f"{path} is a folder: name a file in it")
    if target.exists() and not target.is_file():
        raise ConfigError(f"{path} is no ordinary file: name another")
    if target.exists() and not os.access(target, os.W_OK):
        raise ConfigError(f"{path} cannot be written: it is read-only")
    if not target.parent.is_dir():
        raise ConfigError(f"{path}: its folder does not exist")
    try:
        # Made anew under a name that nobody could know: a link that somebody put there is not followed.
        descriptor, name = tempfile.mkstemp(prefix=f".{target.name}.", suffix=".partial", dir=target.parent)
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error.strerror}") from error
    os.close(descriptor)
    partial = Path(name)
    try:
        yield partial
        partial.chmod(target.stat().st_mode if target.exists() else 0o666 & ~_umask())
        partial.replace(target)
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error.strerror}") from error
    finally:
        partial.unlink(missing_ok=True)


def _umask() -> int:
    """Permissions that new files do not get; the system tells them only when they are set."""
    found = os.umask(0o077)
    os.umask(found)
    return found


def _new_sibling(target: Path, purpose: str) -> Path:
    """Return a new empty folder beside `target`, with the permissions any new folder has."""
    for number in count():
        sibling = target.with_name(f".{target.name}.{purpose}-{os.getpid()}-{number}")
        try:
            sibling.mkdir()
        except FileExistsError:
            continue
        return sibling
    raise AssertionError  # count() does not end


def _files(folder: Path) -> list[str]:
    """Return the relative paths of everything but folders below `folder`, sorted."""
    found = (item for item in folder.rglob("*") if item.is_symlink() or not item.is_dir())
    return sorted(item.relative_to(folder).as_posix() for item in found)


def _require_replaceable(target: Path, *, shown: str) -> None:
    if not target.exists():
        return
    if not target.is_dir():
        raise ConfigError(f"{shown} is a file, not a folder: name another output folder")
    if Path.cwd().is_relative_to(target):
        raise ConfigError(f"{shown} is the working folder or holds it: name a folder inside it")
    manifest = target / MANIFEST
    known = {MANIFEST}
    if manifest.is_file():
        known.update(manifest.read_text(encoding="utf-8").splitlines())
    foreign = [name for name in _files(target) if name not in known or not manifest.is_file()]
    if foreign:
        more = f" and {len(foreign) - _SHOWN} more" if len(foreign) > _SHOWN else ""
        raise ConfigError(
            f"{shown} holds files that modelcast did not write ({', '.join(foreign[:_SHOWN])}{more}): "
            "move them away or name another output folder"
        )


def _swap(partial: Path, target: Path) -> None:
    """Rename `partial` to `target`; where that fails, the old folder is put back."""
    if not target.exists():
        partial.rename(target)
        return
    parked = _new_sibling(target, "old")
    target.replace(parked)
    try:
        partial.rename(target)
    except OSError:
        parked.replace(target)
        raise
    shutil.rmtree(parked, ignore_errors=True)
