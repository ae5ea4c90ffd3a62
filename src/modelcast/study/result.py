"""What an evaluation returns: rows for tables, columns for Parquet, and the data each figure draws."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from modelcast.core.arrays import FloatArray, IntArray, SingleArray
from modelcast.study.playback import Playback
from modelcast.study.rules import MODEL_SENDER
from modelcast.study.table import Table, TableSchema, count, flag, quantity, ratio, text

__all__ = [
    "POOLED",
    "RATES",
    "REFERENCES",
    "TRACKING",
    "TRIPS",
    "Coded",
    "Columns",
    "Ecdf",
    "EvaluationResult",
    "HoldsEvaluation",
    "Manoeuvre",
    "SampleBlock",
    "Timeline",
    "TripRow",
    "result_of",
    "trip_values",
    "trips_table",
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
        Whether the bank or the free receiver was trained on this very trip: its figures then flatter.
    understood
        What its file was taken for, by subject, where its reader had to find that out
        (`modelcast.trips.understood.Understood.lines`).
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
    understood: Mapping[str, str] = field(default_factory=dict[str, str])


TRIPS = TableSchema(
    "trips",
    "One evaluated trip, as one row.",
    (
        text("id", "Trip identifier: file stem / vehicle."),
        text("source", "Name of the format."),
        quantity("duration_s", "s", "Time observed."),
        quantity("standing_s", "s", "Part of it spent below walking pace."),
        count("vehicles", "Vehicles in the trip: one."),
        count("samples", "Samples."),
        quantity("dt_s", "s", "Median step of the samples."),
        count("gaps", "Gaps that split the trip."),
        flag("resampled", "Whether the trip was resampled to its median rate."),
        text("protocol", "recorded (the log is both input and truth) or sensor (input simulated)."),
        flag("conditioned", "Whether the truth was smoothed."),
        text("velocity_estimator", "Causal estimator that constant velocity and the baseline coast with."),
        quantity("grid_east_m", "m", "Position grid of the recording, east; 0 where there is none."),
        quantity("grid_north_m", "m", "Position grid of the recording, north; 0 where there is none."),
        count("rows", "Rows read."),
        count("skipped", "Rows skipped."),
        count("repaired", "Rows put right."),
        text("warnings", "Kinds of what must be known of the recording before any figure."),
        flag("in_training", "Whether the bank or the free receiver was trained on this very trip."),
    ),
)
"""Trips: a row a trip; reasons and the smoother's figures are in `TripRow` alone."""

_TRIP = text("trip", "Trip identifier; `all` pools every trip, weighted by time.")
_BANK = text("bank", "Name of the bank of sub-models.")
_DURATION = quantity("duration_s", "s", "Time observed.")

RATES = TableSchema(
    "rates",
    "Messages sent at one threshold on an ideal channel, without keep-alive.",
    (
        _TRIP,
        text("policy", "Policy: mbc, or the name of another that decides (`--policy`); baseline; or free."),
        _BANK,
        quantity("threshold_m", "m", "Tracking-error threshold."),
        count("updates", "Model updates sent."),
        count("identifications", "Identifications sent."),
        _DURATION,
        quantity("update_rate_hz", "1/s", "Model updates over the time observed."),
        quantity("identification_rate_hz", "1/s", "Identifications over the time observed."),
        quantity("total_rate_hz", "1/s", "All messages over the time observed."),
        quantity("moving_total_rate_hz", "1/s", "All messages sent while moving over the time spent moving."),
        quantity(
            "bytes_per_s", "byte/s", "Application bytes, messages in their frames, over the time observed."
        ),
        quantity(
            "airtime_per_s",
            "s/s",
            "Time on the air over the time observed, all layers and the security header counted.",
        ),
    ),
)
"""Message rates: a row a trip, policy, bank and threshold."""

REFERENCES = TableSchema(
    "references",
    "Messages of a reference that no bank takes part in, over what the sender sees, on an ideal channel.",
    (
        _TRIP,
        text(
            "reference",
            "clairvoyant-1, clairvoyant-2 or clairvoyant-3 (the fewest messages of a sender that knows the "
            "future and sends polynomials of that degree), or cam (the triggering rules of cooperative "
            "awareness messages).",
        ),
        quantity("threshold_m", "m", "Tracking-error threshold.", missing="cam has none"),
        count("messages", "Messages sent."),
        count(
            "least_messages",
            "The same with every undecided test taken as passed: the fewest messages lie between the two.",
        ),
        _DURATION,
        quantity("rate_hz", "1/s", "Messages over the time observed."),
        count("undecided", "Tests neither proved nor refuted; each was taken as failed."),
    ),
)
"""References: a row a trip, reference and threshold."""

_ONE_SEED = "one seed has no interval"
_NO_GAP = "fewer than two messages arrived"

