"""Rows of an evaluation of safety applications: what single recordings gave, and what pools them."""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.study.compare.bootstrap import Limits
from modelcast.study.safety.rules import Basis

if TYPE_CHECKING:
    from modelcast.study.safety.film import EventFilm

__all__ = [
    "ConditionScores",
    "PairNames",
    "PooledSafety",
    "RecordingScores",
    "SafetyKind",
    "SafetyResult",
    "SenderSpend",
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


@dataclass(frozen=True, slots=True)
class PooledSafety:
    """One candidate on one basis at one loss ratio over all recordings, means over runs.

    Parameters
    ----------
    sensor, mean_burst_s, packet_error_ratio, basis, candidate
        Which.
    threshold_m
        Median of the leaders' thresholds [m].
    message_rate_hz, airtime_ratio
        Messages a second of a leader, and its time on the air over all time.
    missed_ratio, false_ratio
        Share of the true warnings' instants without a warning, and of the others with one.
    missed_events, false_per_hour
        Share of true warnings that never came, and warnings without a true one near an hour [1/h].
    delay_p50_s, delay_p90_s, delay_p99_s
        Of all true warnings; infinite where more were missed [s].
    missed_over, false_over
        Missed and false instants over those of the candidate named by ``against``.
    missed_over_limits, false_over_limits
        Their 95 % intervals over true warnings (pairs, where false ones are counted) and runs.
    loss_log
        Name of the log whose losses were replayed; empty where they were drawn.
    """

    sensor: str
    mean_burst_s: float | None
    packet_error_ratio: float
    basis: Basis
    candidate: str
    _: KW_ONLY
    threshold_m: float
    message_rate_hz: float
    airtime_ratio: float
    missed_ratio: float
    false_ratio: float
    missed_events: float
    false_per_hour: float
    delay_p50_s: float
    delay_p90_s: float
    delay_p99_s: float
    missed_over: float
    false_over: float
    missed_over_limits: Limits
    false_over_limits: Limits
    loss_log: str = ""

    @property
    def kind(self) -> SafetyKind:
        """Sensor and kind of loss."""
        return SafetyKind(self.sensor, self.mean_burst_s, self.loss_log)


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
    pooled: Sequence[PooledSafety]
    events: int
    pairs: int
    counted: int
    positives: int
    failures: Mapping[str, str]
    skipped: Mapping[str, Any]
    film: "EventFilm | None" = None
