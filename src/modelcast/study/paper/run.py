"""The whole reproduction: the plain reading, every choice one at a time, then combinations."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from modelcast.study.compare.stage import usable_trips
from modelcast.study.evaluate import evaluate
from modelcast.study.paper.choices import (
    CHOICES,
    ENDS,
    PLAIN,
    Choice,
    Figure,
    LabelledReading,
    Option,
    Reading,
    combined,
    one_at_a_time,
)
from modelcast.study.paper.claims import claim_rows
from modelcast.study.paper.complement import Complement, complement
from modelcast.study.paper.plan import PaperPlan
from modelcast.study.paper.readings import ReadingRows, figure_of, run_reading
from modelcast.study.paper.result import PaperResult, ReadingResult
from modelcast.study.paper.traffic import with_traffic
from modelcast.study.result import EvaluationResult
from modelcast.trips.manoeuvres.base import ManoeuvreCounts
from modelcast.trips.manoeuvres.rank import count_manoeuvres, rank_trips
from modelcast.trips.trajectory import Trajectory

__all__ = ["Job", "reproduce_paper", "run_job"]

Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class Driven:
    """What was driven, and which sub-model held meanwhile.

    Parameters
    ----------
    counts
        Manoeuvres of every trip.
    complement
        Who held when.
    """

    counts: tuple[ManoeuvreCounts, ...]
    complement: Complement


Found = ReadingRows | EvaluationResult | Driven


@dataclass(frozen=True, slots=True)
class Job:
    """One part of the work, which another process may do.

    Parameters
    ----------
    what
        ``reading``, ``evaluation`` or ``driven``.
    trips, plan
        What all parts share.
    reading
        Of a reading; the plain one for the others.
    """

    what: str
    trips: Sequence[Trajectory]
    plan: PaperPlan
    reading: Reading = PLAIN


def run_job(job: Job) -> Found:
    """Do one part of the work.

    Parameters
    ----------
    job
        Which.
    """
    if job.what == "reading":
        return run_reading(job.trips, job.reading, job.plan)
    if job.what == "evaluation":
        return evaluate(job.trips, job.plan.settings(PLAIN))
    counts = tuple(count_manoeuvres(trip) for trip in job.trips)
    return Driven(counts, complement(job.trips, [one.manoeuvres for one in counts], PLAIN, job.plan))


def reproduce_paper(
    trips: Sequence[Trajectory],
    plan: PaperPlan | None = None,
    *,
    each: Callable[[Callable[[Job], Found], Iterable[Job]], Iterable[Found]] = map,
    progress: Progress | None = None,
) -> PaperResult:
    """Run the paper's evaluation over trips under every choice it leaves open, and judge its claims.

    Parameters
    ----------
    trips
        Recorded trips, with distinct identifiers.
    plan
        Thresholds, losses and seeds; the paper's where None.
    each
        Applies a function to jobs and returns what it gave, in order: `map`, or one that shares the jobs out
        among processes.
    progress
        Called with parts done and parts to do.

    Returns
    -------
    PaperResult
        The same whatever `each` is.

    Raises
    ------
    ConfigError
        Where no trip is long enough for a window, or two have one name.

    Examples
    --------
    >>> from modelcast.world.drive import generate_drive
    >>> plan = PaperPlan((0.5,), (0.4,), seeds=1, resamples=10)
    >>> result = reproduce_paper([generate_drive(seed=1, duration_s=90.0).truth], plan)
    >>> [reading.labelled.label for reading in result.readings][-2:]
    ['combined: best tracking', 'combined: worst tracking']
    """
    plan = PaperPlan() if plan is None else plan
    usable, failures = usable_trips(trips, int(PLAIN.bank.windows.max()))
    labelled = one_at_a_time()
    runs = list(dict.fromkeys(one.reading.run for one in labelled))
    # The longest first, so that no process waits long for the last one.
    jobs = [Job(what, usable, plan) for what in ("evaluation", "driven")]
    jobs += [Job("reading", usable, plan, reading) for reading in runs]
    steps = len(jobs) + len(ENDS)
    done = 0

    def counted(found: Iterable[Found]) -> Iterator[Found]:
        nonlocal done
        for one in found:
            done += 1
            if progress is not None:
                progress(done, steps)
            yield one

    evaluation, driven, *rows = counted(each(run_job, jobs))
    by_run = {reading: one for reading, one in zip(runs, rows, strict=True) if isinstance(one, ReadingRows)}
    readings = [_result(one, by_run) for one in labelled]
    ends = [combined(label, _options(readings, figure, sign)) for label, (figure, sign) in ENDS.items()]
    missing = list(dict.fromkeys(one.reading.run for one in ends if one.reading.run not in by_run))
    steps = len(jobs) + len(missing)
    more = counted(each(run_job, [Job("reading", usable, plan, reading) for reading in missing]))
    by_run |= {
        reading: one for reading, one in zip(missing, more, strict=True) if isinstance(one, ReadingRows)
    }
    readings += [_result(one, by_run) for one in ends]
    if not isinstance(evaluation, EvaluationResult) or not isinstance(driven, Driven):
        raise TypeError(f"each returned {type(evaluation).__name__}, {type(driven).__name__} out of order")
    found = PaperResult(
        plan,
        evaluation=evaluation,
        complement=driven.complement,
        manoeuvres=tuple(rank_trips(driven.counts)),
        readings=tuple(readings),
        claims=claim_rows(readings, evaluation, driven.complement, plan),
        failures=failures,
    )
    return with_traffic(found, ())


def _result(labelled: LabelledReading, by_run: dict[Reading, ReadingRows]) -> ReadingResult:
    rows = by_run[labelled.reading.run]
    return ReadingResult(
        labelled,
        rows,
        messages=figure_of(rows, labelled.reading, "messages"),
        tracking=figure_of(rows, labelled.reading, "tracking"),
    )


def _options(readings: Sequence[ReadingResult], figure: Figure, sign: int) -> Iterator[tuple[Choice, Option]]:
    """Of every choice the option whose figure was the smallest by itself, or with -1 the largest."""
    by_label = {(one.labelled.choice, one.labelled.option): one for one in readings}
    plain = readings[0]
    for choice in CHOICES:
        found = [by_label.get((choice.title, option.label), plain) for option in choice.options]
        figures = np.array([sign * getattr(one, figure) for one in found])
        at = int(np.nanargmin(figures)) if np.isfinite(figures).any() else 0
        yield choice, choice.options[at]
