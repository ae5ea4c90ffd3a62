"""Tables as others write them: names and units in the header, clocks, and units that no name states."""

from pathlib import Path

import numpy as np
import pytest

from modelcast.core.exceptions import ConfigError, DataFormatError
from modelcast.io.csv import CsvReader
from modelcast.io.header_names import told_meanings
from modelcast.io.recordings import Recordings
from modelcast.io.trips import read_trips

STEP_S = 0.1
SPEED_MPS = 20.0


def clock(at: int) -> str:
    """Return a time of day, from a second before eight."""
    tenths = 8 * 36000 - 10 + at
    return f"{tenths // 36000}:{tenths // 600 % 60:02d}:{tenths // 10 % 60:02d}.{tenths % 10}"


def straight(
    header: str, *, time=lambda at: f"{STEP_S * at:.1f}", speed: float = SPEED_MPS, rows: int = 40
) -> str:
    """Return a table of a car that drives east at 20 m/s."""
    lines = [f"{time(at)},{SPEED_MPS * STEP_S * at:.2f},0.0,{speed:.4f}" for at in range(rows)]
    return "\n".join((header, *lines, ""))


def one(made, text, *, columns=None, kind=None):
    (trip,) = read_trips(made.write("t.csv", text), kind, columns=columns)
    return trip


@pytest.mark.parametrize(
    ("name", "factor"),
    [
        ("Speed (km/h)", 3.6),
        ("vehicle_speed_kmh", 3.6),
        ("GPS Speed [kph]", 3.6),
        ("velocity mph", 3600 / 1609.344),
        ("SPEED_KNOTS", 3600 / 1852),
        ("Speed [ft/s]", 1 / 0.3048),
        ("vel (m/s)", 1.0),
    ],
)
def test_a_unit_in_the_name_is_the_unit_that_is_read(made, name, factor):
    trip = one(made, straight(f"Time [s],X,Y,{name}", speed=SPEED_MPS * factor))
    np.testing.assert_allclose(trip.speed_mps, SPEED_MPS, rtol=1e-4)
    assert trip.dt_s == pytest.approx(STEP_S)


def test_two_columns_that_say_the_same_are_not_chosen_between():
    assert told_meanings(["Speed (km/h)", "Speed [m/s]", "Lat", "latitude"]) == {}


@pytest.mark.parametrize(
    "name", ["heading", "yaw rate [deg/s]", "speed limit", "x acceleration", "latency", "Speed (furlongs)"]
)
def test_names_that_leave_something_open_tell_nothing(name):
    assert told_meanings([name]) == {}


def test_names_of_the_table_of_formats_go_before_those_of_others(made):
    text = straight("Time,x,y,speed_kmh", speed=SPEED_MPS * 3.6).replace(
        "speed_kmh", "speed_kmh,Speed [m/s]", 1
    )
    text = text.replace("72.0000\n", "72.0000,1.0\n")
    assert one(made, text).speed_mps == pytest.approx(SPEED_MPS)


def test_latitudes_by_default_names_are_not_given_up_for_other_coordinates(made):
    rows = "".join(f"{at / 10},{48 + at * 1e-5},9.0,1e6,2e6\n" for at in range(20))
    trip = one(made, "time,lat,lon,Easting,Northing\n" + rows)
    assert trip.origin is not None
    assert trip.position_m[-1, 1] == pytest.approx(21.1, abs=0.1)


@pytest.mark.parametrize(
    ("factor", "meaning"),
    [
        (3.6, "speed_kmh"),
        (3600 / 1609.344, "speed_mph"),
        (3600 / 1852, "speed_kn"),
        (1 / 0.3048, "speed_ftps"),
    ],
)
def test_a_speed_without_unit_that_fits_another_unit_is_an_error_whose_remedy_works(made, factor, meaning):
    text = straight("t,x,y,speed", speed=SPEED_MPS * factor)
    with pytest.raises(DataFormatError, match=f"Map it by its unit: {meaning}=speed"):
        one(made, text)
    np.testing.assert_allclose(one(made, text, columns={meaning: "speed"}).speed_mps, SPEED_MPS, rtol=1e-4)
    np.testing.assert_allclose(
        one(made, text, columns={"speed_mps": "speed"}).speed_mps, SPEED_MPS * factor, rtol=1e-4
    )


@pytest.mark.parametrize("factor", [0.9, 1.0, 1.5, 5.0])
def test_a_speed_that_fits_no_unit_is_left_to_the_inspection(made, factor):
    assert len(one(made, straight("t,x,y,speed", speed=SPEED_MPS * factor))) == 40


def test_milliseconds_from_the_start_without_speeds_are_an_error_whose_remedy_works(made):
    text = straight("time,x,y,colour", time=lambda at: str(100 * at))
    with pytest.raises(DataFormatError, match=r"time grows by 100 .* for example t_ms=time; t_s=time"):
        one(made, text)
    assert one(made, text, columns={"t_ms": "time"}).dt_s == pytest.approx(STEP_S)
    assert one(made, text, columns={"t_s": "time"}).dt_s == pytest.approx(100.0)


