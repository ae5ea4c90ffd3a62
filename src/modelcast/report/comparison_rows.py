"""Which rows of a comparison its tables, figure and sentences show."""

from collections.abc import Callable, Iterable
from math import isfinite
from operator import attrgetter

from modelcast.study.compare.result import ComparisonResult
from modelcast.study.result import POOLED
from modelcast.study.table import Row

__all__ = [
    "Limited",
    "candidate_rows",
    "loss_ratios",
    "pooled_rows",
    "protocols",
    "rival_rows_of",
    "thresholds_m",
    "worst_rows",
]

Limited = tuple[float, float | None, float | None]
"""A ratio and the ends of its interval."""


def protocols(result: ComparisonResult) -> list[str]:
    """Return the protocols in the order they were run."""
    return list(dict.fromkeys(row.protocol for row in result.ratios))


def thresholds_m(result: ComparisonResult) -> list[float]:
    """Return the thresholds, rising [m]."""
    return sorted({row.threshold_m for row in result.ratios})


def loss_ratios(result: ComparisonResult) -> list[float]:
    """Return the packet error ratios, rising."""
    return sorted({row.packet_error_ratio for row in result.tracking})


def candidate_rows(result: ComparisonResult, candidate: str, protocol: str) -> list[Row]:
    """Return a candidate's rows over the baseline, by rising threshold.

    Parameters
    ----------
    result
        The comparison.
    candidate, protocol
        Whose.
    """
    return _rising(row for row in result.ratios if (row.candidate, row.protocol) == (candidate, protocol))


def rival_rows_of(result: ComparisonResult, candidate: str, protocol: str, rival: str | None) -> list[Row]:
    """Return a candidate's rows over another one, by rising threshold.

    Parameters
    ----------
    result
        The comparison.
    candidate, protocol
        Whose.
    rival
        The other one.
    """
    whose = candidate, protocol, rival
    return _rising(row for row in result.rivals if (row.candidate, row.protocol, row.rival) == whose)


def pooled_rows(result: ComparisonResult, candidate: str, protocol: str, ratio: float) -> list[Row]:
    """Return a candidate's errors over all trips at a packet error ratio, by rising threshold.

    Parameters
    ----------
    result
        The comparison.
    candidate, protocol
        Whose.
    ratio
        Packet error ratio.
    """
    whose = POOLED, candidate, protocol, ratio
    return _rising(
        row
        for row in result.tracking
        if (row.trip, row.candidate, row.protocol, row.packet_error_ratio) == whose
    )


def worst_rows(result: ComparisonResult, candidate: str, protocol: str, figure: str) -> list[Limited]:
    """Return the largest ratio over the thresholds at each packet error ratio, rising, with its interval.

    Parameters
    ----------
    result
        The comparison.
    candidate, protocol
        Whose.
    figure
        ``p90`` or ``p99`` over the harder equal-rate baseline, ``p90_over_free`` or ``p99_over_free`` over
        the free receiver at the same rate; NaN where no threshold has it.
    """
    central = figure if figure.endswith("_free") else f"{figure}_ratio"
    read: Callable[[Row], tuple[float | None, float | None, float | None]]
    read = attrgetter(central, f"{figure}_low", f"{figure}_high")
    found: list[Limited] = []
    for ratio in loss_ratios(result):
        each = map(read, pooled_rows(result, candidate, protocol, ratio))
        known = [(value, low, high) for value, low, high in each if value is not None and isfinite(value)]
        found.append(max(known, key=lambda one: one[0], default=(float("nan"), None, None)))
    return found


def _rising(rows: Iterable[Row]) -> list[Row]:
    return sorted(rows, key=lambda row: row.threshold_m)
