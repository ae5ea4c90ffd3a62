"""From what a run counted to its rows."""

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.runtime.fleet.arrays import Tally
from modelcast.runtime.fleet.bins_kernels import BINS, lower_edge
from modelcast.runtime.fleet.engine import NetworkRun
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.sender import message_arrays as at
from modelcast.study.network.rows import (
    DISTANCES,
    HEADLINE_M,
    OUTCOMES,
    RUNS,
    SECONDS,
    CaseResult,
    NetworkCase,
)
from modelcast.study.table import Row

__all__ = ["binned_quantiles", "held_figures", "measure", "ratio", "span"]

_EDGES: FloatArray = lower_edge(np.arange(BINS + 1, dtype=np.int64))


def binned_quantiles(counts: IntArray | FloatArray, probabilities: tuple[float, ...]) -> list[float]:
    """Quantiles of a streamed histogram, linear within a bin; NaN where nothing was counted.

    Bins are 2.2 % wide, so a quantile errs by less than that.

    Parameters
    ----------
    counts
        By `bins_kernels.bin_of`, (BINS,); weighted ones are as good as their sum is large.
    probabilities
        Each in 0..1.

    Examples
    --------
    >>> counts = np.zeros(BINS, dtype=np.int64)
    >>> from modelcast.runtime.fleet.bins_kernels import bin_of
    >>> counts[bin_of(0.5)] = 10
    >>> [round(value, 2) for value in binned_quantiles(counts, (0.1, 0.9))]
    [0.5, 0.51]
    """
    reached: FloatArray = np.cumsum(counts, dtype=np.float64)
    if reached[-1] == 0:
        return [np.nan] * len(probabilities)
    found: list[float] = []
    for probability in probabilities:
        target = probability * reached[-1]
        place = int((reached < target).sum())
        before = reached[place - 1] if place else 0.0
        share = (target - before) / max(float(counts[place]), 1.0)
        found.append(float(_EDGES[place] + share * (_EDGES[place + 1] - _EDGES[place])))
    return found


def ratio(part: float, whole: float) -> float:
    """A share, NaN of nothing.

    Parameters
    ----------
    part, whole
        Counts or sums.
    """
    return part / whole if whole > 0 else np.nan


def measure(
    run: NetworkRun, case: NetworkCase, settings: NetworkSettings, *, outcome_bin_m: float
) -> CaseResult:
    """Rows of one run.

    Parameters
    ----------
    run
        What it counted.
    case
        What it was.
    settings
        With what it was run.
    outcome_bin_m
        Width of the radio's bins of distance [m].
    """
    return CaseResult(
        _run_row(run, case, settings, outcome_bin_m),
        _distance_rows(run, case, settings),
        outcomes=_outcome_rows(run, case, outcome_bin_m),
        seconds=_second_rows(run, case, settings),
    )


def span(low_m: float, high_m: float, width_m: float) -> slice:
    """Bins from one distance to another.

    Parameters
    ----------
    low_m, high_m
        Bounds [m].
    width_m
        Of a bin [m].
    """
    return slice(round(low_m / width_m), round(high_m / width_m))


def held_figures(counts: Tally, span: slice) -> dict[str, float]:
    """What hosts hold at the distances of a span: the columns that a run and a distance share.

    Parameters
    ----------
    counts
        Of the hosts.
    span
        Bins of distance.
    """
    pte = binned_quantiles(counts.error[span].sum(axis=0), (0.5, 0.9, 0.95, 0.99))
    age = binned_quantiles(counts.age[span].sum(axis=0), (0.5, 0.9))
    gap = binned_quantiles(counts.gap[span].sum(axis=0), (0.5, 0.9))
    return {
        "held_ratio": ratio(float(counts.held[span].sum()), float(counts.pairs[span].sum())),
        "pte_p50_m": pte[0],
        "pte_p90_m": pte[1],
        "pte_p95_m": pte[2],
        "pte_p99_m": pte[3],
        "age_p50_s": age[0],
        "age_p90_s": age[1],
        "gap_p50_s": gap[0],
        "gap_p90_s": gap[1],
    }