def test_a_map_may_name_what_names_do_not_tell_and_leave_the_rest(made):
    text = straight("time,x,y,id", speed=7.0).replace("7.0000", "7")
    assert one(made, text, columns={"vehicle": "id"}).trip_id == "t/7"
    assert (
        one(made, text.replace(",x,", ",across,"), columns={"east": "across"}, kind="csv").position_m[9, 0]
        == 18.0
    )
    with pytest.raises(ConfigError, match="needs t, and east with north"):
        one(made, text.replace("id", "latitude"), columns={"lon": "latitude"})
    with pytest.raises(ConfigError, match="needs t, and east with north"):
        one(made, text.replace("time,", "hours,"), columns={"vehicle": "id"}, kind="csv")


def test_several_vehicles_without_a_known_name_are_an_error_that_says_what_to_name(made):
    text = straight("time,x,y,id").replace("20.0000", "1")
    both = text + text.partition("\n")[2].replace(",1\n", ",2\n")
    with pytest.raises(DataFormatError, match="which column names them: --columns vehicle=NAME"):
        one(made, both)
    trips = list(read_trips(made.write("both.csv", both), columns={"vehicle": "id"}))
    assert [trip.trip_id for trip in trips] == ["both/1", "both/2"]


def test_times_of_day_without_a_date_are_counted_from_the_first(made):
    trip = one(made, straight("Time,x,y,speed", time=clock, rows=20))
    np.testing.assert_allclose(trip.t_s - trip.t_s[0], STEP_S * np.arange(20), atol=1e-9)
    assert trip.start_unix_s is None


def test_a_date_among_times_of_day_is_an_error(made):
    text = straight("Time,x,y,speed", time=clock, rows=20).replace("7:59:59.5,", "2024-03-15 07:59:59.5,")
    with pytest.raises(DataFormatError, match=r"row 7: Time is .* not a time of day without a date"):
        one(made, text)


def test_a_date_that_can_be_read_in_two_ways_is_an_error_that_asks_which(made):
    text = straight("time,x,y,speed", time=lambda at: f"04/05/2026 07:30:{at:02d}", rows=20)
    with pytest.raises(DataFormatError, match=r"--columns t_dmy=time \(the day\) or --columns t_mdy=time"):
        one(made, text)


def test_a_folder_that_modelcast_wrote_holds_its_trips_alone(made):
    made.write("a.csv", straight("time,x,y,speed"))
    made.write("MANIFEST.txt", "# modelcast demo\na.csv\n")
    left = []
    found = list(Recordings([made.folder], None, on_skipped=lambda *told: left.append(told)))
    assert len(found) == 1
    assert left == []


def test_an_optional_column_without_any_value_is_as_if_it_were_not_there(made):
    rows = straight("time,x,y,speed").replace("20.0000", "20.0000,")
    trip = one(made, rows.replace("speed", "speed,heading_deg", 1))
    assert trip.heading_rad is None
    assert dict(trip.reading.repaired) == {}


def test_a_header_with_fewer_names_than_its_rows_have_fields_is_not_read_by_guess() -> None:
    """Which field has which name is not known then."""
    header, row = b"Time,Latitude,Longitude\n", b"0.0,48.1,11.2"
    assert CsvReader().matches(Path("a.csv"), header + row + b"\n")
    assert not CsvReader().matches(Path("a.csv"), header + row + b",1,,\n")


def test_of_a_folder_a_table_that_only_looks_like_one_is_passed_over_and_told(tmp_path: Path) -> None:
    """Times in hundredths of a second, no speed; named by itself it is refused."""
    rows = "".join(f"{20 * n},{n},0\n" for n in range(30))
    (tmp_path / "log.csv").write_text(f"Time,x,y\n{rows}")
    good = "".join(f"{0.1 * n:.1f},{n},0\n" for n in range(30))
    (tmp_path / "trip.csv").write_text(f"t,x,y\n{good}")
    trips = read_trips(tmp_path)
    assert len(list(trips)) == 1
    assert list(trips.skipped) == [str(tmp_path / "log.csv")]
    with pytest.raises(DataFormatError, match="no reader knows this file"):
        list(read_trips(tmp_path / "log.csv"))
    with pytest.raises(DataFormatError, match="too much for seconds"):
        list(read_trips(tmp_path / "log.csv", format="csv"))


def test_speeds_of_zero_tell_no_unit_of_time(tmp_path: Path) -> None:
    rows = "".join(f"{20 * n},{n},0,0\n" for n in range(30))
    (tmp_path / "log.csv").write_text(f"Time,x,y,speed\n{rows}")
    with pytest.raises(DataFormatError, match="too much for seconds"):
        list(read_trips(tmp_path / "log.csv", format="csv"))