TRACKING = TableSchema(
    "tracking",
    "Tracking at the receiver for one policy, threshold and packet error ratio.",
    (
        _TRIP,
        text(
            "policy",
            "Policy: mbc, or the name of another that decides (`--policy`); baseline (error-driven at the "
            "same threshold), baseline-periodic or baseline-matched (error-driven with its threshold "
            "bisected to the rate); free (the free receiver at the same threshold), or free-matched (with "
            "a threshold of its own that comes near to the rate).",
        ),
        _BANK,
        text(
            "rate_basis",
            "Which of the model-based sender's rates an equal-rate baseline was given: update (the paper) "
            "or total (fairer).",
            missing="the other policies have none",
        ),
        quantity("threshold_m", "m", "The model-based sender's threshold, which names the comparison."),
        quantity(
            "own_threshold_m",
            "m",
            "Threshold that the policy itself ran at.",
            missing="baseline-periodic has none",
        ),
        ratio("packet_error_ratio", "Mean share of messages lost."),
        count("seeds", "Runs pooled."),
        count("samples", "Tracking-error samples."),
        count("excluded_samples", "Samples left out because nothing had arrived yet, or had expired."),
        quantity("message_rate_hz", "1/s", "Messages over the time observed, keep-alive included."),
        quantity("pte_mean_m", "m", "Mean position tracking error after the instant's message."),
        quantity("pte_p50_m", "m", "Median of that error."),
        quantity("pte_p90_m", "m", "90th percentile of that error."),
        quantity(
            "pte_p90_low_m",
            "m",
            "Lower 95 % Student-t limit of that percentile over seeds.",
            missing=_ONE_SEED,
        ),
        quantity(
            "pte_p90_high_m",
            "m",
            "Upper 95 % Student-t limit of that percentile over seeds.",
            missing=_ONE_SEED,
        ),
        quantity("pte_p95_m", "m", "95th percentile of that error."),
        quantity("pte_p99_m", "m", "99th percentile of that error."),
        quantity("pte_before_p90_m", "m", "90th percentile of the error just before the instant's message."),
        quantity("along_p90_m", "m", "90th percentile of the error's size along the track."),
        quantity("cross_p90_m", "m", "90th percentile of the error's size across the track."),
        ratio("beyond_lane_ratio", "Share of samples with an error over 1.5 m."),
        quantity("inter_packet_gap_p50_s", "s", "Median gap between messages received.", missing=_NO_GAP),
        quantity(
            "inter_packet_gap_p95_s", "s", "95th percentile gap between messages received.", missing=_NO_GAP
        ),
        quantity(
            "information_age_mean_s",
            "s",
            "Mean age at each sample of the model update held; an identification does not renew it.",
        ),
        quantity("information_age_p95_s", "s", "95th percentile of that age."),
    ),
)
"""Tracking errors: a row a trip, policy, rate basis, threshold and packet error ratio."""


@dataclass(frozen=True, slots=True)
class Ecdf:
    """Points of one pooled empirical distribution of the tracking error.

    Parameters
    ----------
    policy, rate_basis, threshold_m, packet_error_ratio
        As in `TRACKING`.
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
        As in `TRACKING`.
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
    trips
        What was evaluated.
    rates, tracking
        Tables of `RATES` and `TRACKING`.
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
        Table of `REFERENCES` that the message rates are drawn beside; empty where they were not asked for.
    playback
        The trip of the timeline, to be played in the report; None where no trip holds a manoeuvre.
    """

    settings: Mapping[str, Any]
    _: KW_ONLY
    trips: tuple[TripRow, ...]
    rates: Table
    tracking: Table
    ecdfs: tuple[Ecdf, ...]
    timeline: Timeline | None
    manoeuvre: Manoeuvre | None
    events: Columns
    samples: tuple[SampleBlock, ...]
    failures: Mapping[str, str]
    skipped: Mapping[str, str] = field(default_factory=dict[str, str])
    references: Table = field(default_factory=REFERENCES.table)
    playback: Playback | None = None

    @property
    def sender(self) -> str:
        """What the rows call the model-based sender: ``mbc`` where the error-driven policy decides."""
        return str(self.settings.get("decided_by", MODEL_SENDER))


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


def trips_table(result: EvaluationResult) -> Table:
    """Return the trips of an evaluation as a table of `TRIPS`.

    Parameters
    ----------
    result
        The evaluation.
    """
    return TRIPS.table(TRIPS.row(**trip_values(trip)) for trip in result.trips)


def trip_values(trip: TripRow) -> dict[str, Any]:
    """Return the values of a trip's row of `TRIPS`, by column.

    Parameters
    ----------
    trip
        The trip.
    """
    own = {
        "skipped": sum(trip.skipped.values()),
        "repaired": sum(trip.repaired.values()),
        "warnings": ", ".join(trip.warnings),
        "grid_east_m": trip.grid_m[0],
        "grid_north_m": trip.grid_m[1],
    }
    return {name: own[name] if name in own else getattr(trip, name) for name in TRIPS.names}
