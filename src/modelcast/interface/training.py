"""What is learnt from trips and what the paper claims, with trips in any form."""

import warnings
from collections.abc import Callable, Iterable
from dataclasses import replace

from modelcast.core.argument_types import require_type
from modelcast.interface.given_trips import GivenTripList, GivenTrips
from modelcast.models.profile import Profile
from modelcast.report.console import skipped_lines
from modelcast.study.paper.plan import PaperPlan
from modelcast.study.paper.result import PaperResult
from modelcast.study.paper.run import Found, Job
from modelcast.study.paper.run import reproduce_paper as reproduce
from modelcast.study.training.profile import ProfileSettings
from modelcast.study.training.profile import train_profile as train

__all__ = ["reproduce_paper", "train_profile"]


def train_profile(
    trips: GivenTrips,
    settings: ProfileSettings | None = None,
    *,
    beside: Profile | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> Profile:
    """Train everything that vehicles share.

    A profile has no place for files and vehicles that held no trip: a `UserWarning` names them.

    Parameters
    ----------
    trips
        Recorded trips: a path, a data frame, a trip, what `read_trips` gave, or several of them.
    settings
        What is trained, and how.
    beside
        A profile trained before: its sub-models of families that are not trained now go to the shelf.
    progress
        Called as the work goes on, with what is being done, steps done and steps to do.

    Raises
    ------
    DataFormatError
        Where a file cannot be read.
    MissingExtraError
        Where JAX and optax, which the extra ``train`` brings, is not installed.
    TypeError
        Where a trip is none.
    ValueError
        Where the trips are too short to learn from, or ``validate`` finds a single route only.
    """
    if settings is not None:
        require_type("settings", settings, ProfileSettings)
    taken = GivenTripList(trips)
    recorded = taken.recorded()
    told = skipped_lines(taken.skipped, rest="read_trips(...).skipped")
    if told:
        warnings.warn("\n".join(told), stacklevel=2)
    return train(recorded, settings, beside=beside, progress=progress)


def reproduce_paper(
    trips: GivenTrips,
    plan: PaperPlan | None = None,
    *,
    each: Callable[[Callable[[Job], Found], Iterable[Job]], Iterable[Found]] = map,
    progress: Callable[[int, int], None] | None = None,
) -> PaperResult:
    """Run the paper's evaluation over trips under every choice it leaves open, and judge its claims.

    Parameters
    ----------
    trips
        Recorded trips with distinct identifiers: a path, a data frame, a trip, what `read_trips` gave, or
        several of them.
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
        The same whatever `each` is; `PaperResult.skipped` names files and vehicles that held no trip.

    Raises
    ------
    ConfigError
        Where no trip is long enough for a window, or two have one name.
    DataFormatError
        Where a file cannot be read.
    TypeError
        Where a trip is none.

    Examples
    --------
    >>> from modelcast.world.drive import generate_drive
    >>> plan = PaperPlan((0.5,), (0.4,), seeds=1, resamples=10)
    >>> result = reproduce_paper(generate_drive(seed=1, duration_s=90.0).truth, plan)
    >>> [reading.labelled.label for reading in result.readings][-2:]
    ['combined: best tracking', 'combined: worst tracking']
    """
    if plan is not None:
        require_type("plan", plan, PaperPlan)
    taken = GivenTripList(trips)
    result = reproduce(taken.recorded(), plan, each=each, progress=progress)
    return replace(result, skipped=taken.skipped)
