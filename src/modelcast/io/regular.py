"""Ordinary files: looked at before they are opened, so that no device, pipe or giant is."""

import hashlib
import os
from pathlib import Path

from modelcast.core.exceptions import ConfigError
from modelcast.core.json_text import LARGEST_BYTES
from modelcast.io.places import meant, mode_kind, place_kind

__all__ = ["kind_of", "read_document", "regular_bytes", "sha256_of"]


def kind_of(path: Path) -> str:
    """``file``, ``folder``, ``other``, or nothing where there is none; no name is too odd to ask for.

    Parameters
    ----------
    path
        Any path; a link is followed.
    """
    try:
        kind = place_kind(path)
    except (OSError, ValueError):
        return ""
    return kind if kind in {"file", "folder"} else "other"


def regular_bytes(path: Path) -> int:
    """How many octets an ordinary file holds; it is not opened.

    Parameters
    ----------
    path
        The file; a link is followed.

    Raises
    ------
    ConfigError
        Where it is missing, or no ordinary file.
    """
    try:
        found = path.stat()
    except (OSError, ValueError) as error:
        remedy = f"{meant(path)}. Check the path." if isinstance(error, FileNotFoundError) else ""
        raise ConfigError(f"{_named(path)} cannot be read: {_why(error)}{remedy}") from error
    return _regular(path, found)


def read_document(path: Path) -> str:
    """The text of a small file: an ordinary one, of at most `LARGEST_BYTES`, in UTF-8.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    ConfigError
        Where it is none.
    """
    size = regular_bytes(path)
    if size > LARGEST_BYTES:
        raise ConfigError(f"{_named(path)} has {size} octets; at most {LARGEST_BYTES} are read")
    try:
        with _opened(path) as file:
            # One more than may be: a file that grows meanwhile is still not read whole.
            octets = file.read(LARGEST_BYTES + 1)
    except OSError as error:
        raise ConfigError(f"{_named(path)} cannot be read: {_why(error)}") from error
    if len(octets) > LARGEST_BYTES:
        raise ConfigError(f"{_named(path)} has over {LARGEST_BYTES} octets, more than are read")
    try:
        return octets.decode("utf-8")
    except UnicodeDecodeError as error:
        raise ConfigError(f"{_named(path)} is no text in UTF-8: octet {error.start} is damaged") from error


def sha256_of(path: Path) -> str:
    """SHA-256 of an ordinary file's octets, in hexadecimal digits.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    ConfigError
        Where it is missing, or no ordinary file.
    """
    regular_bytes(path)
    try:
        with _opened(path) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise ConfigError(f"{_named(path)} cannot be read: {_why(error)}") from error


def _opened(path: Path):  # noqa: ANN202 - the type of open() says more than a name would
    """Open for reading; a pipe that took the file's place meanwhile does not make us wait."""
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    try:
        _regular(path, os.fstat(descriptor))
    except ConfigError:
        os.close(descriptor)
        raise
    return os.fdopen(descriptor, "rb")


def _regular(path: Path, found: os.stat_result) -> int:
    kind = mode_kind(found.st_mode)
    if kind != "file":
        raise ConfigError(f"{_named(path)} is {'a folder' if kind == 'folder' else kind}, not a file")
    return found.st_size


def _named(path: Path) -> str:
    """The path without control characters, which a foreign file may hold."""
    text = str(path)
    return text if text.isprintable() else ascii(text)


def _why(error: Exception) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)
