"""One candidate over all trips: its messages, and its errors under loss beside those of its rivals."""

from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass, field

from modelcast.core.arrays import FloatArray, IntArray, SingleArray
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.study.compare.beside import SortedErrors
from modelcast.study.compare.candidate import AbstractCandidate
from modelcast.study.compare.result import COUNTS, CandidateRow
from modelcast.study.compare.stage import StagedTrip
from modelcast.study.context import trip_runtimes
from modelcast.study.metrics import quantiles
from modelcast.study.rate import count_rates
from modelcast.study.rules import RateBasis
from modelcast.study.settings import EvaluationSettings
from modelcast.study.table import Row
from modelcast.study.tracking import walks_under_loss
from modelcast.trips.trajectory import Trajectory

__all__ = [
    "BESIDE",
    "FREE_AT_RATE",
    "READINGS",
    "RIVALS",
    "ErrorGroup",
    "Trial",
    "candidate_row",
    "fit_folds",
    "run_trial",
]

RIVALS = ("matched", "periodic")
"""Both readings of the equal-rate baseline."""

READINGS = ("own", *RIVALS)
"""The candidate, and both of them."""

FREE_AT_RATE = "free_matched"
"""The free receiver at the candidate's rate."""

BESIDE = ("baseline", "free", FREE_AT_RATE)
"""Baseline and free receiver at the candidate's threshold, and the latter at its rate, as far as run."""


@dataclass(slots=True)
class ErrorGroup:
    """Errors of one candidate and its rivals at one threshold and loss ratio, trip by trip.

    Parameters
    ----------
    threshold_m, packet_error_ratio, rate_basis
        Which.
    errors_m
        For each of `READINGS` and `BESIDE`, for each trip, its sorted errors, one array a seed [m]; nothing
        of who is not run.
    messages
        For each of them, messages sent on each trip, keep-alive included.
    """

    threshold_m: float
    packet_error_ratio: float
    rate_basis: RateBasis = "total"
    _: KW_ONLY
    errors_m: dict[str, list[list[SingleArray]]] = field(
        default_factory=lambda: {name: [] for name in (*READINGS, *BESIDE)}
    )
    messages: dict[str, list[float]] = field(
        default_factory=lambda: {name: [] for name in (*READINGS, *BESIDE)}
    )
    _known: dict[tuple[str, range], FloatArray] = field(default_factory=dict[tuple[str, range], FloatArray])

    def quantiles_of(
        self, reading: str, trips: range, shares_s: Sequence[float], probabilities: Sequence[float]
    ) -> FloatArray:
        """Quantiles over some trips, each sample weighing the time it stands for, (Q,) [m].

        Found once: every comparison with another rival asks for them again.

        Parameters
        ----------
        reading
            Of `READINGS` or `BESIDE`, and run.
        trips
            Their places.
        shares_s
            The time one sample of each trip stands for, (N,) [s].
        probabilities
            Q of them, rising, the same at every call.
        """
        key = reading, trips
        if key not in self._known:
            rows = [row for at in trips for row in self.errors_m[reading][at]]
            weights = [shares_s[at] for at in trips for _ in self.errors_m[reading][at]]
            self._known[key] = quantiles(rows, weights, probabilities)
        return self._known[key]


@dataclass(frozen=True, slots=True)
class Trial:
    """One candidate in one protocol.

    Parameters
    ----------
    protocol
        Which protocol.
    counts
        One row for each trip and threshold, in the order of the trips.
    groups
        One for each threshold, rate basis and loss ratio.
    """

    protocol: str
    counts: list[Row]
    groups: list[ErrorGroup]


def fit_folds(
    candidate: AbstractCandidate,
    trips: Sequence[Trajectory],
    route: IntArray,
    settings: EvaluationSettings,
) -> list[EvaluationSettings]:
    """The candidate's settings for every route left out, in the order of the routes.

    Parameters
    ----------
    candidate
        Fitted once where it learns nothing, else once a route, on the trips of all others.
    trips, route
        All trips, and the route of each, (N,).
    settings
        What all candidates share.
    """
    count = int(route.max(initial=-1)) + 1
    if not candidate.is_trained:
        return [candidate.fitted((), settings)] * count
    numbers: list[int] = route.tolist()
    folds = (
        [trip for trip, own in zip(trips, numbers, strict=True) if own != left_out]
        for left_out in range(count)
    )
    return [candidate.fitted(others, settings) for others in folds]


