"""What a path leads to: a file or a folder that can be read, or a reason why not."""

import stat
from pathlib import Path
from typing import Literal

from modelcast.core.exceptions import DataFormatError
from modelcast.core.near_names import near

__all__ = ["meant", "mode_kind", "place_kind", "readable_kind"]

_SPECIAL = {
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


def mode_kind(mode: int) -> str:
    """Return ``file``, ``folder``, or what else in words.

    Parameters
    ----------
    mode
        As the operating system tells it of a place.
    """
    kind = stat.S_IFMT(mode)
    return {stat.S_IFREG: "file", stat.S_IFDIR: "folder"}.get(kind) or _SPECIAL.get(kind, "no regular file")


def place_kind(path: str | Path) -> str:
    """Return what a path leads to, links followed: ``file``, ``folder``, or what else in words.

    Parameters
    ----------
    path
        As the user named it.

    Raises
    ------
    OSError
        Where that cannot be told.
    """
    return mode_kind(Path(path).stat().st_mode)


def meant(missing: Path) -> str:
    """Return a question for the neighbour that was meant by a name, nothing where none is near.

    Parameters
    ----------
    missing
        What is not there.
    """
    try:
        return near(missing.name, [entry.name for entry in missing.parent.iterdir()])
    except OSError:
        return ""


def readable_kind(path: str | Path) -> Literal["file", "folder"]:
    """Return whether a path leads to a file or to a folder; nothing is opened, so a pipe makes nobody wait.

    Parameters
    ----------
    path
        As the user named it.

    Raises
    ------
    DataFormatError
        Where there is nothing, a broken link, a pipe, a socket or a device.
    """
    name = str(path)
    try:
        kind = place_kind(path)
    except OSError as error:
        if Path(path).is_symlink() and not Path(path).exists():
            target = Path(path).readlink()
            raise DataFormatError(
                name, f"is a broken link, to {target}", remedy="Mend or remove it."
            ) from error
        if isinstance(error, FileNotFoundError | NotADirectoryError):
            if name == "-":
                raise DataFormatError(
                    name,
                    "does not exist, and the standard input is not read here",
                    remedy="Write it into a file and name that.",
                ) from error
            raise DataFormatError(
                name, f"does not exist{meant(Path(path))}", remedy="Check the path."
            ) from error
        raise DataFormatError(name, f"cannot be read: {error.strerror or error}") from error
    if kind == "file":
        return "file"
    if kind == "folder":
        return "folder"
    raise DataFormatError(
        name, f"is {kind}, not a file", remedy="Write its content into a file and name that."
    )
