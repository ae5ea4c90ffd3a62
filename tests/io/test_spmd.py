"""The three Safety Pilot formats: units, each listed repair, order and bounded memory."""

import numpy as np
import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.io import spmd, text_blocks
from modelcast.io.registry import get_reader
from modelcast.io.trips import read_trips


def one(path):
    (trip,) = read_trips(path)
    return trip


def test_bsm_values_are_si(made):
    trip = one(made.write("b.csv", made.lines([made.bsm_row(at) for at in range(5)])))
    assert (trip.trip_id, trip.vehicle) == ("b/7-70", "7")
    assert trip.t_s.tolist() == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4], abs=1e-6)
    assert trip.position_m[4] == pytest.approx([0.0, 4.0], abs=0.02)
    assert trip.speed_mps[0] == 10.0
    assert trip.acceleration_mps2[0] == 9.9999998e-3
    assert trip.yaw_rate_radps[0] == pytest.approx(np.radians(1.5))
    assert trip.heading_rad[0] == 0.0
    assert trip.up_m[4] == pytest.approx(4.0, abs=1e-3)
    assert (trip.origin.latitude_deg, trip.origin.altitude_m) == (42.0, 200.0)
    assert trip.start_unix_s is None


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
@pytest.mark.parametrize("header", [None, "as published", "Gentime"])
def test_header_byte_order_mark_and_line_ends_do_not_matter(made, end, mark, header):
    text = made.bsm_header.replace("GenTime", "Gentime") if header == "Gentime" else made.bsm_header
    rows = [made.bsm_row(at) for at in range(4)]
    content = mark + made.lines(rows, header=header and text, end=end)
    trip = one(made.write("b.csv", content))
    assert len(trip) == trip.reading.rows == 4


def test_disorder_is_sorted_and_counted(made):
    rows = [made.bsm_row(at) for at in (0, 2, 1, 3, 3)]
    trip = one(made.write("b.csv", made.lines(rows)))
    assert trip.up_m == pytest.approx([0, 1, 2, 3], abs=1e-3)
    assert dict(trip.reading.repaired) == {"out of time order": 1}
    assert dict(trip.reading.skipped) == {"duplicate time": 1}


@pytest.mark.parametrize(
    "changed",
    [
        {"Latitude": 90.0000001},
        {"Longitude": 180.0000001},
        {"Latitude": ""},
        {"Latitude": 0, "Longitude": 0.0},
    ],
)
def test_unavailable_position_is_skipped(made, changed):
    rows = [made.bsm_row(0, **changed), *(made.bsm_row(at) for at in range(1, 5))]
    trip = one(made.write("b.csv", made.lines(rows)))
    assert dict(trip.reading.skipped) == {"position unavailable": 1}
    assert trip.position_m[0] == pytest.approx([0, 0], abs=1e-9)


@pytest.mark.parametrize(
    ("changed", "column", "word"),
    [
        ({"Speed": 163.82}, "speed_mps", "speed"),
        ({"Speed": "NULL"}, "speed_mps", "speed"),
        ({"Heading": 360.0}, "heading_rad", "heading"),
        ({"Ax": 20.01}, "acceleration_mps2", "acceleration"),
        ({"Yawrate": "   "}, "yaw_rate_radps", "yaw rate"),
    ],
)
def test_unavailable_value_holds_the_last_one(made, changed, column, word):
    rows = [made.bsm_row(at, **(changed if at == 7 else {})) for at in range(12)]
    trip = one(made.write("b.csv", made.lines(rows)))
    assert getattr(trip, column)[7] == getattr(trip, column)[6]
    assert dict(trip.reading.repaired) == {f"{word} missing, last value held": 1}


def test_yaw_rate_garbage_is_counted_and_held(made):
    rows = [made.bsm_row(at, **({"Yawrate": 254.0} if at == 7 else {})) for at in range(12)]
    trip = one(made.write("b.csv", made.lines(rows)))
    assert trip.yaw_rate_radps[7] == pytest.approx(np.radians(1.5))
    assert trip.reading.repaired["yaw rate implausible"] == 1


