"""``run.json``: what a run was asked for, with which versions, on which inputs; enough to repeat it."""

import hashlib
import json
import platform
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any, cast

from modelcast.cli.evaluate_options import EvaluateOptions
from modelcast.core.exceptions import ConfigError
from modelcast.core.version import package_version

__all__ = ["RUN_SCHEMA", "EvaluationRun", "load_run", "write_run"]

RUN_SCHEMA = 1
"""Version of the layout of ``run.json``."""

_PACKAGES = ("matplotlib", "numba", "numpy", "polars", "pyarrow", "pymap3d", "scipy")


@dataclass(frozen=True, slots=True)
class EvaluationRun:
    """What ``modelcast evaluate`` was asked for.

    Parameters
    ----------
    paths, format_name, columns, trip
        The trips.
    options
        Everything that changes the figures.
    """

    paths: tuple[Path, ...]
    format_name: str | None
    columns: str | None
    trip: str
    options: EvaluateOptions

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Everything it reads: the trips, and the profile where one is named."""
        return (*self.paths, *self.options.files)

    def arguments(self) -> dict[str, Any]:
        """The arguments as plain values."""
        return {
            "paths": [str(path) for path in self.paths],
            "format": self.format_name,
            "columns": self.columns,
            "trip": self.trip,
            "options": self.options.as_plain(),
        }


def write_run(folder: Path, command: str, arguments: Mapping[str, Any], inputs: Iterable[Path] = ()) -> None:
    """Write ``run.json`` into a folder.

    Parameters
    ----------
    folder
        An existing folder.
    command
        Name of the command.
    arguments
        Its arguments as plain values.
    inputs
        Files and folders it reads; every file that can be read is hashed.
    """
    document = {
        "schema": RUN_SCHEMA,
        "command": command,
        "arguments": arguments,
        "versions": {
            "modelcast": package_version(),
            "python": platform.python_version(),
            **{name: metadata.version(name) for name in _PACKAGES},
        },
        "inputs": _hashes(inputs),
    }
    text = json.dumps(document, indent=2, sort_keys=True) + "\n"
    (folder / "run.json").write_text(text, encoding="utf-8", newline="\n")


def load_run(path: Path) -> EvaluationRun:
    """The evaluation that a ``run.json`` describes, once its inputs are seen to be unchanged.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    ConfigError
        Where it is no such file, or an input is missing, new or has changed.
    """
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        if document["schema"] != RUN_SCHEMA or document["command"] != "evaluate":
            raise ConfigError(
                f"{path}: command {document['command']}, schema {document['schema']}; "
                f"--rerun repeats runs of evaluate, schema {RUN_SCHEMA}"
            )
        run = _run_from(document["arguments"])
        recorded: dict[str, str] = document["inputs"]
    except OSError as error:
        raise ConfigError(f"{path} cannot be read: {error.strerror}") from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ConfigError(f"{path} is not a run.json of modelcast evaluate: {error!r}") from error
    _require_same_inputs(path, run.inputs, recorded)
    return run


def _run_from(arguments: Mapping[str, Any]) -> EvaluationRun:
    options: dict[str, Any] = {
        name: tuple(cast("list[float]", value)) if isinstance(value, list) else value
        for name, value in arguments["options"].items()
    }
    return EvaluationRun(
        tuple(Path(name) for name in arguments["paths"]),
        arguments["format"],
        arguments["columns"],
        arguments["trip"],
        EvaluateOptions.from_plain(options),
    )


def _require_same_inputs(path: Path, inputs: Iterable[Path], recorded: Mapping[str, str]) -> None:
    for name in recorded:
        if not Path(name).is_file():
            raise ConfigError(f"{path}: input {name} is missing; run from the same folder as before")
    found = _hashes(inputs)
    for name in recorded:
        if name not in found:
            raise ConfigError(f"{path}: input {name} cannot be read any more")
    for name, digest in found.items():
        if name not in recorded:
            raise ConfigError(f"{path}: input {name} is new since that run")
        if recorded[name] != digest:
            raise ConfigError(f"{path}: input {name} has changed since that run")


def _hashes(inputs: Iterable[Path]) -> dict[str, str]:
    """SHA-256 of every file by its name, without those that cannot be read: the run did without them too."""
    digests = {str(file): _sha256(file) for path in inputs for file in _files(path)}
    return {name: digest for name, digest in digests.items() if digest is not None}


def _files(path: Path) -> list[Path]:
    """The regular files at and under a path; a pipe is not opened, it would wait for a writer."""
    return sorted(item for item in (path.rglob("*") if path.is_dir() else [path]) if item.is_file())


def _sha256(path: Path) -> str | None:
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return None
