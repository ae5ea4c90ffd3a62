"""CSV and Parquet: names and maps of columns, vehicles, errors, and round trips through the writers."""

import numpy as np
import polars as pl
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from modelcast.core.exceptions import ConfigError, DataFormatError
from modelcast.core.geodesy import Origin
from modelcast.core.trajectory import build_trajectory
from modelcast.io.trips import read_trips
from modelcast.io.write_trips import write_csv, write_parquet

WRITERS = {"csv": write_csv, "parquet": write_parquet}
both = pytest.mark.parametrize("kind", WRITERS)


def write(made, kind, columns):
    frame = pl.DataFrame(columns)
    path = made.folder / f"t.{kind}"
    frame.write_csv(path) if kind == "csv" else frame.write_parquet(path)
    return path


@both
def test_map_names_columns_and_units(made, kind):
    path = write(
        made,
        kind,
        {"ms": [0, 100, 200], "a": [0.0, 1, 2], "b": [0.0, 0, 0], "v": [36.0] * 3, "h": [90.0] * 3},
    )
    columns = {"t_ms": "ms", "east": "a", "north": "b", "speed_kmh": "v", "heading_deg": "h"}
    (trip,) = read_trips(path, kind, columns=columns)
    assert trip.trip_id == "t/vehicle"
    assert trip.t_s == pytest.approx([0, 0.1, 0.2])
    assert trip.speed_mps == pytest.approx(10)
    assert trip.heading_rad == pytest.approx(np.pi / 2)


@both
def test_latitudes_become_a_local_plane_shared_by_vehicles(made, kind):
    columns = {"time": [0.0, 0.0, 0.1, 0.1], "lat": [42.0, 42.001] * 2, "lon": [-83.0] * 4}
    path = write(made, kind, columns | {"vehicle": list("abab")})
    first, second = read_trips(path)
    assert (first.trip_id, second.trip_id) == ("t/a", "t/b")
    assert first.origin == second.origin == Origin(42.0, -83.0)
    assert second.position_m[0] == pytest.approx([0, 111.07], abs=0.01)
    assert first.up_m is None


@both
def test_missing_cells_are_skipped_or_held(made, kind):
    x = [None, *map(float, range(11))]
    speed = [None if at == 6 else float(at) for at in range(12)]
    path = write(made, kind, {"t": [at / 10 for at in range(12)], "x": x, "y": [0.0] * 12, "speed": speed})
    (trip,) = read_trips(path)
    assert dict(trip.reading.skipped) == {"position blank": 1}
    assert dict(trip.reading.repaired) == {"speed missing, last value held": 1}
    assert trip.speed_mps[5] == 5.0


@both
@pytest.mark.parametrize("bad", [[0.0, 0.2, 0.1], [0.0, 0.1, 0.1]])
def test_time_that_does_not_increase_is_an_error_with_its_row(made, kind, bad):
    path = write(made, kind, {"t": bad, "x": [0.0] * 3, "y": [0.0] * 3})
    row = 4 if kind == "csv" else 3
    with pytest.raises(
        DataFormatError, match=rf"row {row}: time of t/vehicle does not increase: 0\.1 after .* Sort"
    ):
        list(read_trips(path))


@both
def test_nan_is_an_error_with_its_row(made, kind):
    path = write(made, kind, {"t": [0.0, 0.1], "x": [0.0, float("nan")], "y": [0.0, 0.0]})
    with pytest.raises(DataFormatError, match=r"row \d: x is '?[nN]a[nN]'?, not a finite number"):
        list(read_trips(path))


@both
def test_text_in_a_number_column_is_an_error(made, kind):
    path = write(made, kind, {"t": ["0", "soon"], "x": ["0", "0"], "y": ["0", "0"]})
    with pytest.raises(
        DataFormatError, match="'soon', not a finite number" if kind == "csv" else "'t' holds large_string"
    ):
        list(read_trips(path))


@both
def test_latitude_beyond_the_pole_is_an_error(made, kind):
    path = write(made, kind, {"t": [0.0], "lat": [91.0], "lon": [0.0]})
    with pytest.raises(DataFormatError, match=r"latitude_deg is 91\.0, beyond 90"):
        list(read_trips(path))


@both
def test_unknown_names_are_an_error_that_shows_a_map(made, kind):
    path = write(made, kind, {"a": [0.0], "b": [1.0]})
    with pytest.raises(
        DataFormatError, match=r"among the columns a, b\. Give a column map, for example t=time,east=x"
    ):
        list(read_trips(path, kind))


