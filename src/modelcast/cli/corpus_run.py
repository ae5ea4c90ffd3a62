"""``modelcast evaluate`` on a corpus: every partition as a task, then one result of all."""

import os
import shutil
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from modelcast.cli import terminal
from modelcast.cli.evaluation_run import show
from modelcast.cli.named_words import origins_in_use
from modelcast.cli.progress import busy, rated
from modelcast.cli.reading import PARTLY_FAILED
from modelcast.cli.run_record import EvaluationRun, write_run
from modelcast.corpora.evaluation import evaluate_corpus
from modelcast.corpora.layout import open_corpus
from modelcast.corpora.parts import PARTS_FOLDER
from modelcast.corpora.running import Tally, Watch
from modelcast.io.output import atomic_folder
from modelcast.io.results import summary_document, write_summary
from modelcast.report.html import write_report
from modelcast.study.context import reads_context

if TYPE_CHECKING:
    from collections.abc import Generator

    from modelcast.corpora.executors.base import AbstractExecutor

__all__ = ["run_corpus_evaluation", "shares_out", "unfinished_folder", "watched_job"]


def shares_out(asked: EvaluationRun) -> bool:
    """Whether the trips are one corpus that is shared out, all of it.

    Single trips of a corpus, and a bank that reads context, are evaluated like files: by one process.

    Parameters
    ----------
    asked
        Trips and options.
    """
    if not asked.is_corpus or (asked.format_name, asked.columns, asked.trip) != (None, None, "*"):
        return False
    if reads_context(asked.options.settings().bank):
        terminal.complain(
            f"the bank {asked.options.bank} reads context, so trips know of each other: one process evaluates"
            " them all"
        )
        return False
    return True


def unfinished_folder(out: Path) -> Path:
    """Where parts are until all is done: beside the output folder.

    Parameters
    ----------
    out
        The output folder.
    """
    return out.with_name(f"{out.name}.unfinished")


def run_corpus_evaluation(
    asked: EvaluationRun, out: Path, executor: "AbstractExecutor", *, json: bool, quiet: bool
) -> int:
    """Run what was asked for and return the exit code.

    Parameters
    ----------
    asked
        A corpus (`shares_out`), and options.
    out
        Output folder.
    executor
        Where the partitions are worked on.
    json
        Print the summary instead of tables.
    quiet
        Print nothing but errors.
    """
    settings = asked.options.settings()
    corpus = open_corpus(asked.paths[0])
    work = unfinished_folder(out)
    with atomic_folder(out, command="evaluate", shown=f"--out {out}") as folder:
        with watched_job("evaluate", quiet=quiet or json) as watch:
            found = evaluate_corpus(corpus, settings, work, executor, watch=watch)
        result = found.result
        write_run(
            folder,
            "evaluate",
            asked.arguments(),
            asked.inputs,
            training_trips=[trip.id for trip in result.trips if trip.in_training],
            foreign=origins_in_use(asked.options.policy, [settings.bank]),
        )
        with busy("writing the report", quiet=quiet or json):
            write_summary(result, folder)
            write_report(result, folder)
        _publish(work / PARTS_FOLDER, folder / PARTS_FOLDER, keep=bool(found.outcome.failures))
    if found.outcome.failures:
        terminal.complain(f"{work} keeps what is done: the same command tries the failed partitions again")
    else:
        shutil.rmtree(work, ignore_errors=True)
    if json:
        terminal.say_json(summary_document(result))
    elif not quiet:
        show(result, out)
    return PARTLY_FAILED if result.failures else 0


@contextmanager
def watched_job(stage: str, *, quiet: bool) -> "Generator[Watch]":
    """Yield what is told how far a job is, and shows it.

    Parameters
    ----------
    stage
        What is done.
    quiet
        Show nothing.
    """
    with rated(quiet=quiet) as tell:

        def watch(tally: Tally) -> None:
            tell(stage, tally.done, tally.partitions, tally.rows)

        yield watch


def _publish(parts: Path, place: Path, *, keep: bool) -> None:
    """Move the parts, or where they are to stay, give their files a second name."""
    if keep:
        shutil.copytree(parts, place, copy_function=_linked)
    else:
        parts.rename(place)


def _linked(source: str, place: str) -> str:
    try:
        os.link(source, place)
    except OSError:  # another kind of file system
        shutil.copy2(source, place)
    return place
