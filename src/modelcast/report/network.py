"""A network evaluation for people: the table as Markdown and for the terminal, the page, the figures."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.table import Table

from modelcast.core.cells import escape, html_table, markdown, number
from modelcast.io.fcd_survey import FcdSurvey, survey_document
from modelcast.report.figures.files import drawn, write_drawings
from modelcast.report.figures.network import NETWORK_FIGURES
from modelcast.report.figures.senders import NO_THRESHOLD_TEXT, also_told, threshold_text
from modelcast.report.fleet_warnings import warnings_console, warnings_markdown, warnings_part
from modelcast.report.literal import literal
from modelcast.report.mixed import mixed_markdown, mixed_part
from modelcast.report.page import CSS, option_rows, page
from modelcast.report.people import people_cells, people_heads, people_markdown
from modelcast.report.roadside import roadside_cells, roadside_heads, roadside_markdown
from modelcast.report.style import style
from modelcast.study.network.rows import NO_BANK, NetworkResult
from modelcast.study.table import Row

__all__ = ["network_console", "network_markdown", "traffic_lines", "write_network_report"]

_COLUMNS = (
    ("message_rate_hz", "messages [1/s]", 1.0),
    ("update_rate_hz", "updates [1/s]", 1.0),
    ("identification_rate_hz", "identifications [1/s]", 1.0),
    ("model_ratio", "with model [%]", 100.0),
    ("frame_bytes", "bytes a frame", 1.0),
    ("bytes_per_s", "bytes/s", 1.0),
    ("busy_ratio", "CBR [%]", 100.0),
    ("power_dbm", "power [dBm]", 1.0),
    ("delivery_ratio", "received [%]", 100.0),
    ("collision_ratio", "collided [%]", 100.0),
    ("held_ratio", "tracked [%]", 100.0),
    ("gap_p90_s", "IPG p90 [s]", 1.0),
    ("age_p90_s", "age p90 [s]", 1.0),
    ("pte_p50_m", "PTE p50 [m]", 1.0),
    ("pte_p90_m", "PTE p90 [m]", 1.0),
    ("pte_p95_m", "PTE p95 [m]", 1.0),
    ("pte_p99_m", "PTE p99 [m]", 1.0),
)
_TERMINAL = {
    "update_rate_hz": "updates [1/s]",
    "identification_rate_hz": "identif. [1/s]",
    "bytes_per_s": "bytes/s",
    "busy_ratio": "CBR [%]",
    "pte_p90_m": "PTE p90 [m]",
    "pte_p99_m": "PTE p99 [m]",
}
_SENDERS = ("policy", "bank", "sub-models", "start", "identify")
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


def _rows(result: NetworkResult, names: Sequence[str]) -> list[list[str]]:
    groups: dict[tuple[str, ...], dict[str, Row]] = {}
    for row in result.pooled:
        density = f"{row.density_per_km:g}" if np.isfinite(row.density_per_km) else "-"
        key = (density, row.radio, *_told(result, row), str(row.seeds))
        groups.setdefault(key, {})[row.figure] = row
    factors = {name: factor for name, _, factor in _COLUMNS}
    return [
        [*key, *(_cell(figures[name], factors[name]) for name in names)] for key, figures in groups.items()
    ]


def _cell(row: Row, factor: float) -> str:
    middle = number(factor * row.value)
    if row.low is None or row.high is None:
        return middle
    return f"{middle} ± {number(factor * 0.5 * (row.high - row.low), 2)}"


def traffic_lines(found: FcdSurvey) -> list[str]:
    """What a file of floating-car data holds, in lines for the terminal and the report.

    Parameters
    ----------
    found
        As `modelcast.io.fcd.survey_fcd` gives it.
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
    result: NetworkResult, traffic: Mapping[str, Any] | None = None, notes: Sequence[str] = ()
) -> str:
    """Return the one table of a network evaluation as Markdown.

    Parameters
    ----------
    result
        All runs.
    traffic
        What the file of floating-car data holds, as plain values; None where the traffic is none.
    notes
        What must be known before the figures.
    """
    names = [name for name, _, _ in _COLUMNS]
    heads = [*_heads(result), *(title for _, title, _ in _COLUMNS)]
    lines = [
        _SCOPE,
        "",
        *(text for line in notes for text in (f"**{markdown(line)}**", "")),
        _joined(heads),
        "|" + "---|" * len(heads),
    ]
    lines += [_joined(cells) for cells in _rows(result, names)]
    if result.pooled_warnings:
        lines += ["", "Warnings:", "", *warnings_markdown(result)]
    if result.roadside:
        lines += ["", "Roadside units, of vehicles 50 m to 150 m away:", "", *roadside_markdown(result)]
    if result.people:
        lines += ["", "A device of people:", "", *people_markdown(result)]
    if result.senders:
        lines += ["", "What was sent of each bank, and by which rules:", ""]
        lines += [_joined(_SENDERS), "|" + "---|" * len(_SENDERS)]
        lines += [_joined(cells) for cells in _sender_cells(result)]
    if traffic is not None:
        lines += ["", "Traffic:", "", *(f"- {line.strip()}" for line in _traffic_lines(traffic))]
    return "\n".join(lines) + "\n"


