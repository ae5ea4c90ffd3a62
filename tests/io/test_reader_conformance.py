"""What every reader promises, on a small made file of its format."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from modelcast.core.exceptions import DataFormatError
from modelcast.io.base import AbstractTripReader
from modelcast.io.registry import FORMATS, detect_format, get_reader
from modelcast.io.trips import read_trips

FORMAT_NAMES = tuple(FORMATS)
each_format = pytest.mark.parametrize("name", FORMAT_NAMES)


@each_format
def test_detection_finds_the_format(made, name):
    assert detect_format(made.valid(name)) == name


@each_format
def test_name_is_the_registered_one(name):
    assert get_reader(name).name == name


@each_format
def test_trips_have_unique_ids_and_increasing_float64_columns(made, name):
    trips = list(read_trips(made.valid(name)))
    assert trips
    assert len({trip.trip_id for trip in trips}) == len(trips)
    for trip in trips:
        assert trip.source == name
        assert (np.diff(trip.t_s) > 0).all()
        assert all(column.dtype == np.float64 for column in trip.columns().values())


@each_format
def test_rows_are_samples_and_skipped_rows(made, name):
    for trip in read_trips(made.valid(name)):
        assert not trip.resampled
        assert trip.reading.rows == len(trip) + sum(trip.reading.skipped.values())


@each_format
def test_reads_the_same_twice(made, name):
    path = made.valid(name)
    for first, second in zip(read_trips(path), read_trips(path), strict=True):
        assert first.trip_id == second.trip_id
        for column, other in zip(first.columns().values(), second.columns().values(), strict=True):
            assert column.tobytes() == other.tobytes()


@each_format
def test_missing_file_is_an_error_that_names_it_as_given(name):
    with pytest.raises(DataFormatError, match=r"^no/such\.file: does not exist\. Check the path\.$"):
        list(read_trips("no/such.file", name))


@each_format
def test_empty_file_is_an_error(made, name):
    path = made.write("empty", b"")
    with pytest.raises(DataFormatError, match="empty"):
        list(read_trips(path, name))


PLAIN_TABLES = {("csv", "interaction")}
"""A reader of tables, and a format whose file is a table with names that tell what is in it."""


@each_format
@pytest.mark.parametrize("other", FORMAT_NAMES)
def test_file_of_another_format_is_an_error(made, name, other):
    path = made.valid(other)
    if (name, other) in PLAIN_TABLES:
        assert len(list(read_trips(path, name))) == len(list(read_trips(path, other)))
    elif name != other and path.is_file() and not made.valid(name).is_dir():
        with pytest.raises(DataFormatError):
            list(read_trips(path, name))


edits = st.lists(
    st.tuples(st.sampled_from(["flip", "cut", "insert", "delete"]), st.floats(0, 1), st.binary(max_size=5)),
    min_size=1,
    max_size=5,
)


def damaged(content: bytes, steps: list[tuple[str, float, bytes]]) -> bytes:
    data = bytearray(content)
    for kind, place, extra in steps:
        at = int(place * len(data))
        if kind == "flip":
            data[at : at + len(extra)] = extra
        elif kind == "insert":
            data[at:at] = extra
        elif kind == "delete":
            del data[at : at + 9]
        else:
            del data[at:]
    return bytes(data)


@each_format
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(steps=edits, pick=st.integers(0, 5))
def test_damage_raises_nothing_but_format_errors(session_made, name, steps, pick):
    path = session_made.valid(name)
    files = [path] if path.is_file() else sorted(one for one in path.rglob("*") if one.is_file())
    victim = files[-1 - pick % len(files)]
    victim.write_bytes(damaged(victim.read_bytes(), steps))
    try:
        for trip in read_trips(path, name):
            assert len(trip) > 0
    except DataFormatError as error:
        assert str(session_made.folder) in str(error)  # noqa: PT017 - both outcomes are right


def test_every_reader_is_held_to_the_contract(concrete_classes):
    # That of corpora has no format of its own: tests/corpora/test_reader.py is its contract.
    held = {type(get_reader(name)) for name in (*FORMAT_NAMES, "corpus")}
    assert concrete_classes(AbstractTripReader) == held
