"""Claims about positions that no vehicle can reach."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.trips.inspection import inspect
from modelcast.trips.jumps import (
    JUMP_TOLERANCE_M,
    MAX_ACCELERATION_MPS2,
    MAX_SPEED_MPS,
    _Steps,
    jumps_between,
)
from modelcast.trips.trajectory import JUMPED, OFF_EARTH, Trajectory, build_trajectory


def drive(rate_hz: float = 10.0, duration_s: float = 60.0) -> tuple[FloatArray, FloatArray]:
    """A car at 12 m/s that sways and speeds up and down."""
    t = np.arange(0.0, duration_s, 1.0 / rate_hz)
    return t, np.stack([12.0 * t + 8.0 * np.sin(0.2 * t), 20.0 * np.cos(0.15 * t)], axis=1)


def made(t: FloatArray, path: FloatArray) -> Trajectory:
    trip = build_trajectory("made/1", t, path)
    assert trip.reading.rows == t.size
    if not trip.resampled:
        assert len(trip) + sum(trip.reading.skipped.values()) == t.size
    return trip


@pytest.mark.parametrize("rate_hz", [1.0, 5.0, 10.0, 18.0, 50.0])
@pytest.mark.parametrize("turned_rad", [0.0, 2.0, 4.0])
def test_a_jump_of_fifty_metres_that_lasts_splits_the_trip_and_keeps_every_row(
    rate_hz: float, turned_rad: float
) -> None:
    t, path = drive(rate_hz)
    path[t.size // 2 :] += 50.0 * np.array([np.sin(turned_rad), np.cos(turned_rad)])
    trip = made(t, path)
    assert trip.segments.tolist() == [0, t.size // 2, t.size]
    assert np.array_equal(trip.position_m, path)
    found = inspect(trip)
    assert (found.jumps, found.gaps) == (1, 0)
    assert found.largest_jump_m == pytest.approx(50.0, abs=10.0)


@pytest.mark.parametrize("rows", [1, 7, 40])
@pytest.mark.parametrize("away_m", [(60.0, 0.0), (-1.0e6, 3.0e5)])
def test_a_glitch_that_comes_back_is_skipped_and_counted(rows: int, away_m: tuple[float, float]) -> None:
    t, path = drive()
    broken = path.copy()
    broken[200 : 200 + rows] += away_m
    trip = made(t, broken)
    assert trip.reading.skipped == {JUMPED: rows}
    assert inspect(trip).jumps == 0
    near = np.array([np.interp(trip.t_s, t, path[:, axis]) for axis in (0, 1)]).T
    assert np.abs(trip.position_m - near).max() < 0.05, "interpolated over one missing row at most"


def test_a_frozen_glitch_is_skipped_too() -> None:
    t, path = drive()
    path[100:130] = (9000.0, -4000.0)
    assert made(t, path).reading.skipped == {JUMPED: 30}


def test_a_sentinel_is_no_place_on_earth() -> None:
    t, path = drive()
    path[100:115] = -1073741824.0
    trip = made(t, path)
    assert trip.reading.skipped == {OFF_EARTH: 15}
    assert np.abs(trip.position_m).max() < 1e4


def test_a_few_rows_at_an_end_are_a_glitch_but_half_a_trip_is_none() -> None:
    t, path = drive()
    path[:3] -= 7000.0
    path[-2:] += 7000.0
    assert made(t, path).reading.skipped == {JUMPED: 5}
    t, path = drive()
    path[:200] -= 7000.0
    assert made(t, path).segments.tolist() == [0, 200, 600]


def test_times_start_at_zero_again_and_the_absolute_time_moves_where_the_first_rows_are_skipped() -> None:
    t, path = drive()
    path[:3] -= 7000.0
    trip = build_trajectory("made/1", t, path, start_unix_s=1000.0)
    assert trip.t_s[0] == 0.0
    assert trip.start_unix_s == pytest.approx(1000.3)


def test_a_glitch_that_lasts_longer_than_what_surrounds_it_is_kept() -> None:
    t, path = drive(duration_s=12.0)
    path[20:100] += 300.0
    assert made(t, path).segments.tolist() == [0, 20, 100, 120]


@pytest.mark.parametrize("speed_mps", [5.0, 20.0, 45.0])
def test_positions_repeated_by_a_slow_receiver_are_no_jumps(speed_mps: float) -> None:
    t = np.arange(0.0, 60.0, 0.1)
    path = np.stack([speed_mps * t, 0.1 * t**2], axis=1)[(np.arange(t.size) // 10) * 10]
    assert made(t, path).segments.tolist() == [0, 600]
    path[310:] += 300.0
    assert inspect(made(t, path)).jumps == 1


def test_a_car_that_stood_for_a_minute_jumps_like_any_other() -> None:
    t = np.arange(0.0, 60.0, 0.1)
    path = np.stack([np.where(t < 50.0, 0.0, (t - 50.0) ** 2), 0.0 * t], axis=1)
    path[480:] += 50.0
    assert made(t, path).segments.tolist() == [0, 480, 600]


def test_a_place_far_behind_a_long_gap_is_a_jump_only_if_nothing_could_get_there() -> None:
    for away_m, jumps in ((1000.0, 0), (100.0 * MAX_SPEED_MPS, 1)):
        t, path = drive()
        t[300:] += 50.0
        path[300:] += away_m
        found = inspect(made(t, path))
        assert (found.gaps, found.jumps) == (1, jumps)


@given(seed=st.integers(0, 200), size_m=st.sampled_from([0.01, 0.5, 2.0, 8.0]))
def test_noise_is_no_jump_whatever_its_size(seed: int, size_m: float) -> None:
    t, path = drive()
    path += np.random.default_rng(seed).normal(0.0, size_m, path.shape)
    trip = made(t, path)
    assert trip.segments.tolist() == [0, t.size]
    assert jumps_between(trip.t_s, trip.position_m, trip.segments)[0].size == 0


@pytest.mark.parametrize(("size_m", "jumps"), [(0.8 * JUMP_TOLERANCE_M, 0), (1.2 * JUMP_TOLERANCE_M, 1)])
def test_the_tolerance_decides(size_m: float, jumps: int) -> None:
    t = np.arange(0.0, 40.0, 0.1)
    path = np.stack([10.0 * t, 0.0 * t], axis=1)
    path[200:, 1] += size_m
    assert made(t, path).segments.size - 2 == jumps


def test_a_wrong_unit_is_refused_by_name() -> None:
    t, path = drive()
    with pytest.raises(ValueError, match=r"599 of 599 steps are faster than any vehicle.*check the units"):
        build_trajectory("made/1", t, 1000.0 * path)


@given(
    st.integers(5, 60),
    st.integers(0, 2**32 - 1),
    st.sampled_from([0.0, 0.01, 0.5, 3.0]),
    st.lists(st.tuples(st.integers(0, 59), st.floats(-400.0, 400.0)), max_size=4),
)
def test_the_short_way_to_none_impossible_is_the_rule(
    count: int, seed: int, noise_m: float, jumps: list[tuple[int, float]]
):
    rng = np.random.default_rng(seed)
    t_s = np.cumsum(rng.choice([0.1, 0.2, 1.0], count))
    position_m = np.stack([12.0 * t_s, 0.4 * t_s**2], axis=1) + rng.normal(0.0, noise_m, (count, 2))
    for at, size_m in jumps:
        position_m[at:] += size_m
    steps = _Steps.of(t_s, position_m)
    found = steps.impossible()
    if found.size < 20:
        assert not found.any()
        return
    reach_m = MAX_ACCELERATION_MPS2 * steps.elapsed**2 + steps.tolerance_m
    assert np.array_equal(found, (np.minimum(*steps.deviations_m()) > reach_m) | steps.too_fast())
