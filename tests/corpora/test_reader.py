"""A corpus is a source of trips like any other."""

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

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


@settings(max_examples=80, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(
    pick=st.integers(0, 3),
    place=st.floats(0.0, 1.0),
    octets=st.binary(max_size=6),
    kind=st.sampled_from(["flip", "cut", "insert"]),
)
def test_damage_raises_nothing_but_format_errors(
    corpus: Corpus, pick: int, place: float, octets: bytes, kind: str
):
    files = ["corpus.json", "catalogue.parquet", corpus.partitions[0].files[0], "skipped.parquet"]
    path = corpus.path / files[pick]
    whole = path.read_bytes()
    at = int(place * len(whole))
    behind = {"flip": whole[at + len(octets) :], "cut": b"", "insert": whole[at:]}[kind]
    path.write_bytes(whole[:at] + (b"" if kind == "cut" else octets) + behind)
    try:
        for trip in read_trips(corpus.path, "corpus"):
            assert len(trip) > 0
    except DataFormatError as error:
        assert str(corpus.path) in str(error)  # noqa: PT017 - both outcomes are right
    finally:
        path.write_bytes(whole)


def test_convert_and_trips_take_it(corpus: Corpus, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert run(["convert", str(corpus.path), "--out", str(tmp_path / "all.parquet")]) == 0
    assert len(list(read_trips(tmp_path / "all.parquet"))) == sum(one.trips for one in corpus.partitions)
    assert run(["trips", str(corpus.path), "--trip", "odd/*", "--quiet"]) == 0
    assert "odd/uneven" in capsys.readouterr().out
