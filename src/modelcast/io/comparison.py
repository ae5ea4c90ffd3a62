"""What a comparison leaves on disk, for programs to read.

``summary.json`` (`comparison_document`)
    ``schema`` (1), ``modelcast`` (version), ``settings``, ``routes``, ``trips``, ``candidates``, ``ratios``,
    ``rivals``, ``tracking``, ``references``, ``failures``, ``skipped``: the rows of
    `modelcast.study.compare.result` that pool all trips. A number that does not exist is null.
``messages.parquet``
    One row for each candidate, protocol, trip and threshold: `COUNTS`.
``tracking.parquet``
    One row for each candidate, protocol, trip, threshold and packet error ratio: `TRACKING_RATIOS`, rows
    that pool all trips (``"all"``) among them.

The same result gives the same bytes.
"""

from pathlib import Path
from typing import Any

from modelcast.core.version import package_version
from modelcast.io.documents import plain_value, row_document
from modelcast.io.result_files import write_result
from modelcast.study.compare.result import ComparisonResult
from modelcast.study.result import POOLED

__all__ = ["COMPARISON_SCHEMA", "comparison_document", "write_comparison"]

COMPARISON_SCHEMA = 1
"""Version of the layout of a comparison's ``summary.json``."""


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
        "routes": result.routes.plain(),
        "trips": [row_document(row) for row in result.trips],
        "candidates": [row_document(row) for row in result.candidates],
        "ratios": result.ratios.plain(),
        "rivals": result.rivals.plain(),
        "tracking": [row.plain() for row in result.tracking if row.trip == POOLED],
        "references": result.references.plain(),
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
    tables = {"messages": result.counts, "tracking": result.tracking}
    return write_result(comparison_document(result), tables, folder)
