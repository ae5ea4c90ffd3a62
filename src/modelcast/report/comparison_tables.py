"""The tables of a comparison: ratios at the same threshold without loss, and both readings under loss.

A table has one reading: ratios of messages at one threshold beside errors at one rate would say together what
neither says.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from modelcast.core.cells import Cells
from modelcast.report.comparison_rows import (
    candidate_rows,
    loss_ratios,
    pooled_rows,
    rival_rows_of,
    thresholds_m,
    worst_rows,
)
from modelcast.study.compare.result import CandidateRow, ComparisonResult
from modelcast.study.table import Row
from modelcast.study.wording import centimetres

__all__ = [
    "ComparisonTable",
    "counted_over",
    "listed_values",
    "number",
    "protocol_tables",
    "shown_name",
    "shown_rivals",
]

_MISSING = "-"
_OVER_BASELINE = (
    "Messages, bytes and airtime over the baseline's at the same threshold, without loss: ratios of sums "
    "with 95 % bootstrap intervals over the trips; difference of the message ratio to {against}; trips times "
    "thresholds with more than max(1.02 x baseline, baseline + 3) messages, and the trip with the most "
    "beyond that bound."
)
_OVER_RIVAL = (
    "The same over {rival}; trips times thresholds with more than max(1.05 x its own, its own + 5) messages."
)
_SAME_THRESHOLD = (
    "All run at the same threshold, and each sends what it needs: messages a second, keep-alives among them, "
    "and 90th percentile of the tracking error, at {thresholds}. The free receiver is run by the candidate's "
    "rules: it repeats under losses where the candidate does."
)
_SAME_RATE = (
    "All send as often as the candidate ({basis} rate): 90th and 99th percentile of its tracking error over "
    "those of the harder of both equal-rate baselines, and of the free receiver, at the worst threshold, "
    "with 95 % bootstrap intervals over the trips."
)


@dataclass(frozen=True, slots=True)
class ComparisonTable:
    """A table with what it shows.

    Parameters
    ----------
    title, legend
        Plain text.
    cells
        The table.
    """

    title: str
    legend: str
    cells: Cells


def protocol_tables(result: ComparisonResult, protocol: str) -> list[ComparisonTable]:
    """Return the tables of one protocol, with every interval.

    Parameters
    ----------
    result
        The comparison.
    protocol
        Which.
    """
    legend = _OVER_BASELINE.format(against=result.settings.get("against"))
    tables = [
        ComparisonTable(
            "Same threshold, without loss: over the baseline", legend, _over_baseline(result, protocol)
        ),
        *(
            ComparisonTable(
                f"Same threshold, without loss: over {_named(result, rival)}",
                _OVER_RIVAL.format(rival=_named(result, rival)),
                _over_rival(result, protocol, rival),
            )
            for rival in shown_rivals(result)
        ),
    ]
    if not loss_ratios(result):
        return tables
    thresholds = " / ".join(centimetres(item) for item in thresholds_m(result))
    basis = str(result.settings.get("rate_basis", "total"))
    return [
        *tables,
        ComparisonTable(
            "Same threshold, with losses: messages and errors",
            _SAME_THRESHOLD.format(thresholds=thresholds),
            _same_threshold(result, protocol),
        ),
        ComparisonTable(
            "Same rate, with losses: errors", _SAME_RATE.format(basis=basis), _same_rate(result, protocol)
        ),
    ]


def _named(result: ComparisonResult, rival: str) -> str:
    return "the free receiver" if rival == result.free else rival


def shown_rivals(result: ComparisonResult) -> list[str]:
    """Return the candidates that all are held against beside the baseline, the free receiver first.

    Parameters
    ----------
    result
        The comparison.
    """
    named = dict.fromkeys((result.free, result.rival))
    known = {row.rival for row in result.rivals}
    alone = len(result.candidates) == 1
    return [rival for rival in named if rival is not None and rival in known and not alone]


def shown_name(candidate: CandidateRow) -> str:
    """Return what tables call a candidate."""
    return f"{candidate.name} (trained)" if candidate.is_trained else candidate.name


def _over_baseline(result: ComparisonResult, protocol: str) -> Cells:
    thresholds = [centimetres(item) for item in thresholds_m(result)]
    heads = ["candidate", *(f"messages, {text}" for text in thresholds)]
    heads += ["difference, " + " / ".join(thresholds), "bytes, " + " / ".join(thresholds)]
    heads += [*(f"airtime, {text}" for text in thresholds), "over the bound", "worst trip"]
    cells: list[list[str]] = []
    for candidate in result.candidates:
        rows = candidate_rows(result, candidate.name, protocol)
        own = [shown_name(candidate), *_limited(rows, "message")]
        own += ["; ".join(_signed(row) for row in rows), listed_values(rows, "bytes_ratio")]
        cells.append([*own, *_limited(rows, "airtime"), *_over_the_bound(rows)])
    return Cells(heads, cells, 1)


def _over_rival(result: ComparisonResult, protocol: str, rival: str) -> Cells:
    thresholds = [centimetres(item) for item in thresholds_m(result)]
    heads = ["candidate", *(f"messages, {text}" for text in thresholds)]
    heads += ["bytes, " + " / ".join(thresholds), *(f"airtime, {text}" for text in thresholds)]
    heads += ["over the bound", "worst trip"]
    cells: list[list[str]] = []
    for candidate in result.candidates:
        rows = rival_rows_of(result, candidate.name, protocol, rival)
        own = [shown_name(candidate), *_limited(rows, "message"), listed_values(rows, "bytes_ratio")]
        cells.append([*own, *_limited(rows, "airtime"), *_over_the_bound(rows)])
    return Cells(heads, cells, 1)


def _same_threshold(result: ComparisonResult, protocol: str) -> Cells:
    """Messages and errors of each candidate, the free receiver and the baseline, at every loss ratio."""
    whose = (("", "candidate"), ("free_", "free receiver"), ("baseline_", "baseline"))
    shown = [one for one in whose if one[0] != "free_" or result.free is not None]
    heads = ["candidate", "lost [%]", *(f"{name} [1/s]" for _, name in shown)]
    heads += [f"{name} p90 [m]" for _, name in shown]
    cells: list[list[str]] = []
    for candidate in result.candidates:
        for ratio in loss_ratios(result):
            rows = pooled_rows(result, candidate.name, protocol, ratio)
            sent = [listed_values(rows, f"{prefix or 'message_'}rate_hz") for prefix, _ in shown]
            errors = [listed_values(rows, f"{prefix}p90_m") for prefix, _ in shown]
            cells.append([shown_name(candidate), f"{100 * ratio:.4g}", *sent, *errors])
    return Cells(heads, cells, 1)


def _same_rate(result: ComparisonResult, protocol: str) -> Cells:
    """Errors of each candidate over those of its rivals, at every loss ratio."""
    figures = {"p90": "p90 / baseline", "p99": "p99 / baseline"}
    if result.free is not None:
        figures = {
            "p90_over_free": "p90 / free receiver",
            "p90": "p90 / baseline",
            "p99_over_free": "p99 / free receiver",
            "p99": "p99 / baseline",
        }
    cells: list[list[str]] = []
    for candidate in result.candidates:
        found = [worst_rows(result, candidate.name, protocol, figure) for figure in figures]
        for at, ratio in enumerate(loss_ratios(result)):
            worst = [_with_limits(*one[at]) for one in found]
            cells.append([shown_name(candidate), f"{100 * ratio:.4g}", *worst])
    return Cells(["candidate", "lost [%]", *figures.values()], cells, 1)


def _limited(rows: Sequence[Row], name: str) -> list[str]:
    """Ratios of messages, bytes or airtime with their intervals."""
    ends = [row.picked((f"{name}_ratio", f"{name}_low", f"{name}_high")) for row in rows]
    return [_with_limits(*one.values()) for one in ends]


def listed_values(rows: Sequence[Row], name: str) -> str:
    """Return one column of several rows in a cell.

    Parameters
    ----------
    rows
        By rising threshold.
    name
        Of the column.
    """
    return " / ".join(number(getattr(row, name)) for row in rows)


def counted_over(rows: Sequence[Row]) -> str:
    """Return how many trips times thresholds are over the bound.

    Parameters
    ----------
    rows
        Of ratios.
    """
    return f"{sum(row.trips_over for row in rows)} of {sum(row.trips for row in rows)}"


def _over_the_bound(rows: Sequence[Row]) -> list[str]:
    """How many trips times thresholds are over the bound, and the worst of them."""
    worst = max(rows, key=lambda row: row.worst_excess)
    at = centimetres(worst.threshold_m)
    return [counted_over(rows), f"{worst.worst_trip}, {worst.worst_ratio:.2f} at {at}"]


def number(value: float | None) -> str:
    """Return a number in two places; a dash where there is none.

    Parameters
    ----------
    value
        Any; None and NaN are none.
    """
    return _MISSING if value is None or value != value else f"{value:.2f}"  # noqa: PLR0124  NaN


def _with_limits(value: float, low: float | None, high: float | None, sign: str = "") -> str:
    if value != value:  # noqa: PLR0124  NaN
        return _MISSING
    form = f"{sign}.2f"
    return f"{value:{form}}" + ("" if low is None or high is None else f" [{low:{form}}, {high:{form}}]")


def _signed(row: Row) -> str:
    return _with_limits(row.difference, row.difference_low, row.difference_high, "+")
