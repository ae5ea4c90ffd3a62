"""A comparison for people: the table, as Markdown and for the terminal, and the figure's files."""

from collections.abc import Sequence
from pathlib import Path

from rich.console import Group, RenderableType
from rich.table import Table

from modelcast.core.cells import markdown
from modelcast.report.console import failures_table, warning_texts
from modelcast.report.figures.comparison import plot_comparison, rival_rows_of, worst_rows
from modelcast.report.figures.files import drawn, write_drawings
from modelcast.report.headline import nearest_ratio
from modelcast.report.literal import literal
from modelcast.report.style import style
from modelcast.report.training_trips import training_note
from modelcast.report.warnings import warning_lines
from modelcast.study.compare.result import CandidateRow, ComparisonResult
from modelcast.study.table import Row
from modelcast.study.wording import centimetres

__all__ = ["comparison_console", "comparison_markdown", "scope_line", "write_comparison_report"]

_MISSING = "-"


def write_comparison_report(result: ComparisonResult, folder: str | Path) -> list[Path]:
    """Write ``table.md``, ``comparison.png`` and ``comparison.svg``; return their paths.

    Parameters
    ----------
    result
        The comparison.
    folder
        An existing folder.
    """
    table = Path(folder) / "table.md"
    table.write_text(comparison_markdown(result), encoding="utf-8", newline="\n")
    with style():
        drawing = drawn("comparison", plot_comparison(result))
    return [table, *write_drawings([drawing], folder)]


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
    lines += [scope_line(result), ""]
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
        heads, cells = _full_table(result, protocol)
        lines += [_joined(heads), "|" + "---|" * len(heads)]
        lines += [_joined(row) for row in cells]
        lines += _reference_lines(result, protocol)
        lines += _rival_lines(result, protocol)
    left_out = [f"- {markdown(name)}: {markdown(reason)}" for name, reason in sorted(result.failures.items())]
    if left_out:
        lines += ["", "Left out:", "", *left_out]
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
    lines = ["", _RIVAL_LEGEND.format(rival=result.rival), "", _joined(heads), "|" + "---|" * len(heads)]
    for candidate in result.candidates:
        rows = rival_rows_of(result, candidate.name, protocol)
        worst = max(rows, key=lambda row: row.worst_excess)
        cells = [markdown(_shown_name(candidate))]
        cells += [_with_limits(row.message_ratio, row.message_low, row.message_high) for row in rows]
        cells += [" / ".join(f"{row.bytes_ratio:.2f}" for row in rows)]
        cells += [_with_limits(row.airtime_ratio, row.airtime_low, row.airtime_high) for row in rows]
        cells += [f"{sum(row.trips_over for row in rows)} of {sum(row.trips for row in rows)}"]
        cells += [
            f"{markdown(worst.worst_trip)}, {worst.worst_ratio:.2f} at {centimetres(worst.threshold_m)}"
        ]
        lines.append(_joined(cells))
    return lines


_LEGEND = (
    "Messages, bytes and airtime over the baseline's at the same threshold, ratios of sums with 95 % "
    "bootstrap intervals over the trips; difference of the message ratio to `{against}`; 90th and 99th "
    "percentile of the tracking error over the harder baseline's at equal {basis} rate, worst threshold, at "
    "each packet error ratio; trips times thresholds with more than max(1.02 x baseline, baseline + 3) "
    "messages, and the trip with the most beyond that bound."
)


def _full_table(result: ComparisonResult, protocol: str) -> tuple[list[str], list[list[str]]]:
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
        own = [markdown(_shown_name(candidate))]
        own += [_with_limits(row.message_ratio, row.message_low, row.message_high) for row in rows]
        own += ["<br>".join(_signed(row) for row in rows)]
        own += [" / ".join(f"{row.bytes_ratio:.2f}" for row in rows)]
        own += [_with_limits(row.airtime_ratio, row.airtime_low, row.airtime_high) for row in rows]
        own += [_worst(result, candidate, protocol, percentile) for percentile in (90, 99) if losses]
        worst = _worst_row(rows)
        own += [f"{sum(row.trips_over for row in rows)} of {sum(row.trips for row in rows)}"]
        own += [f"{markdown(worst.worst_trip)}, {worst.worst_ratio:.2f} at {centimetres(worst.threshold_m)}"]
        cells.append(own)
    return heads, cells


