"""What a network evaluation leaves on disk, for programs to read.

``runs/<case>-<key>.json``
    Rows of one run (`modelcast.io.network_runs`).
``summary.json`` (`network_document`)
    ``schema`` (8), ``modelcast`` (version), ``inputs`` (a hash of every file read), ``traffic`` (what a file
    of traffic holds, else null), ``options``, ``senders`` (`SenderRow`), ``runs`` (`RunRow`),
    ``pooled`` (`PooledRow`), ``warnings`` (`PooledWarnings`),
    ``roadside`` (`RoadsideRow`), ``people`` (`PeopleRow`). A number that does not exist is null.
``runs.parquet``, ``distances.parquet``, ``outcomes.parquet``, ``seconds.parquet``
    One row a run; a run and bin of 25 m; a run and bin of the radio; a run and second.
``pairings.parquet``, ``penetration.parquet``
    Of mixed fleets: one row a run, sender and reading; a run and share of model receivers.
``warnings.parquet``, ``warned_hosts.parquet``, ``warned_events.parquet``, ``pooled_warnings.parquet``
    Where hosts have applications: one row a run, application, sender and reading; each of its hosts; each
    true warning; and all seeds together.
``roadside.parquet``, ``roadside_distances.parquet``
    With roadside units: one row a run; a run and bin of 25 m.
``people.parquet``
    With people: one row a run.

The same runs give the same bytes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from modelcast.io.arrow import columns_table, write_tables
from modelcast.io.documents import document_text, plain_value, row_document
from modelcast.io.network_runs import RunKey
from modelcast.study.network.people_rows import PeopleRow
from modelcast.study.network.roadside_rows import RoadsideDistanceRow, RoadsideRow
from modelcast.study.network.rows import (
    DistanceRow,
    NetworkResult,
    OutcomeRow,
    PairingRow,
    PenetrationRow,
    RunRow,
    SecondRow,
)
from modelcast.study.network.warning_rows import PooledWarnings, WarnedEventRow, WarnedHostRow, WarningRow

__all__ = ["NETWORK_SCHEMA", "network_document", "write_network"]

NETWORK_SCHEMA = 8
"""Version of the layout of ``summary.json``; since 2 it holds inputs and traffic, since 3 banks, since 4
thresholds, since 5 warnings, since 6 relative errors and no capacities, since 7 roadside, since 8
people."""

_TEXT = {"radio", "policy", "bank", "sender", "reading", "application", "people_policy"}

_SOME = {
    "pairings",
    "penetration",
    "warnings",
    "warned_hosts",
    "warned_events",
    "pooled_warnings",
    "roadside",
    "roadside_distances",
    "people",
}
"""Tables that only some runs have: of mixed fleets, of hosts with applications, of roadside units, of
people."""


def network_document(
    result: NetworkResult,
    options: Mapping[str, Any],
    key: RunKey,
    traffic: Mapping[str, Any] | None = None,
    training_trips: Sequence[str] = (),
) -> dict[str, Any]:
    """Return the content of ``summary.json`` as plain values.

    Parameters
    ----------
    result
        All runs.
    options
        What they were run with.
    key
        Version and inputs.
    traffic
        What the traffic's file holds (`modelcast.io.traffic_survey.survey_document`); None where it is none.
    training_trips
        Recorded trips of the traffic that the shipped profile was trained on.
    """
    return {
        "schema": NETWORK_SCHEMA,
        "modelcast": key.version,
        "inputs": plain_value(key.all_inputs),
        "traffic": None if traffic is None else plain_value(dict(traffic)),
        "training_trips": list(training_trips),
        "options": plain_value(dict(options)),
        "senders": [row_document(row) for row in result.senders],
        "runs": [row_document(row) for row in result.runs],
        "pooled": [row_document(row) for row in result.pooled],
        "warnings": [row_document(row) for row in result.pooled_warnings],
        "roadside": [row_document(row) for row in result.roadside],
        "people": [row_document(row) for row in result.people],
    }


def write_network(
    result: NetworkResult,
    options: Mapping[str, Any],
    folder: str | Path,
    *,
    key: RunKey,
    traffic: Mapping[str, Any] | None = None,
    training_trips: Sequence[str] = (),
) -> list[Path]:
    """Write ``summary.json`` and the Parquet files; return their paths.

    Parameters
    ----------
    result, options, key, traffic, training_trips
        As for `network_document`.
    folder
        An existing folder.
    """
    folder = Path(folder)
    summary = folder / "summary.json"
    text = document_text(network_document(result, options, key, traffic, training_trips))
    summary.write_text(text, encoding="utf-8", newline="\n")
    paths = [summary]
    groups: tuple[tuple[str, Sequence[Any], Any], ...] = (
        ("runs", result.runs, RunRow),
        ("distances", result.distances, DistanceRow),
        ("outcomes", result.outcomes, OutcomeRow),
        ("seconds", result.seconds, SecondRow),
        ("pairings", result.pairings, PairingRow),
        ("penetration", result.penetration, PenetrationRow),
        ("warnings", result.warnings, WarningRow),
        ("warned_hosts", result.warned_hosts, WarnedHostRow),
        ("warned_events", result.warned_events, WarnedEventRow),
        ("pooled_warnings", result.pooled_warnings, PooledWarnings),
        ("roadside", result.roadside, RoadsideRow),
        ("roadside_distances", result.roadside_distances, RoadsideDistanceRow),
        ("people", result.people, PeopleRow),
    )
    for name, rows, row_type in groups:
        if not rows and name in _SOME:
            continue
        columns: dict[str, Any] = {}
        for field in fields(row_type):
            kind = object if field.name in _TEXT else np.int64 if field.type is int else np.float64
            columns[field.name] = np.array([getattr(row, field.name) for row in rows], dtype=kind)
        table = columns_table(columns)
        path = folder / f"{name}.parquet"
        write_tables([table], table.schema, path)
        paths.append(path)
    return paths
