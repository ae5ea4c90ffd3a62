"""A comparison as Markdown, as a page, and for the terminal."""

from collections.abc import Sequence
from pathlib import Path

from rich.console import Group, RenderableType

from modelcast.core.cells import Cells, escape, markdown
from modelcast.core.version import package_version
from modelcast.report.comparison_findings import comparison_findings
from modelcast.report.comparison_rows import (
    candidate_rows,
    loss_ratios,
    pooled_rows,
    protocols,
    rival_rows_of,
    thresholds_m,
    worst_rows,
)
from modelcast.report.comparison_tables import (
    counted_over,
    listed_values,
    number,
    protocol_tables,
    shown_name,
    shown_rivals,
)
from modelcast.report.console import failures_table, left_out_text, skipped_lines, warning_texts
from modelcast.report.console_table import ConsoleTable, console_table
from modelcast.report.figures.comparison import plot_comparison
from modelcast.report.figures.files import Drawing, drawn, write_report_files
from modelcast.report.literal import Prose, literal
from modelcast.report.page import CSS, embedded_figure, findings_paragraphs, page
from modelcast.report.ratio_words import counted
from modelcast.report.settings_section import settings_section
from modelcast.report.style import style
from modelcast.report.training_trips import training_note
from modelcast.report.warnings import warning_lines
from modelcast.study.compare.result import CandidateRow, ComparisonResult
from modelcast.study.compare.settings import CompareSettings
from modelcast.study.loss_ratios import nearest_ratio
from modelcast.study.rules import MODEL_SENDER
from modelcast.study.table import Row

__all__ = [
    "comparison_console",
    "comparison_markdown",
    "comparison_page",
    "scope_line",
    "write_comparison_report",
]


def write_comparison_report(result: ComparisonResult, folder: str | Path) -> list[Path]:
    """Write ``table.md``, ``report.html`` and the figure ``comparison``; return their paths.

    Parameters
    ----------
    result
        The comparison.
    folder
        An existing folder.
    """
    with style():
        drawing = drawn("comparison", plot_comparison(result))
    texts = {"table.md": comparison_markdown(result), "report.html": comparison_page(result, drawing)}
    return write_report_files(texts, [drawing], folder)


def _training_lines(result: ComparisonResult) -> list[str]:
    return training_note([trip.id for trip in result.trips if trip.in_training], len(result.trips))


def _route_lines(result: ComparisonResult) -> list[str]:
    return [
        f"route {row.route}: {row.name}, {counted(row.trips, 'trip')}, {row.duration_s:.0f} s"
        for row in result.routes
    ]


def comparison_markdown(result: ComparisonResult) -> str:
    """Return what was found, and the tables of a comparison as Markdown, one part a protocol.

    Parameters
    ----------
    result
        The comparison.
    """
    told = warning_lines((trip.id, trip.warnings) for trip in result.trips)
    lines = [f"- **Warning**: {markdown(line)}" for line in told] + ([""] if told else [])
    lines += [markdown(scope_line(result)), ""]
    for title, text in comparison_findings(result):
        lines += [f"**{title}.** {markdown(text)}", ""]
    lines += [text for line in _training_lines(result) for text in (markdown(line), "")]
    lines += [f"- {markdown(line)}" for line in _route_lines(result)]
    for protocol in protocols(result):
        lines += ["", f"### {protocol}"]
        for table in protocol_tables(result, protocol):
            head = f"**{markdown(table.title)}.** {markdown(table.legend)}"
            lines += ["", head, "", *table.cells.markdown()]
        lines += _reference_lines(result, protocol)
    left_out = [*sorted(result.failures.items()), *sorted(result.skipped.items())]
    if left_out:
        lines += ["", "Left out:", ""]
        lines += [f"- {markdown(name)}: {markdown(reason)}" for name, reason in left_out]
    return "\n".join(lines) + "\n"


_CAPTION = (
    "A row of panels for each protocol and rival. Two panels at the left: messages and airtime at the same "
    "threshold without loss, ratios of sums over all trips. Then the 90th percentile of the tracking error "
    "over the rival's, at the worst threshold: first where all run at the same threshold, then where all "
    "send as often as the candidate, in the baseline's row against the harder of both equal-rate baselines. "
    "Thin bars are 95 % bootstrap intervals over the trips; banks of several sub-models are dashed."
)


def _caption(result: ComparisonResult) -> str:
    """What the figure shows: of a third candidate compared against too, where there is one."""
    if result.rival in (None, result.free):
        return _CAPTION
    return (
        f"{_CAPTION} The row over {result.rival}: messages, bytes, airtime, and the share of trips beyond "
        "either bound."
    )