def test_column_missing_too_often_is_left_out(made):
    rows = [made.bsm_row(at, **({"Ax": 20.01} if at % 2 else {})) for at in range(12)]
    trip = one(made.write("b.csv", made.lines(rows)))
    assert trip.acceleration_mps2 is None
    assert dict(trip.reading.repaired) == {"acceleration left out, too often missing": 6}


def test_rows_before_a_first_value_are_skipped(made):
    rows = [made.bsm_row(at, **({"Speed": 163.82} if at == 0 else {})) for at in range(12)]
    trip = one(made.write("b.csv", made.lines(rows)))
    assert len(trip) == 11
    assert dict(trip.reading.skipped) == {"no first value yet": 1}


def test_cut_last_line_is_skipped_and_counted(made):
    content = made.lines([made.bsm_row(at) for at in range(5)])[:-60]
    trip = one(made.write("b.csv", content))
    assert len(trip) == 4
    assert trip.reading.rows == 5
    assert dict(trip.reading.skipped) == {"partial last line": 1}


@pytest.mark.parametrize("block_bytes", [50, 300, 454, 1000])
def test_cut_last_line_is_counted_wherever_blocks_end(made, monkeypatch, block_bytes):
    content = made.lines([made.bsm_row(at) for at in range(5)])[:-60]
    monkeypatch.setattr(text_blocks, "BLOCK_BYTES", block_bytes)
    trip = one(made.write("b.csv", content))
    assert (len(trip), dict(trip.reading.skipped)) == (4, {"partial last line": 1})


def test_short_line_inside_is_an_error(made):
    rows = [made.bsm_row(0), "7,70,7", made.bsm_row(2)]
    with pytest.raises(DataFormatError, match=r"row 2: 3 fields where the format has 19\."):
        list(read_trips(made.write("b.csv", made.lines(rows)), "spmd-bsm"))


@pytest.mark.parametrize("text", ["nan", "inf", "12..5", "1e400"])
def test_text_that_is_no_number_is_an_error_with_row_and_value(made, text):
    rows = [made.bsm_row(0), made.bsm_row(1, Latitude=text)]
    path = made.write("b.csv", made.lines(rows, header=made.bsm_header))
    with pytest.raises(DataFormatError, match=rf"row 3: Latitude is '{text}', not a finite number\. Correct"):
        list(read_trips(path))


def test_header_without_a_needed_column_is_an_error(made):
    path = made.write("b.csv", made.lines([made.bsm_row(0)], header=made.bsm_header.replace("Speed", "Pace")))
    with pytest.raises(DataFormatError, match="row 1: the header has no column 'Speed'"):
        list(read_trips(path, "spmd-bsm"))


def test_vehicle_without_a_usable_row_is_reported(made):
    rows = [made.bsm_row(0), made.bsm_row(1, TxDevice=5, Latitude="NULL")]
    told = {}
    (trip,) = read_trips(made.write("b.csv", made.lines(rows)), on_skipped=told.__setitem__)
    assert trip.trip_id == "b/7-70"
    assert told == {"b/5-70-by7": "no usable row: 1 position unavailable"}


def shuffled_rows(made, count=40):
    rows = [
        made.bsm_row(at, RxDevice=device, TxDevice=device, FileId=file)
        for device in (1, 2) for file in (10, 11, 12) for at in range(count)
    ]  # fmt: skip
    order = np.random.default_rng(1).permutation(len(rows))
    return [rows[at] for at in order]


