"""Runs pooled over seeds."""

from collections.abc import Iterable, Sequence
from dataclasses import fields

import numpy as np

from modelcast.study.metrics import confidence_limits
from modelcast.study.network.pool_warnings import pool_warnings
from modelcast.study.network.rows import (
    CASE_KEYS,
    CaseResult,
    NetworkResult,
    PooledRow,
    RunRow,
    SenderRow,
)

__all__ = ["gather", "pool"]

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
    return NetworkResult(
        runs,
        [row for one in ordered for row in one.distances],
        outcomes=[row for one in ordered for row in one.outcomes],
        seconds=[row for one in ordered for row in one.seconds],
        pooled=pool(runs),
        senders=senders,
        pairings=[row for one in ordered for row in one.pairings],
        penetration=[row for one in ordered for row in one.penetration],
        warnings=[row for one in ordered for row in one.warnings],
        warned_hosts=[row for one in ordered for row in one.warned_hosts],
        warned_events=[row for one in ordered for row in one.warned_events],
        roadside=[row for one in ordered for row in one.roadside],
        roadside_distances=[row for one in ordered for row in one.roadside_distances],
        people=[row for one in ordered for row in one.people],
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
