"""The files that a run reads: how large they are, what is in them, and whether they still are the same."""

import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from modelcast.core.exceptions import ConfigError
from modelcast.io.regular import kind_of, regular_bytes, sha256_of

__all__ = ["recorded_inputs", "require_same_inputs"]


def recorded_inputs(inputs: Iterable[Path]) -> dict[str, dict[str, Any]]:
    """Size and SHA-256 of every file, by its path.

    Parameters
    ----------
    inputs
        Files, and folders with files. One that cannot be read is left out: the run did without it too.
    """
    found: dict[str, dict[str, Any]] = {}
    for path in inputs:
        for file in sorted(_files(path)):
            with suppress(ConfigError):
                found[str(file)] = {"bytes": regular_bytes(file), "sha256": sha256_of(file)}
    return found


def require_same_inputs(
    place: str, inputs: Iterable[Path], recorded: Mapping[str, Mapping[str, Any]]
) -> None:
    """Refuse a run whose inputs are not those that were recorded.

    Nothing is opened before every file is seen to be an ordinary one of the recorded size, and a folder is
    left at the first file that was not recorded.

    Parameters
    ----------
    place
        The ``run.json``, for errors.
    inputs
        Files and folders.
    recorded
        As `recorded_inputs` returned them.

    Raises
    ------
    ConfigError
        Where one is missing, new, no ordinary file, or has changed.
    """
    found: set[str] = set()
    for path in inputs:
        for file in _files(path):
            if str(file) not in recorded:
                raise ConfigError(f"{place}: input {file} is new since that run")
            found.add(str(file))
    for name, was in recorded.items():
        if not kind_of(Path(name)):
            raise ConfigError(f"{place}: input {name} is missing; run from the same folder as before")
        if name not in found:
            raise ConfigError(f"{place}: {name} is recorded as an input, but the arguments do not name it")
        size = regular_bytes(Path(name))
        if size != was["bytes"]:
            raise ConfigError(
                f"{place}: input {name} has changed since that run: it had {was['bytes']} octets, now {size}"
            )
    for name in sorted(found):
        if sha256_of(Path(name)) != recorded[name]["sha256"]:
            raise ConfigError(f"{place}: input {name} has changed since that run")


def _files(path: Path) -> Iterator[Path]:
    """The file itself, or the ordinary files in the folder and below, links to folders left alone."""
    if kind_of(path) != "folder":
        yield path
        return
    for folder, _, names in os.walk(path):
        for name in names:
            file = Path(folder) / name
            if kind_of(file) == "file":
                yield file
