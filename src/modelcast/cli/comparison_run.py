"""The work of ``modelcast compare``: shared out over a corpus where it can be, else all trips together."""

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import KW_ONLY, dataclass, replace
from pathlib import Path

from modelcast.cli.all_trips import all_trips
from modelcast.cli.compare_options import CompareOptions
from modelcast.cli.corpus_run import corpus_alone, corpus_parts, job_key
from modelcast.cli.executor_options import ExecutorOptions
from modelcast.cli.options import parse_columns
from modelcast.cli.progress import counted
from modelcast.cli.reading import TripSource
from modelcast.core.exceptions import ConfigError
from modelcast.corpora.comparison import ComparisonJob, pool_comparison, why_not_shared
from modelcast.io.manifest import require_replaceable
from modelcast.study.compare.free import with_free
from modelcast.study.compare.result import ComparisonResult
from modelcast.study.compare.run import checked_reference, compare

__all__ = ["Comparison", "compared"]


@dataclass(frozen=True, slots=True)
class Comparison:
    """What ``modelcast compare`` was asked for.

    Parameters
    ----------
    paths, format_name, columns, trip, rate_hz
        The trips.
    options
        What changes the figures.
    where
        What does not.
    """

    paths: tuple[Path, ...]
    format_name: str | None
    columns: str | None
    _: KW_ONLY
    trip: str
    rate_hz: float | None
    options: CompareOptions
    where: ExecutorOptions

    def source(self) -> TripSource:
        """The trips, not yet taken.

        Raises
        ------
        ConfigError
            Where their format, columns or rate are none.
        """
        return TripSource(
            self.paths,
            format_name=self.format_name,
            columns=parse_columns(self.columns),
            pattern=self.trip,
            rate_hz=self.rate_hz,
        )


@contextmanager
def compared(asked: Comparison, out: Path, *, quiet: bool) -> Generator[ComparisonResult]:
    """Compare, and yield what was found; what an interrupted call needs goes when the block ends well.

    Parameters
    ----------
    asked
        What to compare, and where.
    out
        The output folder.
    quiet
        Show no progress.

    Raises
    ------
    ConfigError
        Where an option is out of its range, the output folder holds something else, or there is no usable
        trip.
    """
    if asked.where.cluster in {"trip", "route"}:
        raise ConfigError(
            f"--cluster says where a corpus is worked on: what the bootstrap resamples is --resample-by "
            f"{asked.where.cluster}"
        )
    settings = asked.options.settings()
    candidates = with_free(asked.options.candidates(), settings.evaluation)
    checked_reference(candidates, settings)
    source = asked.source()
    require_replaceable(out.resolve(), "compare", shown=f"--out {out}")
    corpus = corpus_alone(asked.paths)
    if corpus is None:
        asked.where.require_no_corpus()
        yield _together(asked, source, "other recordings are named beside it", quiet=quiet)
        return
    reason = why_not_shared(candidates, settings)
    if asked.rate_hz is not None:
        reason = "--rate is for trips as they are read: make a corpus of that rate"
    if reason is not None:
        asked.where.require_one_process(reason)
        yield _together(asked, source, reason, quiet=quiet)
        return
    options = asked.options
    key = job_key({**options.as_plain(), "trip": asked.trip}, options.files, options.foreign)
    job = ComparisonJob(candidates, settings, pattern=asked.trip, asked=key)
    with corpus_parts(corpus, job, out, asked.where.executor(), quiet=quiet) as outcome:
        failures = {f"partition {name}": reason for name, reason in outcome.failures.items()}
        yield pool_comparison(outcome, job, failures=failures, skipped={})


def _together(asked: Comparison, source: TripSource, reason: str, *, quiet: bool) -> ComparisonResult:
    """Compare all trips in this process, for a reason where there is a corpus."""
    settings, candidates = asked.options.settings(), asked.options.candidates()
    trips = all_trips(source, asked.paths, reason, quiet=quiet)
    with counted("trips", quiet=quiet) as progress:
        found = compare(trips, candidates, settings, progress=progress)
    failures = {**found.failures, **source.failures}
    return replace(found, failures=failures, skipped=dict(source.skipped))