def comparison_console(result: ComparisonResult) -> RenderableType:
    """Return a short table a protocol: lowest and highest threshold, one loss ratio, no intervals.

    Parameters
    ----------
    result
        The comparison.
    """
    parts = warning_texts((trip.id, trip.warnings) for trip in result.trips)
    parts += [literal(line) for line in (scope_line(result), *_training_lines(result))]
    thresholds_m = _thresholds_m(result)
    shown_m = sorted({thresholds_m[0], thresholds_m[-1]}) if thresholds_m else []
    ratio = nearest_ratio(_ratios(result))
    at = None if ratio is None else _ratios(result).index(ratio)
    for protocol in _protocols(result):
        table = Table(title=f"Over the baseline, {protocol}", title_justify="left", header_style="")
        table.add_column("candidate")
        levels = " / ".join(f"{100 * item:g}" for item in shown_m)
        for head in ("messages", "bytes", "airtime"):
            table.add_column(f"{head}\n{levels} cm", justify="right")
        if ratio is not None:
            table.add_column(f"p90 / p99\nPER {100 * ratio:g} %", justify="right")
        table.add_column("trips over\nthe bound", justify="right")
        for candidate in result.candidates:
            table.add_row(
                literal(_shown_name(candidate)), *_short_cells(result, candidate, protocol, shown_m, at)
            )
        parts.append(table)
        if result.rival is not None:
            parts.append(_rival_table(result, protocol, shown_m))
    if result.failures:
        parts.append(failures_table(result.failures))
    return Group(*parts)


def _rival_table(result: ComparisonResult, protocol: str, shown_m: Sequence[float]) -> Table:
    """Return the short table over the candidate compared against."""
    table = Table(title=f"Over {result.rival}, {protocol}", title_justify="left", header_style="")
    table.add_column("candidate")
    levels = " / ".join(f"{100 * item:g}" for item in shown_m)
    for head in ("messages", "bytes", "airtime"):
        table.add_column(f"{head}\n{levels} cm", justify="right")
    table.add_column("trips over\nits bound", justify="right")
    for candidate in result.candidates:
        rows = rival_rows_of(result, candidate.name, protocol)
        shown = [row for row in rows if row.threshold_m in shown_m]
        table.add_row(
            literal(_shown_name(candidate)),
            " / ".join(f"{row.message_ratio:.2f}" for row in shown),
            " / ".join(f"{row.bytes_ratio:.2f}" for row in shown),
            " / ".join(f"{row.airtime_ratio:.2f}" for row in shown),
            f"{sum(row.trips_over for row in rows)} of {sum(row.trips for row in rows)}",
        )
    return table


def _short_cells(
    result: ComparisonResult,
    candidate: CandidateRow,
    protocol: str,
    shown_m: Sequence[float],
    at: int | None,
) -> list[str]:
    """Return a candidate's cells for the terminal; `at` is the place of the loss ratio shown."""
    rows = _rows(result, candidate, protocol)
    shown = [row for row in rows if row.threshold_m in shown_m]
    cells = [
        " / ".join(f"{row.message_ratio:.2f}" for row in shown),
        " / ".join(f"{row.bytes_ratio:.2f}" for row in shown),
        " / ".join(f"{row.airtime_ratio:.2f}" for row in shown),
    ]
    if at is not None:
        found = (worst_rows(result, candidate.name, protocol, percentile)[at] for percentile in (90, 99))
        cells.append(" / ".join(_number(value) for value in found))
    return [*cells, f"{sum(row.trips_over for row in rows)} of {sum(row.trips for row in rows)}"]


def scope_line(result: ComparisonResult) -> str:
    """Return in one line what was compared."""
    hours = sum(trip.duration_s for trip in result.trips) / 3600.0
    return (
        f"{_counted(len(result.trips), 'trip')}, {hours:.2f} h, {_counted(len(result.routes), 'route')}; "
        f"{_counted(len(result.candidates), 'candidate')}, seed {result.settings.get('seed')}"
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


def _worst_row(rows: Sequence[Row]) -> Row:
    return max(rows, key=lambda row: row.worst_excess)


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


def _joined(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"
