"""Finding readers: names, folders, several paths, other packages' readers, cheap imports."""

import subprocess
import sys

import pytest

from modelcast.core.exceptions import ConfigError, DataFormatError
from modelcast.io.registry import get_reader, reader_names
from modelcast.io.trips import read_trips


def test_unknown_format_names_the_known_ones(made):
    with pytest.raises(ConfigError, match=r"Unknown format 'kml'\. Known: .*spmd-bsm, .*csv\."):
        list(read_trips(made.valid("csv"), "kml"))


def test_file_that_no_reader_knows_is_an_error_with_a_remedy(made):
    path = made.write("notes.txt", "nothing\n")
    with pytest.raises(DataFormatError, match=r"notes\.txt: no reader knows this file\. .* by --format: "):
        list(read_trips(path))


def test_several_paths_and_formats_come_in_the_order_given(made):
    trips = read_trips([made.valid("nyc-cvpd"), made.valid("csv")])
    assert [trip.source for trip in trips] == ["nyc-cvpd", "csv"]


def test_folder_yields_what_is_known_and_reports_the_rest(made):
    (made.folder / "deep").mkdir()
    made.valid("csv").rename(made.folder / "deep" / "a.csv")
    made.valid("comma2k19")
    made.write("notes.txt", "nothing\n")
    told = {}
    trips = list(read_trips(made.folder, on_skipped=told.__setitem__))
    assert [trip.trip_id for trip in trips] == ["a/vehicle", "drive/40"]
    assert list(told.values()) == ["no reader knows this file"]


def test_folder_with_a_format_yields_that_one_only(made):
    made.valid("csv")
    made.valid("nmea")
    told = {}
    trips = list(read_trips(made.folder, "nmea", on_skipped=told.__setitem__))
    assert [trip.source for trip in trips] == ["nmea"]
    assert list(told.values()) == ["is csv, not nmea"]


def test_folder_without_trips_is_an_error(made):
    made.write("notes.txt", "nothing\n")
    with pytest.raises(DataFormatError, match="no file in this folder is a trip"):
        list(read_trips(made.folder))


def test_same_stem_in_two_folders_keeps_identifiers_apart(made):
    content = made.valid("csv").read_bytes()
    paths = []
    for name in ("one", "two"):
        (made.folder / name).mkdir()
        paths.append(made.write(f"{name}/t.csv", content))
    assert [trip.trip_id for trip in read_trips(paths)] == ["t/vehicle", "t/vehicle#2"]


def test_same_file_twice_is_read_once(made):
    path = made.valid("csv")
    assert len(list(read_trips([path, path]))) == 1


def test_reader_of_another_package_is_found_by_its_entry_point(made, other_package):
    other_package("mine", {"modelcast.readers": {"mine": "modelcast.io.csv:CsvReader"}})
    assert reader_names()[0] == "mine"
    assert len(list(read_trips(made.valid("csv"), "mine"))) == 1


def test_entry_point_that_is_no_reader_is_an_error(other_package):
    other_package("mine", {"modelcast.readers": {"mine": "builtins:dict"}})
    with pytest.raises(ConfigError, match="'mine' is no AbstractTripReader"):
        get_reader("mine")


def test_importing_the_registry_loads_no_format():
    code = "import sys, modelcast.io.trips; print(*[m for m in ('polars', 'pyarrow') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)  # noqa: S603
    assert done.stdout.strip() == ""
