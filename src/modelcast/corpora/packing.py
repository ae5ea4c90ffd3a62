"""A partition out of the staged sources, in a folder that appears whole or not at all."""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

import hashlib
import json
import shutil
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq

from modelcast.corpora.catalogue import CATALOGUE
from modelcast.corpora.layout import ROWS_FOLDER, Partition, partition_folder
from modelcast.corpora.merging import BATCH, STAGED
from modelcast.corpora.partition_rows import write_rows
from modelcast.corpora.staging import source_folder, staged_samples
from modelcast.io.output import atomic_file, lasting_rename
from modelcast.io.partial import clean_leftovers, partial_folder

__all__ = ["Packing", "pack", "packed_already"]

_OPEN_SOURCES = 64


@dataclass(frozen=True, slots=True)
class Packing:
    """A partition to be written.

    Parameters
    ----------
    name
        Of the partition.
    corpus
        The corpus' folder.
    staging
        The folder of all staged sources.
    catalogue
        The merged catalogue, a row group a partition.
    group
        The partition's row group.
    key
        Hash of all that the partition is made from.
    """

    name: str
    corpus: Path
    staging: Path
    catalogue: Path
    group: int
    key: str

    @property
    def mark(self) -> Path:
        """The file that says that it is done."""
        return self.staging / f"packed-{self.name}.json"


def packed_already(work: Packing) -> Partition | None:
    """Return what an earlier run made of a partition, None where that is to be done (again).

    Parameters
    ----------
    work
        The partition.
    """
    try:
        found = json.loads(work.mark.read_text(encoding="utf-8"))
        packed = Partition(
            found["name"], tuple(found["files"]), found["trips"], found["rows"], found["digest"]
        )
    except (OSError, ValueError, TypeError, KeyError):
        return None
    return packed if found.get("key") == work.key else None


def pack(work: Packing) -> Partition:
    """Write a partition's samples, by trip and time.

    Parameters
    ----------
    work
        The partition.
    """
    with pq.ParquetFile(work.catalogue) as file:
        catalogue = file.read_row_group(work.group)
    target = partition_folder(work.corpus, work.name)
    clean_leftovers(target)
    with partial_folder(target) as folder:
        names = write_rows(folder, _trips(work, catalogue))
        digest = hashlib.sha256()
        for name in names:
            with (folder / name).open("rb") as file:
                digest.update(hashlib.file_digest(file, "sha256").digest())
        for batch in catalogue.select(CATALOGUE.names).to_batches(max_chunksize=1000):
            for row in batch.to_pylist():
                digest.update(json.dumps(row, sort_keys=True).encode())
        if target.exists():
            shutil.rmtree(target)
        lasting_rename(folder, target)
    packed = Partition(
        work.name,
        tuple(f"{ROWS_FOLDER}/{target.name}/{name}" for name in names),
        catalogue.num_rows,
        sum(catalogue["samples"].to_pylist()),
        digest.hexdigest(),
    )
    with atomic_file(work.mark) as file:
        file.write(json.dumps({"key": work.key, **asdict(packed)}).encode())
    return packed


def _trips(work: Packing, catalogue: Any) -> Iterator[tuple[dict[str, Any], Any]]:
    """Yield the trips' rows of the catalogue with their samples."""

    @lru_cache(maxsize=_OPEN_SOURCES)
    def samples_of(number: int) -> Any:
        return staged_samples(source_folder(work.staging, number))

    for batch in catalogue.to_batches(max_chunksize=1000):
        for row in batch.to_pylist():
            yield row, samples_of(row[STAGED])(row[BATCH])
