"""One run of ``modelcast evaluate``: read, evaluate, write, show."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from modelcast.cli import terminal
from modelcast.cli.named_words import origins_in_use
from modelcast.cli.options import parse_columns
from modelcast.cli.progress import busy, watched
from modelcast.cli.reading import PARTLY_FAILED, TripSource
from modelcast.cli.run_record import EvaluationRun, write_run
from modelcast.core.exceptions import ConfigError
from modelcast.io.output import atomic_folder, require_apart, require_writable
from modelcast.io.record_files import RecordFiles
from modelcast.io.results import summary_document, write_message_trace, write_results, write_summary
from modelcast.report.console import console_report
from modelcast.report.html import write_report
from modelcast.study.evaluate import evaluate
from modelcast.study.recording import AbstractRecordSink
from modelcast.study.result import EvaluationResult
from modelcast.study.settings import EvaluationSettings

__all__ = ["evaluate_source", "finish", "publish", "record", "run_evaluation", "show", "tell"]


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
        _require_trace(trace, out, asked.inputs)
    source = TripSource(
        asked.paths,
        format_name=asked.format_name,
        columns=parse_columns(asked.columns),
        pattern=asked.trip,
        rate_hz=asked.rate_hz,
    )
    with atomic_folder(out, command="evaluate", shown=f"--out {out}") as folder:
        with RecordFiles(folder) as records:
            result = evaluate_source(source, settings, records, quiet=quiet)
        record(asked, result, folder)
        finish(result, folder, quiet=quiet)
        if trace is not None:
            write_message_trace(folder, trace, policy=settings.sender)
    return tell(result, out, json=json, quiet=quiet)


def record(asked: EvaluationRun, result: EvaluationResult, folder: Path) -> None:
    """Write ``run.json``.

    Parameters
    ----------
    asked
        Trips and options.
    result
        What was found.
    folder
        An existing folder.
    """
    write_run(
        folder,
        "evaluate",
        asked.arguments(),
        asked.inputs,
        training_trips=[trip.id for trip in result.trips if trip.in_training],
        foreign=origins_in_use(asked.options.policy, [asked.options.settings().bank]),
    )


def finish(result: EvaluationResult, folder: Path, *, quiet: bool) -> None:
    """Write summary and report, where messages and samples are written already.

    Parameters
    ----------
    result
        What was found.
    folder
        An existing folder.
    quiet
        Show no progress.
    """
    with busy("writing the report", quiet=quiet):
        write_summary(result, folder)
        write_report(result, folder)


def tell(result: EvaluationResult, out: Path, *, json: bool, quiet: bool) -> int:
    """Print what was found and return the exit code.

    Parameters
    ----------
    result
        What was found.
    out
        Output folder.
    json
        Print the summary instead of tables.
    quiet
        Print nothing.
    """
    if json:
        terminal.say_json(summary_document(result))
    elif not quiet:
        show(result, out)
    return PARTLY_FAILED if result.failures else 0


def evaluate_source(
    source: TripSource, settings: EvaluationSettings, records: AbstractRecordSink, *, quiet: bool
) -> EvaluationResult:
    """Evaluate all trips of a source behind a progress bar; files that failed are among the failures.

    Parameters
    ----------
    source
        The trips.
    settings
        What to do.
    records
        Takes messages and samples.
    quiet
        Show no progress.
    """
    with watched(source, quiet=quiet) as trips:
        result = evaluate(trips, settings, records=records)
    return replace(result, failures={**result.failures, **source.failures}, skipped=dict(source.skipped))


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


def _require_trace(trace: Path, out: Path, inputs: Iterable[Path]) -> None:
    """Refuse a trace that could not be written, before the work is done."""
    if trace.suffix not in {".csv", ".parquet"}:
        raise ConfigError(f"--trace {trace}: end it in .csv or .parquet")
    require_writable(trace, shown=f"--trace {trace}")
    require_apart(trace, inputs, shown=f"--trace {trace}")
    if trace.resolve().is_relative_to(out.resolve()):
        raise ConfigError(f"--trace {trace}: name a file outside --out {out}, which is replaced whole")


def show(result: EvaluationResult, out: Path) -> None:
    """Print the tables of an evaluation and where its report is.

    Parameters
    ----------
    result
        What was found.
    out
        The output folder.
    """
    terminal.show(console_report(result))
    terminal.say(f"report: {out / 'report.html'}")
