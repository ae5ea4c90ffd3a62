"""Runs pooled over seeds."""

from collections.abc import Iterable, Sequence

import numpy as np

from modelcast.study.metrics import confidence_limits
from modelcast.study.network.pool_warnings import pool_warnings
from modelcast.study.network.rows import (
    CASE_KEYS,
    CASE_TABLES,
    POOLED,
    RUNS,
    SENDERS,
    SETTING_KEYS,
    CaseResult,
    NetworkResult,
)
from modelcast.study.network.warning_rows import POOLED_WARNINGS
from modelcast.study.table import Row

__all__ = ["gather", "pool"]

FIGURES = tuple(name for name in RUNS.names if name not in CASE_KEYS)


def gather(results: Iterable[CaseResult], senders: Sequence[Row] = (), *, against: str = "") -> NetworkResult:
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
    tables = {
        name: schema.table(row for one in ordered for row in getattr(one, name))
        for name, schema in CASE_TABLES.items()
    }
    return NetworkResult(
        RUNS.table(runs),
        **tables,
        pooled=POOLED.table(pool(runs)),
        senders=SENDERS.table(senders),
        pooled_warnings=POOLED_WARNINGS.table(pool_warnings(ordered, against)),
    )


def _key(row: Row) -> tuple[float, str, str, str, float, int]:
    density, threshold_m = (
        value if np.isfinite(value) else 0.0 for value in (row.density_per_km, row.threshold_m)
    )
    return (density, row.radio, row.policy, row.bank, threshold_m, row.run)


def pool(runs: Sequence[Row]) -> list[Row]:
    """Mean and interval over seeds of every figure, for each density, radio, policy, bank and threshold.

    Parameters
    ----------
    runs
        In order.
    """
    groups: dict[tuple[str, ...], list[Row]] = {}
    for row in runs:
        key = repr(row.density_per_km), row.radio, row.policy, row.bank, repr(row.threshold_m)
        groups.setdefault(key, []).append(row)
    rows: list[Row] = []
    for own in groups.values():
        for figure in FIGURES:
            values = np.array([getattr(row, figure) for row in own], dtype=np.float64)
            there = values[np.isfinite(values)]
            low, high = confidence_limits(values)
            rows.append(
                POOLED.row(
                    **own[0].picked(SETTING_KEYS),
                    seeds=len(own),
                    figure=figure,
                    value=float(there.mean()) if there.size else np.nan,
                    low=low,
                    high=high,
                )
            )
    return rows
