"""What a network evaluation leaves on disk, for programs to read.

``runs/<case>-<key>.json``
    Rows of one run (`modelcast.io.network_runs`).
``summary.json`` (`network_document`)
    ``schema`` (8), ``modelcast`` (version), ``inputs`` (a hash of every file read), ``traffic`` (what a file
    of traffic holds, else null), ``options``, ``senders`` (`SENDERS`), ``runs`` (`RUNS`),
    ``pooled`` (`POOLED`), ``warnings`` (`POOLED_WARNINGS`),
    ``roadside`` (`ROADSIDE`), ``people`` (`PEOPLE`). A number that does not exist is null.
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
from pathlib import Path
from typing import Any

from modelcast.io.documents import plain_value
from modelcast.io.network_runs import RunKey
from modelcast.io.result_files import write_result
from modelcast.study.network.rows import CASE_TABLES, NetworkResult
from modelcast.study.table import Table

__all__ = ["NETWORK_SCHEMA", "network_document", "write_network"]

NETWORK_SCHEMA = 8
"""Version of the layout of ``summary.json``; since 2 it holds inputs and traffic, since 3 banks, since 4
thresholds, since 5 warnings, since 6 relative errors and no capacities, since 7 roadside, since 8
people."""

_ALWAYS = ("runs", "distances", "outcomes", "seconds")
"""Tables that every evaluation has; the others are of mixed fleets, of hosts with applications, of roadside
units, of people."""


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
        "senders": result.senders.plain(),
        "runs": result.runs.plain(),
        "pooled": result.pooled.plain(),
        "warnings": result.pooled_warnings.plain(),
        "roadside": result.roadside.plain(),
        "people": result.people.plain(),
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
    tables: dict[str, Table] = {
        name: getattr(result, name) for name in ("runs", *CASE_TABLES, "pooled_warnings")
    }
    shown = {name: table for name, table in tables.items() if table or name in _ALWAYS}
    return write_result(network_document(result, options, key, traffic, training_trips), shown, folder)
