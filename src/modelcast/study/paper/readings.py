"""One reading over all trips: messages beside the baseline's, and errors beside both equal-rate baselines."""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from typing import get_args

import numpy as np

from modelcast.models.bank import Bank
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.banks import FREE, free_bank
from modelcast.study.compare.settings import CompareSettings
from modelcast.study.compare.stage import StagedTrip, stage_trips
from modelcast.study.compare.table import Resamples, ratio_rows, rival_rows, tracking_rows
from modelcast.study.compare.trial import Trial, run_trial
from modelcast.study.paper.choices import PLAIN, Figure, Reading, Schedule
from modelcast.study.paper.complement import Complement, complement
from modelcast.study.paper.plan import PaperPlan
from modelcast.study.result import POOLED
from modelcast.study.rules import RATE_BASES
from modelcast.study.settings import EvaluationSettings
from modelcast.study.table import Row
from modelcast.study.tracking import LossRuns
from modelcast.trips.manoeuvres.base import FoundManoeuvre
from modelcast.trips.trajectory import Trajectory

__all__ = ["ALONE", "HYBRID", "UPDATES", "ReadingRows", "RivalKey", "figure_of", "run_reading"]

HYBRID = "hybrid"
UPDATES = "updates alone"
ALONE = "Gaussian process alone"

RivalKey = tuple[str, str]
"""Rate basis and schedule of an equal-rate baseline."""


@dataclass(frozen=True, slots=True)
class ReadingRows:
    """What one reading found, for every rival that it can be held against.

    Parameters
    ----------
    reading
        Its options; those of the rival are not looked at.
    messages
        All messages of the hybrid over the baseline's, one row a threshold; the difference is to the Gaussian
        process alone.
    updates
        The same with its updates alone.
    alone
        The same of the Gaussian process alone.
    tracking
        One row a threshold and packet error ratio for all trips and one a trip, by rate basis and schedule of
        the baseline: at the headline's ratio, and of the plain reading at all of the sweep.
    beside_free
        All messages of the hybrid over those of the strongest cheap rival at the same threshold, one row a
        threshold: plain messages whose receivers coast by the bank `modelcast.station.banks.free_bank`.
    tracking_beside_free
        As ``tracking``, the equal-rate baselines being of that bank; at the headline's ratio alone.
    complement
        Which sub-model held when.
    headline_ratio
        The packet error ratio that readings are compared at.
    """

    reading: Reading
    _: KW_ONLY
    messages: tuple[Row, ...]
    updates: tuple[Row, ...]
    alone: tuple[Row, ...]
    tracking: Mapping[RivalKey, tuple[Row, ...]]
    beside_free: tuple[Row, ...]
    tracking_beside_free: Mapping[RivalKey, tuple[Row, ...]]
    complement: Complement
    headline_ratio: float

    def pooled(self, reading: Reading) -> tuple[Row, ...]:
        """Tracking over all trips against the rival of a reading, one row a threshold.

        Parameters
        ----------
        reading
            Its rate basis and schedule are taken.
        """
        return tuple(row for row in self.sweep(reading) if row.packet_error_ratio == self.headline_ratio)

    def sweep(self, reading: Reading) -> tuple[Row, ...]:
        """The same at every packet error ratio that was run."""
        rows = self.tracking[reading.rate_basis, reading.schedule]
        return tuple(row for row in rows if row.trip == POOLED)

    def by_trip(self, reading: Reading) -> tuple[Row, ...]:
        """Tracking at the headline's ratio, one row a trip and threshold."""
        rows = self.tracking[reading.rate_basis, reading.schedule]
        ratio = self.headline_ratio
        return tuple(row for row in rows if row.trip != POOLED and row.packet_error_ratio == ratio)

    def beside_free_pooled(self, reading: Reading) -> tuple[Row, ...]:
        """As `pooled`, the rival being of the free bank."""
        rows = self.tracking_beside_free[reading.rate_basis, reading.schedule]
        return tuple(row for row in rows if row.trip == POOLED)

    def beside_free_by_trip(self, reading: Reading) -> tuple[Row, ...]:
        """As `by_trip`, the rival being of the free bank."""
        rows = self.tracking_beside_free[reading.rate_basis, reading.schedule]
        return tuple(row for row in rows if row.trip != POOLED)


