"""The readers on the real files that MODELCAST_DATA names."""

import numpy as np
import pytest

from modelcast.io.openacc import read_platoon
from modelcast.io.registry import detect_format
from modelcast.io.trips import read_trips

pytestmark = pytest.mark.real

FILES = {
    "spmd/bsm_p1_dev.csv": ("spmd-bsm", 1, 3242),
    "spmd/formats/one_day/BsmP1_04_11_13_02_20_14_01.csv": ("spmd-bsm", 1, 19),
    "spmd/formats/one_day/BsmP1_04_11_13_02_20_14_02.csv": ("spmd-bsm", 1, 19),
    "spmd/formats/one_day/BsmP1_04_11_13_02_20_14_03.csv": ("spmd-bsm", 2, 19),
    "spmd/formats/one_day/BsmP1_04_11_13_02_20_14_04.csv": ("spmd-bsm", 1, 19),
    "spmd/formats/one_day/BsmP1_04_11_13_02_20_14_05.csv": ("spmd-bsm", 1, 19),
    "spmd/formats/one_day/DataWsu_04_11_13.csv": ("spmd-wsu", 1, 19),
    "spmd/formats/one_day/HV_Primary_04_11_13.csv": ("spmd-hv", 1, 19),
    "spmd/formats/two_month/april_BsmP1.csv": ("spmd-bsm", 1, 20),
    "spmd/formats/two_month/DataWsu.csv": ("spmd-wsu", 1, 19),
    "spmd/formats/two_month/HV_Primary.csv": ("spmd-hv", 1, 19),
    "openacc_zalazone/long_setting__dynamic_part16.csv": ("openacc", 7, 8400),
    "openacc_zalazone/no_ACC__handling_part22.csv": ("openacc", 9, 28800),
    "openacc_zalazone/short_setting__dynamic_part12.csv": ("openacc", 11, 14289),
    "openacc_zalazone/short_setting__handling_part14.csv": ("openacc", 10, 8000),
    "openacc_zalazone/short_setting__handling_part36.csv": ("openacc", 8, 21848),
    "comma2k19/Example_1/b0c9d2329ad1606b_2018-08-02--08-34-47/40": ("comma2k19", 1, 579),
    "nyc_cvpd/nycdot-fcw-event.json": ("nyc-cvpd", 2, 322),
    "smartloc/Berlin_Potsdamer_Platz_GT.txt": ("smartloc", 1, 21410),
    "smartloc/Berlin_Potsdamer_Platz_Input.txt": ("smartloc", 1, 21410),
}
each_file = pytest.mark.parametrize("name", FILES)


@each_file
def test_format_is_detected_and_every_row_accounted_for(data_folder, name):
    kind, count, rows = FILES[name]
    assert detect_format(data_folder / name) == kind
    trips = list(read_trips(data_folder / name))
    assert len({trip.trip_id for trip in trips}) == len(trips) == count
    assert sum(trip.reading.rows for trip in trips) == rows
    for trip in trips:
        assert trip.resampled or trip.reading.rows == len(trip) + sum(trip.reading.skipped.values())


@each_file
def test_speed_and_heading_agree_with_the_motion(data_folder, name):
    for trip in read_trips(data_folder / name):
        step = 10 if trip.dt_s < 0.15 else 5
        if len(trip) < 40 * step or trip.speed_mps is None or "A305214A" in trip.trip_id:
            continue
        inside = trip.segment_start[step:] == trip.segment_start[:-step]
        moved = (trip.position_m[step:] - trip.position_m[:-step]) / (trip.t_s[step:] - trip.t_s[:-step])[
            :, None
        ]
        speed = np.hypot(moved[:, 0], moved[:, 1])
        middle = trip.speed_mps[step // 2 :][: speed.size]
        assert np.median(np.abs(speed - middle)[inside]) < 0.6, "a 1 Hz unit lags by half a second"
        if trip.heading_rad is not None:
            fast = inside & (speed > 3)
            course = np.arctan2(moved[:, 0], moved[:, 1])
            off = np.angle(np.exp(1j * (course - trip.heading_rad[step // 2 :][: speed.size])))
            assert np.median(np.abs(off)[fast]) < np.radians(3)


def test_yaw_rates_are_clockwise(data_folder):
    for name in (
        "spmd/bsm_p1_dev.csv",
        "smartloc/Berlin_Potsdamer_Platz_GT.txt",
        "nyc_cvpd/nycdot-fcw-event.json",
    ):
        for trip in read_trips(data_folder / name):
            if trip.heading_rad is None:
                velocity = np.gradient(trip.position_m, trip.t_s, axis=0)
                heading = np.unwrap(np.arctan2(velocity[:, 0], velocity[:, 1]))
            else:
                heading = np.unwrap(trip.heading_rad)
            turning = np.abs(trip.yaw_rate_radps) > np.radians(3)
            if turning.sum() > 20 and np.ptp(heading) > 1.0:
                rate = np.gradient(heading, trip.t_s)
                assert np.sign(np.median((rate * trip.yaw_rate_radps)[turning & (trip.speed_mps > 3)])) > 0


def test_bmw_repeats_positions_in_every_file_so_vehicle_order_names_columns(data_folder):
    """One car's receiver repeats positions; its name stays the same while its column changes."""
    for name in ("long_setting__dynamic_part16", "no_ACC__handling_part22", "short_setting__handling_part36"):
        repeats = {
            trip.trip_id.rpartition("/")[2]: (np.diff(trip.position_m, axis=0) == 0).all(axis=1).sum()
            for trip in read_trips(data_folder / "openacc_zalazone" / f"{name}.csv")
            if not trip.resampled
        }
        assert max(repeats, key=lambda car: repeats[car]) == "BMW_I3"
        assert repeats["BMW_I3"] > 30


def test_stuck_speed_of_the_new_york_target_is_kept(data_folder):
    trips = {trip.trip_id[-8:]: trip for trip in read_trips(data_folder / "nyc_cvpd/nycdot-fcw-event.json")}
    assert np.unique(trips["A305214A"].speed_mps).tolist() == pytest.approx([5.68])


@pytest.mark.slow
def test_whole_folder_reads_with_unique_identifiers(data_folder):
    trips = list(read_trips(data_folder))
    assert len({trip.trip_id for trip in trips}) == len(trips)
    folders = ("spmd", "openacc_zalazone", "comma2k19", "nyc_cvpd", "smartloc")
    assert sum(len(list(read_trips(data_folder / name))) for name in folders) == 61


@pytest.mark.parametrize("name", [name for name in FILES if name.startswith("openacc")])
def test_a_real_platoon_drives_in_line(data_folder, name):
    """On the file's one clock every car has another within 60 m most of the time, and none on top of it."""
    platoon = read_platoon(data_folder / name)
    assert platoon.slots == FILES[name][1]
    there = platoon.active.all(axis=1)
    position = platoon.position_m[there]
    apart = np.hypot(*(position[:, :, None] - position[:, None]).transpose(3, 0, 1, 2))
    apart[:, np.arange(platoon.slots), np.arange(platoon.slots)] = np.inf
    nearest = apart.min(axis=2)
    assert (nearest < 60.0).mean() > 0.9
    assert nearest.min() > 2.0
    jerk = np.diff(platoon.acceleration_mps2, axis=0)[platoon.active[1:] & platoon.active[:-1]] * 10.0
    assert np.sqrt((jerk**2).mean()) < 2.0
