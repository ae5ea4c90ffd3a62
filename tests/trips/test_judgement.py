"""Claims about what a user is told of a recording before any figure."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.io.trips import read_trips
from modelcast.models.learned.spans import short_at
from modelcast.models.profile import default_profile
from modelcast.trips.inspection import inspect
from modelcast.trips.judgement import judge
from modelcast.trips.trajectory import build_trajectory
from modelcast.world.drive import generate_drive

THRESHOLDS_M = (0.2, 0.5)


def path_at(rate_hz: float, noise_m: float = 0.0) -> tuple[FloatArray, FloatArray]:
    t = np.arange(0.0, 60.0, 1.0 / rate_hz)
    path = np.stack([12.0 * t + 8.0 * np.sin(0.2 * t), 20.0 * np.cos(0.15 * t)], axis=1)
    return t, path + np.random.default_rng(1).normal(0.0, noise_m, path.shape)


def told(rate_hz: float = 10.0, noise_m: float = 0.0) -> Mapping[str, str]:
    return judge(inspect(build_trajectory("made/1", *path_at(rate_hz, noise_m))), THRESHOLDS_M)


def test_an_honest_recording_at_ten_hertz_is_told_nothing_of() -> None:
    assert told() == {}
    assert judge(inspect(generate_drive(seed=3, duration_s=120.0).truth), THRESHOLDS_M) == {}


@pytest.mark.parametrize(("noise_m", "named"), [(0.1, ""), (0.3, "20 cm"), (2.0, "20, 50 cm")])
def test_noise_above_a_threshold_is_told_with_that_threshold(noise_m: float, named: str) -> None:
    found = told(noise_m=noise_m)
    assert found.keys() == ({"noise"} if named else set())
    assert named in found.get("noise", "")


def test_noise_in_places_is_told_and_a_smoothed_truth_has_none() -> None:
    t, path = path_at(10.0)
    path[:120] += np.random.default_rng(1).normal(0.0, 1.0, (120, 2))
    found = inspect(build_trajectory("made/1", t, path))
    assert "in places" in judge(found, THRESHOLDS_M)["noise"]
    assert "noise" not in judge(found, THRESHOLDS_M, smoothed=True)


@pytest.mark.parametrize("rate_hz", [9.65, 10.0, 10.4])
def test_rates_near_ten_hertz_are_ten_hertz(rate_hz: float) -> None:
    assert "rate" not in told(rate_hz)


@pytest.mark.parametrize(
    ("rate_hz", "spans"), [(1.0, "9 s"), (5.0, "1.8 s"), (18.0, "0.5 s"), (50.0, "0.18 s")]
)
def test_other_rates_are_told_with_what_windows_span_and_are_never_resampled(
    rate_hz: float, spans: str
) -> None:
    t, path = path_at(rate_hz)
    trip = build_trajectory("made/1", t, path)
    assert np.array_equal(trip.position_m, path)
    assert not trip.resampled
    text = judge(inspect(trip), THRESHOLDS_M)["rate"]
    assert f"ten span {spans}" in text
    assert ("errors between samples" in text) == (rate_hz < 10.0)


def test_at_one_hertz_the_residual_is_no_noise_and_no_fix_period_is_made_up() -> None:
    found = told(1.0, noise_m=1.0)
    assert found.keys() == {"rate"}


@pytest.mark.parametrize(
    ("rate_hz", "works"), [(1.0, True), (5.0, True), (10.0, True), (12.5, False), (50.0, False)]
)
def test_a_learned_sub_model_whose_window_is_too_short_is_named(rate_hz: float, *, works: bool) -> None:
    assert (short_at(default_profile().bank, 1.0 / rate_hz) == "") == works


def test_repeated_positions_are_told_with_their_true_rate() -> None:
    t, path = path_at(10.0)
    found = judge(inspect(build_trajectory("made/1", t, path[(np.arange(t.size) // 10) * 10])), (5.0,))
    assert "hold 1 new positions a second" in found["repeated"]


def test_joined_fixes_jumps_and_glitches_are_told_with_their_sizes() -> None:
    t, path = path_at(10.0)
    lines = np.stack([np.interp(t, t[::10], path[::10, axis]) for axis in (0, 1)], axis=1)
    assert (
        "about 1 s apart"
        in judge(inspect(build_trajectory("made/1", t, lines)), THRESHOLDS_M)["straight-lines"]
    )
    path[100:104] += 900.0
    path[400:, 1] += 50.0
    found = judge(inspect(build_trajectory("made/1", t, path)), THRESHOLDS_M)
    assert "4 rows (position jump and back) of 600" in found["glitch"]
    assert "jumps once" in found["jump"]
    assert "50 m" in found["jump"]


def test_a_column_of_speeds_that_contradicts_the_positions_is_told() -> None:
    drive = generate_drive(seed=3, duration_s=120.0).truth
    assert drive.speed_mps is not None
    found = judge(inspect(replace(drive, speed_mps=2.0 * drive.speed_mps)), THRESHOLDS_M)
    assert "ratio 2" in found["stuck-speed"]


def test_the_units_own_extrapolation_is_called_that_and_not_straight_lines(data_folder: Path) -> None:
    (trip,) = read_trips(data_folder / "spmd" / "bsm_p1_dev.csv")
    found = judge(inspect(trip), THRESHOLDS_M, smoothed=True)
    assert found.keys() == {"extrapolated"}
    assert "fixes 1 s apart" in found["extrapolated"]


def test_of_the_clean_development_cars_only_the_broken_ones_are_warned_of(data_folder: Path) -> None:
    for trip in read_trips(data_folder / "openacc_zalazone"):
        kinds = judge(inspect(trip), THRESHOLDS_M).keys()
        assert kinds <= {"noise"}, trip.trip_id
        assert not kinds or "BMW_I3" in trip.trip_id
