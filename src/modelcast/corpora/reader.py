"""A corpus as a source of trips, for everything that reads trips.

Trips keep the format they came from first, what was skipped and repaired, and all other fields; they come by
partition, in it by identifier. `modelcast.io.registry` knows this reader by name, as it knows those of other
packages: `modelcast.io` itself knows nothing of corpora.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import ClassVar

from modelcast.corpora.layout import CORPUS_FILE, is_corpus, open_corpus
from modelcast.io.base import AbstractTripReader, OnSkipped, ignore_skipped
from modelcast.trips.trajectory import Trajectory

__all__ = ["CorpusReader"]


class CorpusReader(AbstractTripReader):
    """Reads a folder that `modelcast ingest` made."""

    name: ClassVar[str] = "corpus"

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether it is the folder of a corpus, finished or not."""
        return not head and path.is_dir() and is_corpus(path)

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield its trips one at a time; what gave none is in its ``skipped.parquet``."""
        del on_skipped
        corpus = open_corpus(path)
        for partition in corpus.partitions:
            yield from corpus.trips(partition)

    def stands_for(self, path: Path) -> Path:
        """Return ``corpus.json`` in it."""
        return path / CORPUS_FILE
