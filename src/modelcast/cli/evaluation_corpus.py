"""``modelcast evaluate`` on a corpus: every partition as a task, then one result of all."""

import os
import shutil
from pathlib import Path

from modelcast.cli import terminal
from modelcast.cli.corpus_run import corpus_alone, corpus_parts, job_key
from modelcast.cli.evaluation_run import finish, record, tell
from modelcast.cli.executor_options import ExecutorOptions
from modelcast.cli.named_words import origins_in_use
from modelcast.cli.run_record import EvaluationRun
from modelcast.corpora.evaluation import EvaluateJob, reduce_evaluation
from modelcast.corpora.layout import Corpus
from modelcast.corpora.parts import PARTS_FOLDER
from modelcast.io.output import atomic_folder
from modelcast.study.context import reads_context

__all__ = ["corpus_to_share", "run_corpus_evaluation"]


def corpus_to_share(asked: EvaluationRun, where: ExecutorOptions) -> Corpus | None:
    """Return the corpus that is shared out, None where one process evaluates all trips like those of files.

    Parameters
    ----------
    asked
        Trips and options.
    where
        Where a corpus is worked on.

    Raises
    ------
    ConfigError
        Where it is to be shared out, and cannot be.
    DataFormatError
        Where the corpus is unfinished or damaged.
    """
    corpus = corpus_alone(asked.paths)
    if corpus is None:
        where.require_no_corpus()
        return None
    reason = None
    if asked.rate_hz is not None:
        reason = "--rate is for trips as they are read: make a corpus of that rate"
    elif reads_context(asked.options.settings().bank):
        reason = f"the bank {asked.options.bank} reads context, so trips know of each other"
    if reason is not None:
        where.require_one_process(reason)
        terminal.complain(f"all trips are evaluated together, in one process: {reason}")
        return None
    return corpus


def run_corpus_evaluation(
    asked: EvaluationRun, corpus: Corpus, out: Path, where: ExecutorOptions, *, json: bool, quiet: bool
) -> int:
    """Run what was asked for and return the exit code.

    Parameters
    ----------
    asked
        Trips and options.
    corpus
        The trips.
    out
        Output folder.
    where
        Where the partitions are worked on.
    json
        Print the summary instead of tables.
    quiet
        Print nothing but errors.
    """
    settings = asked.options.settings()
    foreign = origins_in_use(asked.options.policy, [settings.bank])
    key = job_key(asked.options.as_plain(), asked.options.files, foreign)
    job = EvaluateJob(settings, pattern=asked.trip, asked=key)
    silent = quiet or json
    with (
        atomic_folder(out, command="evaluate", shown=f"--out {out}") as folder,
        corpus_parts(corpus, job, out, where.executor(), quiet=silent) as outcome,
    ):
        result = reduce_evaluation(corpus, settings, outcome)
        record(asked, result, folder)
        finish(result, folder, quiet=silent)
        for part in outcome.parts:
            # Under a second name: what an interrupted call needs stays until the output is there.
            place = folder / PARTS_FOLDER / part.partition
            shutil.copytree(part.folder, place, copy_function=_linked)
    return tell(result, out, json=json, quiet=quiet)


def _linked(source: str, place: str) -> str:
    try:
        os.link(source, place)
    except OSError:  # another kind of file system
        shutil.copy2(source, place)
    return place