def figure_of(rows: ReadingRows, reading: Reading, figure: Figure) -> float:
    """The one number that ranks readings: the geometric mean of a ratio over the thresholds.

    Parameters
    ----------
    rows
        What the reading found.
    reading
        The reading, its rival with it.
    figure
        All messages over the baseline's, or the 90th percentile of the error over the rival's.

    Returns
    -------
    float
        NaN where a ratio does not exist.
    """
    if figure == "messages":
        ratios = [row.message_ratio for row in rows.messages]
    else:
        ratios = [row.p90_ratio for row in rows.pooled(reading)]
    values = np.array(ratios)
    return float(np.exp(np.log(values).mean())) if (values > 0).all() else float("nan")


def run_reading(
    trips: Sequence[Trajectory],
    reading: Reading,
    plan: PaperPlan,
    manoeuvres: Sequence[Sequence[FoundManoeuvre]] | None = None,
) -> ReadingRows:
    """Run a reading over trips that all hold a window.

    Parameters
    ----------
    trips
        With distinct identifiers.
    reading
        One option of every choice.
    plan
        What all readings share.
    manoeuvres
        Of each trip, at which the sub-models' paths are compared; none where not given.

    Raises
    ------
    ConfigError
        Where a trip lacks what the reading asks of it.
    """
    ratios = plan.packet_error_ratios if reading == PLAIN else (plan.headline_ratio,)
    settings = plan.settings(reading, ratios)
    compared = CompareSettings(settings, (settings.protocol,), resamples=plan.resamples)
    ((protocol, staged),) = stage_trips(trips, compared, beside=False).items()
    route = np.arange(len(trips), dtype=np.int64)
    resamples = Resamples.drawn(route, plan.resamples, plan.seed)
    trial = run_trial(
        HYBRID, protocol, staged, route, [settings] * len(trips), step=_nothing, bases=RATE_BASES
    )
    process = next(member for member in settings.bank.members if member.name != "cv")
    rates_alone = replace(settings, bank=Bank((process,)), packet_error_ratios=())
    alone = run_trial(ALONE, protocol, staged, route, [rates_alone] * len(trips), step=_nothing)
    rows = ratio_rows([*trial.counts, *alone.counts, *map(_updates, trial.counts)], ALONE, resamples)
    at_free = replace(settings, bank=free_bank(), start="order", identify="never", packet_error_ratios=())
    free = run_trial(FREE, protocol, staged, route, [at_free] * len(trips), step=_nothing)
    headline = replace(settings, packet_error_ratios=(plan.headline_ratio,))
    beside = run_trial(
        HYBRID,
        protocol,
        [_beside_free(trip, headline) for trip in staged],
        route,
        [headline] * len(trips),
        step=_nothing,
        bases=RATE_BASES,
    )
    rivals = rival_rows([*trial.counts, *free.counts], FREE, resamples)
    of = {name: tuple(row for row in rows if row.candidate == name) for name in (HYBRID, UPDATES, ALONE)}
    return ReadingRows(
        reading,
        messages=of[HYBRID],
        updates=of[UPDATES],
        alone=of[ALONE],
        tracking=_by_rival(trial, staged, resamples),
        beside_free=tuple(row for row in rivals if row.candidate == HYBRID),
        tracking_beside_free=_by_rival(beside, staged, resamples),
        complement=complement(staged, manoeuvres or [()] * len(trips), settings),
        headline_ratio=plan.headline_ratio,
    )


def _beside_free(trip: StagedTrip, settings: EvaluationSettings) -> StagedTrip:
    """The trip with plain messages that are coasted by the free bank as its baseline."""
    baseline = TripRuntime(
        trip.case.seen,
        free_bank(),
        trip.case.estimator,
        quantised=settings.quantised,
        sensed=trip.baseline.sensed,
    )
    return replace(trip, baseline=baseline, losses=LossRuns(trip.case, baseline, settings))


def _by_rival(
    trial: Trial, staged: Sequence[StagedTrip], resamples: Resamples
) -> dict[RivalKey, tuple[Row, ...]]:
    """Tracking rows by rate basis and schedule of the baseline."""
    times = [(trip.case.truth.dt_s, trip.case.truth.duration_s) for trip in staged]
    shares_s, durations_s = zip(*times, strict=True)
    tracking: dict[RivalKey, tuple[Row, ...]] = {}
    for schedule in get_args(Schedule):
        found = tracking_rows(
            HYBRID,
            trial,
            shares_s=shares_s,
            durations_s=durations_s,
            resamples=resamples,
            rivals=(schedule,),
            one_trip_by_seeds=True,
        )
        for basis in RATE_BASES:
            tracking[basis, schedule] = tuple(row for row in found if row.rate_basis == basis)
    return tracking


def _updates(row: Row) -> Row:
    """The row as if its identifications had not been sent."""
    return row.replaced(candidate=UPDATES, identifications=0)


def _nothing() -> None:
    """A trip is done: nobody watches the trips of a reading."""
