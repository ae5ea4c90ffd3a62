"""Outputs that appear whole or not at all, files and folders alike.

A command writes into a temporary sibling of what the user named; only a command that succeeds renames it. An
error or an interrupt removes it and leaves the old output as it was; after a kill the next run to the same
place does (`modelcast.io.partial`). Of several runs to one place at a time, the one that ends last wins, and
its output is whole.
"""

import errno
import os
import shutil
import stat
from collections.abc import Callable, Generator, Iterable
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from modelcast.core.exceptions import ConfigError
from modelcast.core.refusals import is_full, refusal
from modelcast.io.manifest import require_replaceable, write_manifest
from modelcast.io.partial import clean_leftovers, old_sibling, partial_file, partial_folder

__all__ = [
    "atomic_file",
    "atomic_folder",
    "lasting_rename",
    "require_apart",
    "require_writable",
    "written_into",
]

_TAKEN = frozenset({errno.EEXIST, errno.ENOTEMPTY})


@contextmanager
def atomic_folder(
    path: str | Path, *, command: str | None = None, shown: str | None = None
) -> Generator[Path]:
    """Yield a temporary folder that takes the place of `path` when the block ends without an error.

    Parameters
    ----------
    path
        The output folder. Missing parents are created. An empty folder, or one an earlier run wrote, is
        replaced.
    command
        Name of the command that writes; it does not replace the result of another.
    shown
        What errors call the folder; `path` where None.

    Yields
    ------
    Path
        The folder to write into, beside `path`.

    Raises
    ------
    ConfigError
        Where `path` is a file, is the working folder, holds files that modelcast did not write, or holds the
        result of another command. It is raised before the block runs, and again after it if such a file has
        appeared meanwhile. Also where there is no room for what the block writes.

    Notes
    -----
    An error or an interrupt in the block removes the temporary folder, and the parents made for it, and
    leaves the old output as it was.

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
    target, told, shown = Path(path).resolve(), shown, shown or str(path)
    clean_leftovers(target)
    require_replaceable(target, command, shown=shown)
    missing = [folder for folder in target.parents if not folder.exists()]
    written: os.stat_result | None = None
    try:
        with ExitStack() as stack:
            try:
                partial = stack.enter_context(partial_folder(target))
            except OSError as error:
                raise ConfigError(f"{shown} cannot be written: {refusal(error)}") from error
            yield partial
            write_manifest(partial, command)
            _sync_tree(partial)
            written = partial.stat()
            _place(partial, target, command, shown=shown)
            _sync(target.parent)
    except BaseException as error:
        for folder in missing:
            with suppress(OSError):
                folder.rmdir()
        _note_left(error, target, told, written)
        if isinstance(error, OSError) and is_full(error):  # whoever wrote named no file, or the temporary one
            raise ConfigError(f"{shown} cannot be written: {refusal(error)}") from error
        raise


def _note_left(error: BaseException, target: Path, told: str | None, written: os.stat_result | None) -> None:
    """Have an interrupt say what an output is that errors have a name for: not there, the old one, or whole.

    Parameters
    ----------
    error
        What ends the writing.
    target, told
        The output, and what errors call it.
    written
        What takes its place once it is whole; None before.
    """
    if isinstance(error, KeyboardInterrupt) and told is not None:
        found = target.stat() if target.exists() else None
        if found is None:
            error.add_note(f"{told} is not written")
        elif written is not None and os.path.samestat(found, written):
            error.add_note(f"{told} is written")
        else:
            error.add_note(f"{told} is as it was")


@contextmanager
def atomic_file(
    path: str | Path, *, inputs: Iterable[str | Path] = (), shown: str | None = None
) -> Generator[BinaryIO]:
    """Yield a temporary file, open for writing, that takes the place of `path` when the block ends well.

    Parameters
    ----------
    path
        The output file, in a folder that exists. An older file is replaced; its permissions are kept. A link
        is followed, so that its target is replaced and not the link.
    inputs
        Files and folders that are read meanwhile: none of them is replaced.
    shown
        What errors call the file; `path` where None.

    Raises
    ------
    ConfigError
        Where `path` is a folder, a device or a pipe, its folder does not exist, it is one of the inputs, or
        it cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> target = Path(tempfile.mkdtemp()) / "a.txt"
    >>> with atomic_file(target) as file:
    ...     _ = file.write(b"a")
    ...     target.exists()
    False
    >>> [item.name for item in target.parent.iterdir()]
    ['a.txt']
    """
    target, told, shown = require_writable(path, shown=shown), shown, shown or str(path)
    require_apart(path, inputs, shown=shown)
    clean_leftovers(target)
    written: os.stat_result | None = None
    try:
        with partial_file(target) as (partial, descriptor):
            with os.fdopen(descriptor, "wb", closefd=False) as file:
                yield file
            os.fsync(descriptor)
            if os.name == "nt":  # where an open file cannot be renamed
                os.close(descriptor)
            with suppress(OSError):
                partial.chmod(stat.S_IMODE(target.stat().st_mode))
            written = partial.stat()
            partial.replace(target)
            _sync(target.parent)
    except BrokenPipeError:
        raise
    except OSError as error:
        raise ConfigError(f"{shown} cannot be written: {refusal(error)}") from error
    except KeyboardInterrupt as error:
        _note_left(error, target, told, written)
        raise


def written_into(path: str | Path, write: Callable[[Path], Iterable[Path]]) -> list[Path]:
    """Have files written into a folder, where each is whole; return their paths.

    Parameters
    ----------
    path
        The folder; it and its parents are made where they are missing. Files in it that are not written now
        stay.
    write
        Is given a temporary folder in `path` to write into, and returns what it wrote there.

    Raises
    ------
    ConfigError
        Where it is a file, or the operating system refuses to make it or to write into it.

    Notes
    -----
    Files take their places when all are written: an error or an interrupt while they are leaves those that
    were there. An interrupt between two renamings leaves one file of old and another of now.

    Examples
    --------
    >>> import tempfile
    >>> target = Path(tempfile.mkdtemp()) / "a" / "b"
    >>> def write(folder: Path) -> list[Path]:
    ...     (folder / "c.txt").write_text("c")
    ...     return [folder / "c.txt"]
    >>> written_into(target, write) == [target / "c.txt"] == list(target.iterdir())
    True
    """
    folder = Path(path)
    stem = folder / "output"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        clean_leftovers(stem)
        with partial_folder(stem) as partial:
            written = [folder / one.relative_to(partial) for one in write(partial)]
            _sync_tree(partial)
            _move_into(folder, partial)
    except OSError as error:
        why = "it is a file" if folder.is_file() else refusal(error).rstrip(".")
        raise ConfigError(f"{path} cannot be written into: {why}: name another folder") from error
    return written


def _move_into(target: Path, source: Path) -> None:
    """Rename all that is in a folder into another one, where files of the same name are replaced."""
    for item in sorted(source.iterdir()):
        place = target / item.name
        if item.is_dir() and place.is_dir():
            _move_into(place, item)
        else:
            item.replace(place)
    _sync(target)


def lasting_rename(partial: Path, target: Path) -> None:
    """Rename a folder so that a crash of the machine leaves it whole, or not there at all.

    Parameters
    ----------
    partial
        A folder whose files are closed.
    target
        Its new name on the same file system, which is free.
    """
    _sync_tree(partial)
    partial.rename(target)
    _sync(target.parent)


def require_writable(path: str | Path, *, shown: str | None = None) -> Path:
    """Return an output file's place, with links followed, or refuse it before the work is done.

    Parameters
    ----------
    path
        The output file.
    shown
        What errors call it; `path` where None.

    Raises
    ------
    ConfigError
        Where it is a folder, a device or a pipe, or its folder does not exist or takes no new file.
    """
    shown = shown or str(path)
    try:
        target = Path(path).resolve()
        folder = target.parent
        if not folder.is_dir():
            raise ConfigError(f"{shown}: its folder does not exist: make it, or name another file")
        if target.exists() and not target.is_file():
            kind = "a folder" if target.is_dir() else "a device or a pipe"
            raise ConfigError(f"{shown} is {kind}, not a file: name another file")
    except (OSError, RuntimeError) as error:  # a loop of links is a RuntimeError before Python 3.13
        raise ConfigError(f"{shown} cannot be written: {error}") from error
    if not os.access(folder, os.W_OK):
        raise ConfigError(f"{shown}: its folder cannot be written to: name another file")
    return target


def require_apart(path: str | Path, inputs: Iterable[str | Path], *, shown: str | None = None) -> None:
    """Refuse an output file that is one of the inputs, by whatever name, link or hard link.

    Parameters
    ----------
    path
        The output file.
    inputs
        Files and folders; of a folder all files count.
    shown
        What errors call the output file; `path` where None.

    Raises
    ------
    ConfigError
        Where it is one of them.
    """
    with suppress(OSError):
        target = Path(path).stat()
        for given in map(Path, inputs):
            for file in (given, *(given.rglob("*") if given.is_dir() else ())):
                with suppress(OSError):
                    if os.path.samestat(file.stat(), target):
                        raise ConfigError(
                            f"{shown or path} is the input {file}, which is never replaced: name another file"
                        )


def _place(partial: Path, target: Path, command: str | None, *, shown: str) -> None:
    """Rename `partial` to `target`; where that fails, or is interrupted, the old folder is put back."""
    old = old_sibling(partial)
    while True:
        require_replaceable(target, command, shown=shown)
        try:
            with suppress(FileNotFoundError):
                partial.chmod(stat.S_IMODE(target.stat().st_mode))
                target.rename(old)
            partial.rename(target)
        except BaseException as error:
            if old.exists() and not target.exists():
                old.rename(target)
            # Where another run's output has taken the place meanwhile, that one is replaced.
            if not (isinstance(error, OSError) and error.errno in _TAKEN):
                raise
        else:
            return
        finally:
            if target.exists():
                shutil.rmtree(old, ignore_errors=True)


def _sync_tree(folder: Path) -> None:
    """Have the operating system write a folder out: a crash after the renaming then loses nothing."""
    for item in folder.rglob("*"):
        _sync(item)
    _sync(folder)


def _sync(path: Path) -> None:
    if os.name != "posix":  # elsewhere a file opened for reading cannot be synced
        return
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
