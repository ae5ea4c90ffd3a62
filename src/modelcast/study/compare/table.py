"""From a candidate's trials to rows: each trip, and all pooled, with bootstrap intervals over the trips."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.chance import child_generator
from modelcast.study.compare.bootstrap import (
    Limits,
    limits,
    quantile_resamples,
    ratio_resamples,
    resample_weights,
)
from modelcast.study.compare.result import (
    RATIOS,
    RIVAL_RATIOS,
    TRACKING_RATIOS,
    excess_of,
    messages_of,
    rival_bound,
)
from modelcast.study.compare.trial import BESIDE, FREE_AT_RATE, READINGS, RIVALS, ErrorGroup, Trial
from modelcast.study.metrics import confidence_limits, quantiles
from modelcast.study.result import POOLED
from modelcast.study.table import Row

__all__ = ["Resamples", "ratio_rows", "rival_rows", "rivals_rows", "tracking_rows"]

_PROBABILITIES = (0.9, 0.99)
_PERCENTILES = ("p90", "p99")


@dataclass(frozen=True, slots=True)
class Resamples:
    """The bootstrap's draws, the same for everything that is compared.

    Parameters
    ----------
    weights
        How often each resample draws each trip, (R, N).
    clusters
        Trips of one number are drawn together, (N,).
    """

    weights: FloatArray
    clusters: IntArray

    @classmethod
    def drawn(cls, clusters: IntArray, count: int, seed: int) -> "Resamples":
        """Draw them.

        Parameters
        ----------
        clusters
            Trips of one number are drawn together, (N,).
        count
            R.
        seed
            Of the run.
        """
        return cls(resample_weights(clusters, count, child_generator(seed, "bootstrap")), clusters)


def ratio_rows(counts: Sequence[Row], reference: str, resamples: Resamples) -> list[Row]:
    """Ratios of sums over all trips, for every candidate, protocol and threshold.

    Parameters
    ----------
    counts
        Rows of all candidates; within each candidate, protocol and threshold in the order of the trips.
    reference
        Name of the candidate that differences are taken to.
    resamples
        The bootstrap's draws.
    """
    groups: dict[tuple[str, str, float], list[Row]] = {}
    for row in counts:
        groups.setdefault((row.candidate, row.protocol, row.threshold_m), []).append(row)
    drawn = {key: _drawn_ratio(group, resamples) for key, group in groups.items()}
    return [
        _ratio_row(
            groups[key],
            groups[reference, *key[1:]],
            resamples,
            drawn=drawn[key],
            reference_drawn=drawn[reference, *key[1:]],
        )
        for key in groups
    ]


def _ratio_row(
    rows: list[Row],
    reference: list[Row],
    resamples: Resamples,
    *,
    drawn: FloatArray,
    reference_drawn: FloatArray,
) -> Row:
    clusters = resamples.clusters
    duration_s = sum(row.duration_s for row in rows)
    own_bytes, base_bytes = (_column(rows, name) for name in ("message_bytes", "baseline_bytes"))
    own_air, base_air = (_column(rows, name) for name in ("airtime_s", "baseline_airtime_s"))
    base = sum(row.baseline_messages for row in rows)
    ratio, other = _ratio(rows), _ratio(reference)
    low, high = limits(drawn, clusters)
    difference_low, difference_high = limits(drawn - reference_drawn, clusters)
    bytes_low, bytes_high = limits(ratio_resamples(resamples.weights, own_bytes, base_bytes), clusters)
    air_low, air_high = limits(ratio_resamples(resamples.weights, own_air, base_air), clusters)
    worst = max(rows, key=excess_of)
    return RATIOS.row(
        **rows[0].picked(("candidate", "protocol", "threshold_m")),
        trips=len(rows),
        duration_s=duration_s,
        update_rate_hz=sum(row.updates for row in rows) / duration_s,
        identification_rate_hz=sum(row.identifications for row in rows) / duration_s,
        baseline_rate_hz=base / duration_s,
        message_ratio=ratio,
        message_low=low,
        message_high=high,
        difference=ratio - other,
        difference_low=difference_low,
        difference_high=difference_high,
        bytes_per_s=float(own_bytes.sum()) / duration_s,
        baseline_bytes_per_s=float(base_bytes.sum()) / duration_s,
        bytes_ratio=float(own_bytes.sum() / base_bytes.sum()),
        bytes_low=bytes_low,
        bytes_high=bytes_high,
        airtime_per_s=float(own_air.sum()) / duration_s,
        baseline_airtime_per_s=float(base_air.sum()) / duration_s,
        airtime_ratio=float(own_air.sum() / base_air.sum()),
        airtime_low=air_low,
        airtime_high=air_high,
        trips_over=sum(excess_of(row) > 0 for row in rows),
        worst_trip=worst.trip,
        worst_excess=excess_of(worst),
        worst_ratio=messages_of(worst) / worst.baseline_messages,
    )


def rivals_rows(counts: Sequence[Row], reference: str, free: str | None, resamples: Resamples) -> list[Row]:
    """`rival_rows` over the candidate compared against, then over the free receiver where that is another.

    Parameters
    ----------
    counts, reference, resamples
        As for `ratio_rows`.
    free
        Name of the free receiver; None where it was not run.
    """
    names = [reference] if free is None or free == reference else [reference, free]
    return [row for name in names for row in rival_rows(counts, name, resamples)]


def rival_rows(counts: Sequence[Row], rival: str, resamples: Resamples) -> list[Row]:
    """Messages, bytes and airtime over another candidate's, for every candidate, protocol and threshold.

    Parameters
    ----------
    counts, resamples
        As for `ratio_rows`.
    rival
        Name of the candidate that all are held against.
    """
    groups: dict[tuple[str, str, float], list[Row]] = {}
    for row in counts:
        groups.setdefault((row.candidate, row.protocol, row.threshold_m), []).append(row)
    return [_rival_row(rows, groups[rival, *key[1:]], resamples) for key, rows in groups.items()]


def _rival_row(rows: Sequence[Row], rival: Sequence[Row], resamples: Resamples) -> Row:
    ratios: list[float] = []
    drawn: list[Limits] = []
    for name in ("messages", "message_bytes", "airtime_s"):
        own, other = _column(rows, name), _column(rival, name)
        ratios.append(float(own.sum() / other.sum()))
        drawn.append(limits(ratio_resamples(resamples.weights, own, other), resamples.clusters))
    excess = [
        messages_of(own) - rival_bound(messages_of(other)) for own, other in zip(rows, rival, strict=True)
    ]
    worst = int(np.argmax(excess))
    return RIVAL_RATIOS.row(
        **rows[0].picked(("candidate", "protocol", "threshold_m")),
        rival=rival[0].candidate,
        message_ratio=ratios[0],
        message_low=drawn[0][0],
        message_high=drawn[0][1],
        bytes_ratio=ratios[1],
        bytes_low=drawn[1][0],
        bytes_high=drawn[1][1],
        airtime_ratio=ratios[2],
        airtime_low=drawn[2][0],
        airtime_high=drawn[2][1],
        trips=len(rows),
        trips_over=sum(one > 0 for one in excess),
        worst_trip=rows[worst].trip,
        worst_excess=float(excess[worst]),
        worst_ratio=messages_of(rows[worst]) / messages_of(rival[worst]),
    )


def _column(rows: Sequence[Row], name: str) -> FloatArray:
    """Return a column of `COUNTS`, or the ``messages`` of all kinds."""
    found = [messages_of(row) if name == "messages" else getattr(row, name) for row in rows]
    return np.array(found, dtype=np.float64)


def _ratio(rows: Sequence[Row]) -> float:
    return sum(messages_of(row) for row in rows) / sum(row.baseline_messages for row in rows)


def _drawn_ratio(rows: Sequence[Row], resamples: Resamples) -> FloatArray:
    return ratio_resamples(resamples.weights, _column(rows, "messages"), _column(rows, "baseline_messages"))


def tracking_rows(
    name: str,
    trial: Trial,
    *,
    shares_s: Sequence[float],
    durations_s: Sequence[float],
    resamples: Resamples,
    rivals: Sequence[str] = RIVALS,
    one_trip_by_seeds: bool = False,
) -> list[Row]:
    """Tracking errors under loss of one candidate: all trips pooled first, then each.

    Parameters
    ----------
    name
        The candidate.
    trial
        Its errors.
    shares_s
        The time one sample of each trip stands for, (N,) [s].
    durations_s
        Time observed of each trip, (N,) [s].
    resamples
        The bootstrap's draws.
    rivals
        Which readings of the equal-rate baseline ratios are to; of several, the harder.
    one_trip_by_seeds
        Where there is one trip to draw, give Student-t limits over the seeds of the losses instead of none.
    """
    trips = list(dict.fromkeys(row.trip for row in trial.counts))
    pooled: list[Row] = []
    alone: list[Row] = []
    times = np.array([shares_s, durations_s])
    for group in trial.groups:
        held = (rivals, (FREE_AT_RATE,)) if group.errors_m[FREE_AT_RATE] else (rivals,)
        drawn = _drawn_limits(group, shares_s, resamples, held)
        if one_trip_by_seeds and len(trips) == 1:
            drawn = _seed_limits(group, held)
        whole = _Part(POOLED, range(len(trips)), held, drawn)
        pooled.append(_tracking_row((name, trial.protocol), group, whole, times))
        for at, trip in enumerate(trips):
            part = _Part(trip, range(at, at + 1), held, [_NO_LIMITS] * len(held))
            alone.append(_tracking_row((name, trial.protocol), group, part, times))
    return [*pooled, *alone]


_NO_LIMITS: tuple[Limits, Limits] = ((None, None), (None, None))


@dataclass(frozen=True, slots=True)
class _Part:
    """Some of the trips, their name in rows, whom ratios are to, and the limits of both over the trips.

    Ratios are to the harder of each of ``held``; ``limits`` are of p90 and p99, one pair for each.
    """

    name: str
    trips: range
    held: Sequence[Sequence[str]]
    limits: Sequence[tuple[Limits, Limits]]


def _drawn_limits(
    group: ErrorGroup, shares_s: Sequence[float], resamples: Resamples, held: Sequence[Sequence[str]]
) -> list[tuple[Limits, Limits]]:
    """Intervals of both ratios, against the harder rival in each resample."""
    if np.unique(resamples.clusters).size < 2:
        return [_NO_LIMITS] * len(held)

    def drawn(name: str) -> FloatArray:
        return quantile_resamples(resamples.weights, group.errors_m[name], shares_s, _PROBABILITIES)

    own = drawn("own")
    each = [_divided(own, np.minimum.reduce([drawn(name) for name in rivals])) for rivals in held]
    return [(limits(one[:, 0], resamples.clusters), limits(one[:, 1], resamples.clusters)) for one in each]


def _divided(own: FloatArray, rival: FloatArray) -> FloatArray:
    """Their ratios; NaN where the rival's is nothing."""
    return np.divide(own, rival, out=np.full(own.shape, np.nan), where=rival > 0)


