"""Tables of the pilots: both units, names of columns, quotes, stamps."""

import numpy as np
import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.io.trips import read_trips

COUNT = 12


def trips_of(made, rows, header=None):
    path = made.write("p.csv", made.lines(list(rows), header=header or made.pilot_header, end="\n"))
    return list(read_trips(path, "cv-pilot"))


def coded(made, at, **changed: object):
    row = {
        "lat": 410_000_000 + 900 * at,
        "long": -1048500000,
        "elev": 18568,
        "yaw": 50,
        "speed": 500,
        "heading": 0,
    }
    return made.pilot_row(at, **(row | changed))


def test_values_are_si_and_there_is_no_absolute_time(made):
    (trip,) = read_trips(made.valid("cv-pilot"))
    assert trip.trip_id == "pilot/3DEF0000"
    assert np.diff(trip.t_s) == pytest.approx(0.1)
    assert trip.yaw_rate_radps == pytest.approx(np.radians(0.5))
    assert (trip.start_unix_s, trip.acceleration_mps2) == (None, None)
    assert trip.clock_s is not None


def test_codes_are_told_by_the_first_latitude(made):
    (trip,) = trips_of(made, [coded(made, at) for at in range(COUNT)])
    assert trip.origin.latitude_deg == 41.0
    assert trip.origin.altitude_m == pytest.approx(1856.8)
    assert trip.speed_mps == pytest.approx(10.0)
    assert trip.yaw_rate_radps == pytest.approx(np.radians(0.5))


def test_one_table_has_one_unit(made):
    with pytest.raises(DataFormatError, match=r"row 3: the latitude is 410000900.0, over 90 degrees, unlike"):
        trips_of(made, [made.pilot_row(0), coded(made, 1)])
    with pytest.raises(DataFormatError, match=r"row 3: latitude_deg is 41.5, no whole number"):
        trips_of(made, [coded(made, 0), coded(made, 1, lat=41.5)])


def test_names_and_order_of_columns_may_differ(made):
    header = (
        "coredata_long,coredata_lat,metadata_odeReceivedAt,COREDATA_SECMARK,coreData_id,coreData_elev,"
        "coreData_accelset_yaw,coreData_accelset_accelLong,coreData_speed,coreData_heading,randomNum"
    )
    rows = [
        f"-104.85,{41.1 + 1e-5 * at},07/31/2019 12:{at // 600:02d}:00 PM,{100 * at},AB,5,0.5,0.2,10,0,.5"
        for at in range(COUNT)
    ]
    (trip,) = trips_of(made, rows, header)
    assert np.diff(trip.t_s) == pytest.approx(0.1)
    assert trip.acceleration_mps2 == pytest.approx(0.2)


def test_a_whole_second_of_the_stamp_is_enough(made):
    rows = [
        made.pilot_row(at, generated="04/06/2021 10:30:00 AM", mark=(59_500 + 100 * at) % 60_000)
        for at in range(COUNT)
    ]
    (trip,) = trips_of(made, rows)
    assert np.diff(trip.t_s) == pytest.approx(0.1)


def test_the_stamp_of_reception_stands_in_for_that_of_the_record(made):
    rows = [made.pilot_row(at) for at in range(COUNT)]
    rows[4] = made.pilot_row(4, generated="NULL", received="2018-11-20T12:13:50.000")
    rows[5] = made.pilot_row(5, generated="", received="")
    (trip,) = trips_of(made, rows)
    assert dict(trip.reading.skipped) == {"time missing": 1}
    assert trip.t_s[4] == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("row", "told"),
    [
        (
            {"size": '"{""width"": 4,\n""length"": 5}"'},
            "row 3: cannot be split into fields: a quoted cell holds a line",
        ),
        ({"size": "5,5"}, "row 3: 12 fields where the header has 11"),
        ({"speed": "nan"}, "row 3: speed_mps is 'nan', not a finite number"),
        ({"id": ""}, "row 3: coreData_id is blank"),
        ({"generated": "yesterday"}, "row 3: the time of the message is 'yesterday': it is no date"),
        (
            {"generated": "2018-11-20T12:13:50Z"},
            "row 3: .* has a zone that is known, unlike the first of the file",
        ),
    ],
)
def test_what_is_wrong_is_told_with_its_line(made, row, told):
    with pytest.raises(DataFormatError, match=told):
        trips_of(made, [made.pilot_row(0), made.pilot_row(1, **row), made.pilot_row(2)])


def test_a_header_without_a_stamp_is_told(made):
    with pytest.raises(DataFormatError, match="row 1: the header has no column metadata_generatedat or"):
        trips_of(made, ["1"], "coreData_id,coreData_secMark,coreData_lat,coreData_long")


def test_a_cut_last_line_is_counted_also_within_quotes(made):
    path = made.valid("cv-pilot")
    content = path.read_bytes()
    for cut in (4, 20, 60):
        path.write_bytes(content[:-cut])
        (trip,) = read_trips(path)
        assert (len(trip), dict(trip.reading.skipped)) == (COUNT - 1, {"partial last line": 1})


def test_a_line_without_end_is_refused(made, monkeypatch):
    monkeypatch.setattr("modelcast.io.cv_pilot._LONGEST_LINE", 2000)
    with pytest.raises(DataFormatError, match="row 3: a line of over 2000 characters"):
        trips_of(made, [made.pilot_row(0), "x" * 5000])
