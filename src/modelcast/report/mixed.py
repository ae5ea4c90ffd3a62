"""What a mixed fleet is told in: the pairings of senders and receivers, and the penetration map."""

from collections.abc import Sequence

import numpy as np
from rich.console import RenderableType

from modelcast.core.cells import Cells, number
from modelcast.report.console_table import placed_table
from modelcast.report.figures.mixed import plot_penetration
from modelcast.report.figures.senders import density_text
from modelcast.report.parts import Part
from modelcast.study.network.rows import CASE_KEYS, PAIRINGS, NetworkResult
from modelcast.study.table import Row

__all__ = ["mixed_console", "mixed_markdown", "mixed_part"]

_FIGURES = (
    "message_rate_hz",
    "bytes_per_s",
    "airtime_ratio",
    "held_ratio",
    "pte_p50_m",
    "pte_p90_m",
    "pte_p99_m",
    "age_p90_s",
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


def _cells(result: NetworkResult, names: Sequence[str] = _FIGURES) -> Cells:
    """One row a pairing, means over seeds; pairings that no pair had are left out."""
    busy = {_run(row): row.busy_ratio for row in result.runs}
    groups: dict[tuple[str, ...], list[Row]] = {}
    for row in sorted(result.pairings, key=lambda row: row.senders_ratio):
        if row.pairs:
            density, share = density_text(row.density_per_km), f"{100.0 * row.senders_ratio:g} %"
            groups.setdefault((density, row.radio, share, row.sender, row.reading), []).append(row)
    found: list[list[str]] = []
    for key, rows in sorted(groups.items(), key=lambda one: one[0][:2]):
        load = np.mean([busy[_run(row)] for row in rows])
        means = (PAIRINGS[name].cell(np.mean([getattr(row, name) for row in rows])) for name in names)
        found.append([*key, number(100.0 * float(load)), *means])
    return Cells([*_HEADS, *(PAIRINGS[name].shown_heading for name in names)], found, 5)


def _run(row: Row) -> tuple[str, ...]:
    """Which run a row is of; numbers as text, for NaN is like nothing."""
    return tuple(map(repr, row.picked(CASE_KEYS).values()))


def mixed_markdown(result: NetworkResult) -> str:
    """Return the table of pairings as Markdown.

    Parameters
    ----------
    result
        All runs.
    """
    return "\n".join(_cells(result).markdown()) + "\n"


def mixed_console(result: NetworkResult) -> RenderableType:
    """Return the short table of pairings for the terminal.

    Parameters
    ----------
    result
        All runs.
    """
    found = _cells(result, _TERMINAL)
    places: list[str] = []
    rows: list[list[str]] = []
    for density, radio, share, sender, reading, *figures in found.rows:
        place = radio if density == "-" else f"{radio}, {density}/km"
        places.append(f"{place}, {share} new")
        rows.append([f"{sender}, {reading}", *figures])
    cells = Cells(["sender, read as", *found.heads[5:]], rows, 1)
    title = "Who is tracked by whom, 50 m to 150 m apart, means over seeds"
    return placed_table(cells, places, title, padding=(0, 1, 0, 1))


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
            cells=_cells(result),
            figures={"penetration": (_MAP, plot_penetration(result))},
        )
    ]
