"""From tracking runs to table rows and curves: per trip, and pooled over trips weighted by time.

A trip's quantiles are exact: its errors are in memory once. Over trips, pools hold histograms, which never
grow, and whole millionths in place of sums, so that pools of parts merge in any order to the same bytes.
"""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field

import numpy as np

from modelcast.core.arrays import FloatArray, SingleArray
from modelcast.study.histogram import MILLIONTHS, Histogram, millionths
from modelcast.study.metrics import LANE_M, confidence_limits, quantiles
from modelcast.study.result import TRACKING, Ecdf
from modelcast.study.table import Row
from modelcast.study.tracking import Contender, TrackingRun

__all__ = ["TrackingPool", "pool_ecdf", "pool_row", "sorted_errors", "trip_row"]

_PROBABILITIES = (0.5, 0.9, 0.95, 0.99)
_ECDF_PROBABILITIES = np.concatenate([np.linspace(0.0, 0.98, 295), np.linspace(0.9805, 1.0, 40)])


@dataclass(slots=True)
class TrackingPool:
    """Errors of one contender at one loss ratio, over one trip or many.

    Parameters
    ----------
    contender, packet_error_ratio
        Whose errors.
    by_seed
        Errors of every seed, weighted by the time a sample stands for [us].
    own_threshold_m
        Threshold that the contender itself ran at [m]; None where it has none, or trips differ.
    samples, excluded
        Samples over all seeds: with an error, and without.
    messages
        Messages sent, mean over the seeds, in millionths.
    duration_us, beyond_us
        Time observed; over all seeds the time spent with an error over a lane's half width.
    before, along, cross, age
        Of all seeds, weighted as the errors are.
    gaps
        Between messages received; every gap weighs the same.
    """

    contender: Contender
    packet_error_ratio: float
    _: KW_ONLY
    by_seed: list[Histogram] = field(default_factory=list[Histogram])
    own_threshold_m: float | None = None
    samples: int = 0
    excluded: int = 0
    messages: int = 0
    duration_us: int = 0
    beyond_us: int = 0
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
        after_m = run.after_m[ratio]
        step_us = max(millionths(dt_s), 1)
        for errors_m in after_m:
            one = Histogram()
            one.add(errors_m, step_us)
            self.by_seed.append(one)
        self.samples = sum(one.weight for one in self.by_seed) // step_us
        self.excluded = after_m.size - self.samples
        self.own_threshold_m = run.own_threshold_m[ratio]
        self.messages = millionths(run.messages[ratio])
        self.duration_us = millionths(duration_s)
        self.beyond_us = step_us * int(np.count_nonzero(after_m > LANE_M))
        self.before.add(run.before_m[ratio], step_us)
        self.along.add(run.along_m[ratio], step_us)
        self.cross.add(run.cross_m[ratio], step_us)
        self.age.add(run.age_s[ratio], step_us)
        self.gaps.merge(run.gaps_s[ratio])

    def merge(self, other: "TrackingPool") -> None:
        """Add another pool of the same contender and loss ratio.

        Parameters
        ----------
        other
            It stays as it is.
        """
        if not self.by_seed:
            self.by_seed = [Histogram() for _ in other.by_seed]
            self.own_threshold_m = other.own_threshold_m
        elif self.own_threshold_m != other.own_threshold_m:
            self.own_threshold_m = None
        for kept, added in zip(self.by_seed, other.by_seed, strict=True):
            kept.merge(added)
        self.samples += other.samples
        self.excluded += other.excluded
        self.messages += other.messages
        self.duration_us += other.duration_us
        self.beyond_us += other.beyond_us
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


def trip_row(trip: str, pool: TrackingPool, errors_m: Sequence[SingleArray]) -> Row:
    """The table row of one trip, its quantiles exact.

    Parameters
    ----------
    trip
        Its id.
    pool
        Its errors.
    errors_m
        The same errors sorted, one array a seed, as `sorted_errors` gives them [m].
    """
    same = [1.0] * len(errors_m)
    per_seed = np.array([quantiles([rows], [1.0], [0.9])[0] for rows in errors_m], dtype=np.float64)
    return _row(trip, pool, quantiles(errors_m, same, _PROBABILITIES), per_seed)


def pool_row(trip: str, pool: TrackingPool) -> Row:
    """The table row of a pool, its quantiles those of its histograms.

    Parameters
    ----------
    trip
        The name of pooled rows.
    pool
        The errors.
    """
    per_seed = np.array([one.quantile(0.9) for one in pool.by_seed], dtype=np.float64)
    return _row(trip, pool, Histogram.merged(pool.by_seed).quantiles(_PROBABILITIES), per_seed)


def pool_ecdf(pool: TrackingPool) -> Ecdf:
    """The empirical distribution of a pool's errors, at a few hundred points."""
    return Ecdf(
        pool.contender.policy,
        pool.contender.rate_basis,
        pool.contender.threshold_m,
        pool.packet_error_ratio,
        Histogram.merged(pool.by_seed).quantiles(_ECDF_PROBABILITIES),
        _ECDF_PROBABILITIES,
    )


def _row(trip: str, pool: TrackingPool, errors_m: FloatArray, per_seed_m: FloatArray) -> Row:
    """A row, given the quantiles of all errors and the 90th percentile of every seed's."""
    p50, p90, p95, p99 = errors_m.tolist()
    low, high = confidence_limits(per_seed_m)
    weight_us = max(sum(one.weight for one in pool.by_seed), 1)
    gaps = pool.gaps if pool.gaps.weight > 0 else None
    return TRACKING.row(
        trip=trip,
        policy=pool.contender.policy,
        bank=pool.contender.bank,
        rate_basis=pool.contender.rate_basis,
        threshold_m=pool.contender.threshold_m,
        own_threshold_m=pool.own_threshold_m,
        packet_error_ratio=pool.packet_error_ratio,
        seeds=len(pool.by_seed),
        samples=pool.samples,
        excluded_samples=pool.excluded,
        message_rate_hz=pool.messages / pool.duration_us,
        pte_mean_m=sum(one.total for one in pool.by_seed) / (weight_us * MILLIONTHS),
        pte_p50_m=p50,
        pte_p90_m=p90,
        pte_p90_low_m=low,
        pte_p90_high_m=high,
        pte_p95_m=p95,
        pte_p99_m=p99,
        pte_before_p90_m=pool.before.quantile(0.9),
        along_p90_m=pool.along.quantile(0.9),
        cross_p90_m=pool.cross.quantile(0.9),
        beyond_lane_ratio=pool.beyond_us / weight_us,
        inter_packet_gap_p50_s=gaps.quantile(0.5) if gaps else None,
        inter_packet_gap_p95_s=gaps.quantile(0.95) if gaps else None,
        information_age_mean_s=pool.age.mean,
        information_age_p95_s=pool.age.quantile(0.95),
    )
