"""Roadside units and devices of people of a network evaluation for people: means over seeds."""

from collections.abc import Sequence
from math import isfinite

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.cells import Cells
from modelcast.report.figures.senders import density_text
from modelcast.study.network.rows import NetworkResult
from modelcast.study.table import Row, Table

__all__ = ["people_cells", "roadside_cells"]

_ROADSIDE = (
    "busy_ratio",
    "delivery_ratio",
    "held_ratio",
    "age_p90_s",
    "pte_p90_m",
    "pte_p99_m",
    "repeated_rate_hz",
    "unsent_ratio",
)
_PEOPLE = (
    "people",
    "message_rate_hz",
    "frame_bytes",
    "power_dbm",
    "received_rate_hz",
    "unread_rate_hz",
    "far_rate_hz",
    "read_rate_hz",
)


def roadside_cells(result: NetworkResult) -> Cells:
    """One row a density, radio, sender and threshold, 50 m to 150 m from a unit.

    Parameters
    ----------
    result
        All runs.
    """
    heads = ("density", "radio", "policy", "bank", "units")
    return _means(result.roadside, heads, "units", _ROADSIDE)


def people_cells(result: NetworkResult) -> Cells:
    """One row a density, radio, sender, bank and threshold: a device's figures.

    Parameters
    ----------
    result
        All runs.
    """
    heads = ("density", "radio", "vehicles", "bank", "sending by")
    return _means(result.people, heads, "people_policy", _PEOPLE)


def _means(table: Table, heads: Sequence[str], last: str, names: Sequence[str]) -> Cells:
    """Means over seeds of what has one, by density, radio, sender, bank and a last column."""
    groups: dict[tuple[str, ...], list[Row]] = {}
    for row in table:
        policy = row.policy + (f" {row.threshold_m:g} m" if isfinite(row.threshold_m) else "")
        key = (density_text(row.density_per_km), row.radio, policy, row.bank, str(getattr(row, last)))
        groups.setdefault(key, []).append(row)
    columns = [table.schema[name] for name in names]
    rows: list[list[str]] = []
    for key, own in groups.items():
        part = table.schema.table(own)
        rows.append([*key, *(column.cell(_mean(part[column.name])) for column in columns)])
    texts = 4 + int(table.schema[last].is_text)
    return Cells([*heads, *(column.shown_heading for column in columns)], rows, texts)


def _mean(values: FloatArray) -> float:
    there = values[np.isfinite(values)]
    return float(there.mean()) if there.size else np.nan
