"""The main job: trips in, an `EvaluationResult` out."""

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, field

import numpy as np

from modelcast.core.exceptions import ConfigError
from modelcast.models.learned.spans import short_at
from modelcast.runtime.trip.context import TripContexts
from modelcast.runtime.trip.runtime import TripMessages, TripRuntime, sense_trip
from modelcast.station.banks import BASELINE_BANK
from modelcast.study.case import SensedTrip, TripCase, make_case
from modelcast.study.context import case_contexts, reads_context, trip_runtimes
from modelcast.study.illustration import draw_manoeuvre, draw_timeline, sharpest_instant
from modelcast.study.pooling import TrackingPool, pool_ecdf, pool_row
from modelcast.study.rate import RateCount, count_rates, pooled_rates, rate_row
from modelcast.study.recording import EventRecorder, sample_block
from modelcast.study.reference import count_references, pooled_references
from modelcast.study.result import (
    POOLED,
    RATES,
    REFERENCES,
    TRACKING,
    EvaluationResult,
    Manoeuvre,
    SampleBlock,
    Timeline,
    TripRow,
)
from modelcast.study.settings import EvaluationSettings
from modelcast.study.table import Row
from modelcast.study.tracking import Contender, run_tracking
from modelcast.trips.fingerprint import known_trips
from modelcast.trips.trajectory import Trajectory

__all__ = ["evaluate"]

Progress = Callable[[int, int], None]


@dataclass(slots=True)
class _Collected:
    """What has been gathered from the trips so far."""

    trips: list[TripRow] = field(default_factory=list[TripRow])
    counts: list[RateCount] = field(default_factory=list[RateCount])
    rates: list[Row] = field(default_factory=list[Row])
    references: list[Row] = field(default_factory=list[Row])
    tracking: list[Row] = field(default_factory=list[Row])
    pools: dict[tuple[Contender, float], TrackingPool] = field(
        default_factory=dict[tuple[Contender, float], TrackingPool]
    )
    samples: list[SampleBlock] = field(default_factory=list[SampleBlock])
    failures: dict[str, str] = field(default_factory=dict[str, str])
    sharpness: float = -1.0
    timeline: Timeline | None = None
    manoeuvre: Manoeuvre | None = None


def evaluate(
    trips: Iterable[Trajectory | SensedTrip],
    settings: EvaluationSettings | None = None,
    *,
    progress: Progress | None = None,
) -> EvaluationResult:
    """Run the hybrid bank and the raw-message baseline over trips: rates, tracking under loss, figures' data.

    Parameters
    ----------
    trips
        Recorded trips, or trips whose truth is known apart; they are taken one at a time,
        but all at once for a bank that reads context.
    settings
        What to do; the defaults are the paper's.
    progress
        Called with trips done and trips known so far.

    Returns
    -------
    EvaluationResult
        Rows per trip and pooled, and what the figures draw.

    Raises
    ------
    ConfigError
        Where no trip is long enough for a window.

    Examples
    --------
    >>> from modelcast.world.drive import generate_drive
    >>> drive = generate_drive(seed=1, duration_s=120.0)
    >>> settings = EvaluationSettings((0.5,), (0.0,), seeds=1)
    >>> result = evaluate([drive.truth], settings)
    >>> [(row.policy, row.threshold_m) for row in result.rates if row.trip == "all"]
    [('mbc', 0.5), ('baseline', 0.5)]
    """
    settings = EvaluationSettings() if settings is None else settings
    collected = _Collected()
    events = EventRecorder(settings)
    done = 0
    contexts = None
    if reads_context(settings.bank):  # then trips know of each other
        trips = list(trips)
        contexts = case_contexts([make_case(trip, settings) for trip in trips], settings)
    for done, trip in enumerate(trips, start=1):
        _evaluate_trip(trip, settings, collected, events, (contexts, done - 1))
        if progress is not None:
            progress(done, done)
    if not collected.trips:
        reasons = "; ".join(f"{trip}: {reason}" for trip, reason in collected.failures.items())
        raise ConfigError("no usable trip" + (f" ({reasons})" if reasons else ""))
    if settings.map_at is not None and collected.manoeuvre is None:
        raise ConfigError(f"no trip named {settings.map_at[0]} to draw the map of")
    return EvaluationResult(
        settings.as_plain(),
        trips=tuple(collected.trips),
        rates=RATES.table([*pooled_rates(collected.counts), *collected.rates]),
        tracking=TRACKING.table(
            [*(pool_row(POOLED, pool) for pool in collected.pools.values()), *collected.tracking]
        ),
        ecdfs=tuple(pool_ecdf(pool) for pool in collected.pools.values()),
        timeline=collected.timeline,
        manoeuvre=collected.manoeuvre,
        events=events.columns(),
        samples=tuple(collected.samples),
        failures=collected.failures,
        references=REFERENCES.table([*pooled_references(collected.references), *collected.references]),
    )


