"""What a mixed fleet is told in: the pairings of senders and receivers, and the penetration map."""

from collections.abc import Sequence

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import RenderableType
from rich.table import Table

from modelcast.core.cells import markdown, number
from modelcast.report.figures.mixed import plot_penetration
from modelcast.report.literal import literal
from modelcast.report.parts import Part
from modelcast.study.network.rows import NetworkResult
from modelcast.study.table import Row

__all__ = ["mixed_console", "mixed_markdown", "mixed_part"]

_FIGURES = (
    ("message_rate_hz", "messages [1/s]", 1.0),
    ("bytes_per_s", "kB/s", 1e-3),
    ("airtime_ratio", "airtime [%]", 100.0),
    ("held_ratio", "held [%]", 100.0),
    ("pte_p50_m", "PTE p50 [m]", 1.0),
    ("pte_p90_m", "p90 [m]", 1.0),
    ("pte_p99_m", "p99 [m]", 1.0),
    ("age_p90_s", "age p90 [s]", 1.0),
)
_TERMINAL = ("message_rate_hz", "held_ratio", "pte_p50_m", "pte_p90_m", "pte_p99_m")
_SCOPE = (
    "What a vehicle of each sender sends, and how it is tracked 50 m to 150 m away by those who read in one "
    "way; means over seeds."
)
_MAP = (
    "Tracking errors over all pairs by the shares of vehicles that send by the last policy and that read "
    "models; the others read as legacy receivers do."
)
_HEADS = ("density", "radio", "new senders", "sender", "read as", "busy [%]")


def _cells(result: NetworkResult, names: Sequence[str]) -> list[list[str]]:
    """One row a pairing, means over seeds; pairings that no pair had are left out."""
    busy = {(row.density_per_km, row.radio, row.policy, row.run): row.busy_ratio for row in result.runs}
    groups: dict[tuple[str, ...], list[Row]] = {}
    for row in sorted(result.pairings, key=lambda row: row.senders_ratio):
        if row.pairs:
            density = f"{row.density_per_km:g}" if np.isfinite(row.density_per_km) else "-"
            share = f"{100.0 * row.senders_ratio:g} %"
            groups.setdefault((density, row.radio, share, row.sender, row.reading), []).append(row)
    factors = {name: factor for name, _, factor in _FIGURES}
    found: list[list[str]] = []
    for key, rows in sorted(groups.items(), key=lambda one: one[0][:2]):
        load = np.mean([busy[row.density_per_km, row.radio, row.policy, row.run] for row in rows])
        means = [factors[name] * np.mean([getattr(row, name) for row in rows]) for name in names]
        found.append([*key, *(number(float(value)) for value in (100.0 * load, *means))])
    return found


def mixed_markdown(result: NetworkResult) -> str:
    """Return the table of pairings as Markdown.

    Parameters
    ----------
    result
        All runs.
    """
    names = [name for name, _, _ in _FIGURES]
    heads = [*_HEADS, *(title for _, title, _ in _FIGURES)]
    rows = [heads, *_cells(result, names)]
    lines = ["| " + " | ".join(map(markdown, cells)) + " |" for cells in rows]
    lines.insert(1, "|" + "---|" * len(heads))
    return "\n".join(lines) + "\n"


def mixed_console(result: NetworkResult) -> RenderableType:
    """Return the short table of pairings for the terminal.

    Parameters
    ----------
    result
        All runs.
    """
    titles = {name: title for name, title, _ in _FIGURES}
    title = "Who is tracked by whom, 50 m to 150 m apart, means over seeds"
    shown = Table(title=title, title_justify="left", box=SIMPLE_HEAD, padding=(0, 1), header_style="")
    shown.add_column("sender, read as", no_wrap=True)
    for head in ("busy [%]", *(titles[name] for name in _TERMINAL)):
        shown.add_column(head, justify="right")
    before: list[str] = []
    for density, radio, share, sender, reading, busy, *figures in _cells(result, _TERMINAL):
        if [density, radio, share] != before:
            place = radio if density == "-" else f"{radio}, {density}/km"
            shown.add_section()
            shown.add_row(literal(f"{place}, {share} new", style="bold"))
        shown.add_row(*map(literal, (f"{sender}, {reading}", busy, *figures)))
        before = [density, radio, share]
    return shown


def mixed_part(result: NetworkResult) -> list[Part]:
    """Return the part of a page, none where all fleets are of one kind.

    Parameters
    ----------
    result
        All runs.
    """
    if not result.pairings:
        return []
    return [
        Part(
            "Who is tracked by whom",
            _SCOPE,
            heads=[*_HEADS, *(title for _, title, _ in _FIGURES)],
            rows=_cells(result, [name for name, _, _ in _FIGURES]),
            text_columns=5,
            figures={"penetration": (_MAP, plot_penetration(result))},
        )
    ]
