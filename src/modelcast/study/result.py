"""What an evaluation returns: rows for tables, columns for Parquet, and the data each figure draws."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from modelcast.core.arrays import FloatArray, IntArray, SingleArray

__all__ = [
    "POOLED",
    "Coded",
    "Columns",
    "Ecdf",
    "EvaluationResult",
    "HoldsEvaluation",
    "Manoeuvre",
    "RateRow",
    "ReferenceRow",
    "SampleBlock",
    "Timeline",
    "TrackingRow",
    "TripRow",
    "result_of",
]

POOLED = "all"
"""The ``trip`` of rows that pool every trip, weighted by time."""


@dataclass(frozen=True, slots=True)
class Coded:
    """A column of names that repeat.

    Parameters
    ----------
    codes
        Index of each row's name, (N,).
    names
        The names.
    """

    codes: npt.NDArray[np.int32]
    names: tuple[str, ...]


Columns = Mapping[str, npt.NDArray[Any] | Coded]
"""Named columns of equal length: a table without a data-frame library."""


@dataclass(frozen=True, slots=True)
class TripRow:
    """One evaluated trip.

    Parameters
    ----------
    id
        ``<file stem>/<vehicle>``.
    source
        Name of the format.
    duration_s, standing_s
        Time observed, and the part of it spent below walking pace [s].
    vehicles
        Vehicles in the trip: one.
    samples, dt_s
        Number of samples and their median step [s].
    gaps, resampled
        Gaps that split the trip, and whether it was resampled to its median rate.
    protocol
        ``recorded`` (the log is both input and truth) or ``sensor`` (truth conditioned, input simulated).
    conditioned
        True where the truth was smoothed.
    velocity_estimator
        The causal estimator that constant velocity and the baseline coast with.
    grid_m
        Position grid of the recording, east and north [m]; 0 where there is none.
    rows, skipped, repaired
        Rows read, and those skipped or put right, by reason.
    conditioning
        The smoother's parameters and figures where it was used.
    warnings
        What must be known of the recording before any figure, by kind, as in
        `modelcast.trips.judgement.judge`; ``bank`` for sub-models that do not work as trained at this rate.
    in_training
        Whether the bank was trained on this very trip: its figures then flatter.
    """

    id: str
    source: str
    duration_s: float
    _: KW_ONLY
    standing_s: float
    vehicles: int
    samples: int
    dt_s: float
    gaps: int
    resampled: bool
    protocol: str
    conditioned: bool
    velocity_estimator: str
    grid_m: tuple[float, float]
    rows: int
    skipped: Mapping[str, int]
    repaired: Mapping[str, int]
    conditioning: Mapping[str, float] | None
    warnings: Mapping[str, str] = field(default_factory=dict[str, str])
    in_training: bool = False


@dataclass(frozen=True, slots=True)
class RateRow:
    """Messages sent at one threshold on an ideal channel, without keep-alive.

    Parameters
    ----------
    trip
        Trip id, or `POOLED`.
    policy
        ``mbc`` or ``baseline``.
    bank
        Name of the bank of sub-models.
    threshold_m
        Tracking-error threshold [m].
    updates, identifications
        Messages sent.
    update_rate_hz, identification_rate_hz, total_rate_hz
        Messages over the time observed [Hz].
    moving_total_rate_hz
        All messages sent while moving over the time spent moving [Hz].
    bytes_per_s
        Application bytes over the time observed: the messages in their frames [byte/s].
    airtime_per_s
        Time on the air over the time observed, all layers and the security header counted [s/s].
    """

    trip: str
    policy: str
    bank: str
    _: KW_ONLY
    threshold_m: float
    updates: int
    identifications: int
    duration_s: float
    update_rate_hz: float
    identification_rate_hz: float
    total_rate_hz: float
    moving_total_rate_hz: float
    bytes_per_s: float
    airtime_per_s: float


@dataclass(frozen=True, slots=True)
class ReferenceRow:
    """Messages of a reference that no bank takes part in, over what the sender sees, on an ideal channel.

    Parameters
    ----------
    trip
        Trip id, or `POOLED`.
    reference
        ``clairvoyant-1``, ``clairvoyant-2`` or ``clairvoyant-3`` (the fewest messages of a sender that knows
        the future and sends polynomials of that degree), or ``cam`` (the triggering rules of cooperative
        awareness messages).
    threshold_m
        Tracking-error threshold [m]; None for ``cam``, which has none.
    messages
        Messages sent.
    least_messages
        The same with every undecided test taken as passed: the fewest messages lie between the two.
    duration_s
        Time observed [s].
    rate_hz
        Messages over the time observed [Hz].
    undecided
        Tests that were neither proved nor refuted; each was taken as failed.
    """

    trip: str
    reference: str
    threshold_m: float | None
    _: KW_ONLY
    messages: int
    least_messages: int
    duration_s: float
    rate_hz: float
    undecided: int


@dataclass(frozen=True, slots=True)
class TrackingRow:
    """Tracking at the receiver for one policy, threshold and packet error ratio.

    Parameters
    ----------
    trip
        Trip id, or `POOLED`.
    policy
        ``mbc``, ``baseline`` (error-driven at the same threshold), ``baseline-periodic`` or
        ``baseline-matched`` (error-driven with its threshold bisected to the rate).
    rate_basis
        Which of MBC's rates an equal-rate baseline was given: ``update`` (the paper), ``total`` (fairer),
        or None for the other policies.
    threshold_m
        MBC's threshold, which names the comparison [m].
    own_threshold_m
        The threshold the policy itself ran at; None for ``baseline-periodic`` [m].
    packet_error_ratio
        Mean share of messages lost, 0..1.
    seeds
        Runs pooled.
    samples, excluded_samples
        Tracking-error samples, and those left out because nothing had arrived yet (or had expired).
    message_rate_hz
        Messages sent over the time observed, keep-alive included [Hz].
    pte_mean_m .. pte_p99_m
        Mean and quantiles of the position tracking error after the instant's message [m].
    pte_p90_low_m, pte_p90_high_m
        95 % Student-t confidence limits of the 90th percentile over the seeds [m]; None for one seed.
    pte_before_p90_m
        90th percentile of the error just before the instant's message [m].
    along_p90_m, cross_p90_m
        90th percentiles of the error's size along and across the track [m].
    beyond_lane_ratio
        Share of samples with an error over 1.5 m.
    inter_packet_gap_p50_s, inter_packet_gap_p95_s
        Gaps between messages received [s].
    information_age_mean_s, information_age_p95_s
        Age at each sample of the model update held; an identification does not renew it [s].
    """

    trip: str
    policy: str
    bank: str
    _: KW_ONLY
    rate_basis: str | None
    threshold_m: float
    own_threshold_m: float | None
    packet_error_ratio: float
    seeds: int
    samples: int
    excluded_samples: int
    message_rate_hz: float
    pte_mean_m: float
    pte_p50_m: float
    pte_p90_m: float
    pte_p90_low_m: float | None
    pte_p90_high_m: float | None
    pte_p95_m: float
    pte_p99_m: float
    pte_before_p90_m: float
    along_p90_m: float
    cross_p90_m: float
    beyond_lane_ratio: float
    inter_packet_gap_p50_s: float | None
    inter_packet_gap_p95_s: float | None
    information_age_mean_s: float
    information_age_p95_s: float


@dataclass(frozen=True, slots=True)
class Ecdf:
    """Points of one pooled empirical distribution of the tracking error.

    Parameters
    ----------
    policy, rate_basis, threshold_m, packet_error_ratio
        As in `TrackingRow`.
    tracking_error_m
        Quantiles, (Q,) rising [m].
    probability
        Their probabilities, (Q,) from 0 to 1.
    """

    policy: str
    rate_basis: str | None
    threshold_m: float
    packet_error_ratio: float
    tracking_error_m: FloatArray
    probability: FloatArray


@dataclass(frozen=True, slots=True)
class Timeline:
    """A stretch of one trip as the sender sees it: every sub-model's error against the threshold.

    Parameters
    ----------
    trip, threshold_m
        Which trip and threshold.
    members
        Names of the sub-models, M of them, in the bank's order.
    t_s
        Sample times, (K,) [s].
    tracking_error_m
        Error of every sub-model fitted at the last update, before the instant's message, (K, M) [m]; NaN
        where a sub-model had too short a window.
    in_use
        Index of the sub-model in use after the instant's message, (K,).
    update_s, identification_s
        Times of model updates and of sub-model identifications in the stretch [s].
    """

    trip: str
    threshold_m: float
    members: tuple[str, ...]
    t_s: FloatArray
    tracking_error_m: FloatArray
    in_use: IntArray
    update_s: FloatArray
    identification_s: FloatArray


@dataclass(frozen=True, slots=True)
class Manoeuvre:
    """The sharpest manoeuvre of a trip, with the path each sub-model predicts from one instant before it.

    Parameters
    ----------
    trip, start_s
        Which trip, and when the prediction starts [s].
    history_m
        Positions the sub-models were fitted to, (n, 2) [m].
    truth_m
        True positions from the start on, (H, 2) [m].
    horizons_s
        Times after the start, (H,) [s].
    predicted_m
        Predicted positions by name of sub-model, (H, 2) each [m].
    survival_s
        Time until each sub-model's error first reaches the threshold, by name [s]; inf for never.
    threshold_m
        That threshold [m].
    """

    trip: str
    start_s: float
    history_m: FloatArray
    truth_m: FloatArray
    horizons_s: FloatArray
    predicted_m: Mapping[str, FloatArray]
    survival_s: Mapping[str, float]
    threshold_m: float


@dataclass(frozen=True, slots=True)
class SampleBlock:
    """Tracking-error samples of one contender over one trip: L loss ratios, S seeds kept, T instants.

    Parameters
    ----------
    trip, policy, bank, rate_basis, threshold_m
        As in `TrackingRow`.
    packet_error_ratios
        (L,).
    t_s
        (T,) [s].
    errors
        ``tracking_error_m`` and ``tracking_error_before_m`` after and before the instant's message,
        ``along_track_m``, ``cross_track_m`` (left of the course positive) and ``information_age_s``; each
        (L, S, T), NaN where the host held nothing.
    """

    trip: str
    policy: str
    bank: str
    rate_basis: str | None
    threshold_m: float
    packet_error_ratios: tuple[float, ...]
    t_s: FloatArray
    errors: Mapping[str, SingleArray]


@dataclass(frozen=True, slots=True)
class EvaluationResult:
    """Everything one evaluation found.

    Parameters
    ----------
    settings
        What was asked for, as plain values.
    trips, rates, tracking
        Rows of the three tables.
    ecdfs, timeline, manoeuvre
        What the figures draw; the last two are None where no trip holds them.
    events
        One row a message of the rate runs: trip, policy, bank, threshold_m, t_s, kind, sub_model, size_bytes,
        airtime_s.
    samples
        Blocks of the tracking-error samples kept (see the settings).
    failures
        Trips that could not be evaluated, with the reason.
    skipped
        Files and vehicles that held no trip, with the reason.
    references
        Rows of the references that the message rates are drawn beside; empty where they were not asked for.
    """

    settings: Mapping[str, Any]
    _: KW_ONLY
    trips: tuple[TripRow, ...]
    rates: tuple[RateRow, ...]
    tracking: tuple[TrackingRow, ...]
    ecdfs: tuple[Ecdf, ...]
    timeline: Timeline | None
    manoeuvre: Manoeuvre | None
    events: Columns
    samples: tuple[SampleBlock, ...]
    failures: Mapping[str, str]
    skipped: Mapping[str, str] = field(default_factory=dict[str, str])
    references: tuple[ReferenceRow, ...] = ()


class HoldsEvaluation(Protocol):
    """What holds the rows of an evaluation, as what `modelcast.evaluate` returns does."""

    @property
    def result(self) -> EvaluationResult:
        """The rows."""
        ...


def result_of(held: EvaluationResult | HoldsEvaluation) -> EvaluationResult:
    """Return the rows of an evaluation, given themselves or by what holds them.

    Parameters
    ----------
    held
        Either.
    """
    return held if isinstance(held, EvaluationResult) else held.result
