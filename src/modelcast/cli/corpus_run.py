"""A command's job over a corpus: where its parts are until the output folder appears."""

import hashlib
import importlib.resources
import json
import shutil
from collections.abc import Generator, Iterable, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from modelcast.cli.progress import rated
from modelcast.cli.terminal import complain
from modelcast.corpora.executors.base import AbstractExecutor
from modelcast.corpora.executors.versions import worker_versions
from modelcast.corpora.job import AbstractJob
from modelcast.corpora.layout import Corpus, is_corpus, open_corpus
from modelcast.corpora.parts import DONE_FILE, PARTS_FOLDER
from modelcast.corpora.running import Outcome, Tally, claimed_results, run_job
from modelcast.io.regular import sha256_of

__all__ = ["corpus_alone", "corpus_parts", "job_key"]


def corpus_alone(paths: Sequence[Path]) -> Corpus | None:
    """Return the corpus that a command names, None where it names anything else, or more.

    Parameters
    ----------
    paths
        What it names.

    Raises
    ------
    DataFormatError
        Where it is unfinished, damaged or of another version.
    """
    return open_corpus(paths[0]) if len(paths) == 1 and is_corpus(paths[0]) else None


@contextmanager
def corpus_parts(
    corpus: Corpus, job: AbstractJob, out: Path, executor: AbstractExecutor, *, quiet: bool
) -> Generator[Outcome]:
    """Do a job with every partition and yield what was found; no other run works on the output meanwhile.

    The parts are in ``NAME.unfinished`` beside the output folder ``NAME``. They go when the block ends well
    and no partition has failed; else they wait for the next run. Where there is none nothing stays.

    Parameters
    ----------
    corpus, job, executor
        As for `modelcast.corpora.running.run_job`.
    out
        The output folder.
    quiet
        Show no progress.

    Raises
    ------
    ConfigError
        As `run_job` does.
    """
    target = out.resolve()
    results = target.with_name(f"{target.name}.unfinished")
    with claimed_results(results, job.name):
        whole = False
        try:
            with rated(quiet=quiet) as show:

                def watch(tally: Tally) -> None:
                    show("partitions", tally.done, tally.partitions, tally.rows)

                outcome = run_job(corpus, job, results, executor, watch=watch)
            for name, reason in outcome.failures.items():
                complain(f"partition {name} is left out: {reason}")
            yield outcome
            whole = not outcome.failures
        except KeyboardInterrupt as error:
            kept = sum(1 for _ in (results / PARTS_FOLDER).glob(f"*/{DONE_FILE}"))
            if kept:
                parts = "1 partition is" if kept == 1 else f"{kept} partitions are"
                error.add_note(f"{parts} kept: the same command goes on from there")
            raise
        finally:
            if whole or not any((results / PARTS_FOLDER).glob(f"*/{DONE_FILE}")):
                shutil.rmtree(results, ignore_errors=True)


def job_key(options: Mapping[str, Any], files: Iterable[Path], foreign: Mapping[str, str]) -> str:
    """Return the hash of all that a job's findings depend on beside the partition.

    Parameters
    ----------
    options
        Plain values.
    files
        Files that are read; their contents count.
    foreign
        Package and version of what other packages bring.

    Raises
    ------
    ConfigError
        Where a file cannot be read.
    """
    shipped = importlib.resources.files("modelcast") / "profiles" / "default.json"
    document = {
        "options": options,
        "files": {str(path): sha256_of(path) for path in files},
        "shipped": hashlib.sha256(shipped.read_bytes()).hexdigest(),
        "foreign": dict(foreign),
        "versions": worker_versions(),
    }
    text = json.dumps(document, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()
