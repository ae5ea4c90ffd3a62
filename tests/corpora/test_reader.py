"""A corpus is a source of trips like any other."""

from collections.abc import Callable
from pathlib import Path

import pytest

from modelcast.cli.app import run
from modelcast.core.exceptions import DataFormatError
from modelcast.corpora.ingestion import ingest
from modelcast.corpora.layout import Corpus
from modelcast.corpora.sources import find_sources
from modelcast.io.registry import detect_format
from modelcast.io.trips import read_trips


@pytest.fixture
def corpus(sources: Callable[[], Path], tmp_path: Path) -> Corpus:
    return ingest(find_sources([sources()]), tmp_path / "c", partitions=3).corpus


def test_trips_are_read_from_it_and_from_a_folder_that_holds_it(corpus: Corpus, sources: Callable[[], Path]):
    assert detect_format(corpus.path) == "corpus"
    inside = [trip.trip_id for one in corpus.partitions for trip in corpus.trips(one)]
    assert [trip.trip_id for trip in read_trips(corpus.path)] == inside
    beside = [trip.trip_id for trip in read_trips([corpus.path, sources() / "may.csv"])]
    assert len(beside) == len(inside) + 6
    assert "may/10100-3#2" in beside


def test_its_own_files_are_not_taken_for_recordings(corpus: Corpus):
    assert len(list(read_trips([corpus.path, corpus.path]))) == sum(one.trips for one in corpus.partitions)


def test_an_unfinished_one_is_an_error(corpus: Corpus):
    (corpus.path / "corpus.json").rename(corpus.path / "ingest.json")
    with pytest.raises(DataFormatError, match="unfinished"):
        list(read_trips(corpus.path))


def test_a_corpus_of_a_corpus_holds_the_same_trips(corpus: Corpus, tmp_path: Path):
    again = ingest(find_sources([corpus.path]), tmp_path / "again", partitions=3).corpus
    for one, other in zip(corpus.partitions, again.partitions, strict=True):
        assert (one.name, one.trips, one.rows) == (other.name, other.trips, other.rows)
        assert [(t.trip_id, t.vehicle, t.reading) for t in corpus.trips(one)] == [
            (t.trip_id, t.vehicle, t.reading) for t in again.trips(other)
        ]


def test_convert_and_trips_take_it(corpus: Corpus, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert run(["convert", str(corpus.path), "--out", str(tmp_path / "all.parquet")]) == 0
    assert len(list(read_trips(tmp_path / "all.parquet"))) == sum(one.trips for one in corpus.partitions)
    assert run(["trips", str(corpus.path), "--trip", "odd/*", "--quiet"]) == 0
    assert "odd/uneven" in capsys.readouterr().out