def comparison_page(result: ComparisonResult, drawing: Drawing) -> str:
    """Return a comparison as one HTML document.

    Parameters
    ----------
    result
        The comparison.
    drawing
        Its figure.
    """
    warned = warning_lines((trip.id, trip.warnings) for trip in result.trips)
    body = [
        "<h1>Candidates side by side</h1>",
        f'<p class="scope">{escape(scope_line(result))}. modelcast {escape(package_version())}.</p>',
        *findings_paragraphs(comparison_findings(result)),
        *(f'<p class="note">warning: {escape(line)}.</p>' for line in warned),
        *(f'<p class="note">{escape(line)}.</p>' for line in _training_lines(result)),
        embedded_figure(drawing, 1, "Every candidate beside its rivals", _caption(result)),
    ]
    for protocol in protocols(result):
        body.append(f"<h2>Protocol {escape(protocol)}</h2>")
        for table in protocol_tables(result, protocol):
            body += [f"<h3>{escape(table.title)}</h3>", table.cells.html()]
            body.append(f'<p class="note">{escape(table.legend)}</p>')
        body += [f'<p class="note">{escape(line)}</p>' for line in _reference_lines(result, protocol) if line]
    routes = "".join(f"<li>{escape(line)}</li>" for line in _route_lines(result))
    body += ["<h2>Routes</h2>", f"<ul>{routes}</ul>"]
    left_out = [*sorted(result.failures.items()), *sorted(result.skipped.items())]
    if left_out:
        body += ["<h2>Left out</h2>", Cells(["what", "why"], left_out).html()]
    body += ["<h2>Settings</h2>", settings_section(result.settings, CompareSettings().as_plain())]
    return page("modelcast: candidates side by side", CSS, body)


def comparison_console(result: ComparisonResult) -> RenderableType:
    """Return what was found, and short tables: lowest and highest threshold, one loss ratio, no intervals.

    Parameters
    ----------
    result
        The comparison.
    """
    parts = warning_texts((trip.id, trip.warnings) for trip in result.trips)
    parts += [Prose(line) for line in (scope_line(result), *_training_lines(result))]
    for title, text in comparison_findings(result):
        parts += [literal(""), Prose(f"{title}: {text}")]
    parts.append(literal(""))
    for protocol in protocols(result):
        parts += _short_tables(result, protocol)
    parts += [literal(line) for line in skipped_lines(result.skipped)]
    if result.failures:
        parts.append(failures_table(result.failures))
    return Group(*parts)


def _short_tables(result: ComparisonResult, protocol: str) -> list[ConsoleTable]:
    """The tables of one protocol for the terminal, each of one reading."""
    known_m = thresholds_m(result)
    shown_m = sorted({known_m[0], known_m[-1]})
    levels = " / ".join(f"{100 * item:g}" for item in shown_m)
    names = ["baseline", *("free" if name == result.free else name for name in shown_rivals(result))]
    heads = [f"{what}\n/ {name}" for what in ("messages", "airtime") for name in names]
    rows = [
        [
            shown_name(candidate),
            *_short_ratios(result, candidate, protocol, shown_m),
            counted_over(candidate_rows(result, candidate.name, protocol)),
        ]
        for candidate in result.candidates
    ]
    title = f"Same threshold, {protocol}, without loss ({levels} cm)"
    tables = [console_table(Cells(["candidate", *heads, "trips over\nthe bound"], rows, 1), title)]
    ratio = nearest_ratio(loss_ratios(result))
    if ratio is None:
        return tables
    whose = [("", "own"), ("baseline_", "baseline")]
    if result.free is not None:
        whose.insert(1, ("free_", "free"))
    heads = [f"{name}\n{what}" for what in ("1/s", "p90") for _, name in whose]
    rows: list[list[str]] = []
    for candidate in result.candidates:
        found = _shown(pooled_rows(result, candidate.name, protocol, ratio), shown_m)
        sent = [listed_values(found, f"{prefix or 'message_'}rate_hz") for prefix, _ in whose]
        rows.append(
            [shown_name(candidate), *sent, *(listed_values(found, f"{prefix}p90_m") for prefix, _ in whose)]
        )
    lost = f"{protocol}, {100 * ratio:g} % lost"
    title = f"Same threshold, {lost}: messages per second, p90 of the error in metres ({levels} cm)"
    tables.append(console_table(Cells(["candidate", *heads], rows, 1), title))
    figures = {"p90": "p90\n/ baseline", "p99": "p99\n/ baseline"}
    if result.free is not None:
        figures |= {"p90_over_free": "p90\n/ free", "p99_over_free": "p99\n/ free"}
    at = loss_ratios(result).index(ratio)
    rows = [
        [
            shown_name(candidate),
            *(number(worst_rows(result, candidate.name, protocol, figure)[at][0]) for figure in figures),
        ]
        for candidate in result.candidates
    ]
    basis = result.settings.get("rate_basis", "total")
    title = f"Same {basis} rate as the candidate, {lost}: error over its rivals', worst threshold"
    return [*tables, console_table(Cells(["candidate", *figures.values()], rows, 1), title)]


def _short_ratios(
    result: ComparisonResult, candidate: CandidateRow, protocol: str, shown_m: Sequence[float]
) -> list[str]:
    """Messages over each rival's, then airtime."""
    each = [candidate_rows(result, candidate.name, protocol)]
    each += [rival_rows_of(result, candidate.name, protocol, rival) for rival in shown_rivals(result)]
    found = [_shown(rows, shown_m) for rows in each]
    return [listed_values(rows, name) for name in ("message_ratio", "airtime_ratio") for rows in found]


def _shown(rows: Sequence[Row], shown_m: Sequence[float]) -> list[Row]:
    return [row for row in rows if row.threshold_m in shown_m]


def scope_line(result: ComparisonResult) -> str:
    """Return in one line what was compared."""
    hours = sum(trip.duration_s for trip in result.trips) / 3600.0
    sender = result.settings.get("decided_by", MODEL_SENDER)
    decides = "" if sender == MODEL_SENDER else f"; {sender} decides when the candidates send"
    return (
        f"{counted(len(result.trips), 'trip')}, {hours:.2f} h, {counted(len(result.routes), 'route')}; "
        f"{counted(len(result.candidates), 'candidate')}, seed {result.settings.get('seed')}{decides}"
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
