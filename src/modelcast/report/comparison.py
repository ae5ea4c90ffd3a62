"""A comparison for people: the table, as Markdown and for the terminal, and the figure's files."""

from collections.abc import Sequence
from pathlib import Path

from rich.console import Group, RenderableType

from modelcast.core.cells import Cells, markdown
from modelcast.report.console import failures_table, left_out_text, skipped_lines, warning_texts
from modelcast.report.console_table import console_table
from modelcast.report.figures.comparison import plot_comparison, rival_rows_of, worst_rows
from modelcast.report.figures.files import drawn, write_report_files
from modelcast.report.literal import Prose, literal
from modelcast.report.style import style
from modelcast.report.training_trips import training_note
from modelcast.report.warnings import warning_lines
from modelcast.study.compare.result import CandidateRow, ComparisonResult
from modelcast.study.loss_ratios import nearest_ratio
from modelcast.study.rules import MODEL_SENDER
from modelcast.study.table import Row
from modelcast.study.wording import centimetres

__all__ = ["comparison_console", "comparison_markdown", "scope_line", "write_comparison_report"]

_MISSING = "-"


def write_comparison_report(result: ComparisonResult, folder: str | Path) -> list[Path]:
    """Write ``table.md`` and the figure ``comparison`` as PNG, SVG and PDF; return their paths.

    Parameters
    ----------
    result
        The comparison.
    folder
        An existing folder.
    """
    with style():
        drawing = drawn("comparison", plot_comparison(result))
    return write_report_files({"table.md": comparison_markdown(result)}, [drawing], folder)


def _training_lines(result: ComparisonResult) -> list[str]:
    return training_note([trip.id for trip in result.trips if trip.in_training], len(result.trips))


def comparison_markdown(result: ComparisonResult) -> str:
    """Return the table of a comparison as Markdown, one part a protocol.

    Parameters
    ----------
    result
        The comparison.
    """
    told = warning_lines((trip.id, trip.warnings) for trip in result.trips)
    lines = [f"- **Warning**: {markdown(line)}" for line in told] + ([""] if told else [])
    lines += [markdown(scope_line(result)), ""]
    lines += [text for line in _training_lines(result) for text in (markdown(line), "")]
    lines += [
        f"- route {row.route}: {markdown(row.name)}, {_counted(row.trips, 'trip')}, {row.duration_s:.0f} s"
        for row in result.routes
    ]
    for protocol in _protocols(result):
        lines += [
            "",
            f"### {protocol}",
            "",
            _LEGEND.format(against=_against(result), basis=result.settings.get("rate_basis", "total")),
            "",
        ]
        lines += _full_table(result, protocol).markdown()
        lines += _reference_lines(result, protocol)
        lines += _rival_lines(result, protocol)
    left_out = [*sorted(result.failures.items()), *sorted(result.skipped.items())]
    if left_out:
        lines += ["", "Left out:", ""]
        lines += [f"- {markdown(name)}: {markdown(reason)}" for name, reason in left_out]
    return "\n".join(lines) + "\n"


_RIVAL_LEGEND = (
    "Messages, bytes and airtime over those of `{rival}`, with the same intervals; trips times thresholds "
    "with more than max(1.05 x `{rival}`, `{rival}` + 5) messages, and the trip with the most beyond that "
    "bound."
)


def _rival_lines(result: ComparisonResult, protocol: str) -> list[str]:
    """Return the table over the candidate compared against; nothing where that is the baseline."""
    if result.rival is None:
        return []
    thresholds = _thresholds(result)
    heads = ["candidate", *(f"messages, {text}" for text in thresholds)]
    heads += ["bytes, " + " / ".join(thresholds), *(f"airtime, {text}" for text in thresholds)]
    heads += ["over the bound", "worst trip"]
    cells: list[list[str]] = []
    for candidate in result.candidates:
        rows = rival_rows_of(result, candidate.name, protocol)
        own = [_shown_name(candidate), *_limited(rows, "message"), _listed(rows, "bytes_ratio")]
        cells.append([*own, *_limited(rows, "airtime"), *_over_the_bound(rows)])
    return ["", _RIVAL_LEGEND.format(rival=result.rival), "", *Cells(heads, cells, 1).markdown()]


