"""What is no corpus is refused with a reason, and files are of the sizes that are said."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.corpora.catalogue import SAMPLED
from modelcast.corpora.ingestion import ingest
from modelcast.corpora.layout import Corpus, is_corpus, open_corpus
from modelcast.corpora.partition_rows import FILE_BYTES, GROUP_ROWS, MOST_GROUP_ROWS, SAMPLES, write_rows
from modelcast.corpora.sources import find_sources
from modelcast.io.trips import read_trips


@pytest.fixture
def corpus(sources: Callable[[], Path], tmp_path: Path) -> Corpus:
    return ingest(
        find_sources([sources() / "may.csv", sources() / "april.csv"]), tmp_path / "c", partitions=2
    ).corpus


def all_trips(corpus: Corpus) -> list[Any]:
    return [trip for one in open_corpus(corpus.path).partitions for trip in corpus.trips(one)]


def test_what_is_no_corpus_is_told(tmp_path: Path):
    (tmp_path / "corpus.json").write_text('{"format": "another"}')
    for place in (tmp_path, tmp_path / "none", tmp_path / "corpus.json"):
        assert not is_corpus(place)
        with pytest.raises(DataFormatError, match="is no corpus"):
            open_corpus(place)


def test_another_version_and_an_unfinished_one_are_refused(corpus: Corpus):
    path = corpus.path / "corpus.json"
    document = json.loads(path.read_text())
    path.write_text(json.dumps({**document, "version": 99}))
    assert is_corpus(corpus.path)
    with pytest.raises(DataFormatError, match="version 99"):
        open_corpus(corpus.path)
    path.rename(corpus.path / "ingest.json")
    assert is_corpus(corpus.path)
    with pytest.raises(DataFormatError, match="unfinished"):
        open_corpus(corpus.path)


def changed_document(corpus: Corpus, change: dict[str, Any]) -> None:
    """Write another first partition into ``corpus.json``."""
    path = corpus.path / "corpus.json"
    document = json.loads(path.read_text())
    document["partitions"][0] |= change
    path.write_text(json.dumps(document))


@pytest.mark.parametrize(
    "change",
    [
        {"name": "../../../escaped"},
        {"name": "0001"},
        {"name": "0000/x"},
        {"files": [1]},
        {"files": []},
        {"files": "rows/partition=0000/0000.parquet"},
        {"files": ["rows/partition=0001/0000.parquet"]},
        {"files": ["rows/partition=0000/../../x.parquet"]},
        {"files": ["/etc/passwd"]},
        {"rows": "x"},
        {"rows": 1.5},
        {"trips": True},
        {"trips": -1},
        {"digest": None},
        {"other": 1},
    ],
    ids=str,
)
def test_a_list_of_partitions_that_no_ingest_writes_is_refused(corpus: Corpus, change: dict[str, Any]):
    changed_document(corpus, change)
    with pytest.raises(DataFormatError, match=r"corpus\.json: is damaged"):
        open_corpus(corpus.path)


@pytest.mark.parametrize("partitions", ["absent", None, [], {}, [1], [{}]], ids=str)
def test_a_document_without_a_list_of_partitions_is_refused(corpus: Corpus, partitions: object):
    path = corpus.path / "corpus.json"
    document = json.loads(path.read_text())
    del document["partitions"]
    path.write_text(
        json.dumps(document if partitions == "absent" else {**document, "partitions": partitions})
    )
    with pytest.raises(DataFormatError, match=r"corpus\.json: is damaged"):
        open_corpus(corpus.path)


def test_brackets_in_brackets_are_no_corpus(tmp_path: Path):
    (tmp_path / "corpus.json").write_text("[" * 200_000)
    assert not is_corpus(tmp_path)


@pytest.mark.parametrize("column", ["clock_s", "samples", "skipped"])
@pytest.mark.parametrize("retyped", [False, True])
def test_a_catalogue_of_other_columns_is_named(corpus: Corpus, column: str, retyped: bool):
    path = corpus.path / "catalogue.parquet"
    table = pq.read_table(path)
    at = table.schema.get_field_index(column)
    words = pa.array(["x"] * table.num_rows)
    pq.write_table(table.set_column(at, column, words) if retyped else table.drop_columns([column]), path)
    with pytest.raises(DataFormatError, match=rf"catalogue\.parquet: has no column {column} of type"):
        all_trips(corpus)


def test_samples_without_a_column_are_named(corpus: Corpus):
    path = corpus.path / corpus.partitions[0].files[0]
    pq.write_table(pq.ParquetFile(path).read().drop_columns(["east_m"]), path)
    with pytest.raises(DataFormatError, match=r"0000\.parquet: has no column east_m of type double"):
        all_trips(corpus)


def test_a_missing_file_is_told_when_it_is_opened(corpus: Corpus):
    (corpus.path / corpus.partitions[1].files[0]).unlink()
    with pytest.raises(DataFormatError, match=r"lacks its file rows/partition=0001/0000\.parquet"):
        open_corpus(corpus.path)


@pytest.mark.parametrize("at", [0.2, 0.5])
def test_damaged_samples_end_in_an_error(corpus: Corpus, at: float):
    path = corpus.path / corpus.partitions[0].files[0]
    octets = bytearray(path.read_bytes())
    middle = int(len(octets) * at)
    octets[middle : middle + 8] = b"\xff" * 8
    path.write_bytes(octets)
    with pytest.raises(DataFormatError, match=r"0000\.parquet: cannot be read"):
        all_trips(corpus)


def test_files_of_another_partition_are_noticed(corpus: Corpus):
    first, second = (corpus.path / one.files[0] for one in corpus.partitions)
    first.write_bytes(second.read_bytes())
    if corpus.partitions[0].rows > corpus.partitions[1].rows:
        with pytest.raises(DataFormatError, match="fewer rows"):
            all_trips(corpus)


def test_its_rows_are_a_parquet_table_of_trips(corpus: Corpus):
    """What the parquet reader makes of the rows alone is each trip with its samples."""
    alone = {trip.trip_id: trip for trip in read_trips(corpus.path / "rows")}
    for trip in all_trips(corpus):
        assert np.array_equal(alone[trip.trip_id].position_m, trip.position_m)
        assert alone[trip.trip_id].start_unix_s == trip.start_unix_s


def made_trips(lengths: list[int]) -> Iterator[tuple[dict[str, Any], Any]]:
    rng = np.random.default_rng(0)
    noise = rng.random(max(lengths))
    for number, length in enumerate(lengths):
        row = dict.fromkeys(
            ("origin_latitude_deg", "origin_longitude_deg", "origin_altitude_m", "start_unix_s"), 1.0
        )
        columns = [pa.array(noise[:length]) for _ in SAMPLED]
        yield {**row, "trip": f"made/{number:03d}"}, pa.record_batch(columns, schema=SAMPLES)


def test_files_and_row_groups_stay_within_their_bounds(tmp_path: Path):
    lengths = [1_700_000, 3000, 260_000, *[90_000] * 12]
    names = write_rows(tmp_path, made_trips(lengths))
    groups: list[int] = []
    rows_of: dict[str, set[str]] = {}
    for name in names:
        assert (tmp_path / name).stat().st_size <= FILE_BYTES
        with pq.ParquetFile(tmp_path / name) as file:
            for group in range(file.num_row_groups):
                groups.append(file.metadata.row_group(group).num_rows)
                for trip in set(file.read_row_group(group, columns=["trip"])["trip"].to_pylist()):
                    rows_of.setdefault(trip, set()).add(f"{name}/{group}")
    assert sum(groups) == sum(lengths)
    assert all(GROUP_ROWS <= rows <= MOST_GROUP_ROWS for rows in groups[:-1])
    assert len(names) > 1
    assert len(rows_of["made/000"]) == 3
    assert all(len(places) == 1 for trip, places in rows_of.items() if trip != "made/000")


def test_a_long_name_of_many_rows_is_written_as_text(tmp_path: Path):
    """5,000 octets for every one of 600,000 rows are more than a column of text holds."""
    rows, name = 600_000, "n" * 5000
    ((row, _),) = made_trips([1])
    samples = pa.record_batch([pa.array(np.zeros(rows))] * len(SAMPLED), schema=SAMPLES)
    (file,) = write_rows(
        tmp_path, [({**row, "trip": name}, samples), ({**row, "trip": "short"}, samples[:9])]
    )
    with pq.ParquetFile(tmp_path / file) as written:
        assert written.metadata.num_rows == rows + 9
        assert written.schema_arrow.field("trip").type == pa.string()
        last = written.read_row_group(written.num_row_groups - 1, columns=["trip"])["trip"]
        assert last.slice(len(last) - 9).to_pylist() == ["short"] * 9
