"""Rows of an evaluation of safety applications: what single recordings gave, and what pools them."""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.study.safety.rules import Basis
from modelcast.study.table import Column, Row, Table, TableSchema, count, quantity, ratio, text

if TYPE_CHECKING:
    from modelcast.study.safety.film import EventFilm

__all__ = [
    "DELAYS",
    "EVENTS",
    "POOLED_SAFETY",
    "ConditionScores",
    "PairNames",
    "RecordingScores",
    "SafetyKind",
    "SafetyResult",
    "SenderSpend",
    "kind_of",
    "over_columns",
]


class SafetyKind(NamedTuple):
    """What tells cases apart that have senders, bases and runs in common.

    Parameters
    ----------
    sensor
        What vehicles see of themselves.
    mean_burst_s
        How losses come: mean length of bursts, None for one by one, or where a log had no loss [s].
    loss_log
        Name of the log whose losses were replayed; empty where they were drawn.
    """

    sensor: str
    mean_burst_s: float | None
    loss_log: str = ""


@dataclass(frozen=True, slots=True)
class PairNames:
    """A pair by the identifiers of its trips, and how far behind the follower drives [s]."""

    leader: str
    follower: str
    headway_s: float


@dataclass(frozen=True, slots=True)
class SenderSpend:
    """What the leaders of a recording spent.

    Parameters
    ----------
    messages, airtime_s
        Sums over the leaders.
    thresholds_m
        Threshold of each leader [m].
    """

    messages: int
    airtime_s: float
    thresholds_m: tuple[float, ...]


@dataclass(frozen=True, slots=True, eq=False)
class ConditionScores:
    """One candidate on one basis at one loss ratio, in K runs.

    Parameters
    ----------
    candidate, basis, packet_error_ratio
        Which.
    spend
        What it sent.
    missed
        Instants of each true warning at which the host did not warn, (E, K).
    delay_s
        How late each came, infinite where it did not, (E, K) [s].
    false
        Instants at which the host of each pair warned and perfect knowledge did not, (N, K).
    false_warnings
        Warnings of each pair without a true one near, (N, K).
    """

    candidate: str
    basis: Basis
    packet_error_ratio: float
    _: KW_ONLY
    spend: SenderSpend
    missed: IntArray
    delay_s: FloatArray
    false: IntArray
    false_warnings: IntArray


@dataclass(frozen=True, slots=True, eq=False)
class RecordingScores:
    """What N pairs of one recording gave, over E true warnings.

    Parameters
    ----------
    name
        Of the recording.
    sensor, mean_burst_s
        What vehicles see of themselves, and how losses come: None for one by one.
    pairs
        (N,) of them.
    counted, negatives
        Instants of each pair near the decision, and those of them without a true warning, (N,).
    duration_s
        Time that each pair was together, (N,) [s].
    leaders_s
        Time that all leaders were recorded [s].
    event_pair
        Whose each true warning is, (E,).
    event_s
        When it begins on the leader's clock, (E,) [s].
    positives
        Instants of it that count, (E,).
    conditions
        What the candidates made of it.
    loss_log
        Name of the log whose losses were replayed; empty where they were drawn.
    """

    name: str
    sensor: str
    mean_burst_s: float | None
    _: KW_ONLY
    pairs: Sequence[PairNames]
    counted: IntArray
    negatives: IntArray
    duration_s: FloatArray
    leaders_s: float
    event_pair: IntArray
    event_s: FloatArray
    positives: IntArray
    conditions: Sequence[ConditionScores]
    loss_log: str = ""

    @property
    def kind(self) -> SafetyKind:
        """Sensor and kind of loss."""
        return SafetyKind(self.sensor, self.mean_burst_s, self.loss_log)


DELAYS = tuple(
    quantity(f"delay_p{at}_s", "s", f"How late warnings come: percentile {at}; infinite where more never do.")
    for at in (50, 90, 99)
)
"""How late warnings come."""


