"""comma2k19: what a sender would have had at each fix, and folders above a segment."""

import numpy as np
import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.io.comma2k19 import Comma2k19Reader
from modelcast.io.registry import detect_format
from modelcast.io.trips import read_trips


def test_time_is_the_fix_s_utc_not_when_it_was_logged(made):
    (trip,) = read_trips(made.valid("comma2k19"))
    assert trip.trip_id == "drive/40"
    assert np.diff(trip.t_s) == pytest.approx(0.1, abs=1e-6)
    assert trip.start_unix_s == pytest.approx(1.53e9)
    assert not trip.resampled


def test_speed_is_the_last_can_value_at_or_before_the_fix_was_logged(made):
    arrays = made.comma_arrays()
    (trip,) = read_trips(made.comma(made.folder / "d" / "1", arrays))
    can_s = arrays["CAN/speed/t"]
    expected = [can_s[can_s <= at].max() - 990.0 for at in arrays["GNSS/live_gnss_ublox/t"]]
    assert trip.speed_mps.tolist() == expected


def test_yaw_rate_is_the_gyro_about_the_down_axis(made):
    (trip,) = read_trips(made.valid("comma2k19"))
    assert trip.yaw_rate_radps == pytest.approx(0.25)
    assert trip.heading_rad == pytest.approx(np.pi / 2)


def test_yaw_rate_does_not_see_the_future(made):
    arrays = made.comma_arrays()
    before = next(iter(read_trips(made.comma(made.folder / "a" / "1", arrays))))
    arrays["IMU/gyro/value"][arrays["IMU/gyro/t"] > 1000.55] = 5.0
    after = next(iter(read_trips(made.comma(made.folder / "b" / "1", arrays))))
    assert (before.yaw_rate_radps == after.yaw_rate_radps)[:5].all()
    assert (after.yaw_rate_radps[6:] > 0.25).all()


def test_missing_epochs_are_interpolated_with_the_rest(made):
    arrays = made.comma_arrays()
    kept = np.arange(12) != 5
    for name in ("GNSS/live_gnss_ublox/t", "GNSS/live_gnss_ublox/value"):
        arrays[name] = arrays[name][kept]
    (trip,) = read_trips(made.comma(made.folder / "d" / "1", arrays))
    assert (trip.reading.rows, len(trip), trip.resampled) == (11, 12, True)


def test_logs_without_can_or_gyro_leave_the_columns_out(made):
    arrays = {name: array for name, array in made.comma_arrays().items() if name.startswith("GNSS")}
    (trip,) = read_trips(made.comma(made.folder / "d" / "1", arrays))
    assert trip.speed_mps is None
    assert trip.yaw_rate_radps is None


def test_zero_position_is_no_fix(made):
    arrays = made.comma_arrays()
    arrays["GNSS/live_gnss_ublox/value"][0, :2] = 0.0
    (trip,) = read_trips(made.comma(made.folder / "d" / "1", arrays))
    assert dict(trip.reading.skipped) == {"no fix": 1}


@pytest.mark.parametrize("given", [None, "comma2k19"])
def test_folder_above_yields_segments_in_order_of_number(made, given):
    for number in (10, 9):
        made.comma(made.folder / "all" / "drive" / str(number))
    trips = read_trips(made.folder / "all", given)
    assert sorted(trip.trip_id for trip in trips) == ["drive/10", "drive/9"]
    ordered = Comma2k19Reader().read(str(made.folder / "all"))
    assert [trip.trip_id for trip in ordered] == ["drive/9", "drive/10"]


@pytest.mark.parametrize(
    ("drive", "vehicle"),
    [
        ("b0c9d2329ad1606b|2018-08-02--08-34-47", "b0c9d2329ad1606b"),
        ("b0c9d2329ad1606b_2018-08-02--08-34-47", "b0c9d2329ad1606b"),
        ("my drive", ""),
    ],
)
def test_the_vehicle_is_the_device_in_the_drive_s_name(made, drive, vehicle):
    segment = made.valid("comma2k19")
    home = made.folder / drive
    home.mkdir()
    segment.rename(home / "7")
    (trip,) = read_trips(home / "7")
    assert (trip.trip_id, trip.vehicle) == (f"{drive}/7", vehicle)


def test_segment_folder_is_detected(made):
    assert detect_format(made.valid("comma2k19")) == "comma2k19"


def test_pickled_array_is_an_error(made):
    folder = made.valid("comma2k19")
    with (folder / "processed_log/CAN/speed/value").open("wb") as file:
        np.save(file, np.array([{}], dtype=object), allow_pickle=True)
    with pytest.raises(
        DataFormatError, match="speed/value: is not a NumPy array: Object arrays cannot be loaded"
    ):
        list(read_trips(folder))


def test_nan_in_a_log_is_an_error_with_its_row(made):
    arrays = made.comma_arrays()
    arrays["CAN/speed/value"][3] = np.nan
    with pytest.raises(DataFormatError, match=r"speed, row 4: time or value is not a finite number"):
        list(read_trips(made.comma(made.folder / "d" / "1", arrays)))


def test_a_header_of_an_array_cut_within_its_dictionary_is_an_error(made):
    """NumPy's tokenizer ends in an error of its own there."""
    folder = made.comma(made.folder / "drive" / "40")
    victim = folder / "processed_log" / "CAN" / "speed" / "t"
    head = b"{'descr': '<f8', 'fortran_order': (False\n"
    victim.write_bytes(b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head)
    with pytest.raises(DataFormatError, match="is not a NumPy array"):
        list(read_trips(folder))


def test_infinite_times_are_an_error(made):
    arrays = made.comma_arrays()
    arrays["CAN/speed/t"][3:6] = np.inf
    with pytest.raises(DataFormatError, match="row 4: time or value is not a finite number"):
        list(read_trips(made.comma(made.folder / "drive" / "40", arrays)))
