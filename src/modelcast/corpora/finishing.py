"""The end of an ingest: what tells of the rows, and last of all that the folder is a corpus."""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, asdict, dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from modelcast.core.version import package_version
from modelcast.corpora.catalogue import CATALOGUE
from modelcast.corpora.layout import (
    CATALOGUE_FILE,
    CORPUS_FILE,
    FORMAT,
    SKIPPED_FILE,
    VERSION,
    Corpus,
    Partition,
    open_corpus,
)
from modelcast.corpora.sources import FoundSources
from modelcast.corpora.staging import Staged
from modelcast.io.documents import document_text
from modelcast.io.output import atomic_file
from modelcast.io.skipped import merge_skipped

__all__ = ["Ingested", "Made", "failures_of", "finish", "skipped_of", "write_grouped"]

_SKIPPED: Any = pa.schema(
    [*((name, pa.string()) for name in ("source", "trip", "reason", "kind")), ("rows", pa.int64())]
)
_KINDS = ("skipped", "repaired")


@dataclass(frozen=True, slots=True)
class Made:
    """What is there once the partitions are packed.

    Parameters
    ----------
    folder
        The corpus' folder.
    found
        The sources.
    staged
        What became of each, by its number.
    settings
        How they were read.
    catalogue
        Of all trips, by partition and trip, a `pyarrow.Table`.
    partitions
        By name.
    """

    folder: Path
    found: FoundSources
    staged: Mapping[int, Staged]
    _: KW_ONLY
    settings: Mapping[str, Any]
    catalogue: Any
    partitions: tuple[Partition, ...]


@dataclass(frozen=True, slots=True)
class Ingested:
    """What became of an ingest.

    Parameters
    ----------
    corpus
        The corpus.
    trips, rows, samples
        Numbers of trips, of rows read for them, and of samples stored.
    skipped_rows, repaired_rows
        Rows left out and put right, by reason.
    rows_without_trip
        Rows of vehicles that gave no trip, all left out; they are in none of the numbers above.
    skipped
        Vehicles and files that gave no trip, with the reason.
    failures
        Sources that could not be read, with the reason.
    kept
        Sources that an earlier run had read already.
    """

    corpus: Corpus
    trips: int
    rows: int
    samples: int
    skipped_rows: Mapping[str, int]
    repaired_rows: Mapping[str, int]
    rows_without_trip: int
    skipped: Mapping[str, str]
    failures: Mapping[str, str]
    kept: int


def finish(made: Made, *, kept: int) -> Ingested:
    """Write the catalogue, what was skipped, and ``corpus.json``.

    Parameters
    ----------
    made
        What is there.
    kept
        As in `Ingested`.
    """
    folder, staged = made.folder, made.staged
    write_grouped(folder / CATALOGUE_FILE, made.catalogue.select(CATALOGUE.names))
    counts = _write_skipped(folder / SKIPPED_FILE, made)
    document = {
        "format": FORMAT,
        "version": VERSION,
        "modelcast": package_version(),
        "settings": dict(made.settings),
        "sources": [
            {
                "source": source.label,
                "format": source.reader.name,
                "octets": one.state[1],
                "trips": one.trips,
                "rows": one.rows,
                "samples": one.samples,
                "failure": one.failure or None,
            }
            for source, one in zip(made.found.sources, staged.values(), strict=True)
        ],
        "failures": failures_of(made.found, staged),
        "partitions": [{**asdict(one), "files": list(one.files)} for one in made.partitions],
    }
    with atomic_file(folder / CORPUS_FILE) as file:
        file.write(document_text(document).encode())
    return Ingested(
        open_corpus(folder),
        trips=made.catalogue.num_rows,
        rows=sum(one.rows for one in staged.values()),
        samples=sum(one.samples for one in staged.values()),
        skipped_rows=counts["skipped"],
        repaired_rows=counts["repaired"],
        rows_without_trip=sum(sum(one.skipped_rows.values()) for one in staged.values()),
        skipped=skipped_of(made.found, staged),
        failures=failures_of(made.found, staged),
        kept=kept,
    )


def write_grouped(path: Path, catalogue: Any) -> None:
    """Write a catalogue, a row group a partition.

    Parameters
    ----------
    path
        The file.
    catalogue
        By partition, a `pyarrow.Table`.
    """
    rows = Counter[str](catalogue["partition"].to_pylist())
    start = 0
    with atomic_file(path) as file, pq.ParquetWriter(file, catalogue.schema, compression="zstd") as writer:
        for count in rows.values():
            writer.write_table(catalogue.slice(start, count), row_group_size=count)
            start += count


def skipped_of(found: FoundSources, staged: Mapping[int, Staged]) -> dict[str, str]:
    """Return what gave no trip, with the reason.

    Parameters
    ----------
    found, staged
        As in `Made`.
    """
    return merge_skipped([found.skipped, *(one.skipped for one in staged.values())])


def failures_of(found: FoundSources, staged: Mapping[int, Staged]) -> dict[str, str]:
    """Return the sources that could not be read, with the reason.

    Parameters
    ----------
    found, staged
        As in `Made`.
    """
    failed = {one.label: staged[one.number].failure for one in found.sources}
    return {**found.failures, **{label: reason for label, reason in failed.items() if reason}}


def _write_skipped(path: Path, made: Made) -> dict[str, dict[str, int]]:
    """Write a row for each trip and reason, and return the rows by kind and reason."""
    counts = {kind: Counter[str]() for kind in _KINDS}
    with atomic_file(path) as file, pq.ParquetWriter(file, _SKIPPED, compression="zstd") as writer:
        for batch in made.catalogue.select(["source", "trip", *_KINDS]).to_batches(max_chunksize=10_000):
            rows: list[dict[str, Any]] = []
            for trip in batch.to_pylist():
                for kind, count in counts.items():
                    for one in trip[kind]:
                        rows.append({**one, "source": trip["source"], "trip": trip["trip"], "kind": kind})
                        count[one["reason"]] += one["rows"]
            writer.write_table(pa.Table.from_pylist(rows, schema=_SKIPPED))
        writer.write_table(pa.Table.from_pylist(_without_trip(made), schema=_SKIPPED))
    return {kind: dict(count) for kind, count in counts.items()}


def _without_trip(made: Made) -> Sequence[dict[str, Any]]:
    """Return what gave no trip as rows of the table of what was skipped."""
    named = [(name, "", reason, None) for name, reason in made.found.skipped.items()]
    for source in made.found.sources:
        staged = made.staged[source.number]
        named += [
            (source.label, trip, reason, staged.skipped_rows.get(trip))
            for trip, reason in staged.skipped.items()
        ]
    return [
        {"source": source, "trip": trip, "reason": reason, "kind": "no trip", "rows": rows}
        for source, trip, reason, rows in named
    ]
