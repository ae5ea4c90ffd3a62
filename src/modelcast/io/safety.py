"""What an evaluation of a safety application leaves on disk, for programs to read.

``summary.json`` (`safety_document`)
    ``schema`` (2), ``modelcast`` (version), ``settings``, counts of true warnings, pairs and instants,
    ``pooled`` (rows of `POOLED_SAFETY`), ``failures``, ``skipped``. A number that does not exist is null, an
    infinite one too: a delay of warnings that never came.
``pooled.parquet``
    The same rows.
``events.parquet``
    One row for each true warning, sensor, kind of loss, loss ratio, basis, candidate and run: whose it is,
    when it begins, its instants, how many of them were missed, and how late the warning came.

The same result gives the same bytes.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from modelcast.core.version import package_version
from modelcast.io.arrow import write_tables
from modelcast.io.documents import plain_value
from modelcast.io.result_files import write_result
from modelcast.io.table_files import arrow_columns
from modelcast.study.safety.result import EVENTS, RecordingScores, SafetyResult

__all__ = ["SAFETY_SCHEMA", "safety_document", "write_safety"]

SAFETY_SCHEMA = 2
"""Version of the layout of ``summary.json``; since 2 the ends of intervals are columns of their own."""


def safety_document(result: SafetyResult) -> dict[str, Any]:
    """Return the content of ``summary.json`` as plain values.

    Parameters
    ----------
    result
        The evaluation.
    """
    return {
        "schema": SAFETY_SCHEMA,
        "modelcast": package_version(),
        "settings": plain_value(result.settings),
        "events": result.events,
        "pairs": result.pairs,
        "counted": result.counted,
        "positives": result.positives,
        "pooled": result.pooled.plain(),
        "failures": plain_value(result.failures),
        "skipped": plain_value(result.skipped),
    }


def write_safety(result: SafetyResult, folder: str | Path) -> list[Path]:
    """Write ``summary.json``, ``pooled.parquet`` and ``events.parquet``; return their paths.

    Parameters
    ----------
    result
        The evaluation.
    folder
        An existing folder.
    """
    written = write_result(safety_document(result), {"pooled": result.pooled}, folder)
    events = Path(folder) / "events.parquet"
    parts = [arrow_columns(EVENTS, _events(one)) for one in result.recordings]
    write_tables(parts, parts[0].schema, events)
    return [*written, events]


def _events(scores: RecordingScores) -> dict[str, list[Any]]:
    """Events of one recording under all conditions, a row a run."""
    events, parts = scores.positives.size, list[Mapping[str, Any]]()
    for one in scores.conditions:
        runs = int(one.false.shape[1])
        places: list[int] = scores.event_pair.tolist()
        pairs = [scores.pairs[at] for at in places]
        rows = events * runs
        parts.append(
            {
                "recording": [scores.name] * rows,
                "sensor": [scores.sensor] * rows,
                "mean_burst_s": [scores.mean_burst_s] * rows,
                "loss_log": [scores.loss_log] * rows,
                "packet_error_ratio": [one.packet_error_ratio] * rows,
                "basis": [one.basis] * rows,
                "candidate": [one.candidate] * rows,
                "leader": [pair.leader for pair in pairs for _ in range(runs)],
                "follower": [pair.follower for pair in pairs for _ in range(runs)],
                "run": np.tile(np.arange(runs), events).tolist(),
                "t_s": np.repeat(scores.event_s, runs).tolist(),
                "instants": np.repeat(scores.positives, runs).tolist(),
                "missed": one.missed.ravel().tolist(),
                "delay_s": one.delay_s.ravel().tolist(),
            }
        )
    return {name: [value for part in parts for value in part[name]] for name in EVENTS.names}
