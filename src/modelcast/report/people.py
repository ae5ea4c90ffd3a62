"""What the devices of people of a network evaluation sent and received, as a table."""

from collections.abc import Sequence

import numpy as np

from modelcast.core.cells import markdown, number
from modelcast.study.network.rows import NetworkResult
from modelcast.study.table import Row

__all__ = ["people_cells", "people_heads", "people_markdown"]

_FIGURES = (
    ("people", "people", 1.0),
    ("message_rate_hz", "sent [1/s]", 1.0),
    ("frame_bytes", "frame [B]", 1.0),
    ("power_dbm", "power [dBm]", 1.0),
    ("received_rate_hz", "received [1/s]", 1.0),
    ("unread_rate_hz", "unread [1/s]", 1.0),
    ("far_rate_hz", "too far [1/s]", 1.0),
    ("read_rate_hz", "read [1/s]", 1.0),
)
people_heads = ("density", "radio", "vehicles", "bank", "people", *(title for _, title, _ in _FIGURES[1:]))
"""Titles of the columns of `people_cells`; the third to fifth say who sends by which policy and bank."""


def people_cells(result: NetworkResult) -> list[list[str]]:
    """One row a density, radio, sender, bank and threshold: a device's figures, means over seeds.

    Parameters
    ----------
    result
        All runs.
    """
    groups: dict[tuple[str, ...], list[Row]] = {}
    for row in result.people:
        density = f"{row.density_per_km:g}" if np.isfinite(row.density_per_km) else "-"
        policy = row.policy + (f" {row.threshold_m:g} m" if np.isfinite(row.threshold_m) else "")
        groups.setdefault((density, row.radio, policy, row.bank, row.people_policy), []).append(row)
    cells: list[list[str]] = []
    for (density, radio, policy, bank, people_policy), rows in groups.items():
        means = [
            (factor * float(np.nanmean(values)) if np.isfinite(values).any() else np.nan)
            for values, factor in (
                (np.array([getattr(row, name) for row in rows]), factor) for name, _, factor in _FIGURES
            )
        ]
        shown = [number(value) if np.isfinite(value) else "-" for value in means]
        cells.append([density, radio, policy, bank, f"{shown[0]}, {people_policy}", *shown[1:]])
    return cells


def people_markdown(result: NetworkResult) -> Sequence[str]:
    """Return the table as lines of Markdown.

    Parameters
    ----------
    result
        All runs.
    """
    rows = [list(people_heads), *people_cells(result)]
    lines = ["| " + " | ".join(map(markdown, cells)) + " |" for cells in rows]
    return [lines[0], "|" + "---|" * len(people_heads), *lines[1:]]
