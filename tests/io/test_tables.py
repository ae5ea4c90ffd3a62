"""CSV and Parquet: names and maps of columns, vehicles, errors, and round trips through the writers."""

import re

import numpy as np
import polars as pl
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from modelcast.core.exceptions import ConfigError, DataFormatError
from modelcast.core.geodesy import Origin
from modelcast.io.column_map import example_map
from modelcast.io.trips import read_trips
from modelcast.io.write_trips import write_csv, write_parquet
from modelcast.trips.trajectory import build_trajectory

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


def test_nan_among_typed_numbers_is_an_error_with_its_row(made):
    path = write(made, "parquet", {"t": [0.0, 0.1], "x": [0.0, float("nan")], "y": [0.0, 0.0]})
    with pytest.raises(DataFormatError, match=r"row 2: x is nan, not a finite number"):
        list(read_trips(path))


@pytest.mark.parametrize("word", ["NaN", "nan", "NA", "None", "-", ""])
def test_words_for_no_number_are_blank_in_text(made, word):
    (trip,) = read_trips(made.write("t.csv", f"t,x,y\n0,0,0\n0.1,{word},0\n0.2,2,0\n"))
    assert (len(trip), dict(trip.reading.skipped)) == (2, {"position blank": 1})


@pytest.mark.parametrize("word", ["inf", "-inf", "nil", "1e400"])
def test_other_words_are_an_error(made, word):
    with pytest.raises(DataFormatError, match=f"row 3: x is '{word}', not a finite number"):
        list(read_trips(made.write("t.csv", f"t,x,y\n0,0,0\n0.1,{word},0\n")))


@both
def test_text_in_a_number_column_is_an_error(made, kind):
    path = write(made, kind, {"t": ["0", "soon"], "x": ["0", "0"], "y": ["0", "0"]})
    with pytest.raises(
        DataFormatError, match="'soon', not a finite number" if kind == "csv" else "'x' holds large_string"
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
        DataFormatError,
        match=r"among the columns a, b\. Give a column map, for example --columns 't=\?,east=\?,north=\?'",
    ):
        list(read_trips(path, kind))


@both
@pytest.mark.parametrize(
    ("columns", "error", "message"),
    [
        ({"t": "t", "east": "x", "north": "q"}, DataFormatError, "has no column 'q' for north"),
        ({"t": "t", "heading": "x"}, ConfigError, "Say heading_rad or heading_deg"),
        ({"t": "t", "lat": "x"}, ConfigError, "needs t, and east with north or lat with lon"),
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


@pytest.mark.slow
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


ROWS = [(at / 10, 1.2 * at, 0.5, 12.0) for at in range(12)]
MS_2024 = 1710496800000
"""2024-03-15 10:00:00 UTC."""


def table(separator=",", *, decimal=".", times=None, names=("t", "x", "y", "speed"), end="\n"):
    """Return a table of text; `times` writes the time of a row."""
    lines = [separator.join(names)]
    for at, row in enumerate(ROWS):
        cells = [str(value).replace(".", decimal) for value in row]
        lines.append(separator.join([times(at) if times else cells[0], *cells[1:]]))
    return end.join(lines) + end


def one(path, columns=None):
    (trip,) = read_trips(path, columns=columns)
    return trip


def same(trip):
    """Check that a trip is that of `ROWS`."""
    assert (len(trip), trip.reading.rows, dict(trip.reading.skipped)) == (12, 12, {})
    assert trip.t_s == pytest.approx([row[0] for row in ROWS], abs=1e-6)
    assert trip.position_m[:, 0] == pytest.approx([row[1] for row in ROWS])
    assert trip.speed_mps == pytest.approx(12.0)
    return trip


@pytest.mark.parametrize("separator", [",", ";", "\t", "|", " ", "   ", " \t "])
@pytest.mark.parametrize("decimal", [".", ","])
def test_csv_separator_and_mark_of_decimals_are_found(made, separator, decimal):
    if separator != decimal:
        same(one(made.write("t.csv", table(separator, decimal=decimal))))


@pytest.mark.parametrize(
    "before", ["# made up\n\n# by hand, here\n", "sep=,\n", "\n\n", "\ufeff", "# "], ids=repr
)
def test_csv_lines_before_the_header_are_passed_over(made, before):
    same(one(made.write("t.csv", before + table())))


def test_csv_error_names_the_line_whatever_stands_before_the_header(made):
    with pytest.raises(DataFormatError, match="row 6: x is 'oops'"):
        list(
            read_trips(
                made.write("t.csv", "# a\n\n" + table().replace("1.2,", "oops,", 1).replace("\n", "\n\n", 1))
            )
        )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            table(";", decimal=",") + "1,2;14.4;0,5;12,0\n",
            "decimal points and decimal commas: '14.4' and '0,0'",
        ),
        (table(";").replace("1.2;", "1,234.5;"), "row 3: x is '1,234.5', not a finite number"),
        (table(names=("t", "x", "y", "x")), r"column 'x' occurs more than once \(columns 2, 4\)"),
    ],
)
def test_csv_that_can_be_read_in_two_ways_is_an_error(made, text, message):
    with pytest.raises(DataFormatError, match=message):
        list(read_trips(made.write("t.csv", text)))