def _run_row(run: NetworkRun, case: NetworkCase, settings: NetworkSettings, outcome_bin_m: float) -> Row:
    counts, sums = run.tally, run.sent.total
    sent = float(sums[at.MESSAGES])
    middle = span(*HEADLINE_M, settings.distance_bin_m)
    gap = counts.gap[middle].sum(axis=0)
    relative = binned_quantiles(counts.relative[middle].sum(axis=0), (0.5, 0.9, 0.99))
    fate = run.outcomes[span(*HEADLINE_M, outcome_bin_m)].sum(axis=0).astype(np.float64)
    frames = float(fate.sum())
    steady = run.series[round(settings.warm_up_s / settings.dt_s) :]
    causes = [ratio(float(run.sent.causes[cause]), sent) for cause in range(at.CAUSES)]
    means = [float(column.mean()) for column in steady[:, [0, 5, 6, 7]].T]
    return RUNS.row(
        **case.values(),
        vehicles=means[0],
        message_rate_hz=ratio(sent, run.vehicle_s),
        update_rate_hz=ratio(sent - sums[at.IDENTIFICATIONS], run.vehicle_s),
        identification_rate_hz=ratio(sums[at.IDENTIFICATIONS], run.vehicle_s),
        time_ratio=causes[1],
        dynamics_ratio=causes[2],
        critical_ratio=causes[3],
        model_ratio=ratio(sums[at.MODELS], sent),
        certificate_ratio=ratio(sums[at.CERTIFICATES], sent),
        payload_bytes=ratio(sums[at.PAYLOAD_BYTES], sent),
        frame_bytes=ratio(sums[at.FRAME_BYTES], sent),
        bytes_per_s=ratio(sums[at.FRAME_BYTES], run.vehicle_s),
        airtime_ratio=ratio(sums[at.AIRTIME_S], run.vehicle_s),
        power_dbm=ratio(sums[at.POWER_DBM], sent),
        busy_ratio=run.busy_ratio,
        expired_ratio=ratio(float(run.expired), sent),
        delivery_ratio=ratio(fate[0], frames),
        collision_ratio=ratio(fate[3] + fate[4], frames),
        hidden_ratio=ratio(fate[3], frames),
        concurrent_ratio=ratio(fate[4], frames),
        half_duplex_ratio=ratio(fate[1], frames),
        weak_ratio=ratio(fate[2], frames),
        **held_figures(counts, middle),
        relative_p50_m=relative[0],
        relative_p90_m=relative[1],
        relative_p99_m=relative[2],
        gap_p99_s=binned_quantiles(gap, (0.99,))[0],
        neighbours=means[1],
        inter_transmit_time_s=means[2],
        channel_quality=means[3],
        tracks_per_s=ratio(float(counts.held.sum()), len(steady) * settings.dt_s),
    )


def _distance_rows(run: NetworkRun, case: NetworkCase, settings: NetworkSettings) -> list[Row]:
    return [
        DISTANCES.row(
            **case.values(),
            low_m=number * settings.distance_bin_m,
            high_m=(number + 1) * settings.distance_bin_m,
            pairs=int(run.tally.pairs[number]),
            **held_figures(run.tally, slice(number, number + 1)),
        )
        for number in range(settings.distances)
    ]


def _outcome_rows(run: NetworkRun, case: NetworkCase, bin_m: float) -> list[Row]:
    rows: list[Row] = []
    for number, fate in enumerate(run.outcomes):
        pairs = int(fate.sum())
        shares = [ratio(float(part), pairs) for part in fate]
        rows.append(
            OUTCOMES.row(
                **case.values(),
                low_m=number * bin_m,
                high_m=(number + 1) * bin_m,
                pairs=pairs,
                received_ratio=shares[0],
                half_duplex_ratio=shares[1],
                weak_ratio=shares[2],
                hidden_ratio=shares[3],
                concurrent_ratio=shares[4],
            )
        )
    return rows


def _second_rows(run: NetworkRun, case: NetworkCase, settings: NetworkSettings) -> list[Row]:
    a_second = max(1, round(1.0 / settings.dt_s))
    rows: list[Row] = []
    for number, errors in enumerate(run.recent):
        part = run.series[number * a_second : (number + 1) * a_second]
        vehicles = max(float(part[:, 0].sum()) * settings.dt_s, settings.dt_s)
        rows.append(
            SECONDS.row(
                **case.values(),
                t_s=(number + 1) * a_second * settings.dt_s,
                message_rate_hz=float(part[:, 1].sum()) / vehicles,
                busy_ratio=_mean(part[:, 3]),
                power_dbm=_mean(part[:, 4]),
                neighbours=_mean(part[:, 5]),
                inter_transmit_time_s=_mean(part[:, 6]),
                channel_quality=_mean(part[:, 7]),
                pte_p90_m=binned_quantiles(errors, (0.9,))[0],
            )
        )
    return rows


def _mean(values: FloatArray) -> float:
    """Mean of what is there; NaN where nothing is."""
    there = values[np.isfinite(values)]
    return float(there.mean()) if there.size else np.nan
