"""What `read_trips` returns: a list that is read when it is asked for, of files and data frames alike."""

from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from modelcast.core.exceptions import ConfigError, DataFormatError
from modelcast.io import trips as trips_module
from modelcast.io.csv import CsvReader
from modelcast.io.trips import Trips, read_trips
from modelcast.trips.trajectory import Trajectory

NAMES = ("a", "b", "c")


def table(names: tuple[str, ...] = NAMES, rows: int = 30) -> pl.DataFrame:
    t_s = np.arange(rows) / 10
    return pl.concat(
        pl.DataFrame({"t_s": t_s, "east_m": t_s * at, "north_m": t_s - at, "vehicle": name})
        for at, name in enumerate(names)
    )


def pandas_frame(frame: pl.DataFrame) -> Any:
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    return pandas.DataFrame(frame.to_dict(as_series=False))


class Interchange:
    """A frame of a library that only knows the older interchange."""

    def __init__(self, frame: pl.DataFrame) -> None:
        self._frame = frame.to_arrow()

    def __dataframe__(self, **options: Any) -> Any:
        return self._frame.__dataframe__(**options)


def same(one: Trajectory, other: Trajectory) -> bool:
    columns = other.columns()
    return one.columns().keys() == columns.keys() and all(
        np.array_equal(values, columns[name]) for name, values in one.columns().items()
    )


@pytest.fixture(name="folder")
def _folder(tmp_path: Path) -> Path:
    for name in NAMES:
        table((name, f"{name}2")).write_csv(tmp_path / f"{name}.csv")
    return tmp_path