_LEGEND = (
    "Messages, bytes and airtime over the baseline's at the same threshold, ratios of sums with 95 % "
    "bootstrap intervals over the trips; difference of the message ratio to `{against}`; 90th and 99th "
    "percentile of the tracking error over the harder baseline's at equal {basis} rate, worst threshold, at "
    "each packet error ratio; trips times thresholds with more than max(1.02 x baseline, baseline + 3) "
    "messages, and the trip with the most beyond that bound."
)


def _full_table(result: ComparisonResult, protocol: str) -> Cells:
    """Return headings and cells with every interval."""
    thresholds = _thresholds(result)
    losses = " / ".join(f"{100 * ratio:g}" for ratio in _ratios(result))
    heads = ["candidate", *(f"messages, {text}" for text in thresholds)]
    heads += ["difference, " + " / ".join(thresholds), "bytes, " + " / ".join(thresholds)]
    heads += [f"airtime, {text}" for text in thresholds]
    heads += [f"p90 at PER {losses} %", f"p99 at PER {losses} %"] if losses else []
    heads += ["over the bound", "worst trip"]
    cells: list[list[str]] = []
    for candidate in result.candidates:
        rows = _rows(result, candidate, protocol)
        own = [_shown_name(candidate), *_limited(rows, "message")]
        own += ["; ".join(_signed(row) for row in rows), _listed(rows, "bytes_ratio")]
        own += _limited(rows, "airtime")
        own += [_worst(result, candidate, protocol, percentile) for percentile in (90, 99) if losses]
        cells.append([*own, *_over_the_bound(rows)])
    return Cells(heads, cells, 1)


def _limited(rows: Sequence[Row], name: str) -> list[str]:
    """Ratios of messages, bytes or airtime with their intervals."""
    ends = [row.picked((f"{name}_ratio", f"{name}_low", f"{name}_high")) for row in rows]
    return [_with_limits(*one.values()) for one in ends]


def _listed(rows: Sequence[Row], name: str) -> str:
    return " / ".join(f"{getattr(row, name):.2f}" for row in rows)


def _counted_over(rows: Sequence[Row]) -> str:
    return f"{sum(row.trips_over for row in rows)} of {sum(row.trips for row in rows)}"


def _over_the_bound(rows: Sequence[Row]) -> list[str]:
    """How many trips times thresholds are over the bound, and the worst of them."""
    worst = max(rows, key=lambda row: row.worst_excess)
    at = centimetres(worst.threshold_m)
    return [_counted_over(rows), f"{worst.worst_trip}, {worst.worst_ratio:.2f} at {at}"]


def comparison_console(result: ComparisonResult) -> RenderableType:
    """Return a short table a protocol: lowest and highest threshold, one loss ratio, no intervals.

    Parameters
    ----------
    result
        The comparison.
    """
    parts = warning_texts((trip.id, trip.warnings) for trip in result.trips)
    parts += [Prose(line) for line in (scope_line(result), *_training_lines(result))]
    thresholds_m = _thresholds_m(result)
    shown_m = sorted({thresholds_m[0], thresholds_m[-1]}) if thresholds_m else []
    ratio = nearest_ratio(_ratios(result))
    at = None if ratio is None else _ratios(result).index(ratio)
    levels = " / ".join(f"{100 * item:g}" for item in shown_m)
    heads = ["candidate", *(f"{head}\n{levels} cm" for head in ("messages", "bytes", "airtime"))]
    for protocol in _protocols(result):
        rows = [_short_cells(result, candidate, protocol, shown_m, at) for candidate in result.candidates]
        losses = [] if ratio is None else [f"p90 / p99\nPER {100 * ratio:g} %"]
        own = [*heads, *losses, "trips over\nthe bound"]
        parts.append(console_table(Cells(own, rows, 1), f"Over the baseline, {protocol}"))
        if result.rival is not None:
            rows = [
                [
                    _shown_name(candidate),
                    *_short_ratios(found, shown_m),
                    _counted_over(found),
                ]
                for candidate in result.candidates
                for found in (rival_rows_of(result, candidate.name, protocol),)
            ]
            over = Cells([*heads, "trips over\nits bound"], rows, 1)
            parts.append(console_table(over, f"Over {result.rival}, {protocol}"))
    parts += [literal(line) for line in skipped_lines(result.skipped)]
    if result.failures:
        parts.append(failures_table(result.failures))
    return Group(*parts)