def over_columns(what: str, whose: str) -> tuple[Column, Column, Column]:
    """Return columns of instants over someone else's, and of the interval's ends.

    Parameters
    ----------
    what
        ``missed`` or ``false``.
    whose
        Whose they are held against, as the description says it.
    """
    missing = "too few units to draw from"
    return (
        quantity(f"{what}_over", "1", f"{what.capitalize()} instants over {whose}."),
        quantity(f"{what}_over_low", "1", "Lower end of its 95 % interval.", missing=missing),
        quantity(f"{what}_over_high", "1", "Upper end of its 95 % interval.", missing=missing),
    )


_CONDITION = (
    text("sensor", "What vehicles see of themselves."),
    quantity(
        "mean_burst_s",
        "s",
        "How losses come: mean length of bursts.",
        missing="losses come one by one, or a log had none",
    ),
    ratio("packet_error_ratio", "Mean share of messages lost."),
    text("basis", "What is equal: the messages, the bytes or the airtime spent."),
    text("candidate", "Name of the sender."),
)
_LOSS_LOG = text("loss_log", "Name of the log whose losses were replayed; empty where they were drawn.")
_MISSED = over_columns("missed", "those of the candidate compared against")
_FALSE = over_columns("false", "those of the candidate compared against")

POOLED_SAFETY = TableSchema(
    "pooled",
    "One candidate on one basis at one loss ratio over all recordings, means over runs; intervals are over "
    "true warnings (pairs, where false ones are counted) and runs.",
    (
        *_CONDITION,
        quantity("threshold_m", "m", "Median of the leaders' thresholds."),
        quantity("message_rate_hz", "1/s", "Messages a second of a leader."),
        ratio("airtime_ratio", "Its time on the air over all time."),
        ratio("missed_ratio", "Share of the true warnings' instants without a warning."),
        ratio("false_ratio", "Share of the other instants near the decision with a warning."),
        ratio("missed_events", "Share of true warnings that never came."),
        quantity("false_per_hour", "1/h", "Warnings without a true one near an hour."),
        *DELAYS,
        _MISSED[0],
        _FALSE[0],
        *_MISSED[1:],
        *_FALSE[1:],
        _LOSS_LOG,
    ),
)
"""Warnings over all recordings: a row a condition and candidate."""

EVENTS = TableSchema(
    "events",
    "What became of one true warning in one run.",
    (
        text("recording", "Name of the recording."),
        *_CONDITION[:2],
        _LOSS_LOG,
        *_CONDITION[2:],
        text("leader", "Trip of the leader."),
        text("follower", "Trip of the follower."),
        count("run", "Number of the run, from 0."),
        quantity("t_s", "s", "When it begins on the leader's clock."),
        count("instants", "Its instants that count."),
        count("missed", "Those of them at which the host did not warn."),
        quantity("delay_s", "s", "How late the warning came; infinite where it did not."),
    ),
)
"""True warnings: a row each and condition, candidate and run."""


def kind_of(row: Row) -> SafetyKind:
    """Return sensor and kind of loss of a row of `POOLED_SAFETY`."""
    return SafetyKind(**row.picked(("sensor", "mean_burst_s", "loss_log")))


@dataclass(frozen=True, slots=True)
class SafetyResult:
    """All of an evaluation over recorded pairs.

    Parameters
    ----------
    settings
        As plain values.
    recordings
        What single recordings gave.
    pooled
        Rows over all of them.
    events, pairs, counted, positives
        True warnings, pairs, instants that count, and those of them with a true warning; of one sensor.
    failures, skipped
        Files and trips left out, and why.
    film
        The true warning at which the sender with the budget gains most; None where there is none.
    """

    settings: Mapping[str, Any]
    _: KW_ONLY
    recordings: Sequence[RecordingScores]
    pooled: Table
    events: int
    pairs: int
    counted: int
    positives: int
    failures: Mapping[str, str]
    skipped: Mapping[str, str]
    film: "EventFilm | None" = None
