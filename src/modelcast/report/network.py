"""A network evaluation for people: the table as Markdown and for the terminal, the page, the figures."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, cast

from rich.console import Group, RenderableType

from modelcast.core.cells import Cells, escape, markdown, number
from modelcast.io.traffic_survey import TrafficSurvey, survey_document
from modelcast.report.console_table import placed_table
from modelcast.report.figures.files import drawn, write_report_files
from modelcast.report.figures.network import NETWORK_FIGURES
from modelcast.report.figures.senders import NO_THRESHOLD_TEXT, also_told, density_text, threshold_text
from modelcast.report.fleet_warnings import warnings_console, warnings_markdown, warnings_part
from modelcast.report.literal import Prose
from modelcast.report.mixed import mixed_markdown, mixed_part
from modelcast.report.network_findings import network_findings
from modelcast.report.page import CSS, figure, findings_paragraphs, page
from modelcast.report.seed_means import people_cells, roadside_cells
from modelcast.report.settings_section import settings_section
from modelcast.report.style import style
from modelcast.study.network.rows import NO_BANK, RUNS, NetworkResult
from modelcast.study.table import Row

__all__ = ["network_console", "network_markdown", "traffic_lines", "write_network_report"]

_FIGURES = (
    "message_rate_hz",
    "update_rate_hz",
    "identification_rate_hz",
    "model_ratio",
    "frame_bytes",
    "bytes_per_s",
    "busy_ratio",
    "power_dbm",
    "delivery_ratio",
    "collision_ratio",
    "held_ratio",
    "gap_p90_s",
    "age_p90_s",
    "pte_p50_m",
    "pte_p90_m",
    "pte_p95_m",
    "pte_p99_m",
)
_TERMINAL = (
    "update_rate_hz",
    "identification_rate_hz",
    "bytes_per_s",
    "busy_ratio",
    "pte_p90_m",
    "pte_p99_m",
)
_SCOPE = (
    "Mean over seeds with its 95 % interval. Received, collided, tracked, gaps, ages and tracking errors "
    "(PTE) are those of vehicles 50 m to 150 m apart; messages, updates, identifications and bytes are a "
    "vehicle's."
)


def _sender(result: NetworkResult) -> tuple[str, ...]:
    """What tells senders apart: the policy, the bank and the threshold where there are several."""
    return ("policy", *also_told(result))


def _told(result: NetworkResult, row: Row) -> list[str]:
    """The cells of a sender."""
    texts = {"policy": row.policy, "bank": row.bank, "threshold": threshold_text(row.threshold_m)}
    return [texts[name] for name in _sender(result)]


def _heads(result: NetworkResult) -> tuple[str, ...]:
    return ("density", "radio", *_sender(result), "seeds")


def _cells(result: NetworkResult, names: Sequence[str] = _FIGURES) -> Cells:
    groups: dict[tuple[str, ...], dict[str, Row]] = {}
    for row in result.pooled:
        key = (density_text(row.density_per_km), row.radio, *_told(result, row), str(row.seeds))
        groups.setdefault(key, {})[row.figure] = row
    heads = _heads(result)
    rows = [[*key, *(_cell(figures[name]) for name in names)] for key, figures in groups.items()]
    return Cells([*heads, *(RUNS[name].shown_heading for name in names)], rows, len(heads) - 1)


def _cell(row: Row) -> str:
    column = RUNS[row.figure]
    if row.low is None or row.high is None:
        return column.cell(row.value)
    return f"{column.cell(row.value)} ± {number(column.factor * 0.5 * (row.high - row.low), 2)}"


def traffic_lines(found: TrafficSurvey) -> list[str]:
    """What traffic from a file holds, in lines for the terminal and the report.

    Parameters
    ----------
    found
        As `modelcast.io.fcd.survey_fcd` or `modelcast.io.sumo.survey_sumo` gives it.
    """
    return _traffic_lines(survey_document(found))


def _traffic_lines(traffic: Mapping[str, Any]) -> list[str]:
    skipped = cast("Mapping[str, int]", traffic["skipped"])
    repaired = cast("Mapping[str, int]", traffic["repaired"])
    rest = "".join(f" + {count} skipped ({reason})" for reason, count in skipped.items())
    step = "" if traffic["step_s"] is None else f", a step of {traffic['step_s']:g} s"
    counts = f"{traffic['vehicles']} vehicles, {traffic['most_at_once']} at once at most"
    return [
        f"{traffic['file']}: {traffic['rows']} rows = {traffic['taken']} taken{rest}",
        f"  {counts}, {traffic['duration_s']:g} s{step}",
        *(f"  {count} rows: {reason}" for reason, count in repaired.items()),
        *(f"  {note}" for note in cast("Sequence[str]", traffic["notes"])),
    ]


def network_markdown(
    result: NetworkResult,
    traffic: Mapping[str, Any] | None = None,
    notes: Sequence[str] = (),
    options: Mapping[str, Any] | None = None,
) -> str:
    """Return what was found and the one table of a network evaluation as Markdown.

    Parameters
    ----------
    result
        All runs.
    traffic
        What the file of floating-car data holds, as plain values; None where the traffic is none.
    notes
        What must be known before the figures.
    options
        What they were run with, as plain values; where None, nothing is said of the traffic.
    """
    lines = [
        *(
            text
            for title, said in network_findings(result, options)
            for text in (f"**{title}.** {markdown(said)}", "")
        ),
        _SCOPE,
        "",
        *(text for line in notes for text in (f"**{markdown(line)}**", "")),
        *_cells(result).markdown(),
    ]
    if result.pooled_warnings:
        lines += ["", "Warnings:", "", *warnings_markdown(result)]
    if result.roadside:
        lines += [
            "",
            "Roadside units, of vehicles 50 m to 150 m away:",
            "",
            *roadside_cells(result).markdown(),
        ]
    if result.people:
        lines += ["", "A device of people:", "", *people_cells(result).markdown()]
    if result.senders:
        sent = "What was sent of each bank, and by which rules:"
        lines += ["", sent, "", *result.senders.cells().markdown()]
    if traffic is not None:
        lines += ["", "Traffic:", "", *(f"- {line.strip()}" for line in _traffic_lines(traffic))]
    return "\n".join(lines) + "\n"


def network_console(result: NetworkResult) -> RenderableType:
    """Return what was found and the short table for the terminal: a line a sender, by radio and density.

    Parameters
    ----------
    result
        All runs.
    """
    seeds = result.pooled[0].seeds if result.pooled else 0
    mean = "one seed" if seeds == 1 else f"mean over {seeds} seeds ± half of its 95 % interval"
    keys, places, rows = len(_heads(result)), list[str](), list[list[str]]()
    found = _cells(result, _TERMINAL)
    for density, radio, *rest in found.rows:
        places.append(radio if density == "-" else f"{radio}, {density}/km")
        sender = (part for part in rest[: keys - 3] if part not in {NO_BANK, NO_THRESHOLD_TEXT})
        rows.append([", ".join(sender), *rest[keys - 2 :]])
    heads = [head.replace("identifications", "identif.") for head in found.heads[keys:]]
    # There is little air between columns: names of policy and bank must fit beside the numbers.
    shown = placed_table(
        Cells([", ".join(_sender(result)), *heads], rows, 1),
        places,
        f"Vehicles 50 m to 150 m apart, {mean}",
        padding=(0, 0, 0, 0),
        min_width=8,
    )
    found_lines = [Prose(f"{title}: {text}") for title, text in network_findings(result)]
    return Group(*found_lines, shown, *([warnings_console(result)] if result.pooled_warnings else ()))


def write_network_report(
    result: NetworkResult,
    options: Mapping[str, Any],
    folder: str | Path,
    *,
    traffic: Mapping[str, Any] | None = None,
    notes: Sequence[str] = (),
    defaults: Mapping[str, Any] | None = None,
) -> list[Path]:
    """Write ``table.md``, ``report.html`` and the figures as PNG and SVG; return their paths.

    Of mixed fleets ``pairings.md`` too.

    Parameters
    ----------
    result
        All runs.
    options
        What they were run with, as plain values.
    folder
        An existing folder.
    traffic, notes
        As for `network_markdown`.
    defaults
        As for `settings_section`.
    """
    if result.pairings:
        (Path(folder) / "pairings.md").write_text(mixed_markdown(result), encoding="utf-8", newline="\n")
    with style():
        drawings = [drawn(name, plot(result)) for name, (_, plot) in NETWORK_FIGURES.items()]
        parts = [*mixed_part(result), *warnings_part(result)]
        more = [drawn(name, plot) for part in parts for name, (_, plot) in part.figures.items()]
    body = [
        "<h1>Fleets on a shared channel</h1>",
        *findings_paragraphs(network_findings(result, options)),
        f'<p class="scope">{escape(_SCOPE)}</p>',
        *(f'<p class="note">{escape(line)}.</p>' for line in notes),
        _cells(result).html(),
    ]
    body += [figure(f"{name}.svg", caption) for name, (caption, _) in NETWORK_FIGURES.items()]
    body += [line for part in parts for line in part.markup()]
    if result.roadside:
        body += [
            "<h2>Roadside units</h2>",
            roadside_cells(result).html(),
        ]
    if result.people:
        body += ["<h2>Devices of people</h2>", people_cells(result).html()]
    if result.senders:
        body += ["<h2>Banks</h2>", result.senders.cells().html()]
    if traffic is not None:
        lines = "".join(f"<li>{escape(line.strip())}</li>" for line in _traffic_lines(traffic))
        body.append(f"<h2>Traffic</h2><ul>{lines}</ul>")
    body += ["<h2>Options</h2>", settings_section(options, defaults)]
    texts = {
        "table.md": network_markdown(result, traffic, notes, options),
        "report.html": page("modelcast: fleets on a shared channel", CSS, body),
    }
    return write_report_files(texts, [*drawings, *more], folder)
