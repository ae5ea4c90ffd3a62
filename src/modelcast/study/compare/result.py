"""What a comparison returns: rows a trip, pooled rows with their intervals, and who took part."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any

__all__ = [
    "CandidateRow",
    "ComparedTrip",
    "ComparisonResult",
    "CountRow",
    "RatioRow",
    "ReferenceRatio",
    "RivalRow",
    "RouteRow",
    "TrackingRatioRow",
    "message_bound",
    "rival_bound",
]


def message_bound(baseline_messages: float) -> float:
    """The most messages that a candidate may send on one trip to do no harm there.

    Examples
    --------
    >>> message_bound(100), message_bound(1000)
    (103, 1020.0)
    """
    return max(1.02 * baseline_messages, baseline_messages + 3)


def rival_bound(rival_messages: float) -> float:
    """The most messages that a candidate may send on one trip to do no harm beside the one compared against.

    Examples
    --------
    >>> rival_bound(40), rival_bound(1000)
    (45, 1050.0)
    """
    return max(1.05 * rival_messages, rival_messages + 5)


@dataclass(frozen=True, slots=True)
class RouteRow:
    """Trips that share their ground or their platoon.

    Parameters
    ----------
    route, name
        Number from 0, and the first file.
    trips, duration_s
        How many, and the time observed [s].
    """

    route: int
    name: str
    trips: int
    duration_s: float


@dataclass(frozen=True, slots=True)
class ComparedTrip:
    """One trip that took part.

    Parameters
    ----------
    id, source
        Identifier, and name of the format.
    route
        Number of its route.
    duration_s, samples, dt_s
        Time observed [s], samples, and their median step [s].
    warnings
        What must be known of the recording before any figure, by kind, as in
        `modelcast.trips.judgement.judge`.
    in_training
        Whether the profile in use was trained on this very trip.
    """

    id: str
    source: str
    route: int
    _: KW_ONLY
    duration_s: float
    samples: int
    dt_s: float
    warnings: Mapping[str, str] = field(default_factory=dict[str, str])
    in_training: bool = False


@dataclass(frozen=True, slots=True)
class CandidateRow:
    """One candidate.

    Parameters
    ----------
    name
        As in all other rows.
    sub_models
        Members in order, with their settings; of a trained candidate, as fitted for the first route left out.
    start, identify
        Rules of its policy.
    is_trained
        Whether it was fitted anew for every route left out.
    is_hybrid
        Whether it has several members, so that identifications may occur.
    update_bytes
        Application bytes of one model update, the first sub-model in use.
    """

    name: str
    sub_models: tuple[str, ...]
    _: KW_ONLY
    start: str
    identify: str
    is_trained: bool
    is_hybrid: bool
    update_bytes: int


@dataclass(frozen=True, slots=True)
class CountRow:
    """Messages of one candidate over one trip on an ideal channel, without keep-alive.

    Parameters
    ----------
    candidate, protocol, trip
        Whose messages, in which protocol, on which trip.
    route
        Route of the trip: what a trained candidate had not seen.
    threshold_m
        Tracking-error threshold [m].
    updates, identifications, message_bytes
        What was sent.
    baseline_messages, baseline_bytes
        What the baseline sent at the same threshold.
    airtime_s, baseline_airtime_s
        How long the messages of both occupy the channel, all layers counted [s].
    duration_s
        Time observed [s].
    """

    candidate: str
    protocol: str
    trip: str
    _: KW_ONLY
    route: int
    threshold_m: float
    updates: int
    identifications: int
    message_bytes: int
    baseline_messages: int
    baseline_bytes: int
    airtime_s: float
    baseline_airtime_s: float
    duration_s: float

    @property
    def messages(self) -> int:
        """Updates and identifications."""
        return self.updates + self.identifications

    @property
    def excess(self) -> float:
        """Messages beyond `message_bound` of the baseline's; negative where there is room."""
        return self.messages - message_bound(self.baseline_messages)


@dataclass(frozen=True, slots=True)
class RatioRow:
    """Messages of one candidate over all trips: ratios of sums, with 95 % intervals over the trips.

    Parameters
    ----------
    candidate, protocol, threshold_m
        Whose figures.
    trips, duration_s
        What they are over [s].
    update_rate_hz, identification_rate_hz, baseline_rate_hz
        Messages over the time observed [Hz].
    message_ratio, message_low, message_high
        All messages over the baseline's.
    difference, difference_low, difference_high
        That ratio less the one of the candidate compared against.
    bytes_per_s, baseline_bytes_per_s
        Application bytes over the time observed [byte/s].
    bytes_ratio, bytes_low, bytes_high
        Their ratio.
    airtime_per_s, baseline_airtime_per_s
        Time on the air over the time observed, all layers and the security header counted [s/s].
    airtime_ratio, airtime_low, airtime_high
        Their ratio.
    trips_over
        Trips on which it sent more than `message_bound` allows.
    worst_trip, worst_excess, worst_ratio
        The trip with the most messages beyond that bound, how many (negative where there is room), and its
        ratio to the baseline.
    """

    candidate: str
    protocol: str
    threshold_m: float
    _: KW_ONLY
    trips: int
    duration_s: float
    update_rate_hz: float
    identification_rate_hz: float
    baseline_rate_hz: float
    message_ratio: float
    message_low: float | None
    message_high: float | None
    difference: float
    difference_low: float | None
    difference_high: float | None
    bytes_per_s: float
    baseline_bytes_per_s: float
    bytes_ratio: float
    bytes_low: float | None
    bytes_high: float | None
    airtime_per_s: float
    baseline_airtime_per_s: float
    airtime_ratio: float
    airtime_low: float | None
    airtime_high: float | None
    trips_over: int
    worst_trip: str
    worst_excess: float
    worst_ratio: float


