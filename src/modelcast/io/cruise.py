"""What a study of platoons leaves on disk, for programs to read.

``summary.json``
    ``schema`` (1), ``modelcast`` (version), ``options`` (what was asked for), ``leader``, ``law``,
    ``ranging``, ``platoons``, ``vehicles``, ``failures`` (files that could not be read, and why), ``rows``:
    those of `CruiseRow`, with the figures of `DriveFigures` under their own names. A number that does not
    exist is null.
``runs.parquet``
    The rows again, a column a key.

The same runs give the same bytes.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from modelcast.core.version import package_version
from modelcast.io.arrow import columns_table, write_tables
from modelcast.io.documents import document_text
from modelcast.study.cruise.run import CruiseResult

__all__ = ["CRUISE_SCHEMA", "cruise_document", "write_cruise"]

CRUISE_SCHEMA = 1
"""Version of the layout; it rises when a key changes its meaning or goes away."""


def cruise_document(
    result: CruiseResult, *, options: Mapping[str, Any], failures: Mapping[str, str] | None = None
) -> dict[str, Any]:
    """Return the content of ``summary.json`` as plain values.

    Parameters
    ----------
    result
        What was found.
    options
        What was asked for.
    failures
        What could not be read, and why.
    """
    return {
        "schema": CRUISE_SCHEMA,
        "modelcast": package_version(),
        "options": dict(options),
        "leader": result.leader,
        "law": result.law,
        "ranging": result.ranging,
        "platoons": result.platoons,
        "vehicles": result.vehicles,
        "failures": dict(failures or {}),
        "rows": [row.as_plain() for row in result.rows],
    }


def write_cruise(document: Mapping[str, Any], folder: str | Path) -> tuple[Path, Path]:
    """Write ``summary.json`` and ``runs.parquet`` and return their paths.

    Parameters
    ----------
    document
        What `cruise_document` returned.
    folder
        An existing folder.
    """
    summary, runs = Path(folder) / "summary.json", Path(folder) / "runs.parquet"
    summary.write_text(document_text(document), encoding="utf-8", newline="\n")
    rows = document["rows"]
    columns = {name: _column(name, [row[name] for row in rows]) for name in rows[0]}
    table = columns_table(columns)
    write_tables([table], table.schema, runs)
    return summary, runs


def _column(name: str, values: list[Any]) -> Any:
    if name == "sender":
        return np.array(values, dtype=object)
    if all(isinstance(value, int) for value in values):
        return np.array(values, dtype=np.int64)
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