def _seed_limits(group: ErrorGroup, held: Sequence[Sequence[str]]) -> list[tuple[Limits, Limits]]:
    """Student-t limits of the mean over seeds of each seed's ratios, on the one trip there is."""

    def by_seed(name: str) -> FloatArray:
        return np.array([quantiles([row], [1.0], _PROBABILITIES) for row in group.errors_m[name][0]])

    own = by_seed("own")
    each = [_divided(own, np.minimum.reduce([by_seed(name) for name in rivals])) for rivals in held]
    return [(confidence_limits(one[:, 0]), confidence_limits(one[:, 1])) for one in each]


_PREFIXES = {"own": "", **{name: f"{name}_" for name in (*READINGS[1:], *BESIDE)}}
"""Of the columns of each contender."""


def _tracking_row(whose: tuple[str, str], group: ErrorGroup, part: _Part, times_s: FloatArray) -> Row:
    """The row of some trips; ``times_s`` is the time of one sample and of the whole of every trip, (2, N)."""
    shares_s = times_s[0].tolist()
    duration_s = float(times_s[1, part.trips].sum())
    found: dict[str, float | None] = {}
    errors_m: dict[str, FloatArray] = {}
    for name, prefix in _PREFIXES.items():
        was_run = bool(group.errors_m[name])
        if was_run:
            errors_m[name] = group.quantiles_of(name, part.trips, shares_s, _PROBABILITIES)
        sent = sum(group.messages[name][at] for at in part.trips) if was_run else None
        found[f"{prefix or 'message_'}rate_hz"] = None if sent is None else sent / duration_s
        for at, column in enumerate(_PERCENTILES):
            found[f"{prefix}{column}_m"] = float(errors_m[name][at]) if was_run else None
    for at, column in enumerate(_PERCENTILES):
        for place, (ratio, ends) in enumerate(
            ((f"{column}_ratio", column), (f"{column}_over_free", f"{column}_over_free"))
        ):
            is_held = place < len(part.held)
            rivals = part.held[place] if is_held else ()
            low, high = part.limits[place][at] if is_held else (None, None)
            found[ratio] = _over([errors_m[name][at] for name in ("own", *rivals)]) if is_held else None
            found |= {f"{ends}_low": low, f"{ends}_high": high}
    return TRACKING_RATIOS.row(
        candidate=whose[0],
        protocol=whose[1],
        trip=part.name,
        threshold_m=group.threshold_m,
        packet_error_ratio=group.packet_error_ratio,
        rate_basis=group.rate_basis,
        **found,
    )


def _over(found_m: Sequence[float]) -> float:
    """The candidate's quantile over the smallest of its rivals'; NaN where that is nothing."""
    harder_m = float(min(found_m[1:]))
    return float(found_m[0]) / harder_m if harder_m > 0 else float("nan")