@pytest.fixture(name="reads")
def _reads(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the files that were read."""
    found: list[str] = []
    read = CsvReader.read

    def counted(self: CsvReader, path: str, *rest: Any) -> Any:
        found.append(Path(path).name)
        return read(self, path, *rest)

    monkeypatch.setattr(CsvReader, "read", counted)
    return found


EXPECTED = ["a/a", "a/a2", "b/b", "b/b2", "c/c", "c/c2"]


@pytest.fixture(params=[trips_module.MOST_HELD_BYTES, 0], ids=["kept", "read again"])
def either(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """All is the same whether trips are kept or read again."""
    monkeypatch.setattr(trips_module, "MOST_HELD_BYTES", request.param)


@pytest.mark.usefixtures("either")
def test_reading_twice_gives_the_same_trips(folder: Path) -> None:
    trips = read_trips(folder)
    first, second = [*iter(trips)], [*iter(trips)]
    assert [trip.trip_id for trip in first] == EXPECTED
    assert all(same(one, other) for one, other in zip(first, second, strict=True))


@pytest.mark.usefixtures("either")
@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(at=st.integers(-6, 5), start=st.none() | st.integers(-8, 8), step=st.sampled_from([-2, -1, 1, 3]))
def test_places_and_slices_are_those_of_a_list(at: int, start: int | None, step: int) -> None:
    names = tuple("abcdef")
    expected = [f"frame/{name}" for name in names]
    trips = read_trips(table(names))
    assert trips[at].trip_id == expected[at]
    assert [trip.trip_id for trip in trips[start::step]] == expected[start::step]
    assert len(trips) == 6


@pytest.mark.parametrize("at", [6, -7])
@pytest.mark.usefixtures("either")
def test_beyond_the_end_is_an_index_error(folder: Path, at: int) -> None:
    with pytest.raises(IndexError, match=f"no trip {at} among 6"):
        read_trips(folder)[at]


@pytest.mark.usefixtures("either")
def test_what_shares_a_name_gets_a_number_wherever_it_is_asked_for() -> None:
    trips = read_trips([table(), table()])
    assert [trip.trip_id for trip in trips][3:] == ["frame/a#2", "frame/b#2", "frame/c#2"]
    assert trips[4].trip_id == "frame/b#2"
    assert np.array_equal(trips[4].position_m, trips[1].position_m)


@pytest.mark.usefixtures("either")
def test_what_gave_no_trip_is_told_once_however_often_it_is_read(folder: Path) -> None:
    (folder / "notes.md").write_text("no trip")
    told: list[str] = []
    trips = read_trips(folder, on_skipped=lambda what, _reason: told.append(what))
    assert (trips[0].trip_id, told) == ("a/a", [])
    assert len(trips) == 6
    assert len([*iter(trips)]) == 6
    assert trips[5].trip_id == "c/c2"
    assert told == [str(folder / "notes.md")]
    assert list(trips.skipped) == told


@pytest.mark.usefixtures("either")
def test_vehicles_of_one_name_that_gave_no_trip_are_all_kept() -> None:
    """Two frames with the same vehicle, which is nowhere: neither is lost to the other."""
    nowhere = pl.when(pl.col("vehicle") != "b").then(pl.col("east_m"))
    frames = [table(("a", "b")).with_columns(east_m=nowhere)] * 2
    told: list[str] = []
    trips = read_trips(frames, on_skipped=lambda what, _reason: told.append(what))
    assert len(trips) == 2
    assert [trip.trip_id for trip in trips] == ["frame/a", "frame/a#2"]
    assert told == ["frame/b", "frame/b"]
    assert list(trips.skipped) == ["frame/b", "frame/b#2"]


def test_nothing_is_read_before_it_is_asked_for_and_no_further(folder: Path, reads: list[str]) -> None:
    trips = read_trips(folder)
    assert (repr(trips), reads) == ("Trips(1 source, not read yet)", [])
    assert trips[2].trip_id == "b/b"
    assert reads == ["a.csv", "b.csv"]
    assert len(trips) == 6
    assert repr(trips) == "Trips(1 source, 6 trips)"
    reads.clear()
    assert [trip.trip_id for trip in trips] == EXPECTED  # kept
    assert reads == []


def test_a_list_of_what_is_kept_reads_each_file_once(folder: Path, reads: list[str]) -> None:
    assert [trip.trip_id for trip in list(read_trips(folder))] == EXPECTED
    assert reads == ["a.csv", "b.csv", "c.csv"]


def test_of_a_large_folder_one_file_is_read_for_one_trip(
    folder: Path, reads: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trips_module, "MOST_HELD_BYTES", 1000)
    trips = read_trips(folder)
    assert len(trips) == 6
    reads.clear()
    assert trips[3].trip_id == "b/b2"
    assert reads == ["b.csv"]


def test_a_trip_that_is_no_longer_there_is_an_index_error(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trips_module, "MOST_HELD_BYTES", 0)
    trips = read_trips(folder)
    assert len(trips) == 6
    table(("b",)).write_csv(folder / "b.csv")
    with pytest.raises(IndexError, match="b/b2 is not in its file any more"):
        trips[3]


def test_a_wrong_file_is_an_error_at_every_reading_and_leaves_nothing_behind(folder: Path) -> None:
    (folder / "b.csv").write_text("t_s,east_m,north_m\n0,oops,0\n")
    trips = read_trips(folder)
    for _ in range(2):
        with pytest.raises(DataFormatError, match=r"b\.csv, row 2"):
            len(trips)
    assert trips[1].trip_id == "a/a2"
    assert repr(trips) == "Trips(1 source, not read yet)"


def test_the_summary_counts_rows_and_the_notebook_shows_it(folder: Path) -> None:
    (folder / "a.csv").write_text((folder / "a.csv").read_text().replace("\n0.1,", "\n,", 1))
    trips = read_trips(folder)
    shown = trips._repr_html_()
    summary = trips.summary()
    assert summary.columns[:4] == ["trip", "source", "duration_s", "samples"]
    assert summary["trip"].to_list() == EXPECTED
    assert summary.row(0, named=True)["skipped"] == 1
    assert summary["rows"].to_list() == 6 * [30]
    assert all(name in shown for name in EXPECTED)
    assert "Trips(1 source, 6 trips)" in shown


def test_a_notebook_reads_no_more_of_a_large_folder_than_it_shows(
    folder: Path, reads: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trips_module, "_MOST_SHOWN", 2)
    shown = read_trips(folder)._repr_html_()
    assert "the first 2" in shown
    assert "a/a2" in shown
    assert "b/b" not in shown
    assert reads == ["a.csv", "b.csv"]


@pytest.mark.parametrize(
    "frame",
    [
        table,
        lambda: table().to_arrow(),
        lambda: table().with_columns(pl.col("vehicle").cast(pl.Categorical)),
        lambda: table().with_columns(pl.col("t_s").cast(pl.Float32).cast(pl.Float64).round(1)),
        lambda: pandas_frame(table()),
        lambda: Interchange(table()),
    ],
    ids=["polars", "pyarrow", "categories", "rounded", "pandas", "interchange"],
)
def test_a_frame_gives_the_trips_of_the_same_parquet_file(frame: Any, tmp_path: Path) -> None:
    path = tmp_path / "frame.parquet"
    table().write_parquet(path)
    expected = [*iter(read_trips(path))]
    found = [*iter(read_trips(frame()))]
    assert [trip.trip_id for trip in found] == [trip.trip_id for trip in expected]
    assert all(same(one, other) for one, other in zip(found, expected, strict=True))
    assert {trip.source for trip in found} == {"frame"}


def test_a_frame_takes_the_column_map_of_files_and_units_with_it() -> None:
    frame = table().rename({"t_s": "clock", "east_m": "px", "north_m": "py", "vehicle": "who"})
    frame = frame.with_columns(kmh=pl.lit(36.0))
    columns = {"t": "clock", "east": "px", "north": "py", "vehicle": "who", "speed_kmh": "kmh"}
    found = read_trips(frame, columns=columns)
    assert [trip.trip_id for trip in found] == ["frame/a", "frame/b", "frame/c"]
    speed_mps = found[0].speed_mps
    assert speed_mps is not None
    assert speed_mps == pytest.approx(10.0)


def test_missing_values_of_a_frame_are_counted_as_those_of_files() -> None:
    frame = table(("a",)).with_columns(east_m=pl.when(pl.col("t_s") == 1.0).then(None).otherwise("east_m"))
    assert read_trips(frame)[0].reading.skipped == {"position blank": 1}


@pytest.mark.parametrize(
    ("frame", "message"),
    [
        (table().cast({"east_m": pl.String}), "frame: column 'east_m' holds .*string"),
        (table().with_columns(east_m=pl.lit(float("nan"))), "frame, row 1: east_m is nan"),
        (table().drop("east_m"), "frame: no known names of time and position among the columns t_s, north_m"),
        (table().clear(), "frame: no rows"),
        (table().with_columns(vehicle=pl.lit(None, pl.String)), "row 1: the vehicle .* is blank"),
    ],
)
def test_what_is_wrong_with_a_frame_is_told_by_row_and_column(frame: Any, message: str) -> None:
    with pytest.raises(DataFormatError, match=message):
        len(read_trips(frame))


def test_a_format_goes_with_files_alone() -> None:
    with pytest.raises(ConfigError, match="csv is that of a file: leave it out"):
        read_trips(table(), "csv")


def test_what_is_no_source_is_refused_at_once() -> None:
    with pytest.raises(TypeError, match="a path or a data frame, not int"):
        Trips([3])


def test_files_and_frames_go_together_in_the_order_given(folder: Path) -> None:
    trips = read_trips([folder / "c.csv", table(("x",)), folder / "a.csv"])
    assert [trip.trip_id for trip in trips] == ["c/c", "c/c2", "frame/x", "a/a", "a/a2"]
