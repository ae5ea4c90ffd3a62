"""The list of what modelcast wrote into a folder, and by which command.

`MANIFEST` has one relative path a line, after a line ``# modelcast COMMAND``. A later run of the same command
replaces a folder only where that list names every file in it: what a user put there is never lost, and no
command replaces the result of another.
"""

from collections.abc import Sequence
from pathlib import Path

from modelcast.core.exceptions import ConfigError

__all__ = ["MANIFEST", "foreign_files", "require_replaceable", "write_manifest"]

MANIFEST = "MANIFEST.txt"
"""Name of the file that lists what modelcast wrote into a folder, one relative path a line."""

_COMMAND = "# modelcast "
_SHOWN = 3


def write_manifest(folder: Path, command: str | None) -> None:
    """Write the list of all files now in a folder.

    Parameters
    ----------
    folder
        An existing folder.
    command
        Name of the command that wrote them; None for no command.
    """
    lines = [*([f"{_COMMAND}{command}"] if command else []), *_files(folder)]
    text = "".join(f"{line}\n" for line in lines)
    (folder / MANIFEST).write_bytes(text.encode("utf-8", errors="surrogateescape"))


def foreign_files(folder: Path) -> Sequence[str]:
    """Return the relative paths of the files in a folder that its manifest does not name.

    Parameters
    ----------
    folder
        An existing folder; without a manifest all its files are foreign.
    """
    lines = _manifest_lines(folder)
    known = {MANIFEST, *lines} if lines is not None else set[str]()
    return [name for name in _files(folder) if name not in known]


def require_replaceable(folder: Path, command: str | None, *, shown: str) -> None:
    """Refuse an output folder that must not be replaced.

    Parameters
    ----------
    folder
        The folder, with links followed.
    command
        The command that would replace it; None to replace the result of any.
    shown
        The folder as the user named it.

    Raises
    ------
    ConfigError
        Where it is a file, is the working folder or holds it, holds files that modelcast did not write, or
        holds the result of another command.
    """
    if not folder.exists():
        blocked = next(parent for parent in folder.parents if parent.exists())
        if not blocked.is_dir():
            raise ConfigError(f"{shown}: {blocked} is a file, not a folder: name another output folder")
        return
    if not folder.is_dir():
        raise ConfigError(f"{shown} is a file, not a folder: name another output folder")
    if Path.cwd().is_relative_to(folder):
        raise ConfigError(f"{shown} is the working folder or holds it: name a folder inside it")
    foreign = foreign_files(folder)
    if foreign:
        more = f" and {len(foreign) - _SHOWN} more" if len(foreign) > _SHOWN else ""
        raise ConfigError(
            f"{shown} holds files that modelcast did not write ({', '.join(foreign[:_SHOWN])}{more}): "
            "move them away or name another output folder"
        )
    author = _author(folder)
    if author and command and author != command:
        raise ConfigError(
            f"{shown} holds the result of modelcast {author}: remove it or name another output folder"
        )


def _manifest_lines(folder: Path) -> Sequence[str] | None:
    manifest = folder / MANIFEST
    return (
        manifest.read_text(encoding="utf-8", errors="surrogateescape").splitlines()
        if manifest.is_file()
        else None
    )


def _author(folder: Path) -> str:
    """Return the command that wrote a folder, empty where that is not said."""
    lines = _manifest_lines(folder) or [""]
    return lines[0].removeprefix(_COMMAND) if lines and lines[0].startswith(_COMMAND) else ""


def _files(folder: Path) -> Sequence[str]:
    """Return the relative paths of everything but folders below `folder`, sorted."""
    found = (item for item in folder.rglob("*") if item.is_symlink() or not item.is_dir())
    return sorted(item.relative_to(folder).as_posix() for item in found)
