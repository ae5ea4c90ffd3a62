"""Runs pooled over seeds, and the density at which tracking fails."""

from collections.abc import Iterable, Sequence
from dataclasses import fields
from itertools import pairwise

import numpy as np

from modelcast.study.metrics import confidence_limits
from modelcast.study.network.pool_warnings import pool_warnings
from modelcast.study.network.rows import (
    CASE_KEYS,
    CapacityRow,
    CaseResult,
    NetworkResult,
    PooledRow,
    RunRow,
    SenderRow,
)

__all__ = ["LIMITS_M", "capacities", "gather", "pool"]

LIMITS_M = (0.5, 1.0)
"""Tracking errors whose density is asked for [m]."""

FIGURES = tuple(field.name for field in fields(RunRow) if field.name not in CASE_KEYS)


def gather(
    results: Iterable[CaseResult], senders: Sequence[SenderRow] = (), *, against: str = ""
) -> NetworkResult:
    """Put the runs in order and pool them.

    Parameters
    ----------
    results
        Of single runs, in any order.
    senders
        What each policy sent of each bank.
    against
        As for `modelcast.study.network.pool_warnings.pool_warnings`.
    """
    ordered = sorted(results, key=lambda one: _key(one.run))
    runs = [one.run for one in ordered]
    pooled = pool(runs)
    return NetworkResult(
        runs,
        [row for one in ordered for row in one.distances],
        outcomes=[row for one in ordered for row in one.outcomes],
        seconds=[row for one in ordered for row in one.seconds],
        pooled=pooled,
        capacities=capacities(pooled),
        senders=senders,
        pairings=[row for one in ordered for row in one.pairings],
        penetration=[row for one in ordered for row in one.penetration],
        warnings=[row for one in ordered for row in one.warnings],
        warned_hosts=[row for one in ordered for row in one.warned_hosts],
        warned_events=[row for one in ordered for row in one.warned_events],
        pooled_warnings=pool_warnings(ordered, against),
    )


def _key(row: RunRow) -> tuple[float, str, str, str, float, int]:
    density, threshold_m = (
        value if np.isfinite(value) else 0.0 for value in (row.density_per_km, row.threshold_m)
    )
    return (density, row.radio, row.policy, row.bank, threshold_m, row.run)


def pool(runs: Sequence[RunRow]) -> list[PooledRow]:
    """Mean and interval over seeds of every figure, for each density, radio, policy, bank and threshold.

    Parameters
    ----------
    runs
        In order.
    """
    groups: dict[tuple[str, ...], list[RunRow]] = {}
    for row in runs:
        key = repr(row.density_per_km), row.radio, row.policy, row.bank, repr(row.threshold_m)
        groups.setdefault(key, []).append(row)
    rows: list[PooledRow] = []
    for own in groups.values():
        for figure in FIGURES:
            values = np.array([getattr(row, figure) for row in own], dtype=np.float64)
            there = values[np.isfinite(values)]
            low, high = confidence_limits(values)
            rows.append(
                PooledRow(
                    density_per_km=own[0].density_per_km,
                    radio=own[0].radio,
                    policy=own[0].policy,
                    bank=own[0].bank,
                    threshold_m=own[0].threshold_m,
                    seeds=len(own),
                    figure=figure,
                    value=float(there.mean()) if there.size else np.nan,
                    low=low,
                    high=high,
                )
            )
    return rows


def capacities(pooled: Sequence[PooledRow]) -> list[CapacityRow]:
    """Density at which the 90th percentile of the tracking error at 100 m reaches each limit.

    Between two densities run, the error is taken as linear in the logarithm of the density; the first
    crossing from below counts.

    Parameters
    ----------
    pooled
        As `pool` gives them.

    Examples
    --------
    >>> rows = [
    ...     PooledRow(
    ...         density_per_km=density,
    ...         radio="dsrc",
    ...         policy="j2945",
    ...         bank="none",
    ...         threshold_m=np.nan,
    ...         seeds=1,
    ...         figure="pte_p90_100_m",
    ...         value=value,
    ...         low=None,
    ...         high=None,
    ...     )
    ...     for density, value in ((25.0, 0.25), (100.0, 0.75))
    ... ]
    >>> [row.density_per_km and round(row.density_per_km, 6) for row in capacities(rows)]
    [50.0, None]
    """
    groups: dict[tuple[str, ...], list[PooledRow]] = {}
    for row in pooled:
        if row.figure == "pte_p90_100_m" and np.isfinite(row.density_per_km):
            groups.setdefault((row.radio, row.policy, row.bank, repr(row.threshold_m)), []).append(row)
    rows: list[CapacityRow] = []
    for (radio, policy, bank, _), own in groups.items():
        ordered = sorted(own, key=lambda row: row.density_per_km)
        rows += [
            CapacityRow(
                radio=radio,
                policy=policy,
                bank=bank,
                threshold_m=own[0].threshold_m,
                limit_m=limit_m,
                density_per_km=_crossing(ordered, limit_m),
                highest_per_km=ordered[-1].density_per_km,
                above_at_lowest=ordered[0].value >= limit_m,
            )
            for limit_m in LIMITS_M
        ]
    return rows


def _crossing(ordered: Sequence[PooledRow], limit_m: float) -> float | None:
    for before, after in pairwise(ordered):
        if before.value < limit_m <= after.value:
            share = (limit_m - before.value) / (after.value - before.value)
            low, high = np.log(before.density_per_km), np.log(after.density_per_km)
            return float(np.exp(low + share * (high - low)))
    return None
