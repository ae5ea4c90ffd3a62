"""From tracking runs to table rows and curves: per trip, and pooled over trips weighted by time."""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field

import numpy as np

from modelcast.core.arrays import FloatArray, SingleArray
from modelcast.study.metrics import LANE_M, Histogram, confidence_limits, quantiles
from modelcast.study.result import TRACKING, Ecdf
from modelcast.study.table import Row
from modelcast.study.tracking import Contender, TrackingRun

__all__ = ["TrackingPool", "pool_ecdf", "pool_row", "sorted_errors"]

_PROBABILITIES = (0.5, 0.9, 0.95, 0.99)
_ECDF_PROBABILITIES = np.concatenate([np.linspace(0.0, 0.98, 295), np.linspace(0.9805, 1.0, 40)])


@dataclass(slots=True)
class TrackingPool:
    """Errors of one contender at one loss ratio, over one trip or many.

    Parameters
    ----------
    contender, packet_error_ratio
        Whose errors.
    by_seed_m
        For every seed, one sorted array of errors a trip [m].
    weights_s
        The time one sample of each trip stands for [s].
    """

    contender: Contender
    packet_error_ratio: float
    _: KW_ONLY
    by_seed_m: list[list[SingleArray]] = field(default_factory=list[list[SingleArray]])
    weights_s: list[float] = field(default_factory=list[float])
    own_threshold_m: float | None = None
    samples: int = 0
    excluded: int = 0
    messages: float = 0.0
    duration_s: float = 0.0
    total_m: float = 0.0
    beyond: float = 0.0
    weight_s: float = 0.0
    before: Histogram = field(default_factory=Histogram)
    along: Histogram = field(default_factory=Histogram)
    cross: Histogram = field(default_factory=Histogram)
    age: Histogram = field(default_factory=Histogram)
    gaps: Histogram = field(default_factory=Histogram)

    def fill(self, run: TrackingRun, ratio: int, dt_s: float, duration_s: float) -> None:
        """Fill an empty pool with one trip's run at the loss ratio of this index.

        Parameters
        ----------
        run
            All of the trip's errors.
        ratio
            Index of the loss ratio.
        dt_s
            The time one sample stands for [s].
        duration_s
            Time observed [s].
        """
        rows = sorted_errors(run, ratio)
        self.by_seed_m = [[row] for row in rows]
        seen = sum(row.size for row in rows)
        self.own_threshold_m = run.own_threshold_m[ratio]
        self.weights_s = [dt_s]
        self.samples = seen
        self.excluded = run.after_m[ratio].size - seen
        self.messages = run.messages[ratio]
        self.duration_s = duration_s
        self.total_m = dt_s * float(sum(row.sum(dtype=np.float64) for row in rows))
        self.beyond = dt_s * float(sum(row.size - np.searchsorted(row, LANE_M, side="right") for row in rows))
        self.weight_s = dt_s * seen
        self.before.add(run.before_m[ratio], dt_s)
        self.along.add(run.along_m[ratio], dt_s)
        self.cross.add(run.cross_m[ratio], dt_s)
        self.age.add(run.age_s[ratio], dt_s)
        self.gaps.merge(run.gaps_s[ratio])

    def merge(self, other: "TrackingPool") -> None:
        """Add another pool of the same contender and loss ratio.

        Parameters
        ----------
        other
            One trip's pool.
        """
        if not self.by_seed_m:
            self.by_seed_m = [[] for _ in other.by_seed_m]
            self.own_threshold_m = other.own_threshold_m
        elif self.own_threshold_m != other.own_threshold_m:
            self.own_threshold_m = None
        for kept, rows in zip(self.by_seed_m, other.by_seed_m, strict=True):
            kept.extend(rows)
        self.weights_s.extend(other.weights_s)
        self.samples += other.samples
        self.excluded += other.excluded
        self.messages += other.messages
        self.duration_s += other.duration_s
        self.total_m += other.total_m
        self.beyond += other.beyond
        self.weight_s += other.weight_s
        for name in ("before", "along", "cross", "age", "gaps"):
            getattr(self, name).merge(getattr(other, name))


def sorted_errors(run: TrackingRun, ratio: int) -> list[SingleArray]:
    """Errors of one run at the loss ratio of this index, sorted, one array a seed, NaN left out [m].

    Parameters
    ----------
    run
        All of the trip's errors.
    ratio
        Index of the loss ratio.
    """
    after = run.after_m[ratio]
    valid = np.count_nonzero(~np.isnan(after), axis=1)
    ordered = np.sort(after, axis=1)  # NaN sorts last
    return [ordered[k, : valid[k]] for k in range(after.shape[0])]


def pool_row(trip: str, pool: TrackingPool) -> Row:
    """The table row of a pool.

    Parameters
    ----------
    trip
        Trip id, or the name of pooled rows.
    pool
        The errors.
    """
    p50, p90, p95, p99 = _quantiles(pool, np.array(_PROBABILITIES))
    per_seed = np.array(
        [quantiles(rows, pool.weights_s, [0.9])[0] for rows in pool.by_seed_m], dtype=np.float64
    )
    low, high = confidence_limits(per_seed)
    weight_s = max(pool.weight_s, 1e-12)
    gaps = pool.gaps if pool.gaps.weight > 0 else None
    return TRACKING.row(
        trip=trip,
        policy=pool.contender.policy,
        bank=pool.contender.bank,
        rate_basis=pool.contender.rate_basis,
        threshold_m=pool.contender.threshold_m,
        own_threshold_m=pool.own_threshold_m,
        packet_error_ratio=pool.packet_error_ratio,
        seeds=len(pool.by_seed_m),
        samples=pool.samples,
        excluded_samples=pool.excluded,
        message_rate_hz=pool.messages / pool.duration_s,
        pte_mean_m=pool.total_m / weight_s,
        pte_p50_m=float(p50),
        pte_p90_m=float(p90),
        pte_p90_low_m=low,
        pte_p90_high_m=high,
        pte_p95_m=float(p95),
        pte_p99_m=float(p99),
        pte_before_p90_m=pool.before.quantile(0.9),
        along_p90_m=pool.along.quantile(0.9),
        cross_p90_m=pool.cross.quantile(0.9),
        beyond_lane_ratio=pool.beyond / weight_s,
        inter_packet_gap_p50_s=gaps.quantile(0.5) if gaps else None,
        inter_packet_gap_p95_s=gaps.quantile(0.95) if gaps else None,
        information_age_mean_s=pool.age.mean,
        information_age_p95_s=pool.age.quantile(0.95),
    )


def pool_ecdf(pool: TrackingPool) -> Ecdf:
    """The empirical distribution of a pool's errors, at a few hundred points."""
    return Ecdf(
        pool.contender.policy,
        pool.contender.rate_basis,
        pool.contender.threshold_m,
        pool.packet_error_ratio,
        _quantiles(pool, _ECDF_PROBABILITIES),
        _ECDF_PROBABILITIES,
    )


def _quantiles(pool: TrackingPool, probabilities: FloatArray) -> FloatArray:
    rows: list[SingleArray] = [row for rows in pool.by_seed_m for row in rows]
    weights: Sequence[float] = pool.weights_s * len(pool.by_seed_m)
    return quantiles(rows, weights, probabilities)
