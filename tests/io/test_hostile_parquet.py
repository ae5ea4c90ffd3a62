"""Parquet files made to fill the memory end in an error, and large row groups do not."""

import subprocess
import sys

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.io import parquet_guard
from modelcast.io.arrow_trips import ArrowTable
from modelcast.io.registry import get_reader
from modelcast.io.table_trips import table_trips

_MOST_ADDRESSES = 6 * 2**30
"""Threads and allocators reserve about 2 GiB of addresses; ten million rows held would take 5 more."""

_READ_ALL = """
import resource, sys
from modelcast.core.exceptions import DataFormatError
from modelcast.io.parquet import ParquetReader
resource.setrlimit(resource.RLIMIT_AS, (int(sys.argv[1]),) * 2)
for path in sys.argv[2:]:
    try:
        print(len(list(ParquetReader().read(path))), "trips")
    except DataFormatError as error:
        print(error.problem)
status = dict(line.split(":", 1) for line in open("/proc/self/status"))
print(status["VmHWM"].split()[0])  # ru_maxrss begins with what the parent had
"""
_MOST_RESIDENT_KIB = 2**20


def track(rows: int) -> dict[str, np.ndarray]:
    t_s = 0.1 * np.arange(rows)
    return {"t_s": t_s, "east_m": 10 * t_s, "north_m": 0 * t_s}


def read(path):
    return list(get_reader("parquet").read(str(path)))


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="limits of a process as Linux has them")
def test_crafted_files_end_in_an_error_within_a_gibibyte(tmp_path):
    equal = pa.table({name: np.zeros(10**6) for name in ("t_s", "east_m", "north_m")})
    named = equal.append_column("vehicle", pa.array(["a"] * 10**6).dictionary_encode())
    long = pa.array(["x" * 2 * 10**7])
    repeated = pa.DictionaryArray.from_arrays(pa.array(np.zeros(10**5, np.int32)), long)
    files = {
        "equal": (pa.concat_tables([equal] * 10), {}),
        "named": (pa.concat_tables([named] * 10), {}),
        "long": (
            pa.table({**track(10**5), "vehicle": repeated}),
            {"dictionary_pagesize_limit": 2**30, "store_schema": False},
        ),
    }
    for name, (table, options) in files.items():
        pq.write_table(table, tmp_path / name, compression="zstd", row_group_size=10**8, **options)
        assert (tmp_path / name).stat().st_size < 2 * 10**6
    done = subprocess.run(  # noqa: S603 - our own interpreter
        [sys.executable, "-c", _READ_ALL, str(_MOST_ADDRESSES), *(str(tmp_path / name) for name in files)],
        capture_output=True, text=True, check=True, timeout=120,
    )  # fmt: skip
    *said, resident_kib = done.stdout.splitlines()
    assert "equal/vehicle has over 3,145,728 rows" in said[0]
    assert "named/a has over 3,145,728 rows" in said[1]
    assert "vehicle has a text of over 1024 octets" in said[2]
    assert int(resident_kib) < _MOST_RESIDENT_KIB


@pytest.mark.parametrize("version", ["1.0", "2.0"])
@pytest.mark.parametrize("compression", ["none", "snappy", "zstd"])
@pytest.mark.parametrize("dictionary", [False, True])
def test_the_heads_of_pages_are_walked_to_the_end_of_a_column(tmp_path, version, compression, dictionary):
    path = tmp_path / "t.parquet"
    names = pa.array([f"vehicle {at // 1000} {'x' * (at % 7)}" for at in range(20_000)])
    table = pa.table({**track(20_000), "vehicle": names})
    pq.write_table(
        table, path, compression=compression, data_page_version=version, use_dictionary=dictionary,
        data_page_size=4096, row_group_size=7000, write_page_checksum=True,
    )  # fmt: skip
    metadata = pq.read_metadata(path)
    with path.open("rb") as file:
        for group in range(metadata.num_row_groups):
            for at in range(metadata.num_columns):
                chunk = metadata.row_group(group).column(at)
                octets, place = 0, chunk.dictionary_page_offset or chunk.data_page_offset
                end = place + chunk.total_compressed_size
                while place < end:
                    page, head = parquet_guard._page_head("t", file, place)
                    octets += head + page[(2,)]
                    place += head + page[(3,)]
                assert (place, octets) == (end, chunk.total_uncompressed_size)


@pytest.mark.parametrize(
    ("limit", "value", "problem"),
    [
        ("MOST_PAGE_BYTES", 100_000, "unpacks to pages of 0 MiB in row group 0"),
        ("MOST_COLUMNS", 2, "has 3 columns, more than 2"),
        ("MOST_FOOTER_BYTES", 50, "has a footer of"),
    ],
)
def test_more_than_a_table_of_trips_needs_is_refused(tmp_path, monkeypatch, limit, value, problem):
    path = tmp_path / "t.parquet"
    pq.write_table(pa.table(track(10_000)), path, use_dictionary=False)
    (trip,) = read(path)
    assert len(trip) == 10_000
    monkeypatch.setattr(parquet_guard, limit, value)
    with pytest.raises(DataFormatError, match=problem):
        read(path)


@pytest.mark.parametrize("octets", [b"PAR1", b"PAR1PAR1", b"PAR1\xff\xff\xff\x00PAR1"])
def test_a_file_without_a_footer_is_an_error(tmp_path, octets):
    path = tmp_path / "t.parquet"
    path.write_bytes(octets)
    with pytest.raises(DataFormatError, match="is not readable as Parquet"):
        read(path)


def test_vehicles_told_by_values_without_a_fixed_size_are_refused(tmp_path):
    path = tmp_path / "t.parquet"
    pq.write_table(pa.table({**track(3), "vehicle": pa.array([["a"], ["b"], ["c"]])}), path)
    with pytest.raises(DataFormatError, match=r"'vehicle' holds list<.*>, not names"):
        read(path)


def test_a_table_of_one_trip_that_is_too_long_is_refused_unread():
    schema = pa.schema([(name, pa.float64()) for name in ("t", "x", "y")])
    asked = []
    table = ArrowTable("long.parquet", None, schema, 10**9, lambda names: asked.append(names) or [])
    with pytest.raises(DataFormatError, match=r"the trip long/vehicle has over [\d,]+ rows"):
        list(table_trips(table, "parquet", lambda *_: None))
    assert not asked


@pytest.mark.slow
def test_one_large_row_group_in_any_order_gives_the_trips_of_many_small_ones(tmp_path):
    vehicles, rows = 20, 500
    whole = {name: np.tile(column, vehicles) for name, column in track(rows).items()}
    whole["vehicle"] = np.repeat(np.arange(vehicles), rows).astype(str)
    order = np.argsort(whole["t_s"], kind="stable")
    table = pa.table({name: column[order] for name, column in whole.items()})
    pq.write_table(table, tmp_path / "t.parquet", row_group_size=10**6)
    expected = {trip.trip_id: trip for trip in read(tmp_path / "t.parquet")}
    pq.write_table(table, tmp_path / "t.parquet", row_group_size=317)
    few = {
        trip.trip_id: trip
        for trip in get_reader("parquet").within(50_000).read(str(tmp_path / "t.parquet"))
    }  # fmt: skip
    assert len(expected) == vehicles
    assert few.keys() == expected.keys()
    for name, trip in few.items():
        assert trip.t_s.tobytes() == expected[name].t_s.tobytes()
        assert trip.position_m.tobytes() == expected[name].position_m.tobytes()
        assert trip.clock_s == expected[name].clock_s
        assert trip.reading == expected[name].reading