def _short_ratios(rows: Sequence[Row], shown_m: Sequence[float]) -> list[str]:
    shown = [row for row in rows if row.threshold_m in shown_m]
    return [_listed(shown, name) for name in ("message_ratio", "bytes_ratio", "airtime_ratio")]


def _short_cells(
    result: ComparisonResult,
    candidate: CandidateRow,
    protocol: str,
    shown_m: Sequence[float],
    at: int | None,
) -> list[str]:
    """Return a candidate's cells for the terminal; `at` is the place of the loss ratio shown."""
    rows = _rows(result, candidate, protocol)
    cells = [_shown_name(candidate), *_short_ratios(rows, shown_m)]
    if at is not None:
        found = (worst_rows(result, candidate.name, protocol, percentile)[at] for percentile in (90, 99))
        cells.append(" / ".join(_number(value) for value in found))
    return [*cells, _counted_over(rows)]


def scope_line(result: ComparisonResult) -> str:
    """Return in one line what was compared."""
    hours = sum(trip.duration_s for trip in result.trips) / 3600.0
    sender = result.settings.get("decided_by", MODEL_SENDER)
    decides = "" if sender == MODEL_SENDER else f"; {sender} decides when the candidates send"
    return (
        f"{_counted(len(result.trips), 'trip')}, {hours:.2f} h, {_counted(len(result.routes), 'route')}; "
        f"{_counted(len(result.candidates), 'candidate')}, seed {result.settings.get('seed')}{decides}"
        f"{left_out_text(result.failures, result.skipped)}"
    )


def _reference_lines(result: ComparisonResult, protocol: str) -> list[str]:
    """Return one line with the references' messages over the baseline's."""
    found: dict[str, list[str]] = {}
    for row in sorted(result.references, key=lambda row: row.threshold_m):
        if row.protocol == protocol:
            found.setdefault(row.reference, []).append(f"{row.message_ratio:.2f}")
    if not found:
        return []
    text = "; ".join(f"`{name}` {' / '.join(values)}" for name, values in found.items())
    return ["", f"References, messages over the baseline's: {text}."]


def _rows(result: ComparisonResult, candidate: CandidateRow, protocol: str) -> list[Row]:
    own = (row for row in result.ratios if (row.candidate, row.protocol) == (candidate.name, protocol))
    return sorted(own, key=lambda row: row.threshold_m)


def _worst(result: ComparisonResult, candidate: CandidateRow, protocol: str, percentile: int) -> str:
    found = worst_rows(result, candidate.name, protocol, percentile)
    return " / ".join(_number(value) for value in found)


def _number(value: float) -> str:
    return _MISSING if value != value else f"{value:.2f}"  # noqa: PLR0124  NaN


def _with_limits(value: float, low: float | None, high: float | None, form: str = ".2f") -> str:
    interval = "" if low is None or high is None else f" [{low:{form}}, {high:{form}}]"
    return f"{value:{form}}{interval}"


def _signed(row: Row) -> str:
    return _with_limits(row.difference, row.difference_low, row.difference_high, "+.2f")


def _shown_name(candidate: CandidateRow) -> str:
    return f"{candidate.name} (trained)" if candidate.is_trained else candidate.name


def _protocols(result: ComparisonResult) -> list[str]:
    return list(dict.fromkeys(row.protocol for row in result.ratios))


def _thresholds_m(result: ComparisonResult) -> list[float]:
    return sorted({row.threshold_m for row in result.ratios})


def _thresholds(result: ComparisonResult) -> list[str]:
    return [centimetres(item) for item in _thresholds_m(result)]


def _ratios(result: ComparisonResult) -> list[float]:
    return sorted({row.packet_error_ratio for row in result.tracking})


def _against(result: ComparisonResult) -> str:
    return str(result.settings.get("against"))


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
