"""The main job: trips in, an `EvaluationResult` out."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict
from math import inf

import numpy as np

from modelcast.models.learned.spans import short_at
from modelcast.runtime.trip.context import TripContexts
from modelcast.runtime.trip.runtime import TripMessages, TripRuntime, sense_trip
from modelcast.station.banks import BASELINE_BANK
from modelcast.study.case import SensedTrip, TripCase, make_case, too_short
from modelcast.study.context import case_contexts, free_runtime, reads_context, trip_runtimes
from modelcast.study.gathered import Gathered, Illustration, TripCount
from modelcast.study.illustration import draw_manoeuvre, draw_timeline, sharpest_instant
from modelcast.study.play import draw_playback
from modelcast.study.pooling import TrackingPool, sorted_errors, trip_row
from modelcast.study.rate import count_free, count_rates
from modelcast.study.recording import AbstractRecordSink, HeldRecords, event_columns, sample_block
from modelcast.study.reference import count_references
from modelcast.study.result import EvaluationResult, TripRow
from modelcast.study.settings import EvaluationSettings
from modelcast.study.tracking import run_tracking
from modelcast.trips.fingerprint import known_trips
from modelcast.trips.trajectory import Trajectory

__all__ = ["evaluate", "evaluate_trip"]

Progress = Callable[[int, int], None]


def evaluate(
    trips: Iterable[Trajectory | SensedTrip],
    settings: EvaluationSettings | None = None,
    *,
    progress: Progress | None = None,
    records: AbstractRecordSink | None = None,
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
    records
        Takes messages and tracking-error samples trip by trip; the result then has none of them, and memory
        does not grow with the driving but by some rows a trip. Where None, the result keeps them.

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
    [('mbc', 0.5), ('baseline', 0.5), ('free', 0.5)]
    """
    settings = EvaluationSettings() if settings is None else settings
    held = HeldRecords()
    gathered = Gathered()
    contexts = None
    if reads_context(settings.bank):  # then trips know of each other
        trips = list(trips)
        contexts = case_contexts([make_case(trip, settings) for trip in trips], settings)
    for done, trip in enumerate(trips, start=1):
        gathered.merge(
            evaluate_trip(
                trip,
                settings,
                records=records or held,
                known=(contexts, done - 1),
                sharper_than_mps2=gathered.sharpness,
            )
        )
        if progress is not None:
            progress(done, done)
    return gathered.result(settings, held)


def evaluate_trip(
    trip: Trajectory | SensedTrip,
    settings: EvaluationSettings,
    *,
    records: AbstractRecordSink,
    known: tuple[TripContexts | None, int] = (None, 0),
    sharper_than_mps2: float = inf,
) -> Gathered:
    """What is found of one trip; of one that is too short for a window, that it failed.

    Parameters
    ----------
    trip
        As for `evaluate`.
    settings
        What to do.
    records
        Takes its messages and samples.
    known
        Contexts of all trips, and which this one is among them.
    sharper_than_mps2
        Draw its sharpest manoeuvre where that is sharper; by default it is only told.
    """
    seen = trip.seen if isinstance(trip, SensedTrip) else trip
    found = Gathered()
    reason = too_short(seen, int(settings.bank.windows.max()))
    if reason:
        found.failures[seen.trip_id] = reason
        return found
    case = make_case(trip, settings)
    quantised = settings.quantised
    sensed = sense_trip(case.seen, case.estimator, quantised=quantised)
    mbc, each = trip_runtimes(case, settings, sensed, *known)
    baseline = TripRuntime(case.seen, BASELINE_BANK, case.estimator, quantised=quantised, sensed=sensed)
    free = free_runtime(case, settings.rival, sensed, quantised=quantised)
    found.trips.append(_trip_row(case, settings))
    counted = count_rates(case, mbc, baseline, settings)
    beside = [] if free is None else count_free(case, free, settings)
    for count, walk in (*counted, *beside):
        found.counts.append(TripCount(seen.trip_id, count))
        records.add_events(event_columns(case, count, walk, settings))
    if settings.references:
        found.references += count_references(case, settings.thresholds_m)
    drawn = counted[2 * settings.detail][1]
    found.illustration = _illustrated(case, (mbc, each, baseline, free), drawn, settings, sharper_than_mps2)
    if not settings.packet_error_ratios:
        return found
    for run in run_tracking(case, each, baseline, settings, free):
        block = sample_block(case, run, settings)
        if block is not None:
            records.add_samples(block)
        for row, ratio in enumerate(settings.packet_error_ratios):
            pool = found.pools[run.contender, ratio] = TrackingPool(run.contender, ratio)
            pool.fill(run, row, case.truth.dt_s, case.truth.duration_s)
            found.tracking.append(trip_row(seen.trip_id, pool, sorted_errors(run, row)))
    return found


def _illustrated(
    case: TripCase,
    runtimes: tuple[TripRuntime, Sequence[TripRuntime], TripRuntime, TripRuntime | None],
    walk: TripMessages,
    settings: EvaluationSettings,
    sharper_than_mps2: float,
) -> Illustration | None:
    """The sharpest manoeuvre of a trip, drawn where it is sharper than that; or the instant asked for."""
    trip = case.truth.trip_id
    if settings.map_at is None:
        sharpest = sharpest_instant(case.truth)
        if sharpest is None:
            return None
        if sharpest.acceleration_mps2 <= sharper_than_mps2:
            return Illustration(trip, sharpest.acceleration_mps2)
        index, acceleration_mps2 = sharpest.index, sharpest.acceleration_mps2
    elif settings.map_at[0] == trip:
        index = min(int(np.searchsorted(case.truth.t_s, settings.map_at[1])), len(case.truth) - 1)
        acceleration_mps2 = 0.0
    else:
        return None
    mbc, _, baseline, _ = runtimes
    threshold_m = walk.policy.threshold_m
    return Illustration(
        trip,
        acceleration_mps2,
        timeline=draw_timeline(case, mbc, walk, index),
        manoeuvre=draw_manoeuvre(case, (mbc, baseline), threshold_m, index),
        playback=draw_playback(
            case, settings, runtimes, threshold_m=threshold_m, at_s=float(case.truth.t_s[index])
        ),
    )


def _trip_row(case: TripCase, settings: EvaluationSettings) -> TripRow:
    recorded = case.recorded
    idle = short_at(settings.bank, recorded.dt_s)
    understood = recorded.reading.understood
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
        in_training=bool(known_trips([recorded], settings.all_training_trips)),
        conditioning=None if case.conditioning is None else asdict(case.conditioning),
        warnings={**case.warnings, **({"bank": idle} if idle else {})},
        understood={} if understood is None else understood.lines(),
    )