def test_csv_without_a_header_is_an_error(made):
    with pytest.raises(DataFormatError, match="row 1: has numbers where the header row should be"):
        list(read_trips(made.write("t.csv", table().partition("\n")[2]), "csv"))


@pytest.mark.parametrize("format_name", [None, "csv"])
def test_unknown_columns_are_an_error_with_a_map_of_their_own_that_works(made, format_name):
    path = made.write("t.csv", table(names=("Clock [s]", "front x", "front y", "velocity")))
    with pytest.raises(DataFormatError) as caught:
        list(read_trips(path, format_name))
    example = str(caught.value).partition("--columns '")[2].partition("'")[0]
    assert example == "t=Clock [s],east=front x,north=front y,speed=velocity"
    same(one(path, columns=dict(part.split("=") for part in example.split(","))))


DATES = {
    "Z": lambda at: f"2024-03-15T10:00:0{at // 10}.{at % 10}00Z",
    "blank, UTC": lambda at: f"2024-03-15 10:00:0{at // 10}.{at % 10} UTC",
    "east": lambda at: f"2024-03-15T11:30:0{at // 10}.{at % 10}+01:30",
    "west": lambda at: f"2024/03/15 05:00:0{at // 10}.{at % 10}00000000-05",
    "no zone": lambda at: f"2024-03-15 10:00:0{at // 10}.{at % 10}",
}


@both
@pytest.mark.parametrize("style", DATES)
def test_dates_and_times_of_day_are_read(made, kind, style):
    path = made.write("t.csv", table(times=DATES[style]))
    if kind == "parquet":
        pl.read_csv(path, schema_overrides={"t": pl.String}).write_parquet(path := made.folder / "t.parquet")
    trip = same(one(path))
    assert trip.start_unix_s == (None if style == "no zone" else MS_2024 / 1000)


@pytest.mark.parametrize("unit", ["ms", "us", "ns"])
@pytest.mark.parametrize("zone", [None, "UTC"])
def test_parquet_time_stamps_tell_their_unit(made, unit, zone):
    factor = {"ms": 1, "us": 1000, "ns": 10**6}[unit]
    stamps = pl.Series("t", [(MS_2024 + 100 * at) * factor for at in range(12)]).cast(pl.Datetime(unit, zone))
    columns = {name: [row[at] for row in ROWS] for at, name in ((1, "x"), (2, "y"), (3, "speed"))}
    trip = same(one(write(made, "parquet", {"t": stamps, **columns})))
    assert trip.start_unix_s == (MS_2024 / 1000 if zone else None)


def test_a_row_with_another_kind_of_date_is_an_error(made):
    rows = table(times=DATES["Z"]).replace("0.500Z", "0.500", 1)
    with pytest.raises(DataFormatError, match=r"row 7: t is '.*0\.500', not a date and time with a zone"):
        list(read_trips(made.write("t.csv", rows)))


@both
@pytest.mark.parametrize(("factor", "word"), [(1, "milli"), (1000, "micro"), (10**6, "nano")])
def test_unix_times_under_a_name_without_unit_are_told_by_their_size(made, kind, factor, word):
    path = made.write("t.csv", table(times=lambda at: str((MS_2024 + 100 * at) * factor)))
    if kind == "parquet":
        pl.read_csv(path).write_parquet(path := made.folder / "t.parquet")
    trip = same(one(path))
    assert dict(trip.reading.repaired) == {f"t taken as Unix {word}seconds": 12}
    assert trip.start_unix_s == MS_2024 / 1000


@pytest.mark.parametrize(("unit", "factor"), [("t_ms", 1), ("t_us", 1000), ("t_ns", 10**6)])
def test_a_stated_unit_needs_no_telling(made, unit, factor):
    names = (unit, "x", "y", "speed")
    trip = same(
        one(made.write("t.csv", table(times=lambda at: str((MS_2024 + 100 * at) * factor), names=names)))
    )
    assert dict(trip.reading.repaired) == {}
    assert np.diff(trip.t_s) == pytest.approx(0.1, abs=1e-12), "nanoseconds keep their digits"


