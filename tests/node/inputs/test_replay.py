"""A recorded trip driven again."""

from pathlib import Path

import numpy as np
import pytest

from modelcast.core.exceptions import ConfigError
from modelcast.io.trips import read_trips
from modelcast.io.write_trips import write_csv
from modelcast.node.inputs.motion_source import MotionSource
from modelcast.node.inputs.opening import gnss_source
from modelcast.node.inputs.replay import TripReplay, trip_from
from modelcast.node.inputs.samples import SAME_S, BusValue, GnssFix
from modelcast.world.drive import generate_drive

TRIP = generate_drive(3, 90.0).truth


def test_every_sample_comes_once_and_none_before_its_time():
    replay = TripReplay(TRIP, begin_s=100.0, latency_s=0.04)
    found = []
    for now_s in np.arange(99.0, 200.0, 0.037).tolist():
        taken = replay.take(now_s)
        assert all(one.received_s <= now_s + SAME_S for one in taken)
        found += taken
    fixes = [one for one in found if isinstance(one, GnssFix)]
    assert [one.measured_s for one in fixes] == (100.0 + TRIP.t_s).tolist()
    assert len(found) == 4 * len(TRIP)
    assert replay.ended


def test_ticks_computed_in_another_way_meet_the_recorded_times():
    replay = TripReplay(TRIP)
    source = MotionSource(replay.origin)
    for tick in range(300):
        source.feed(replay.take(tick / 10))
        motion = source.at(tick / 10)
        assert motion is not None
        assert motion.position_m == tuple(TRIP.position_m[tick].tolist())


@pytest.mark.parametrize("times_as_fast", [0.5, 1.5])
def test_speeds_belong_to_the_places_at_any_pace(times_as_fast: float):
    samples = TripReplay(TRIP, times_as_fast=times_as_fast).take(1e6)
    fixes = [one for one in samples if isinstance(one, GnssFix)]
    t_s = np.array([one.measured_s for one in fixes])
    place_m = np.array([one.position_m for one in fixes])
    by_places = np.hypot(*np.gradient(place_m, t_s, axis=0).T)
    speed = np.array([one.speed_mps for one in fixes])
    still = np.abs(by_places[5:-5] - speed[5:-5])
    assert still.max() < 0.05 * times_as_fast
    values = {name: [one.value for one in samples if isinstance(one, BusValue) and one.quantity == name]
              for name in ("yaw_rate_radps", "acceleration_mps2")}  # fmt: skip
    assert values["yaw_rate_radps"] == pytest.approx((times_as_fast * TRIP.yaw_rate_radps).tolist())
    assert values["acceleration_mps2"] == pytest.approx((times_as_fast**2 * TRIP.acceleration_mps2).tolist())


def test_a_trip_of_a_file_is_found_by_its_id(tmp_path: Path):
    write_csv([TRIP], tmp_path / "made.csv")
    (read,) = read_trips(tmp_path / "made.csv")
    assert trip_from(f"{tmp_path / 'made.csv'}#{read.trip_id}").trip_id == read.trip_id
    with pytest.raises(ConfigError, match="no trip 'other'"):
        trip_from(f"{tmp_path / 'made.csv'}#other")
    source = gnss_source(f"trip:{tmp_path / 'made.csv'}", now_s=lambda: 7.0, utc_at_zero_s=0.0)
    assert source.take(7.0)[0].measured_s == 7.0


@pytest.mark.parametrize(
    "text",
    [
        "",
        "gpsd",
        "gpsd://",
        "gpsd://host",
        "gpsd://host:0",
        "gpsd://host:99999",
        "nmea:",
        "nmea:/dev/x@fast",
        "usb:1",
    ],
)
def test_a_source_that_cannot_be_named_so_is_refused(text: str):
    with pytest.raises(ConfigError):
        gnss_source(text, now_s=lambda: 0.0, utc_at_zero_s=0.0)


@pytest.mark.real
def test_a_replay_of_a_real_trip_gives_its_samples_at_its_times(data_folder: Path):
    (trip,) = read_trips(data_folder / "comma2k19")
    replay, count = TripReplay(trip), 0
    source = MotionSource(replay.origin)
    for at, t_s in enumerate(replay.times_s.tolist()):
        source.feed(replay.take(t_s))
        motion = source.at(t_s)
        if motion is not None and motion.mode == "gnss+can":
            count += motion.position_m == tuple(trip.position_m[at].tolist())
            assert motion.speed_mps == trip.speed_mps[at]
    assert count == len(trip)
