"""What a comparison leaves on disk, for programs to read.

``summary.json`` (`comparison_document`)
    ``schema`` (1), ``modelcast`` (version), ``settings``, ``routes``, ``trips``, ``candidates``, ``ratios``,
    ``rivals``, ``tracking``, ``references``, ``failures``, ``skipped``: the rows of
    `modelcast.study.compare.result` that pool all trips. A number that does not exist is null.
``messages.parquet``
    One row for each candidate, protocol, trip and threshold: `CountRow`.
``tracking.parquet``
    One row for each candidate, protocol, trip, threshold and packet error ratio: `TrackingRatioRow`, rows
    that pool all trips (``"all"``) among them.

The same result gives the same bytes.
"""

from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from modelcast.core.version import package_version
from modelcast.io.arrow import columns_table, write_tables
from modelcast.io.documents import document_text, plain_value, row_document
from modelcast.study.compare.result import ComparisonResult, CountRow, TrackingRatioRow
from modelcast.study.result import POOLED, Columns

__all__ = ["COMPARISON_SCHEMA", "comparison_document", "write_comparison"]

COMPARISON_SCHEMA = 1
"""Version of the layout of a comparison's ``summary.json``."""

_TEXT = {"candidate", "protocol", "rate_basis", "trip"}


def comparison_document(result: ComparisonResult) -> dict[str, Any]:
    """Return the content of ``summary.json`` as plain values.

    Parameters
    ----------
    result
        The comparison.
    """
    return {
        "schema": COMPARISON_SCHEMA,
        "modelcast": package_version(),
        "settings": plain_value(result.settings),
        "routes": [row_document(row) for row in result.routes],
        "trips": [row_document(row) for row in result.trips],
        "candidates": [row_document(row) for row in result.candidates],
        "ratios": [row_document(row) for row in result.ratios],
        "rivals": [row_document(row) for row in result.rivals],
        "tracking": [row_document(row) for row in result.tracking if row.trip == POOLED],
        "references": [row_document(row) for row in result.references],
        "failures": plain_value(result.failures),
        "skipped": plain_value(result.skipped),
    }


def write_comparison(result: ComparisonResult, folder: str | Path) -> list[Path]:
    """Write ``summary.json``, ``messages.parquet`` and ``tracking.parquet``; return their paths.

    Parameters
    ----------
    result
        The comparison.
    folder
        An existing folder.
    """
    folder = Path(folder)
    summary, messages, tracking = (
        folder / name for name in ("summary.json", "messages.parquet", "tracking.parquet")
    )
    summary.write_text(document_text(comparison_document(result)), encoding="utf-8", newline="\n")
    for path, columns in (
        (messages, _columns(result.counts, CountRow)),
        (tracking, _columns(result.tracking, TrackingRatioRow)),
    ):
        table = columns_table(columns)
        write_tables([table], table.schema, path)
    return [summary, messages, tracking]


def _columns(
    rows: Sequence[CountRow | TrackingRatioRow], row_type: type[CountRow | TrackingRatioRow]
) -> Columns:
    """Return rows as columns: text as objects, numbers that do not exist as NaN."""
    columns: dict[str, Any] = {}
    for field in fields(row_type):
        values = [getattr(row, field.name) for row in rows]
        kind = object if field.name in _TEXT else np.int64 if field.type is int else np.float64
        columns[field.name] = np.array(values, dtype=kind)
    return columns
