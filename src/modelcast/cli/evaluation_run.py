"""One run of ``modelcast evaluate``: read, evaluate, write, show; and the ``run.json`` that repeats it."""

import hashlib
import json as json_format
import platform
import sys
from dataclasses import asdict, dataclass, fields, replace
from importlib import metadata
from pathlib import Path
from typing import Any, cast

from rich.console import Console

from modelcast.cli.evaluate_options import EvaluateOptions
from modelcast.cli.options import parse_columns
from modelcast.cli.reading import PARTLY_FAILED, TripSource, watched
from modelcast.core.exceptions import ConfigError
from modelcast.core.version import package_version
from modelcast.evaluation.evaluate import evaluate
from modelcast.evaluation.result import EvaluationResult
from modelcast.evaluation.settings import EvaluationSettings
from modelcast.io.output import atomic_folder
from modelcast.io.results import summary_document, write_message_trace, write_results
from modelcast.report.console import console_report
from modelcast.report.html import write_report

__all__ = ["EvaluationRun", "evaluate_source", "load_run", "publish", "run_evaluation"]

RUN_SCHEMA = 1
"""Version of the layout of ``run.json``."""


@dataclass(frozen=True, slots=True)
class EvaluationRun:
    """What was asked for: enough to repeat it."""

    paths: tuple[Path, ...]
    format_name: str | None
    columns: str | None
    trip: str
    options: EvaluateOptions

    def document(self) -> dict[str, Any]:
        """The content of ``run.json``: arguments, versions and the inputs' hashes."""
        packages = ("numpy", "numba", "scipy", "polars", "pyarrow", "pymap3d", "matplotlib")
        return {
            "schema": RUN_SCHEMA,
            "command": "evaluate",
            "arguments": {
                "paths": [str(path) for path in self.paths],
                "format": self.format_name,
                "columns": self.columns,
                "trip": self.trip,
                "options": asdict(self.options),
            },
            "versions": {
                "modelcast": package_version(),
                "python": platform.python_version(),
                **{name: metadata.version(name) for name in packages},
            },
            "inputs": {str(file): _sha256(file) for path in self.paths for file in _files(path)},
        }


def load_run(path: Path) -> EvaluationRun:
    """The run that a ``run.json`` describes, once its inputs are seen to be unchanged.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    ConfigError
        Where it is no such file, or an input is missing or has changed.
    """
    try:
        document = json_format.loads(path.read_text(encoding="utf-8"))
        if document["schema"] != RUN_SCHEMA:
            raise ConfigError(f"{path}: schema {document['schema']} is not {RUN_SCHEMA}")
        arguments = document["arguments"]
        known = {field.name for field in fields(EvaluateOptions)}
        options: dict[str, Any] = {
            name: tuple(cast("list[float]", value)) if isinstance(value, list) else value
            for name, value in arguments["options"].items()
        }
        unknown = set(options) - known
        if unknown:
            raise ConfigError(f"{path}: unknown options {', '.join(sorted(unknown))}")
        run = EvaluationRun(
            tuple(Path(name) for name in arguments["paths"]),
            arguments["format"],
            arguments["columns"],
            arguments["trip"],
            EvaluateOptions(**options),
        )
        inputs: dict[str, str] = document["inputs"]
    except OSError as error:
        raise ConfigError(f"{path} cannot be read: {error.strerror}") from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ConfigError(f"{path} is not a run.json of modelcast evaluate: {error!r}") from error
    for name, expected in inputs.items():
        if not Path(name).is_file():
            raise ConfigError(f"{path}: input {name} is missing; run from the same folder as before")
        if _sha256(Path(name)) != expected:
            raise ConfigError(f"{path}: input {name} has changed since that run")
    return run


def run_evaluation(asked: EvaluationRun, out: Path, *, trace: Path | None, json: bool, quiet: bool) -> int:
    """Run what was asked for and return the exit code.

    Parameters
    ----------
    asked
        Trips and options.
    out
        Output folder.
    trace
        File for the message trace, or None.
    json
        Print the summary instead of tables.
    quiet
        Print nothing but errors.
    """
    settings = asked.options.settings()
    if trace is not None:
        _require_trace(trace, out)
    source = TripSource(
        asked.paths,
        format_name=asked.format_name,
        columns=parse_columns(asked.columns),
        pattern=asked.trip,
    )
    with atomic_folder(out) as folder:
        result = evaluate_source(source, settings, quiet=quiet or json)
        run = asked.document()
        (folder / "run.json").write_text(json_format.dumps(run, indent=2, sort_keys=True) + "\n")
        publish(result, folder)
        if trace is not None:
            write_message_trace(result, trace)
    if json:
        json_format.dump(summary_document(result), sys.stdout, indent=2, sort_keys=True)
        print()
    elif not quiet:
        console = Console()
        console.print(console_report(result))
        console.print(f"report: {out / 'report.html'}", highlight=False, soft_wrap=True)
    return PARTLY_FAILED if result.failures else 0


def evaluate_source(source: TripSource, settings: EvaluationSettings, *, quiet: bool) -> EvaluationResult:
    """Evaluate all trips of a source behind a progress bar; files that failed are among the failures.

    Parameters
    ----------
    source
        The trips.
    settings
        What to do.
    quiet
        Show no progress.
    """
    with watched(source, quiet=quiet) as trips:
        result = evaluate(trips, settings)
    return replace(result, failures={**result.failures, **source.failures})


def publish(result: EvaluationResult, folder: Path) -> None:
    """Write an evaluation's files into a folder.

    Parameters
    ----------
    result
        What was found.
    folder
        An existing folder.
    """
    write_results(result, folder)
    write_report(result, folder)


def _require_trace(trace: Path, out: Path) -> None:
    """Refuse a trace that could not be written, before the work is done."""
    if trace.suffix not in {".csv", ".parquet"}:
        raise ConfigError(f"--trace {trace}: end it in .csv or .parquet")
    if not trace.parent.is_dir():
        raise ConfigError(f"--trace {trace}: there is no folder {trace.parent}")
    if trace.resolve().is_relative_to(out.resolve()):
        raise ConfigError(f"--trace {trace}: name a file outside --out {out}, which is replaced whole")


def _files(path: Path) -> list[Path]:
    return sorted(item for item in path.rglob("*") if item.is_file()) if path.is_dir() else [path]


def _sha256(path: Path) -> str:
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise ConfigError(f"{path} cannot be read: {error.strerror}") from error