def _evaluate_trip(
    trip: Trajectory | SensedTrip,
    settings: EvaluationSettings,
    collected: _Collected,
    events: EventRecorder,
    known: tuple[TripContexts | None, int],
) -> None:
    seen = trip.seen if isinstance(trip, SensedTrip) else trip
    trip_id = seen.trip_id
    if trip_id in {row.id for row in collected.trips} | set(collected.failures):
        raise ConfigError(f"two trips are named {trip_id}: rename one of their files")
    longest = int(np.diff(seen.segments).max())
    needed = int(settings.bank.windows.max())
    if longest < needed:
        collected.failures[trip_id] = f"its longest part has {longest} samples, a window needs {needed}"
        return
    case = make_case(trip, settings)
    quantised = settings.quantised
    sensed = sense_trip(case.seen, case.estimator, quantised=quantised)
    mbc, each = trip_runtimes(case, settings, sensed, *known)
    baseline = TripRuntime(case.seen, BASELINE_BANK, case.estimator, quantised=quantised, sensed=sensed)
    collected.trips.append(_trip_row(case, settings))
    counted = count_rates(case, mbc, baseline, settings)
    for count, walk in counted:
        collected.counts.append(count)
        collected.rates.append(rate_row(trip_id, count))
        events.add(case, count, walk)
    if settings.references:
        collected.references += count_references(case, settings.thresholds_m)
    _illustrate(case, (mbc, baseline), counted[0][1], settings, collected)
    for run in run_tracking(case, each, baseline, settings):
        block = sample_block(case, run, settings)
        if block is not None:
            collected.samples.append(block)
        for row, ratio in enumerate(settings.packet_error_ratios):
            own = TrackingPool(run.contender, ratio)
            shared = collected.pools.setdefault((run.contender, ratio), TrackingPool(run.contender, ratio))
            own.fill(run, row, case.truth.dt_s, case.truth.duration_s)
            shared.merge(own)
            collected.tracking.append(pool_row(trip_id, own))


def _illustrate(
    case: TripCase,
    banks: tuple[TripRuntime, TripRuntime],
    walk: TripMessages,
    settings: EvaluationSettings,
    collected: _Collected,
) -> None:
    """Keep the timeline and the map of the sharpest manoeuvre so far, or of the one asked for."""
    if settings.map_at is None:
        sharpest = sharpest_instant(case.truth)
        if sharpest is None or sharpest.acceleration_mps2 <= collected.sharpness:
            return
        collected.sharpness = sharpest.acceleration_mps2
        index = sharpest.index
    elif settings.map_at[0] == case.truth.trip_id:
        index = min(int(np.searchsorted(case.truth.t_s, settings.map_at[1])), len(case.truth) - 1)
    else:
        return
    threshold_m = walk.policy.threshold_m
    collected.timeline = draw_timeline(case, banks[0], walk, index)
    collected.manoeuvre = draw_manoeuvre(case, banks, threshold_m, index)


def _trip_row(case: TripCase, settings: EvaluationSettings) -> TripRow:
    recorded = case.recorded
    idle = short_at(settings.bank, recorded.dt_s)
    return TripRow(
        recorded.trip_id,
        recorded.source,
        case.truth.duration_s,
        standing_s=float(np.count_nonzero(case.standing) * case.truth.dt_s),
        vehicles=1,
        samples=len(recorded),
        dt_s=recorded.dt_s,
        gaps=case.inspection.gaps,
        resampled=recorded.resampled,
        protocol=case.protocol,
        conditioned=case.conditioning is not None,
        velocity_estimator=case.estimator.name,
        grid_m=case.inspection.grid_axis_m,
        rows=recorded.reading.rows,
        skipped=dict(recorded.reading.skipped),
        repaired=dict(recorded.reading.repaired),
        in_training=bool(known_trips([recorded], settings.training_trips)),
        conditioning=None if case.conditioning is None else asdict(case.conditioning),
        warnings={**case.warnings, **({"bank": idle} if idle else {})},
    )