@pytest.mark.parametrize("name", ["t_s", "t_ms"])
def test_a_time_that_cannot_be_in_the_stated_unit_is_an_error(made, name):
    text = table(times=lambda at: str((MS_2024 + 100 * at) * 10**6), names=(name, "x", "y", "speed"))
    with pytest.raises(
        DataFormatError, match=rf"row 2: {name} is 17\d+, .* over 3,000 years\. .*t_ns={name}"
    ):
        list(read_trips(made.write("t.csv", text)))


def test_a_time_in_another_unit_than_the_first_is_an_error(made):
    with pytest.raises(DataFormatError, match=r"row 14: t is '1710496800100', not .* unit of the first row"):
        list(read_trips(made.write("t.csv", table() + f"{MS_2024 + 100},14.4,0.5,12.0\n")))


@both
def test_milliseconds_from_the_start_are_told_by_the_speeds(made, kind):
    columns = {
        "t": [100 * at for at in range(12)],
        "x": [row[1] for row in ROWS],
        "y": [0.0] * 12,
        "speed": [12.0] * 12,
    }
    path = write(made, kind, columns)
    with pytest.raises(DataFormatError, match=r"1000 times slower than the speeds say\. .*t_ms=t"):
        list(read_trips(path))
    assert len(one(path, columns={"t_ms": "t", "east": "x", "north": "y", "speed": "speed"})) == 12


@both
@pytest.mark.parametrize("sentinel", [-1073741824.0, -1.07374e9])
def test_rows_of_a_vehicle_off_the_road_are_skipped_by_name(made, kind, sentinel):
    columns = {name: [row[at] for row in ROWS] for at, name in enumerate(("t", "x", "y", "speed"))}
    for name in ("x", "y", "speed"):
        columns[name][4:8] = [sentinel] * 4
    trip = one(write(made, kind, columns))
    assert dict(trip.reading.skipped) == {"off the road (SUMO's -1073741824)": 4}
    assert dict(trip.reading.repaired) == {}
    assert np.abs(trip.position_m).max() < 20
    assert len(trip.segments) == 3, "where the vehicle was off the road is a gap"


@both
def test_sentinels_in_latitude_and_in_speed_alone_are_found(made, kind):
    speed = [12.0] * 6 + [-1073741824.0] + [12.0] * 5
    latitude = [-1073741824.0] + [10.0 + at * 1e-5 for at in range(11)]
    columns = {"t": [row[0] for row in ROWS], "lat": latitude, "lon": [20.0] * 12, "speed_kmh": speed}
    trip = one(write(made, kind, columns))
    assert dict(trip.reading.skipped) == {"off the road (SUMO's -1073741824)": 1}
    assert trip.reading.repaired["speed not known (SUMO's -1073741824)"] == 1
    assert trip.speed_mps == pytest.approx(12.0 / 3.6)


