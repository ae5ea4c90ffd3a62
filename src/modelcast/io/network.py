"""What a network evaluation leaves on disk, for programs to read, and the runs it can take up again.

``runs/<case>.json``
    Rows of one run, written whole when it is done (`write_case`, `read_case`).
``summary.json`` (`network_document`)
    ``schema`` (1), ``modelcast`` (version), ``options``, ``runs`` (`RunRow`), ``pooled`` (`PooledRow`),
    ``capacities`` (`CapacityRow`). A number that does not exist is null.
``runs.parquet``, ``distances.parquet``, ``outcomes.parquet``, ``seconds.parquet``
    One row a run; a run and bin of 25 m; a run and bin of the radio; a run and second.

The same runs give the same bytes.
"""

import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from modelcast.core.exceptions import ConfigError
from modelcast.core.version import package_version
from modelcast.evaluation.network.rows import (
    CaseResult,
    DistanceRow,
    NetworkCase,
    NetworkResult,
    OutcomeRow,
    RunRow,
    SecondRow,
)
from modelcast.io.arrow import columns_table, write_tables
from modelcast.io.documents import document_text, plain_value, row_document

__all__ = [
    "NETWORK_SCHEMA",
    "case_name",
    "network_document",
    "read_case",
    "write_case",
    "write_network",
]

NETWORK_SCHEMA = 1
"""Version of the layout of a network evaluation's files."""

_TEXT = {"radio", "policy"}


def case_name(case: NetworkCase) -> str:
    """File name of a run, without suffix.

    Parameters
    ----------
    case
        The run.

    Examples
    --------
    >>> case_name(NetworkCase(100.0, "dsrc", "j2945", 3))
    'dsrc_j2945_100_3'
    """
    density = f"{case.density_per_km:g}" if math.isfinite(case.density_per_km) else "own"
    return f"{case.radio}_{case.policy}_{density}_{case.run}"


def write_case(result: CaseResult, case: NetworkCase, options: Mapping[str, Any], folder: Path) -> Path:
    """Write one run's rows; the file appears whole or not at all.

    Parameters
    ----------
    result
        The rows.
    case
        The run.
    options
        What it was run with, as plain values: only a call with the same takes it up again.
    folder
        An existing folder.
    """
    document = {
        "schema": NETWORK_SCHEMA,
        "options": dict(options),
        "run": [row_document(result.run)],
        "distances": [row_document(row) for row in result.distances],
        "outcomes": [row_document(row) for row in result.outcomes],
        "seconds": [row_document(row) for row in result.seconds],
    }
    path = folder / f"{case_name(case)}.json"
    partial = path.with_suffix(f".partial-{os.getpid()}")
    partial.write_text(document_text(document), encoding="utf-8", newline="\n")
    partial.replace(path)
    return path


def read_case(case: NetworkCase, options: Mapping[str, Any], folder: Path) -> CaseResult | None:
    """Rows of a run that is done already, None where it is not.

    Parameters
    ----------
    case, options, folder
        As for `write_case`.

    Raises
    ------
    ConfigError
        Where the file is of a run with other options, or no such file at all.
    """
    path = folder / f"{case_name(case)}.json"
    if not path.is_file():
        return None
    try:
        document: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        known = document["options"]
        found = CaseResult(
            _rows(RunRow, document["run"])[0],
            _rows(DistanceRow, document["distances"]),
            outcomes=_rows(OutcomeRow, document["outcomes"]),
            seconds=_rows(SecondRow, document["seconds"]),
        )
    except (ValueError, KeyError, TypeError, IndexError) as error:
        raise ConfigError(f"{path} is not a run of modelcast network: remove it ({error!r})") from error
    if known != dict(options):
        changed = sorted(name for name in {*known, *options} if known.get(name) != options.get(name))
        raise ConfigError(
            f"{path} was run with other options ({', '.join(changed)}): name another output folder"
        )
    return found


def _rows(row_type: Any, documents: Sequence[Mapping[str, Any]]) -> list[Any]:
    """Rows from mappings; null is a number that does not exist."""
    return [
        row_type(**{name: np.nan if value is None else value for name, value in one.items()})
        for one in documents
    ]


def network_document(result: NetworkResult, options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of ``summary.json`` as plain values.

    Parameters
    ----------
    result
        All runs.
    options
        What they were run with.
    """
    return {
        "schema": NETWORK_SCHEMA,
        "modelcast": package_version(),
        "options": plain_value(dict(options)),
        "runs": [row_document(row) for row in result.runs],
        "pooled": [row_document(row) for row in result.pooled],
        "capacities": [row_document(row) for row in result.capacities],
    }


def write_network(result: NetworkResult, options: Mapping[str, Any], folder: str | Path) -> list[Path]:
    """Write ``summary.json`` and the Parquet files; return their paths.

    Parameters
    ----------
    result
        All runs.
    options
        What they were run with.
    folder
        An existing folder.
    """
    folder = Path(folder)
    summary = folder / "summary.json"
    text = document_text(network_document(result, options))
    summary.write_text(text, encoding="utf-8", newline="\n")
    paths = [summary]
    groups: tuple[tuple[str, Sequence[Any], Any], ...] = (
        ("runs", result.runs, RunRow),
        ("distances", result.distances, DistanceRow),
        ("outcomes", result.outcomes, OutcomeRow),
        ("seconds", result.seconds, SecondRow),
    )
    for name, rows, row_type in groups:
        columns: dict[str, Any] = {}
        for field in fields(row_type):
            kind = object if field.name in _TEXT else np.int64 if field.type is int else np.float64
            columns[field.name] = np.array([getattr(row, field.name) for row in rows], dtype=kind)
        table = columns_table(columns)
        path = folder / f"{name}.parquet"
        write_tables([table], table.schema, path)
        paths.append(path)
    return paths
