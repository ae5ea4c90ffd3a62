"""Trips made ready once for all candidates: truth, what is seen, and the baseline they are held against."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from modelcast.core.exceptions import ConfigError
from modelcast.runtime.trip.context import TripContexts
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.banks import BASELINE_BANK
from modelcast.study.case import TripCase, make_case, too_short
from modelcast.study.compare.beside import BesideRuns
from modelcast.study.compare.result import REFERENCE_RATIOS
from modelcast.study.compare.settings import CompareSettings
from modelcast.study.context import case_contexts, free_runtime
from modelcast.study.reference import count_references, pooled_references
from modelcast.study.table import Row
from modelcast.study.tracking import LossRuns
from modelcast.trips.trajectory import Trajectory

__all__ = [
    "StagedTrip",
    "baseline_messages",
    "ratios_of_references",
    "reference_ratios",
    "stage_trips",
    "usable_trips",
]


@dataclass(frozen=True, slots=True)
class StagedTrip:
    """One trip in one protocol, with what every candidate is compared with.

    Parameters
    ----------
    case
        Truth and what the sender sees.
    baseline
        The baseline's bank, ready for it.
    losses
        The loss runs, whose losses and baselines all candidates share.
    contexts, place
        Contexts of all trips in this protocol, and which this one is among them.
    beside
        What candidates are held against beside the equal-rate baselines; None where they are not.
    """

    case: TripCase
    baseline: TripRuntime
    losses: LossRuns
    contexts: TripContexts
    place: int
    beside: BesideRuns | None = None


def stage_trips(
    trips: Sequence[Trajectory], settings: CompareSettings, *, beside: bool = True
) -> dict[str, list[StagedTrip]]:
    """Every trip made ready in every protocol, by protocol.

    Parameters
    ----------
    trips
        The trips, in order.
    settings
        Protocols, sensor and losses.
    beside
        Whether candidates are held against baseline and free receiver at the same threshold, and against the
        free receiver at the same rate, too.
    """
    staged: dict[str, list[StagedTrip]] = {}
    for protocol in settings.protocols:
        own = replace(settings.evaluation, protocol=protocol)
        staged[protocol] = []
        cases = [make_case(trip, own) for trip in trips]
        contexts = case_contexts(cases, own)
        for place, case in enumerate(cases):
            baseline = TripRuntime(case.seen, BASELINE_BANK, case.estimator, quantised=own.quantised)
            losses = LossRuns(case, baseline, own)
            free = free_runtime(case, own.free, baseline.sensed, quantised=own.quantised)
            rivals = BesideRuns(losses, free) if beside else None
            staged[protocol].append(StagedTrip(case, baseline, losses, contexts, place, rivals))
    return staged


def reference_ratios(staged: dict[str, list[StagedTrip]], settings: CompareSettings) -> list[Row]:
    """Messages of the references over the baseline's, pooled over the trips of each protocol.

    Parameters
    ----------
    staged
        As `stage_trips` returns them.
    settings
        Thresholds, and whether references are asked for.
    """
    if not settings.evaluation.references:
        return []
    thresholds_m = settings.evaluation.thresholds_m
    found: list[Row] = []
    for protocol, trips in staged.items():
        rows = [row for trip in trips for row in count_references(trip.case, thresholds_m)]
        each = [baseline_messages(trip, settings) for trip in trips]
        baselines = {threshold_m: sum(one[threshold_m] for one in each) for threshold_m in thresholds_m}
        found += ratios_of_references(protocol, rows, baselines)
    return found


def baseline_messages(trip: StagedTrip, settings: CompareSettings) -> dict[float, int]:
    """Messages of the baseline over one trip, by threshold.

    Parameters
    ----------
    trip
        The trip.
    settings
        Thresholds.
    """
    return {
        threshold_m: trip.baseline.run(settings.evaluation.policy(threshold_m, keep_alive=False)).updates
        for threshold_m in settings.evaluation.thresholds_m
    }


def ratios_of_references(protocol: str, rows: Sequence[Row], baselines: Mapping[float, int]) -> list[Row]:
    """Messages of the references over the baseline's in one protocol.

    Parameters
    ----------
    protocol
        Which.
    rows
        References of all trips, as `count_references` gives them.
    baselines
        Messages of the baseline over all trips, by threshold.
    """
    pooled = pooled_references(rows)
    return [
        REFERENCE_RATIOS.row(
            reference=row.reference,
            protocol=protocol,
            threshold_m=threshold_m,
            message_ratio=row.messages / baseline,
        )
        for threshold_m, baseline in baselines.items()
        for row in pooled
        if row.threshold_m in {None, threshold_m}
    ]


def usable_trips(trips: Sequence[Trajectory], window: int) -> tuple[list[Trajectory], dict[str, str]]:
    """Trips that hold a window, and why the others are left out.

    Parameters
    ----------
    trips
        The trips, in order.
    window
        Samples that some part of a trip must hold.

    Raises
    ------
    ConfigError
        Where two have one name, or none holds the window.
    """
    usable: list[Trajectory] = []
    failures: dict[str, str] = {}
    seen: set[str] = set()
    for trip in trips:
        if trip.trip_id in seen:
            raise ConfigError(f"two trips are named {trip.trip_id}: rename one of their files")
        seen.add(trip.trip_id)
        reason = too_short(trip, window)
        if reason:
            failures[trip.trip_id] = reason
        else:
            usable.append(trip)
    if not usable:
        reasons = "; ".join(f"{trip}: {reason}" for trip, reason in failures.items())
        raise ConfigError("no usable trip" + (f" ({reasons})" if reasons else ""))
    return usable, failures
