"""Claims about trips: when they count as uniform, where they are split, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import Origin
from modelcast.trips.trajectory import (
    GAP_STEPS,
    UNIFORM_TOLERANCE_RATIO,
    Reading,
    Trajectory,
    build_trajectory,
)

ROUNDING_M = 1e-9
"""Interpolating and rotating kilometres in double precision."""


def line(t_s: FloatArray, **columns: FloatArray) -> Trajectory:
    """A drive at 10 m/s to the east and 4 m/s to the south."""
    return build_trajectory("made/1", t_s, np.stack([10 * t_s, -4 * t_s], axis=1), **columns)


def with_step(step_s: float) -> FloatArray:
    """Forty steps of 0.1 s with another one in the middle."""
    steps = np.full(40, 0.1)
    steps[20] = step_s
    return np.concatenate([[0.0], np.cumsum(steps)])


@pytest.mark.parametrize(
    ("step_s", "resampled"), [(0.0751, False), (0.1249, False), (0.0749, True), (0.1251, True)]
)
def test_a_trip_is_uniform_where_every_step_is_within_a_quarter_of_the_median(
    step_s: float, *, resampled: bool
) -> None:
    assert UNIFORM_TOLERANCE_RATIO == 0.25
    trip = line(with_step(step_s))
    assert trip.resampled == resampled
    assert trip.dt_s == pytest.approx(0.1)


def test_a_uniform_trip_keeps_its_times() -> None:
    t = np.cumsum(0.1 * np.random.default_rng(1).uniform(0.85, 1.15, 100))
    trip = line(t)
    assert not trip.resampled
    assert np.array_equal(trip.t_s, t - t[0])


@pytest.mark.parametrize(("step_s", "parts"), [(0.2499, 1), (0.2501, 2), (60.0, 2)])
def test_a_step_over_two_and_a_half_medians_splits_the_trip(step_s: float, parts: int) -> None:
    assert GAP_STEPS == 2.5
    assert line(with_step(step_s)).segments.size - 1 == parts


def test_a_gap_alone_does_not_make_a_trip_uneven() -> None:
    trip = line(with_step(5.0))
    assert not trip.resampled
    assert trip.segments.tolist() == [0, 21, 41]
    assert trip.segment_start[20:22].tolist() == [0, 21]
    assert trip.duration_s == pytest.approx(4.1)


@given(seed=st.integers(0, 1000), rate_hz=st.sampled_from([1.0, 10.0, 50.0]))
def test_resampling_lies_on_the_track_within_its_parts(seed: int, rate_hz: float) -> None:
    """It keeps each part's first time, ends within a step of its last, and has the median step between."""
    rng = np.random.default_rng(seed)
    steps = rng.uniform(0.5, 1.5, 60) / rate_hz
    steps[[20, 40]] = 30.0 / rate_hz
    t = np.concatenate([[0.0], np.cumsum(steps)])
    trip = line(t)
    assert trip.resampled
    assert trip.segments.size == 4
    assert np.abs(trip.position_m - np.outer(trip.t_s, (10, -4))).max() < ROUNDING_M
    bounds = zip(trip.segments[:-1], trip.segments[1:], (0, 21, 41), (20, 40, 60), strict=True)
    for first, end, old_first, old_last in bounds:
        part = trip.t_s[first:end]
        assert part[0] == pytest.approx(t[old_first])
        assert t[old_last] - trip.dt_s - 1e-9 < part[-1] <= t[old_last] + 1e-9
        assert np.diff(part) == pytest.approx(trip.dt_s)


def test_a_resampled_heading_turns_the_short_way_across_south() -> None:
    t = with_step(0.13)
    heading = np.where(np.arange(t.size) % 2, np.pi - 0.01, 0.01 - np.pi)
    trip = line(t, heading_rad=heading)
    assert trip.resampled
    assert trip.heading_rad is not None
    assert np.abs(trip.heading_rad).min() > np.pi - 0.011


def test_resampling_takes_every_column_along() -> None:
    t = with_step(0.13)
    names = ("speed_mps", "heading_rad", "acceleration_mps2", "yaw_rate_radps", "up_m")
    origin, reading = Origin(48.0, 11.0), Reading(rows=99, skipped={"blank": 58})
    position = np.stack([t, t], axis=1)
    trip = build_trajectory(
        "made/1",
        t,
        position,
        **dict.fromkeys(names, 0.1 * t),
        origin=origin,
        start_unix_s=5.0,
        source="csv",
        reading=reading,
    )
    for name in names:
        assert trip.columns()[name] == pytest.approx(0.1 * trip.t_s), name
    assert (trip.origin, trip.start_unix_s, trip.source, trip.reading) == (origin, 5.0, "csv", reading)


def test_times_start_at_zero_wherever_the_log_does() -> None:
    t = 1.6e9 + np.arange(5) * 0.1
    trip = build_trajectory("made/1", t, np.zeros((5, 2)))
    assert trip.t_s == pytest.approx(np.arange(5) * 0.1, abs=1e-6)