def candidate_row(candidate: AbstractCandidate, settings: EvaluationSettings) -> CandidateRow:
    """The row that says who a candidate is.

    Parameters
    ----------
    candidate
        The candidate.
    settings
        As it was fitted for the first route left out.
    """
    return CandidateRow(
        candidate.name,
        tuple(repr(member) for member in settings.bank.members),
        start=settings.rules[0],
        identify=settings.rules[1],
        is_trained=candidate.is_trained,
        is_hybrid=len(settings.bank.members) > 1,
        update_bytes=int(settings.sizes.each_update_bytes(settings.bank, settings.rules[1]).max()),
    )


def run_trial(
    name: str,
    protocol: str,
    staged: Sequence[StagedTrip],
    route: IntArray,
    folds: Sequence[EvaluationSettings],
    *,
    step: Callable[[], None],
    bases: Sequence[RateBasis] = ("total",),
) -> Trial:
    """Run one candidate over all trips of one protocol.

    Parameters
    ----------
    name, protocol
        The candidate's name, and which protocol the trips were made ready in.
    staged, route
        The trips, and the route of each, (N,).
    folds
        The candidate's settings for every route left out.
    step
        Called after each trip.
    bases
        What the equal-rate baselines' rate is equal to.
    """
    first = folds[0]
    groups = [
        ErrorGroup(threshold_m, ratio, basis)
        for threshold_m in first.thresholds_m
        for basis in bases
        for ratio in first.packet_error_ratios
    ]
    trial = Trial(protocol, [], groups)
    numbers: list[int] = route.tolist()
    for trip, number in zip(staged, numbers, strict=True):
        settings = folds[number]
        ready, each = trip_runtimes(trip.case, settings, trip.baseline.sensed, trip.contexts, trip.place)
        trial.counts.extend(_count_rows(name, protocol, trip, ready, settings, route=number))
        _add_errors(trial, trip, each, settings, bases)
        step()
    return trial


def _count_rows(
    name: str,
    protocol: str,
    trip: StagedTrip,
    ready: TripRuntime,
    settings: EvaluationSettings,
    *,
    route: int,
) -> list[Row]:
    """The messages of one trip at every threshold, beside the baseline's."""
    counts = [count for count, _ in count_rates(trip.case, ready, trip.baseline, settings)]
    return [
        COUNTS.row(
            candidate=name,
            protocol=protocol,
            trip=trip.case.truth.trip_id,
            route=route,
            threshold_m=own.threshold_m,
            updates=own.updates,
            identifications=own.identifications,
            message_bytes=own.message_bytes,
            baseline_messages=base.updates,
            baseline_bytes=base.message_bytes,
            airtime_s=own.airtime_s,
            baseline_airtime_s=base.airtime_s,
            duration_s=own.duration_s,
        )
        for own, base in zip(counts[::2], counts[1::2], strict=True)
    ]


def _add_errors(
    trial: Trial,
    trip: StagedTrip,
    each: Sequence[TripRuntime],
    settings: EvaluationSettings,
    bases: Sequence[RateBasis],
) -> None:
    """Add one trip's errors to every group."""
    if not settings.packet_error_ratios:
        return
    groups = iter(trial.groups)
    for threshold_m in settings.thresholds_m:
        walks = walks_under_loss(each, settings, threshold_m)
        runs = trip.losses.contended(each, walks, settings, threshold_m, bases)
        own, *rivals = map(SortedErrors.of, runs)
        shared: dict[str, SortedErrors] = {}
        free: list[SortedErrors] = []
        if trip.beside is not None:
            shared = trip.beside.at_threshold(settings, threshold_m)
            free = trip.beside.at_equal_rate(settings, threshold_m, walks, bases)
        for at in range(len(bases)):
            found = dict(
                zip(READINGS, [own, *rivals[len(RIVALS) * at : len(RIVALS) * (at + 1)]], strict=True)
            )
            found |= shared | ({FREE_AT_RATE: free[at]} if free else {})
            for row in range(len(settings.packet_error_ratios)):
                group = next(groups)
                for name, run in found.items():
                    group.errors_m[name].append(run.errors_m[row])
                    group.messages[name].append(run.messages[row])
