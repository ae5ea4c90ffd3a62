"""What a comparison returns: rows a trip, pooled rows with their intervals, and who took part."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any

from modelcast.station.banks import BASELINE_BANK
from modelcast.study.table import Column, Row, Table, TableSchema, count, quantity, ratio, text

__all__ = [
    "COUNTS",
    "RATIOS",
    "REFERENCE_RATIOS",
    "RIVAL_RATIOS",
    "ROUTES",
    "TRACKING_RATIOS",
    "CandidateRow",
    "ComparedTrip",
    "ComparisonResult",
    "excess_of",
    "message_bound",
    "messages_of",
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


_DURATION = quantity("duration_s", "s", "Time observed.")
_CANDIDATE = text("candidate", "Name of the candidate.")
_PROTOCOL = text("protocol", "Whether inputs are recorded or simulated.")
_THRESHOLD = quantity("threshold_m", "m", "Tracking-error threshold.")
_ONE_TRIP = "one trip, or one route, has no interval"

ROUTES = TableSchema(
    "routes",
    "Trips that share their ground or their platoon.",
    (
        count("route", "Number, from 0."),
        text("name", "Its first file."),
        count("trips", "How many trips."),
        _DURATION,
    ),
)
"""Routes: a row each."""


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


COUNTS = TableSchema(
    "messages",
    "Messages of one candidate over one trip on an ideal channel, without keep-alive.",
    (
        _CANDIDATE,
        _PROTOCOL,
        text("trip", "Identifier of the trip."),
        count("route", "Route of the trip: what a trained candidate had not seen."),
        _THRESHOLD,
        count("updates", "Model updates sent."),
        count("identifications", "Identifications sent."),
        count("message_bytes", "Application bytes sent.", unit="byte"),
        count("baseline_messages", "Messages that the baseline sent at the same threshold."),
        count("baseline_bytes", "Application bytes that the baseline sent.", unit="byte"),
        quantity("airtime_s", "s", "Time that the messages occupy the channel, all layers counted."),
        quantity("baseline_airtime_s", "s", "The same of the baseline's messages."),
        _DURATION,
    ),
)
"""Messages trip by trip: a row a candidate, protocol, trip and threshold."""


def messages_of(row: Row) -> int:
    """Return updates and identifications of a row of `COUNTS`."""
    return row.updates + row.identifications


def excess_of(row: Row) -> float:
    """Return how many messages of a row of `COUNTS` are beyond `message_bound` of the baseline's.

    It is negative where there is room.
    """
    return messages_of(row) - message_bound(row.baseline_messages)


def _over(whose: str, *limited: str) -> tuple[Column, ...]:
    """Ratios to someone's messages, bytes or airtime, each with its interval."""
    what = {"message": "All messages", "bytes": "Application bytes", "airtime": "Time on the air"}
    return tuple(
        column
        for name in limited
        for column in (
            quantity(f"{name}_ratio", "1", f"{what[name]} over {whose}."),
            quantity(f"{name}_low", "1", "Lower end of its 95 % interval over trips.", missing=_ONE_TRIP),
            quantity(f"{name}_high", "1", "Upper end of its 95 % interval.", missing=_ONE_TRIP),
        )
    )


_WORST = (
    text("worst_trip", "Trip with the most messages beyond the bound."),
    quantity("worst_excess", "1", "How many messages beyond it; negative where there is room."),
    quantity("worst_ratio", "1", "Its messages over the other's."),
)

RATIOS = TableSchema(
    "ratios",
    "Messages of one candidate over all trips: ratios of sums, with 95 % intervals over the trips.",
    (
        _CANDIDATE,
        _PROTOCOL,
        _THRESHOLD,
        count("trips", "How many trips."),
        _DURATION,
        quantity("update_rate_hz", "1/s", "Model updates over the time observed."),
        quantity("identification_rate_hz", "1/s", "Identifications over the time observed."),
        quantity("baseline_rate_hz", "1/s", "Messages of the baseline over the time observed."),
        *_over("the baseline's", "message"),
        quantity("difference", "1", "That ratio less the one of the candidate compared against."),
        quantity("difference_low", "1", "Lower end of its 95 % interval.", missing=_ONE_TRIP),
        quantity("difference_high", "1", "Upper end of its 95 % interval.", missing=_ONE_TRIP),
        quantity("bytes_per_s", "byte/s", "Application bytes over the time observed."),
        quantity("baseline_bytes_per_s", "byte/s", "Those of the baseline."),
        *_over("the baseline's", "bytes"),
        quantity(
            "airtime_per_s",
            "s/s",
            "Time on the air over the time observed, all layers and the security header counted.",
        ),
        quantity("baseline_airtime_per_s", "s/s", "That of the baseline."),
        *_over("the baseline's", "airtime"),
        count("trips_over", "Trips on which it sent more than `message_bound` allows."),
        *_WORST,
    ),
)
"""Messages over all trips: a row a candidate, protocol and threshold."""

RIVAL_RATIOS = TableSchema(
    "rivals",
    "Messages of one candidate over those of the one compared against: ratios of sums over all trips.",
    (
        _CANDIDATE,
        text("rival", "The candidate compared against."),
        _PROTOCOL,
        _THRESHOLD,
        *_over("the rival's", "message", "bytes", "airtime"),
        count("trips", "How many trips."),
        count("trips_over", "Trips on which it sent more than `rival_bound` allows."),
        *_WORST,
    ),
)
"""Messages over a rival's: a row a candidate, protocol and threshold."""


