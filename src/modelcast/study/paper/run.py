"""The whole reproduction: the plain reading, every choice one at a time, then combinations."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

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
from modelcast.study.paper.plan import PaperPlan
from modelcast.study.paper.readings import ReadingRows, figure_of, run_reading
from modelcast.study.paper.result import PaperResult, ReadingResult
from modelcast.study.paper.traffic import with_traffic
from modelcast.study.result import EvaluationResult
from modelcast.trips.manoeuvres.base import ManoeuvreCounts
from modelcast.trips.manoeuvres.rank import count_manoeuvres, rank_trips
from modelcast.trips.trajectory import Trajectory

__all__ = ["Found", "Job", "reproduce_paper", "run_job"]

Part = TypeVar("Part", ManoeuvreCounts, EvaluationResult, ReadingRows)
Progress = Callable[[int, int], None]


Found = ReadingRows | EvaluationResult | ManoeuvreCounts


@dataclass(frozen=True, slots=True)
class Job:
    """One part of the work, which another process may do.

    Parameters
    ----------
    what
        ``reading``, ``evaluation``, or ``count`` for the manoeuvres of the first trip.
    trips, plan
        What all parts share.
    reading
        Of a reading; the plain one for the others.
    counts
        Manoeuvres of every trip, for a reading.
    """

    what: str
    trips: Sequence[Trajectory]
    plan: PaperPlan
    reading: Reading = PLAIN
    counts: Sequence[ManoeuvreCounts] = ()


def run_job(job: Job) -> Found:
    """Do one part of the work.

    Parameters
    ----------
    job
        Which.
    """
    if job.what == "reading":
        return run_reading(job.trips, job.reading, job.plan, [one.manoeuvres for one in job.counts])
    if job.what == "evaluation":
        return evaluate(job.trips, job.plan.settings(PLAIN))
    return count_manoeuvres(job.trips[0])


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
    steps, done = 2 + len(runs) + len(ENDS), 0

    def step() -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done, steps)

    counts = _all_of(ManoeuvreCounts, each(run_job, [Job("count", [trip], plan) for trip in usable]))
    step()
    # The longest first, so that no process waits long for the last one.
    jobs = [Job("evaluation", usable, plan)]
    jobs += [Job("reading", usable, plan, reading, counts) for reading in runs]
    found = iter(_told(each(run_job, jobs), step))
    (evaluation,) = _all_of(EvaluationResult, [next(found)])
    by_run = dict(zip(runs, _all_of(ReadingRows, found), strict=True))
    readings = [_result(one, by_run) for one in labelled]
    ends = [combined(label, _options(readings, figure, sign)) for label, (figure, sign) in ENDS.items()]
    missing = list(dict.fromkeys(one.reading.run for one in ends if one.reading.run not in by_run))
    steps = 2 + len(runs) + len(missing)
    more = each(run_job, [Job("reading", usable, plan, reading, counts) for reading in missing])
    by_run |= dict(zip(missing, _all_of(ReadingRows, _told(more, step)), strict=True))
    readings += [_result(one, by_run) for one in ends]
    result = PaperResult(
        plan,
        evaluation=evaluation,
        manoeuvres=tuple(rank_trips(counts)),
        readings=tuple(readings),
        claims=claim_rows(readings),
        failures=failures,
    )
    return with_traffic(result, ())


def _told(found: Iterable[Found], step: Callable[[], None]) -> Iterator[Found]:
    for one in found:
        step()
        yield one


def _all_of(kind: type[Part], found: Iterable[Found]) -> list[Part]:
    """What came back, once all of it is seen to be of the kind asked for."""
    kept: list[Part] = []
    for one in found:
        if not isinstance(one, kind):
            raise TypeError(f"work came back out of order: {type(one).__name__} for {kind.__name__}")
        kept.append(one)
    return kept


def _result(labelled: LabelledReading, by_run: dict[Reading, ReadingRows]) -> ReadingResult:
    rows = by_run[labelled.reading.run]
    return ReadingResult(
        labelled,
        rows,
        messages=figure_of(rows, labelled.reading, "messages"),
        tracking=figure_of(rows, labelled.reading, "tracking"),
    )


def _options(readings: Sequence[ReadingResult], figure: Figure, sign: int) -> Iterator[tuple[Choice, Option]]:
    """Of every open choice the option whose figure was the smallest by itself, or with -1 the largest."""
    by_label = {(one.labelled.choice, one.labelled.option): one for one in readings}
    plain = readings[0]
    for choice in CHOICES:
        if choice.stated:
            continue
        found = [by_label.get((choice.title, option.label), plain) for option in choice.options]
        figures = np.array([sign * getattr(one, figure) for one in found])
        at = int(np.nanargmin(figures)) if np.isfinite(figures).any() else 0
        yield choice, choice.options[at]
