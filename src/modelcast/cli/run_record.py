"""``run.json``: what a run was asked for, with which versions, on which inputs; enough to repeat it."""

import json
import platform
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, cast

from modelcast.cli.evaluate_options import EvaluateOptions
from modelcast.cli.option_rules import LONGEST_PATH, OPTIONS
from modelcast.cli.run_inputs import recorded_inputs, require_same_inputs
from modelcast.core.exceptions import ConfigError
from modelcast.core.json_text import parse_json, schema_of
from modelcast.core.rules import Anything, Each, FieldError, Keys, Maybe, Number, Table, Text, Whole, check
from modelcast.core.version import installed_versions, package_version
from modelcast.corpora.layout import CORPUS_FILE, is_corpus
from modelcast.io.regular import read_document

__all__ = ["RUN_SCHEMA", "EvaluationRun", "load_run", "write_run"]

RUN_SCHEMA = 2
"""Version of the layout of ``run.json``; since 2 it holds the size of every input beside its hash."""

_PACKAGES = ("matplotlib", "numba", "numpy", "polars", "pyarrow", "pymap3d", "scipy")


_PATH = Text(LONGEST_PATH)
_SHA256 = r"[0-9a-f]{64}"
_RUN = Keys(
    {
        "schema": Anything(),
        "command": Text(64),
        "arguments": Keys(
            {
                "paths": Each(_PATH, 1, 10_000),
                "format": Maybe(Text(64)),
                "columns": Maybe(Text(2000)),
                "trip": Text(1000),
                "options": OPTIONS,
            },
            {"rate": Maybe(Number(0.0, 1e6, over=True))},
        ),
        "versions": Table(Text(64), 100),
        "inputs": Table(
            Keys({"bytes": Whole(0, 2**60), "sha256": Text(64, pattern=_SHA256)}),
            100_000,
        ),
        "training_trips": Each(Text(1000), 0, 100_000),
    }
)


@dataclass(frozen=True, slots=True)
class EvaluationRun:
    """What ``modelcast evaluate`` was asked for.

    Parameters
    ----------
    paths, format_name, columns, trip
        The trips.
    options
        Everything that changes the figures.
    rate_hz
        Rate at which the trips are read [Hz]; None for as recorded.
    """

    paths: tuple[Path, ...]
    format_name: str | None
    columns: str | None
    trip: str
    options: EvaluateOptions
    rate_hz: float | None = None

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Everything it reads: the trips, and the profile where one is named.

        Of a corpus its ``corpus.json``, which has the hashes of all that is in it.
        """
        trips = (path / CORPUS_FILE if is_corpus(path) else path for path in self.paths)
        return (*trips, *self.options.files)

    def arguments(self) -> dict[str, Any]:
        """The arguments as plain values."""
        return {
            "paths": [str(path) for path in self.paths],
            "format": self.format_name,
            "columns": self.columns,
            "trip": self.trip,
            "rate": self.rate_hz,
            "options": self.options.as_plain(),
        }


def write_run(
    folder: Path,
    command: str,
    arguments: Mapping[str, Any],
    inputs: Iterable[Path] = (),
    *,
    training_trips: Iterable[str] = (),
    foreign: Mapping[str, str] = MappingProxyType({}),
) -> None:
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
    training_trips
        Identifiers of the trips that the profile in use was trained on.
    foreign
        Package and version of what other packages bring, as `modelcast.core.open_group.OpenGroup.origins`.
    """
    document = {
        "schema": RUN_SCHEMA,
        "command": command,
        "arguments": arguments,
        "versions": {
            "modelcast": package_version(),
            "python": platform.python_version(),
            **installed_versions(_PACKAGES),
            **foreign,
        },
        "inputs": recorded_inputs(inputs),
        "training_trips": list(training_trips),
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
        Where it is no such file, or an input is missing, new or has changed. Nothing that the file names is
        opened before all of it is checked.
    """
    text = read_document(path)
    try:
        document: Any = parse_json(text)
        _require_kind(document)
        check(document, _RUN)
        run = _run_from(cast("dict[str, Any]", document)["arguments"])
    except ValueError as error:
        raise ConfigError(f"{path} is no run.json of modelcast evaluate: {error}") from error
    require_same_inputs(str(path), run.inputs, document["inputs"])
    return run


def _require_kind(document: Any) -> None:
    """Refuse another schema or command by name, before any other field is looked at."""
    schema = schema_of(document, RUN_SCHEMA)
    if schema < RUN_SCHEMA:
        raise ValueError(
            f"$.schema: schema {schema} was made by an older modelcast and says no sizes of its inputs, so "
            "they cannot be checked before they are opened; give the trips and options anew"
        )
    command: Any = document.get("command")
    if command != "evaluate":
        raise FieldError("$.command", command, "'evaluate': --rerun repeats no other command")


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
        arguments.get("rate"),
    )