@both
@pytest.mark.parametrize(
    ("columns", "error", "message"),
    [
        ({"t": "t", "east": "x", "north": "q"}, DataFormatError, "has no column 'q' for north"),
        ({"t": "t", "heading": "x"}, ConfigError, "Say heading_rad or heading_deg"),
        ({"t": "t", "east": "x"}, ConfigError, "needs t, and east with north or lat with lon"),
        ({"t": "t", "t_ms": "t", "east": "x", "north": "y"}, ConfigError, "names a quantity twice"),
    ],
)
def test_map_that_does_not_fit_is_an_error(made, kind, columns, error, message):
    path = write(made, kind, {"t": [0.0], "x": [1.0], "y": [1.0]})
    with pytest.raises(error, match=message):
        list(read_trips(path, kind, columns=columns))


def test_map_for_a_format_with_fixed_columns_is_an_error(made):
    with pytest.raises(ConfigError, match="The format openacc has fixed columns"):
        list(read_trips(made.valid("openacc"), columns={"t": "Time"}))


def test_map_makes_a_csv_of_unknown_names(made):
    path = write(made, "csv", {"when": [0.0, 0.1], "e": [0.0, 1.0], "n": [0.0, 0.0]})
    (trip,) = read_trips(path, columns={"t": "when", "east": "e", "north": "n"})
    assert trip.source == "csv"


def test_csv_padding_quotes_crlf_and_mark_do_not_matter(made):
    content = b'\xef\xbb\xbf"t", x ,y,vehicle\r\n0, 0 ,1E0,"a"\r\n\r\n0.1, 1 ,1, a\r\n'
    (trip,) = read_trips(made.write("t.csv", content))
    assert (trip.trip_id, len(trip), trip.position_m[0].tolist()) == ("t/a", 2, [0.0, 1.0])


def test_csv_cut_last_line_is_counted(made):
    (trip,) = read_trips(made.write("t.csv", "t,x,y\n0,0,0\n1,1,1\n2,2"))
    assert (trip.reading.rows, len(trip)) == (3, 2)
    assert dict(trip.reading.skipped) == {"partial last line": 1}


def test_csv_blank_vehicle_is_an_error(made):
    with pytest.raises(DataFormatError, match=r"row 3: the vehicle \(vehicle\) is blank"):
        list(read_trips(made.write("t.csv", "t,x,y,vehicle\n0,0,0,a\n1,1,1,\n")))


def test_vehicle_without_positions_is_reported(made):
    told = {}
    trips = read_trips(made.write("t.csv", "t,x,y,vehicle\n0,0,0,a\n0,,,b\n"), on_skipped=told.__setitem__)
    assert [trip.trip_id for trip in trips] == ["t/a"]
    assert told == {"t/b": "no usable row: 1 position blank"}


def test_comma_in_an_identifier_is_refused_by_the_csv_writer(made):
    trip = build_trajectory("a,b/1", np.array([0.0]), np.zeros((1, 2)))
    with pytest.raises(ValueError, match="use Parquet"):
        write_csv([trip], made.folder / "t.csv")


numbers = st.floats(-1e6, 1e6, allow_subnormal=False)


@st.composite
def trips(draw, name):
    count = draw(st.integers(1, 8))
    column = st.lists(numbers, min_size=count, max_size=count).map(np.array)
    motion, turning = (
        st.lists(st.floats(-most, most), min_size=count, max_size=count).map(np.array)
        for most in (160.0, 5.7)
    )  # what is larger no vehicle has, and readers take as missing
    steps = draw(st.lists(st.sampled_from([0.1, 0.1, 0.1, 0.11, 1.0]), min_size=count, max_size=count))
    heading = st.lists(st.floats(-np.pi, 3.14), min_size=count, max_size=count).map(np.array)
    return build_trajectory(
        name,
        np.cumsum(steps),
        np.stack([draw(column), draw(column)], axis=1),
        speed_mps=draw(st.none() | motion),
        heading_rad=draw(st.none() | heading),
        acceleration_mps2=draw(st.none() | motion),
        yaw_rate_radps=draw(st.none() | turning),
        up_m=draw(st.none() | column),
        origin=draw(st.none() | st.builds(Origin, st.floats(-90, 90), st.floats(-180, 180), numbers)),
        start_unix_s=draw(st.none() | st.floats(0, 2e9)),
    )


@both
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(first=trips("made/1"), second=trips("made/2"))
def test_what_is_written_reads_back_to_the_bit(session_made, kind, first, second):
    path = session_made.folder / f"round.{kind}"
    WRITERS[kind]([first, second], path)
    for before, after in zip((first, second), read_trips(path), strict=True):
        assert before.trip_id == after.trip_id
        assert before.columns().keys() == after.columns().keys()
        assert before.position_m.tobytes() == after.position_m.tobytes()
        for name in before.columns():
            assert np.array_equal(getattr(before, name), getattr(after, name))
        assert before.segments.tolist() == after.segments.tolist()
        assert (before.origin, before.start_unix_s, before.dt_s) == (
            after.origin,
            after.start_unix_s,
            after.dt_s,
        )