def _errors(percentile: int) -> tuple[Column, ...]:
    """A percentile of the tracking error: of the candidate and of its rivals, and the ratios."""
    name = f"p{percentile}"
    what = f"Percentile {percentile} of the tracking error after the instant's message"
    missing = "single trips have no interval"
    no_free = f"{missing}, and it may not be run"
    return (
        quantity(f"{name}_m", "m", f"{what}."),
        quantity(f"matched_{name}_m", "m", f"{what}, of the baseline of bisected threshold."),
        quantity(f"periodic_{name}_m", "m", f"{what}, of the periodic baseline."),
        quantity(f"{name}_ratio", "1", "The candidate's over the smaller of those compared with."),
        quantity(f"{name}_low", "1", "Lower end of its 95 % interval over the trips.", missing=missing),
        quantity(f"{name}_high", "1", "Upper end of its 95 % interval over the trips.", missing=missing),
        quantity(
            f"baseline_{name}_m", "m", f"{what}, of the baseline at the same threshold.", missing=_NOT_RUN
        ),
        quantity(
            f"free_{name}_m", "m", f"{what}, of the free receiver at the same threshold.", missing=_NOT_RUN
        ),
        quantity(
            f"free_matched_{name}_m", "m", f"{what}, of the free receiver at the same rate.", missing=_NOT_RUN
        ),
        quantity(
            f"{name}_over_free",
            "1",
            "The candidate's over that of the free receiver at its rate.",
            missing=_NOT_RUN,
        ),
        quantity(
            f"{name}_over_free_low", "1", "Lower end of its 95 % interval over the trips.", missing=no_free
        ),
        quantity(
            f"{name}_over_free_high", "1", "Upper end of its 95 % interval over the trips.", missing=no_free
        ),
    )


_NOT_RUN = "it may not be run"

TRACKING_RATIOS = TableSchema(
    "tracking",
    "Tracking error of one candidate under loss, beside the baseline and the free receiver: at the same "
    "threshold, and at the same rate, of the baseline in both readings.",
    (
        _CANDIDATE,
        _PROTOCOL,
        text("trip", "Identifier of the trip; all pools the trips, weighted by time."),
        _THRESHOLD,
        ratio("packet_error_ratio", "Mean share of messages lost."),
        text(
            "rate_basis",
            "Whether the baselines send as often as the candidate does in all (total), or as it sends model "
            "updates alone (update, the paper's).",
        ),
        quantity("message_rate_hz", "1/s", "Messages over the time observed, keep-alive included."),
        quantity("matched_rate_hz", "1/s", "The same of the baseline of bisected threshold."),
        quantity("periodic_rate_hz", "1/s", "The same of the periodic baseline."),
        quantity(
            "baseline_rate_hz", "1/s", "The same of the baseline at the same threshold.", missing=_NOT_RUN
        ),
        quantity(
            "free_rate_hz",
            "1/s",
            "The same of the free receiver's sender at that threshold.",
            missing=_NOT_RUN,
        ),
        quantity(
            "free_matched_rate_hz",
            "1/s",
            "The same of that sender at the candidate's rate.",
            missing=_NOT_RUN,
        ),
        *_errors(90),
        *_errors(99),
    ),
)
"""Tracking errors: a row a candidate, protocol, trip, threshold and packet error ratio."""

REFERENCE_RATIOS = TableSchema(
    "references",
    "Messages of a reference over the baseline's, all trips pooled.",
    (
        text("reference", "As in `modelcast.study.result.REFERENCES`."),
        _PROTOCOL,
        quantity("threshold_m", "m", "Threshold; a reference that knows none has a row at each."),
        quantity("message_ratio", "1", "Its messages over the baseline's at that threshold."),
    ),
)
"""References: a row a reference, protocol and threshold."""


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
        Messages over those of the candidate compared against, then over the free receiver's where that is
        another.
    references
        What the figure draws beside the candidates; empty where it was not asked for.
    failures, skipped
        Trips that could not be compared, and files and vehicles that held no trip, with the reason.
    """

    settings: Mapping[str, Any]
    _: KW_ONLY
    routes: Table
    trips: tuple[ComparedTrip, ...]
    candidates: tuple[CandidateRow, ...]
    ratios: Table
    tracking: Table
    counts: Table
    rivals: Table = field(default_factory=RIVAL_RATIOS.table)
    references: Table = field(default_factory=REFERENCE_RATIOS.table)
    failures: Mapping[str, str] = field(default_factory=dict[str, str])
    skipped: Mapping[str, str] = field(default_factory=dict[str, str])

    @property
    def free(self) -> str | None:
        """The candidate that is the free receiver; None where it was not run."""
        return self.settings.get("free")

    @property
    def rival(self) -> str | None:
        """The candidate compared against, where that says more than the baseline does; else None."""
        name = self.rivals[0].rival if self.rivals else None
        return None if name is None or len(self.candidates) < 2 or self.is_baseline(name) else name

    def is_baseline(self, name: str) -> bool:
        """Whether a candidate has the baseline's bank; one that sends as many messages need not be it.

        Parameters
        ----------
        name
            Of the candidate.
        """
        plain = tuple(repr(member) for member in BASELINE_BANK.members)
        return any(one.sub_models == plain for one in self.candidates if one.name == name)
