"""What roadside units of a network evaluation held and repeated, for people."""

from collections.abc import Sequence

import numpy as np

from modelcast.core.cells import markdown, number
from modelcast.study.network.rows import NetworkResult

__all__ = ["roadside_cells", "roadside_heads", "roadside_markdown"]

_FIGURES = (
    ("busy_ratio", "CBR [%]", 100.0),
    ("delivery_ratio", "received [%]", 100.0),
    ("held_ratio", "tracked [%]", 100.0),
    ("age_p90_s", "age p90 [s]", 1.0),
    ("pte_p90_m", "PTE p90 [m]", 1.0),
    ("pte_p99_m", "PTE p99 [m]", 1.0),
    ("repeated_rate_hz", "repeated [1/s]", 1.0),
    ("unsent_ratio", "of these unsent [%]", 100.0),
)
roadside_heads = ("density", "radio", "policy", "bank", "units", *(title for _, title, _ in _FIGURES))
"""Titles of the columns of `roadside_cells`."""


def roadside_cells(result: NetworkResult) -> list[list[str]]:
    """One row a density, radio, sender and threshold: means over seeds, 50 m to 150 m from a unit.

    Parameters
    ----------
    result
        All runs.
    """
    groups: dict[tuple[str, ...], list[object]] = {}
    for row in result.roadside:
        density = f"{row.density_per_km:g}" if np.isfinite(row.density_per_km) else "-"
        policy = row.policy + (f" {row.threshold_m:g} m" if np.isfinite(row.threshold_m) else "")
        groups.setdefault((density, row.radio, policy, row.bank, str(row.units)), []).append(row)
    return [
        [*key, *(number(factor * float(np.nanmean([getattr(row, name) for row in rows])))
                 if any(np.isfinite(getattr(row, name)) for row in rows) else "-"
                 for name, _, factor in _FIGURES)]
        for key, rows in groups.items()
    ]  # fmt: skip


def roadside_markdown(result: NetworkResult) -> Sequence[str]:
    """Return the table as lines of Markdown.

    Parameters
    ----------
    result
        All runs.
    """
    rows = [list(roadside_heads), *roadside_cells(result)]
    lines = ["| " + " | ".join(map(markdown, cells)) + " |" for cells in rows]
    return [lines[0], "|" + "---|" * len(roadside_heads), *lines[1:]]