def test_one_sample_is_a_trip_of_one_step() -> None:
    trip = build_trajectory("made/1", np.array([3.0]), np.zeros((1, 2)))
    assert (len(trip), trip.t_s[0], trip.duration_s) == (1, 0.0, trip.dt_s)


def test_columns_are_those_that_are_present() -> None:
    t = np.arange(5) * 0.1
    assert set(line(t, speed_mps=t).columns()) == {"t_s", "position_m", "speed_mps"}


def test_the_callers_arrays_are_left_alone() -> None:
    t = 7.0 + np.arange(5) * 0.1
    kept = t.copy()
    line(t)
    assert np.array_equal(t, kept)


@given(rotation_rad=st.floats(-7.0, 7.0), east_m=st.floats(-1e4, 1e4), north_m=st.floats(-1e4, 1e4))
def test_moving_a_trip_keeps_distances_and_turns_headings_with_the_track(
    rotation_rad: float, east_m: float, north_m: float
) -> None:
    t = np.arange(30) * 0.1
    course = np.arctan2(10.0, -4.0)
    trip = line(t, heading_rad=np.full(30, course))
    moved = trip.moved(rotation_rad, (east_m, north_m))
    step = np.diff(moved.position_m, axis=0)
    assert np.hypot(*step.T) == pytest.approx(np.hypot(*np.diff(trip.position_m, axis=0).T))
    assert moved.heading_rad is not None
    along = np.stack([np.sin(moved.heading_rad), np.cos(moved.heading_rad)], axis=1)[1:]
    assert (along * step).sum(axis=1) == pytest.approx(np.hypot(*step.T))
    assert moved.position_m[0] == pytest.approx((east_m, north_m))


def test_a_quarter_turn_anticlockwise_takes_east_to_north() -> None:
    trip = build_trajectory("made/1", np.arange(2.0), np.array([[0.0, 0.0], [1.0, 0.0]]))
    assert trip.moved(np.pi / 2, (0.0, 0.0)).position_m[1] == pytest.approx((0.0, 1.0), abs=1e-12)


FINE = np.arange(4) * 0.1


@pytest.mark.parametrize(
    ("t_s", "position_m", "columns", "message"),
    [
        (np.empty(0), np.empty((0, 2)), {}, "t_s must be .* T >= 1"),
        (FINE, np.zeros((3, 2)), {}, r"position_m must be \(4, 2\), got \(3, 2\)"),
        (FINE, np.zeros((4, 3)), {}, r"position_m must be \(4, 2\), got \(4, 3\)"),
        (FINE, np.zeros((4, 2)), {"speed_mps": np.zeros(3)}, "speed_mps has 3 samples, t_s has 4"),
        (np.array([0.0, 0.1, np.nan, 0.3]), np.zeros((4, 2)), {}, "t_s is not finite at sample 2"),
        (FINE, np.array([[0, 0], [0, np.inf], [0, 0], [0, 0.0]]), {}, "position_m is not finite at sample 1"),
        (
            FINE,
            np.zeros((4, 2)),
            {"speed_mps": np.array([0, 0, 0, np.nan])},
            "speed_mps is not finite at sample 3",
        ),
        (
            np.array([0.0, 0.1, 0.1, 0.3]),
            np.zeros((4, 2)),
            {},
            "time does not increase at sample 2: 0.1 after 0.1",
        ),
        (
            np.array([0.0, 0.2, 0.1, 0.3]),
            np.zeros((4, 2)),
            {},
            "time does not increase at sample 2: 0.1 after 0.2",
        ),
    ],
)
def test_what_is_no_trip_is_refused_with_its_name_and_place(
    t_s: FloatArray, position_m: FloatArray, columns: dict[str, FloatArray], message: str
) -> None:
    with pytest.raises(ValueError, match=f"made/1: {message}"):
        build_trajectory("made/1", t_s, position_m, **columns)


@pytest.mark.parametrize("bounds", [[0, 3], [1, 4], [0, 2, 2, 4], [0, 3, 2, 4]])
def test_segments_must_rise_from_the_first_sample_to_the_last(bounds: list[int]) -> None:
    with pytest.raises(ValueError, match="segments must rise from 0 to 4"):
        Trajectory("made/1", FINE, np.zeros((4, 2)), segments=np.array(bounds), dt_s=0.1)


@pytest.mark.parametrize("dt_s", [0.0, -0.1, np.nan])
def test_a_step_must_be_positive(dt_s: float) -> None:
    with pytest.raises(ValueError, match="dt_s"):
        Trajectory("made/1", FINE, np.zeros((4, 2)), segments=np.array([0, 4]), dt_s=dt_s)


@pytest.mark.real
def test_real_trips_keep_the_rules_they_are_built_by(dynamic_trips: dict[str, Trajectory]) -> None:
    for trip in dynamic_trips.values():
        steps = np.diff(trip.t_s)
        inside = np.ones(steps.size, dtype=bool)
        inside[trip.segments[1:-1] - 1] = False
        assert (np.abs(steps[inside] - trip.dt_s) <= 0.25 * trip.dt_s + 1e-9).all()
        assert (steps[~inside] > GAP_STEPS * trip.dt_s).all()