@both
def test_feet_miles_an_hour_and_knots_become_si(made, kind):
    t = np.arange(30) * 0.1
    table = {
        "t": t,
        "px": 100.0 * t,
        "py": 0.0 * t,
        "h": 0.0 * t + 10.0,
        "v": 0.0 * t + 100.0,
        "a": 0.0 * t + 3.0,
    }
    path = write(made, kind, table)
    places = {"t": "t", "east_ft": "px", "north_ft": "py", "up_ft": "h", "acceleration_ftps2": "a"}
    for word, unit_mps in (("speed_mph", 0.44704), ("speed_kn", 1852 / 3600), ("speed_ftps", 0.3048)):
        (trip,) = read_trips(path, columns={**places, word: "v"})
        np.testing.assert_allclose(trip.speed_mps, 100.0 * unit_mps, rtol=1e-12)
    np.testing.assert_allclose(trip.position_m[:, 0], 30.48 * t, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(trip.up_m, 3.048)
    np.testing.assert_allclose(trip.acceleration_mps2, 0.9144)


def test_names_that_state_feet_and_knots_are_found(made):
    text = "t_s,east_ft,north_ft,speed_knots\n0,0,0,10\n1,10,0,10\n2,20,0,10\n"
    (trip,) = read_trips(made.write("a.csv", text))
    np.testing.assert_allclose(trip.speed_mps, 18520 / 3600)
    np.testing.assert_allclose(np.diff(trip.position_m[:, 0]), 3.048)


def test_a_position_has_one_unit(made):
    path = made.write("feet.csv", "t,a,b\n0,0,0\n1,10,0\n2,20,0\n")
    with pytest.raises(DataFormatError, match="columns a and b give east and north in different units"):
        list(read_trips(path, "csv", columns={"t": "t", "east_ft": "a", "north": "b"}))
    path = made.write("found.csv", "t,east_ft,north\n0,0,0\n1,10,0\n2,20,0\n")
    with pytest.raises(DataFormatError, match="in different units"):
        list(read_trips(path))


def test_an_unknown_table_is_given_a_map_of_its_own_units():
    said = example_map(["time", "x_feet", "y_feet", "v_mph"])
    assert said == "--columns 't=time,east_ft=x_feet,north_ft=y_feet,speed_mph=v_mph'"
    assert "east=?,north=y" in example_map(["time", "x_feet", "y", "v"])


def test_a_name_that_is_found_is_a_meaning_too(made):
    path = made.write("knots.csv", "t,a,b,v\n0,0,0,10\n1,5,0,10\n2,10,0,10\n")
    (trip,) = read_trips(path, "csv", columns={"t": "t", "east": "a", "north": "b", "speed_knots": "v"})
    np.testing.assert_allclose(trip.speed_mps, 10 * 1852 / 3600)


GERMAN = "Kennzeichen;Uhrzeit;Breite;Länge\n" + "".join(
    f"Ä{k % 2};{k};48,1;{11 + k / 1e5}\n" for k in range(6)
)


def test_one_column_that_is_given_is_taken_and_the_error_says_what_is_still_needed(made):
    path = made.write("t.csv", "Kennzeichen,Wann,Breite,Laenge\na,0,1,2\na,1,1,2\n")
    with pytest.raises(ConfigError) as caught:
        list(read_trips(path, "csv", columns={"vehicle": "Kennzeichen"}))
    said = str(caught.value)
    assert "vehicle=Kennzeichen is taken, but time and position are not found" in said
    assert "--columns 't=?,lat=Breite,lon=Laenge,vehicle=Kennzeichen'" in said
    with pytest.raises(ConfigError, match=r"t=Wann is taken, but position is not found"):
        list(read_trips(path, "csv", columns={"t": "Wann"}))


def test_a_position_that_is_half_given_stays_in_the_example():
    assert "'t=?,lat=a,lon=?'" in example_map(["a", "x", "y"], {"lat": "a"})


@pytest.mark.parametrize(("encoding", "counted"), [("cp1252", True), ("latin-1", True), ("utf-8", False)])
def test_text_of_windows_is_read_and_counted(made, encoding, counted):
    path = made.folder / "t.csv"
    path.write_bytes(GERMAN.replace(".", ",").encode(encoding))
    columns = {"t_s": "Uhrzeit", "lat": "Breite", "lon": "Länge", "vehicle": "Kennzeichen"}
    trips = read_trips(path, columns=columns)
    assert [trip.trip_id for trip in trips] == ["t/Ä0", "t/Ä1"]
    assert dict(trips[0].reading.repaired) == ({"read as Windows-1252": 3} if counted else {})


@pytest.mark.parametrize(
    ("cell", "remedy"),
    [
        ("04.05.2026 07:30", "^Write it as seconds"),
        ("4/5/2026 07:30:00", "^Say what comes first: --columns t_dmy=time"),
        ("soon", "^Write it as seconds"),
    ],
)
def test_what_is_no_time_for_certain_is_refused_with_what_to_write(made, cell, remedy):
    with pytest.raises(DataFormatError) as caught:
        list(read_trips(made.write("t.csv", f"time,x,y\n{cell},0,0\n{cell},1,0\n")))
    assert re.search(remedy, caught.value.remedy)


def _platoon(step: float, speed: float) -> str:
    rows = (f"{k / 10},S{car},{step * k + 20 * car:.3f},0,{speed},90" for k in range(100) for car in range(3))
    return "\n".join(["time,stationID,front x,front y,v,cog", *rows]) + "\n"


def test_the_map_that_is_shown_names_vehicle_and_units_and_works_when_copied(made):
    path = made.write("t.csv", _platoon(1.5, 54.0))
    with pytest.raises(DataFormatError) as caught:
        list(read_trips(path))
    example = str(caught.value).partition("--columns '")[2].partition("'")[0]
    assert "vehicle=stationID" in example
    assert "speed_kmh=v" in example
    assert "heading_deg=cog" in example
    trips = read_trips(path, columns=dict(part.split("=") for part in example.split(",")))
    assert [trip.trip_id for trip in trips] == ["t/S0", "t/S1", "t/S2"]
    assert trips[0].speed_mps == pytest.approx(15.0)


def test_speeds_in_metres_a_second_stay_so_in_the_map_that_is_shown(made):
    with pytest.raises(DataFormatError, match="speed=v,"):
        list(read_trips(made.write("t.csv", _platoon(1.5, 15.0))))
