"""What a corpus looks like on disk, and reading it.

``corpus.json``
    `FORMAT` and `VERSION`, the modelcast that wrote it, sources, failures and partitions. Written last: a
    folder without it is no corpus, or one whose ingest has not ended (`UNFINISHED` is there then).
``rows/partition=0017/0000.parquet``
    The samples: the columns of `modelcast.io.write_trips`, by trip and time.
``catalogue.parquet``
    A row a trip (`modelcast.corpora.catalogue`), by partition and trip, a row group a partition.
``skipped.parquet``
    ``source``, ``trip`` (empty where none came of it), ``reason``, ``kind`` (skipped, repaired, no trip) and
    ``rows``.
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import DataFormatError
from modelcast.core.rules import Each, FieldError, Keys, Text, Whole, check
from modelcast.corpora.catalogue import CATALOGUE, SAMPLED, trip_from
from modelcast.corpora.partition_rows import SAMPLES
from modelcast.trips.trajectory import Trajectory

__all__ = [
    "CATALOGUE_FILE",
    "CORPUS_FILE",
    "FORMAT",
    "ROWS_FOLDER",
    "SKIPPED_FILE",
    "UNFINISHED",
    "VERSION",
    "Corpus",
    "Partition",
    "is_corpus",
    "open_corpus",
    "partition_folder",
]

FORMAT = "modelcast corpus"
"""The mark in ``corpus.json``."""

VERSION = 1
"""Of the layout."""

CORPUS_FILE = "corpus.json"
CATALOGUE_FILE = "catalogue.parquet"
SKIPPED_FILE = "skipped.parquet"
ROWS_FOLDER = "rows"

UNFINISHED = "ingest.json"
"""What is there instead of ``corpus.json`` while an ingest has not ended."""

_MOST_BYTES = 64 * 1024**2
_MOST = 2**53
_MOST_LISTED = 1_000_000
_DAMAGED = "Ingest its sources anew."
_PARTITIONS = Each(
    Keys(
        {
            "name": Text(16, pattern="[0-9]{4,}"),
            "files": Each(
                Text(64, pattern=rf"{ROWS_FOLDER}/partition=[0-9]{{4,}}/[0-9]{{4,}}\.parquet"),
                1,
                _MOST_LISTED,
            ),
            "trips": Whole(1, _MOST),
            "rows": Whole(1, _MOST),
            "digest": Text(64, pattern="[0-9a-f]{64}"),
        }
    ),
    1,
    _MOST_LISTED,
)


@dataclass(frozen=True, slots=True)
class Partition:
    """Some vehicles' trips: what one task works on.

    Parameters
    ----------
    name
        Its number, as in ``0017``.
    files
        Files of its samples from the corpus on, in order.
    trips, rows
        Numbers of trips, and of their samples.
    digest
        SHA-256 of the files' contents and the catalogue's rows, in hexadecimal digits.
    """

    name: str
    files: tuple[str, ...]
    trips: int
    rows: int
    digest: str


@dataclass(frozen=True, slots=True)
class Corpus:
    """Many trips on disk.

    Parameters
    ----------
    path
        The folder.
    partitions
        By name; none is empty.
    """

    path: Path
    partitions: tuple[Partition, ...]

    def catalogue(self, partition: Partition) -> Any:
        """Return a partition's rows of the catalogue, a `pyarrow.Table`.

        Parameters
        ----------
        partition
            One of this corpus.

        Raises
        ------
        DataFormatError
            Where the catalogue is damaged, or of another corpus.
        """
        path = self.path / CATALOGUE_FILE
        try:
            with pq.ParquetFile(path, page_checksum_verification=True) as file:
                _require_columns(path, file.schema_arrow, CATALOGUE)
                found = file.read_row_group(self.partitions.index(partition))
        except (pa.ArrowException, OSError, ValueError, IndexError) as error:
            raise DataFormatError(str(path), f"cannot be read: {error}", remedy=_DAMAGED) from error
        if found.num_rows != partition.trips or {partition.name} != set(found["partition"].to_pylist()):
            raise DataFormatError(
                str(path), f"does not hold the trips of partition {partition.name}", remedy=_DAMAGED
            )
        return found

    def trips(self, partition: Partition) -> Iterator[Trajectory]:
        """Yield a partition's trips in order of identifier, each as its reader gave it.

        Parameters
        ----------
        partition
            One of this corpus.

        Raises
        ------
        DataFormatError
            Where a file is damaged, or of another corpus.
        """
        samples = _Samples([self.path / name for name in partition.files])
        for batch in self.catalogue(partition).to_batches(max_chunksize=1000):
            for row in batch.to_pylist():
                try:
                    yield trip_from(row, samples.next(row["samples"]))
                except (ValueError, TypeError) as error:
                    raise DataFormatError(str(self.path), str(error), remedy=_DAMAGED) from error


def is_corpus(path: str | Path) -> bool:
    """Return whether a folder is a corpus, or one whose ingest has not ended; `open_corpus` tells which.

    Parameters
    ----------
    path
        Anything.
    """
    return any(_document(Path(path) / name) is not None for name in (CORPUS_FILE, UNFINISHED))


def open_corpus(path: str | Path) -> Corpus:
    """Return the corpus in a folder.

    Parameters
    ----------
    path
        The folder.

    Raises
    ------
    DataFormatError
        Where it is none, is of another version of modelcast, or its ingest has not ended.
    """
    folder = Path(path)
    document = _document(folder / CORPUS_FILE)
    if document is None:
        if _document(folder / UNFINISHED) is not None:
            raise DataFormatError(
                str(path), "is an unfinished corpus", remedy="Run the same ingest again: it goes on."
            )
        raise DataFormatError(str(path), "is no corpus", remedy="Make one with modelcast ingest.")
    if document.get("version") != VERSION:
        raise DataFormatError(
            str(path),
            f"is a corpus of version {document.get('version')}, this modelcast reads {VERSION}",
            remedy=_DAMAGED,
        )
    partitions = _partitions(folder / CORPUS_FILE, document.get("partitions"))
    missing = [name for one in partitions for name in one.files if not (folder / name).is_file()]
    if missing:
        raise DataFormatError(str(path), f"lacks its file {missing[0]}", remedy=_DAMAGED)
    return Corpus(folder, partitions)


def partition_folder(corpus: Path, name: str) -> Path:
    """Return where a partition's samples are.

    Parameters
    ----------
    corpus
        The folder.
    name
        Of the partition.
    """
    return corpus / ROWS_FOLDER / f"partition={name}"


def _partitions(path: Path, given: object) -> tuple[Partition, ...]:
    """Return the partitions that ``corpus.json`` lists.

    Their names become paths, here and in results folders, so nothing but what `ingest` writes is taken.
    """
    try:
        check(given, _PARTITIONS, "partitions")
    except FieldError as error:
        raise DataFormatError(str(path), f"is damaged: {error}", remedy=_DAMAGED) from error
    partitions = tuple(
        Partition(one["name"], tuple(one["files"]), one["trips"], one["rows"], one["digest"])
        for one in cast("list[dict[str, Any]]", given)
    )
    if len({one.name for one in partitions}) < len(partitions):
        raise DataFormatError(str(path), "is damaged: it names a partition twice", remedy=_DAMAGED)
    for one in partitions:
        strange = [name for name in one.files if Path(name).parent != partition_folder(Path(), one.name)]
        if strange:
            raise DataFormatError(
                str(path), f"is damaged: {strange[0]} is no file of partition {one.name}", remedy=_DAMAGED
            )
    return partitions


def _require_columns(path: Path, found: Any, wanted: Any) -> None:
    """Refuse a Parquet schema without one of the columns, or with another type of it."""
    for column in wanted:
        at = found.get_field_index(column.name)
        if at < 0 or found.field(at).type != column.type:
            raise DataFormatError(
                str(path), f"has no column {column.name} of type {column.type}", remedy=_DAMAGED
            )


def _document(path: Path) -> dict[str, Any] | None:
    """Return a JSON document that has our mark, None where there is none."""
    try:
        if path.stat().st_size > _MOST_BYTES:
            return None
        found: object = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    if not isinstance(found, dict):
        return None
    document = cast("dict[str, Any]", found)
    return document if document.get("format") == FORMAT else None


class _Samples:
    """The columns of several files, one after another, a row group at a time."""

    def __init__(self, files: list[Path]) -> None:
        self._tables = self._read(files)
        self._held: dict[str, FloatArray] = {name: np.zeros(0) for name in SAMPLED}
        self._at = 0
        self._where = ""

    def next(self, rows: int) -> dict[str, FloatArray]:
        """Return the next rows; copies, so that a trip does not hold its row group."""
        parts: list[dict[str, FloatArray]] = []
        while rows:
            left = self._held["t_s"].size - self._at
            if left == 0:
                self._held, self._at = self._next_table(), 0
                continue
            take = slice(self._at, self._at + min(rows, left))
            parts.append({name: column[take] for name, column in self._held.items()})
            self._at, rows = take.stop, rows - (take.stop - take.start)
        return {name: np.concatenate([part[name] for part in parts]) for name in SAMPLED}

    def _next_table(self) -> dict[str, FloatArray]:
        table = next(self._tables, None)
        if table is None:
            raise DataFormatError(self._where, "holds fewer rows than the catalogue says", remedy=_DAMAGED)
        return {name: table[name].to_numpy() for name in SAMPLED}

    def _read(self, files: list[Path]) -> Iterator[Any]:
        for path in files:
            self._where = str(path)
            try:
                with pq.ParquetFile(path, page_checksum_verification=True) as file:
                    _require_columns(path, file.schema_arrow, SAMPLES)
                    for group in range(file.num_row_groups):
                        yield file.read_row_group(group, columns=list(SAMPLED), use_threads=False)
            except (pa.ArrowException, OSError, ValueError) as error:
                raise DataFormatError(str(path), f"cannot be read: {error}", remedy=_DAMAGED) from error
