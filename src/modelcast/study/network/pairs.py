"""The hybrid against the error-driven baseline in traffic, seed by seed: what a model changes on the air.

Both send when their own tracking error passes the same threshold; `HYBRID` sends a model of its bank, with
updates and identifications, `BASELINE` a basic safety message that coasts. A seed gives both the same
traffic and the radio the same generator, so differences are taken within seeds, and their mean has a 95 %
Student-t interval over seeds. A difference is shown where this interval leaves zero out. Where nothing
differs, one row in twenty does so by chance.
"""

from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.study.metrics import confidence_limits
from modelcast.study.network.columns import SETTING, SPAN
from modelcast.study.network.rows import HEADLINE_M, NO_BANK, NetworkResult
from modelcast.study.table import Column, Row, TableSchema, count, flag, quantity, text

__all__ = [
    "BASELINE",
    "FIGURES",
    "HYBRID",
    "PAIRED",
    "Verdict",
    "collision_rate_hz",
    "traffic_rows",
    "verdict_of",
]

HYBRID, BASELINE = "mbc", "baseline"
"""Policies that are compared."""

FIGURES = (
    "message_rate_hz",
    "update_rate_hz",
    "identification_rate_hz",
    "bytes_per_s",
    "busy_ratio",
    "delivery_ratio",
    "collision_ratio",
    "collision_rate_hz",
    "held_ratio",
    "gap_p90_s",
    "pte_p90_m",
    "pte_p99_m",
)
"""Figures of whole runs that are compared: fields of `RUNS`, and `collision_rate_hz`."""

_RANGE_FIGURES = ("held_ratio", "gap_p90_s", "pte_p90_m", "pte_p99_m")
"""Fields of `DISTANCES` that are compared; delivery and collisions come with the radio's own distances."""

Verdict = Literal["fewer", "no difference shown", "more", "one seed"]
"""What the interval of the hybrid minus the baseline says: below zero, around it, above it."""


def _mean_columns(name: str, what: str) -> tuple[Column, ...]:
    """Return columns of a mean and its interval, in the unit of the figure."""
    missing = "one seed has no interval"
    return (
        quantity(name, "", f"{what}, in the unit of the figure."),
        quantity(f"{name}_low", "", "Lower 95 % Student-t limit.", missing=missing),
        quantity(f"{name}_high", "", "Upper 95 % Student-t limit.", missing=missing),
    )


PAIRED = TableSchema(
    "traffic",
    "One figure of the hybrid and of the baseline at one density, radio, bank, threshold and distance.",
    (
        *(column for column in SETTING if column.name != "policy"),
        text("figure", "A name of `FIGURES`."),
        *SPAN,
        flag("by_range", "Whether it is one of several distances."),
        count("seeds", "Seeds in which both have the figure."),
        *_mean_columns("hybrid", "Mean of the hybrid over these seeds"),
        *_mean_columns("baseline", "Mean of the baseline over these seeds"),
        *_mean_columns("difference", "Mean of hybrid minus baseline within a seed"),
        text("verdict", "What the interval of the difference says, a `Verdict`."),
    ),
)
"""Pairs: a row a figure, setting and distance."""


def collision_rate_hz(row: Row) -> float:
    """Frames of a remote 50 m to 150 m away that a host loses to other frames, a second [Hz].

    The share that collides times the frames that are sent: shares alone do not tell a sender of few frames
    from one of many.

    Parameters
    ----------
    row
        A run.
    """
    return row.collision_ratio * row.message_rate_hz * (1.0 - min(row.expired_ratio, 1.0))


def verdict_of(low: float | None, high: float | None) -> Verdict:
    """Return what the interval of a difference says.

    Parameters
    ----------
    low, high
        Its bounds; None for a single seed.

    Examples
    --------
    >>> verdict_of(-0.2, -0.1), verdict_of(-0.1, 0.1), verdict_of(None, None)
    ('fewer', 'no difference shown', 'one seed')
    """
    if low is None or high is None:
        return "one seed"
    return "fewer" if high < 0.0 else "more" if low > 0.0 else "no difference shown"


def traffic_rows(result: NetworkResult) -> list[Row]:
    """Compare the hybrid of every bank with the baseline; nothing where either was not run.

    Parameters
    ----------
    result
        All runs.
    """
    found: dict[_Place, dict[str, dict[int, float]]] = {}
    for place, bank, run, value in _numbers(result):
        if np.isfinite(value):
            found.setdefault(place, {}).setdefault(bank, {})[run] = value
    rows: list[Row] = []
    for bank in result.banks:
        for place, senders in found.items():
            both = sorted(senders.get(bank, {}).keys() & senders.get(NO_BANK, {}).keys())
            if both:
                hybrid, baseline = (
                    np.array([senders[name][run] for run in both]) for name in (bank, NO_BANK)
                )
                rows.append(_row(place, bank, hybrid, baseline))
    return rows


class _Place(NamedTuple):
    """What is compared; numbers that may not exist as text, so that equal ones are one key."""

    density: str
    radio: str
    threshold: str
    figure: str
    low_m: float
    high_m: float
    by_range: bool


def _numbers(result: NetworkResult) -> Iterator[tuple[_Place, str, int, float]]:
    """Every number of the two policies: what it is of, the bank, the seed, and the number."""
    for row in result.runs:
        if row.policy in {HYBRID, BASELINE}:
            for figure in FIGURES:
                value = collision_rate_hz(row) if figure == "collision_rate_hz" else getattr(row, figure)
                yield _place(row, figure, HEADLINE_M), row.bank, row.run, float(value)
    for row in result.outcomes:
        if row.policy in {HYBRID, BASELINE}:
            span = (row.low_m, row.high_m)
            yield _place(row, "delivery_ratio", span, True), row.bank, row.run, row.received_ratio
            collided = row.hidden_ratio + row.concurrent_ratio
            yield _place(row, "collision_ratio", span, True), row.bank, row.run, collided
    for row in result.distances:
        if row.policy in {HYBRID, BASELINE}:
            for figure in _RANGE_FIGURES:
                span = (row.low_m, row.high_m)
                yield _place(row, figure, span, True), row.bank, row.run, float(getattr(row, figure))


def _place(row: Row, figure: str, span_m: tuple[float, float], by_range: bool = False) -> _Place:
    density, threshold = repr(row.density_per_km), repr(row.threshold_m)
    return _Place(density, row.radio, threshold, figure, *span_m, by_range)


def _row(place: _Place, bank: str, hybrid: FloatArray, baseline: FloatArray) -> Row:
    difference = hybrid - baseline
    low, high = confidence_limits(difference)
    of_hybrid, of_baseline = confidence_limits(hybrid), confidence_limits(baseline)
    return PAIRED.row(
        density_per_km=float(place.density),
        radio=place.radio,
        bank=bank,
        threshold_m=float(place.threshold),
        figure=place.figure,
        low_m=place.low_m,
        high_m=place.high_m,
        by_range=place.by_range,
        seeds=hybrid.size,
        hybrid=float(hybrid.mean()),
        hybrid_low=of_hybrid[0],
        hybrid_high=of_hybrid[1],
        baseline=float(baseline.mean()),
        baseline_low=of_baseline[0],
        baseline_high=of_baseline[1],
        difference=float(difference.mean()),
        difference_low=low,
        difference_high=high,
        verdict=verdict_of(low, high),
    )