def _joined(cells: Sequence[str]) -> str:
    return "| " + " | ".join(map(markdown, cells)) + " |"


def _sender_cells(result: NetworkResult) -> list[list[str]]:
    return [[row.policy, row.bank, row.sub_models, row.start, row.identify] for row in result.senders]


def _narrow(title: str) -> Table:
    """A table with little air: names of policy and bank must fit beside the numbers."""
    return Table(title=title, title_justify="left", box=SIMPLE_HEAD, padding=(0, 0), header_style="")


def network_console(result: NetworkResult) -> RenderableType:
    """Return the short table for the terminal: a line a sender, under its radio and density.

    Parameters
    ----------
    result
        All runs.
    """
    seeds = result.pooled[0].seeds if result.pooled else 0
    mean = "one seed" if seeds == 1 else f"mean over {seeds} seeds ± half of its 95 % interval"
    shown = _narrow(f"Vehicles 50 m to 150 m apart, {mean}")
    shown.add_column(", ".join(_sender(result)), no_wrap=True, overflow="fold")
    for head in _TERMINAL.values():
        shown.add_column(head, justify="right", overflow="fold", min_width=8)
    keys, before = len(_heads(result)), ""
    for cells in _rows(result, tuple(_TERMINAL)):
        density, radio, *sender = cells[: keys - 1]
        place = radio if density == "-" else f"{radio}, {density}/km"
        if place != before:
            shown.add_section()
            shown.add_row(literal(place, style="bold"))
        name = ", ".join(part for part in sender if part not in {NO_BANK, NO_THRESHOLD_TEXT})
        shown.add_row(*map(literal, (name, *cells[keys:])))
        before = place
    return Group(shown, *([warnings_console(result)] if result.pooled_warnings else ()))


def write_network_report(
    result: NetworkResult,
    options: Mapping[str, Any],
    folder: str | Path,
    *,
    traffic: Mapping[str, Any] | None = None,
    notes: Sequence[str] = (),
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
    """
    folder = Path(folder)
    place = folder / "table.md"
    place.write_text(network_markdown(result, traffic, notes), encoding="utf-8", newline="\n")
    if result.pairings:
        (folder / "pairings.md").write_text(mixed_markdown(result), encoding="utf-8", newline="\n")
    with style():
        drawings = [drawn(name, plot(result)) for name, (_, plot) in NETWORK_FIGURES.items()]
        parts = [*mixed_part(result), *warnings_part(result)]
        more = [drawn(name, figure) for part in parts for name, (_, figure) in part.figures.items()]
    names = [name for name, _, _ in _COLUMNS]
    heads = [*_heads(result), *(title for _, title, _ in _COLUMNS)]
    body = [
        "<h1>Fleets on a shared channel</h1>",
        f'<p class="scope">{escape(_SCOPE)}</p>',
        *(f'<p class="note">{escape(line)}.</p>' for line in notes),
        html_table(heads, _rows(result, names), text_columns=len(_heads(result)) - 1),
    ]
    for drawing, (caption, _) in zip(drawings, NETWORK_FIGURES.values(), strict=True):
        body.append(
            f'<figure><img src="{drawing.name}.svg" alt="{escape(caption)}">'
            f"<figcaption>{escape(caption)}</figcaption></figure>"
        )
    body += [line for part in parts for line in part.markup()]
    if result.roadside:
        body += [
            "<h2>Roadside units</h2>",
            html_table(roadside_heads, roadside_cells(result), text_columns=4),
        ]
    if result.people:
        body += ["<h2>Devices of people</h2>", html_table(people_heads, people_cells(result), text_columns=4)]
    if result.senders:
        body += ["<h2>Banks</h2>", html_table(_SENDERS, _sender_cells(result), text_columns=len(_SENDERS))]
    if traffic is not None:
        lines = "".join(f"<li>{escape(line.strip())}</li>" for line in _traffic_lines(traffic))
        body.append(f"<h2>Traffic</h2><ul>{lines}</ul>")
    body += ["<h2>Options</h2>", html_table(["option", "value"], option_rows(options), text_columns=2)]
    html = folder / "report.html"
    document = page("modelcast: fleets on a shared channel", CSS, body)
    html.write_text(document, encoding="utf-8", newline="\n")
    return [place, html, *write_drawings([*drawings, *more], folder)]