def test_many_small_blocks_and_little_memory_give_the_same_trips(made, monkeypatch):
    path = made.write("b.csv", made.lines(shuffled_rows(made)))
    whole = {trip.trip_id: trip for trip in read_trips(path)}
    monkeypatch.setattr(text_blocks, "BLOCK_BYTES", 700)
    pieces = {trip.trip_id: trip for trip in get_reader("spmd-bsm").within(120_000).read(str(path))}
    assert whole.keys() == pieces.keys()
    assert len(whole) == 6
    for name, trip in whole.items():
        assert trip.position_m.tobytes() == pieces[name].position_m.tobytes()
        assert trip.reading == pieces[name].reading
        assert trip.origin == pieces[name].origin


def test_sorted_file_yields_a_trip_before_it_is_read_to_the_end(made, monkeypatch):
    rows = [made.bsm_row(at, FileId=file) for file in range(20) for at in range(10)]
    path = made.write("b.csv", made.lines(rows))
    monkeypatch.setattr(text_blocks, "BLOCK_BYTES", 2000)
    seen = []
    real = spmd.number_column

    def noting(path, block, field, name):  # noqa: ANN202
        seen.append(block.index)
        return real(path, block, field, name)

    monkeypatch.setattr(spmd, "number_column", noting)
    next(get_reader("spmd-bsm").within(2000).read(str(path)))
    assert max(seen) <= 1


def test_wsu_speed_is_converted_from_kmh_and_time_is_absolute(made):
    trip = one(made.write("w.csv", made.lines([made.wsu_row(at) for at in range(5)])))
    assert trip.trip_id == "w/8-80"
    assert trip.speed_mps[0] == pytest.approx(10.0)
    assert trip.heading_rad[0] == pytest.approx(np.pi / 2)
    assert trip.yaw_rate_radps[0] == pytest.approx(np.radians(3.0))
    assert trip.start_unix_s == pytest.approx(1349093298.7)


def test_wsu_repeated_fix_is_skipped_and_its_gap_interpolated(made):
    rows = [made.wsu_row(at) for at in range(12)]
    rows[6] = rows[5].replace(",50,", ",60,", 1)
    trip = one(made.write("w.csv", made.lines(rows)))
    assert dict(trip.reading.skipped) == {"repeated fix": 1}
    assert trip.resampled
    assert len(trip) == 12
    assert np.diff(trip.position_m[:, 1]) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(
    ("changed", "reason"),
    [
        ({"GpsValidWsu": 0}, "no fix"),
        ({"GpsCoastingWsu": 1}, "position coasted"),
        ({"GpsTimeWsu": "NULL"}, "no GPS time"),
        ({"LatitudeWsu": ""}, "position unavailable"),
    ],
)
def test_wsu_row_without_a_fix_is_skipped(made, changed, reason):
    rows = [made.wsu_row(at, **(changed if at == 0 else {})) for at in range(5)]
    assert dict(one(made.write("w.csv", made.lines(rows))).reading.skipped) == {reason: 1}


def test_wsu_invalid_can_holds_speed(made):
    rows = [made.wsu_row(at, SpeedWsu=36 + at, ValidCanWsu=int(at != 7)) for at in range(12)]
    trip = one(made.write("w.csv", made.lines(rows)))
    assert trip.speed_mps[7] == trip.speed_mps[6]


def test_hv_empty_first_row_of_another_length_is_skipped(made):
    empty = "9,91,1970" + "," * 50
    rows = [empty, *(made.hv_row(at) for at in range(5))]
    told = {}
    (trip,) = read_trips(made.write("h.csv", made.lines(rows)), on_skipped=told.__setitem__)
    assert trip.trip_id == "h/9-90"
    assert trip.heading_rad[0] == pytest.approx(-np.pi)
    assert told == {"h/9-91": "no usable row: 1 no fix"}


def test_hv_padding_null_and_both_lengths_are_read(made):
    rows = [made.hv_row(0, fields=53, Accel="NULL      "), *(made.hv_row(at) for at in range(1, 5))]
    trip = one(made.write("h.csv", made.lines(rows)))
    assert trip.acceleration_mps2 is None
    assert trip.speed_mps.tolist() == [10.0] * 5
