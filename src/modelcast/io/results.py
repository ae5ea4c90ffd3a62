"""What an evaluation leaves on disk, for programs to read.

``summary.json`` (`summary_document`)
    ``schema`` (1), ``modelcast`` (version), ``settings``, ``trips``, ``rates``, ``references``, ``tracking``,
    ``failures``, ``skipped``. Trips are `TripRow`; the columns of the other rows are `RATES`, `REFERENCES`
    and `TRACKING` of `modelcast.study.result`, under the same names; a
    row that pools all trips has ``"trip": "all"``. A number that does not exist is null. Floats are written
    in full.
``events.parquet``
    One row a message of the rate runs.
``samples.parquet``
    One row a tracking-error sample that the run kept; the columns are `modelcast.io.arrow.SAMPLES_SCHEMA`.
a message trace (`write_message_trace`)
    ``t_s``, ``vehicle``, ``size_bytes``, ``kind``: when each vehicle sends how much, for other simulators.

The same result gives the same bytes: keys are sorted, and there is no time stamp and no absolute path.
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from modelcast.core.exceptions import ConfigError
from modelcast.core.version import package_version
from modelcast.io.arrow import columns_table, plain_text, write_tables
from modelcast.io.documents import document_text, plain_value, row_document
from modelcast.io.output import atomic_file, written_into
from modelcast.io.record_files import EVENTS_FILE, SAMPLES_FILE, RecordFiles
from modelcast.io.table_files import csv_text
from modelcast.study.result import EvaluationResult, HoldsEvaluation, result_of
from modelcast.study.rules import MODEL_SENDER

__all__ = [
    "SUMMARY_SCHEMA",
    "summary_document",
    "write_message_trace",
    "write_results",
    "write_summary",
]

SUMMARY_SCHEMA = 1
"""Version of the layout of ``summary.json``; it rises when a key changes its meaning or goes away."""


def summary_document(result: EvaluationResult) -> dict[str, Any]:
    """Return the content of ``summary.json`` as plain values.

    Parameters
    ----------
    result
        The evaluation.
    """
    return {
        "schema": SUMMARY_SCHEMA,
        "modelcast": package_version(),
        "settings": plain_value(result.settings),
        "trips": [row_document(row) for row in result.trips],
        "rates": result.rates.plain(),
        "references": result.references.plain(),
        "tracking": result.tracking.plain(),
        "failures": plain_value(result.failures),
        "skipped": plain_value(result.skipped),
    }


def write_results(result: EvaluationResult | HoldsEvaluation, folder: str | Path) -> list[Path]:
    """Write ``summary.json``, ``events.parquet`` and ``samples.parquet``; return their paths.

    Parameters
    ----------
    result
        The evaluation, with the messages and samples it kept.
    folder
        Made where it is missing.

    Raises
    ------
    ConfigError
        Where the folder cannot be made or written into.
    """
    found = result_of(result)

    def write(place: Path) -> list[Path]:
        summary = write_summary(found, place)
        with RecordFiles(place) as records:
            records.add_events(found.events)
            for block in found.samples:
                records.add_samples(block)
        return [summary, place / EVENTS_FILE, place / SAMPLES_FILE]

    return written_into(folder, write)


def write_summary(result: EvaluationResult, folder: Path) -> Path:
    """Write ``summary.json`` alone, where `RecordFiles` wrote the rest; return its path.

    Parameters
    ----------
    result
        The evaluation.
    folder
        An existing folder.
    """
    summary = folder / "summary.json"
    summary.write_text(document_text(summary_document(result)), encoding="utf-8", newline="\n")
    return summary


def write_message_trace(
    result: EvaluationResult | Path,
    path: str | Path,
    *,
    policy: str | None = None,
    bank: str | None = None,
    threshold_m: float | None = None,
) -> None:
    """Write when each vehicle sends a message of which size, as CSV or Parquet by the suffix of `path`.

    Every trip starts at its own time 0, so the vehicles of separate recordings run side by side.

    Parameters
    ----------
    result
        The evaluation, with the messages it kept; or the folder that `write_results` or `RecordFiles` wrote.
    path
        ``*.csv`` or ``*.parquet``; it appears whole or not at all.
    policy
        As rows name it; None for the model-based sender, ``mbc`` where the error-driven policy decides. A
        folder's must be named.
    bank
        The bank of sub-models; None for the first one evaluated.
    threshold_m
        The threshold; None for the smallest one evaluated [m].

    Raises
    ------
    ConfigError
        Where the suffix is another, no message fits the choice, or the file cannot be written.
    """
    path = Path(path)
    if path.suffix not in {".csv", ".parquet"}:
        raise ConfigError(f"a message trace is .csv or .parquet, not {path.name!r}")
    table = _message_trace(_messages_of(result, policy), bank=bank, threshold_m=threshold_m)
    with atomic_file(path) as file:
        if path.suffix == ".parquet":
            write_tables([table], table.schema, file)
        else:
            file.write(csv_text(table).encode())


def _messages_of(result: EvaluationResult | Path, policy: str | None) -> Any:
    if isinstance(result, Path):
        wanted = policy or MODEL_SENDER
        table: Any = pq.read_table(result / EVENTS_FILE, filters=pc.field("policy") == wanted)
    else:
        wanted = policy or result.sender
        table = plain_text(columns_table(result.events)).filter(pc.field("policy") == wanted)
    if not table.num_rows:
        raise ConfigError(f"no message of policy {wanted!r}")
    return table


def _message_trace(table: Any, *, bank: str | None, threshold_m: float | None) -> Any:
    bank = bank or str(table["bank"][0].as_py())
    table = table.filter(pc.field("bank") == bank)
    if threshold_m is None and table.num_rows:
        threshold_m = float(np.min(table["threshold_m"].to_numpy()))
    if threshold_m is not None:
        near = np.isclose(table["threshold_m"].to_numpy(), threshold_m, rtol=0.0, atol=1e-9)
        table = table.filter(pa.array(near, pa.bool_()))
    if not table.num_rows:
        raise ConfigError(f"no message of bank {bank!r}, threshold {threshold_m} m")
    table = table.select(["t_s", "trip", "size_bytes", "kind"])
    table = table.rename_columns(["t_s", "vehicle", "size_bytes", "kind"])
    return table.sort_by([("t_s", "ascending"), ("vehicle", "ascending")])