@dataclass(frozen=True, slots=True)
class RivalRow:
    """Messages of one candidate over those of the one compared against: ratios of sums over all trips.

    Parameters
    ----------
    candidate, rival, protocol, threshold_m
        Whose figures, over whose.
    message_ratio, message_low, message_high
        All messages, with a 95 % interval over the trips.
    bytes_ratio, bytes_low, bytes_high
        Application bytes.
    airtime_ratio, airtime_low, airtime_high
        Time on the air.
    trips, trips_over
        How many, and on how many it sent more than `rival_bound` allows.
    worst_trip, worst_excess, worst_ratio
        The trip with the most messages beyond that bound, how many (negative where there is room), and its
        ratio.
    """

    candidate: str
    rival: str
    protocol: str
    _: KW_ONLY
    threshold_m: float
    message_ratio: float
    message_low: float | None
    message_high: float | None
    bytes_ratio: float
    bytes_low: float | None
    bytes_high: float | None
    airtime_ratio: float
    airtime_low: float | None
    airtime_high: float | None
    trips: int
    trips_over: int
    worst_trip: str
    worst_excess: float
    worst_ratio: float


@dataclass(frozen=True, slots=True)
class TrackingRatioRow:
    """Tracking error of one candidate under loss, beside both readings of the baseline at equal rate.

    Parameters
    ----------
    candidate, protocol, trip
        Whose errors; ``all`` pools the trips, weighted by time.
    threshold_m, packet_error_ratio
        Tracking-error threshold [m], and mean share of messages lost, 0..1.
    rate_basis
        Whether the baselines send as often as the candidate does in all (``total``), or as it sends model
        updates alone (``update``, the paper's).
    message_rate_hz, matched_rate_hz, periodic_rate_hz
        Messages sent over the time observed, keep-alive included [Hz].
    p90_m, matched_p90_m, periodic_p90_m
        90th percentiles of the tracking error after the instant's message [m]: of the candidate, of the
        baseline with its threshold bisected to that rate, and of the periodic baseline.
    p99_m, matched_p99_m, periodic_p99_m
        The same, 99th percentiles.
    p90_ratio, p99_ratio
        The candidate's over that of the baselines compared with, of both the smaller.
    p90_low, p90_high, p99_low, p99_high
        95 % intervals of the ratios over the trips; None for single trips.
    """

    candidate: str
    protocol: str
    trip: str
    _: KW_ONLY
    threshold_m: float
    packet_error_ratio: float
    rate_basis: str
    message_rate_hz: float
    matched_rate_hz: float
    periodic_rate_hz: float
    p90_m: float
    matched_p90_m: float
    periodic_p90_m: float
    p90_ratio: float
    p90_low: float | None
    p90_high: float | None
    p99_m: float
    matched_p99_m: float
    periodic_p99_m: float
    p99_ratio: float
    p99_low: float | None
    p99_high: float | None


@dataclass(frozen=True, slots=True)
class ReferenceRatio:
    """Messages of a reference over the baseline's, all trips pooled.

    Parameters
    ----------
    reference
        As in `modelcast.study.result.REFERENCES`.
    protocol, threshold_m
        Protocol and threshold [m]; a reference that knows no threshold has a row at each.
    message_ratio
        Its messages over the baseline's at that threshold.
    """

    reference: str
    protocol: str
    threshold_m: float
    message_ratio: float


@dataclass(frozen=True, slots=True)
class ComparisonResult:
    """Everything one comparison found.

    Parameters
    ----------
    settings
        What was asked for, as plain values.
    routes, trips, candidates
        Who took part.
    ratios, tracking
        Rows of the table: messages, and tracking under loss; `tracking` has a row a trip too.
    counts
        Messages trip by trip.
    rivals
        Messages over those of the candidate compared against.
    references
        What the figure draws beside the candidates; empty where it was not asked for.
    failures, skipped
        Trips that could not be compared, and files and vehicles that held no trip, with the reason.
    """

    settings: Mapping[str, Any]
    _: KW_ONLY
    routes: tuple[RouteRow, ...]
    trips: tuple[ComparedTrip, ...]
    candidates: tuple[CandidateRow, ...]
    ratios: tuple[RatioRow, ...]
    tracking: tuple[TrackingRatioRow, ...]
    counts: tuple[CountRow, ...]
    rivals: tuple[RivalRow, ...] = ()
    references: tuple[ReferenceRatio, ...] = ()
    failures: Mapping[str, str] = field(default_factory=dict[str, str])
    skipped: Mapping[str, str] = field(default_factory=dict[str, str])

    @property
    def rival(self) -> str | None:
        """The candidate compared against, where that says more than the baseline does; else None."""
        name = self.rivals[0].rival if self.rivals else None
        own = {row.message_ratio for row in self.ratios if row.candidate == name}
        return None if len(self.candidates) < 2 or own == {1.0} else name
