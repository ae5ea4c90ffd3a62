"""Lower rates: nothing comes from later samples, ages are bounded, gaps and jumps stay what they are."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from modelcast.trips.rate import HOLD_STEPS, READ_DELAY_STEPS, at_rate
from modelcast.trips.trajectory import Trajectory, build_trajectory


def drive(t_s, **columns: float) -> Trajectory:
    t_s = np.asarray(t_s, dtype=np.float64)
    return build_trajectory("made/1", t_s, np.stack([10.0 * t_s, t_s], axis=1), **columns)


def jittered(steps, seed=0):
    rng = np.random.default_rng(seed)
    return np.cumsum(np.asarray(steps) * 0.1 * (1.0 + rng.uniform(-0.1, 0.1, len(steps))))


steps = st.lists(st.sampled_from([1, 1, 1, 1, 1, 1, 8]), min_size=3, max_size=80)
rates = st.sampled_from([1.0, 2.0, 3.0, 4.0, 5.0, 7.5])


def kept(trip: Trajectory, count: int) -> Trajectory:
    """Return a trip's first samples."""
    columns = {name: column[:count] for name, column in trip.columns().items()}
    segments = np.append(trip.segments[trip.segments < count], count)
    return replace(trip, **columns, segments=segments)


@given(steps=steps, rate_hz=rates, share=st.floats(0.1, 1.0), seed=st.integers(0, 9))
def test_what_comes_later_changes_nothing_before(steps, rate_hz, share, seed):
    whole = drive(jittered(steps, seed))
    assume(whole.dt_s < 0.13)
    count = max(2, round(share * len(whole)))
    other = replace(
        whole,
        position_m=np.where(np.arange(len(whole))[:, None] < count, whole.position_m, 1e3),
    )
    read = at_rate(whole, rate_hz)
    before = read.t_s + READ_DELAY_STEPS / rate_hz < whole.t_s[count - 1]
    np.testing.assert_array_equal(at_rate(other, rate_hz).position_m[before], read.position_m[before])
    short = at_rate(kept(whole, count), rate_hz)
    same = min(int(before.sum()), len(short))
    assert same >= before.sum() - 1
    assert short.t_s[:same].tolist() == read.t_s[:same].tolist()
    assert short.position_m[:same].tobytes() == read.position_m[:same].tobytes()


@given(steps=steps, rate_hz=rates, seed=st.integers(0, 9))
def test_every_sample_is_the_last_one_at_or_before_its_reading(steps, rate_hz, seed):
    trip = drive(jittered(steps, seed))
    assume(trip.dt_s < 0.13)
    read = at_rate(trip, rate_hz)
    delay_s = READ_DELAY_STEPS / rate_hz
    for t_s, position_m in zip(read.t_s, read.position_m, strict=True):
        last = int(np.flatnonzero(trip.t_s <= t_s + delay_s + 1e-9)[-1])
        assert position_m.tolist() == trip.position_m[last].tolist()
        assert t_s + delay_s - trip.t_s[last] <= HOLD_STEPS / rate_hz + 1e-9
    inside = np.delete(np.diff(read.t_s), read.segments[1:-1] - 1)
    np.testing.assert_allclose(inside, 1.0 / rate_hz, rtol=1e-9)


def test_a_rate_that_divides_takes_every_nth_sample():
    trip = drive(0.1 * np.arange(100))
    read = at_rate(trip, 5.0)
    assert read.position_m.tobytes() == trip.position_m[::2][: len(read)].tobytes()
    assert len(read) == 50
    assert dict(read.reading.repaired) == {"taken at 5 Hz": 50}


def test_its_own_rate_changes_no_sample_whatever_the_jitter():
    trip = drive(0.1 * np.arange(200) + np.random.default_rng(1).uniform(-2e-3, 2e-3, 200))
    read = at_rate(trip, 10.0)
    assert read.position_m.tobytes() == trip.position_m.tobytes()
    assert read.segments.tolist() == [0, 200]


def test_ages_of_a_rate_that_does_not_divide_are_counted():
    read = at_rate(drive(0.3 * np.arange(40)), 3.0)
    assert read.dt_s == pytest.approx(1 / 3)
    assert read.reading.repaired["over half a step old at 3 Hz"] > 0
    assert read.reading.samples == 40


def test_a_recording_a_little_slower_is_held_and_counted():
    read = at_rate(drive(np.arange(60) / 9.0), 10.0)
    held = read.reading.repaired["held at 10 Hz"]
    assert held == pytest.approx(6, abs=1)
    assert (np.abs(np.diff(read.position_m[:, 0])) < 1e-12).sum() == held
    assert read.segments.size == 2


def test_a_slower_recording_is_refused():
    with pytest.raises(ValueError, match="recorded at 5 Hz, slower than the rate of 10 Hz"):
        at_rate(drive(0.2 * np.arange(20)), 10.0)


@pytest.mark.parametrize("rate_hz", [0.0, -1.0, np.nan, np.inf])
def test_a_rate_that_is_none_is_refused(rate_hz):
    with pytest.raises(ValueError, match="must be positive and finite"):
        at_rate(drive(0.1 * np.arange(20)), rate_hz)


def test_gaps_split_and_absolute_times_are_those_of_the_readings():
    t_s = np.concatenate([0.1 * np.arange(20), 1e6 + 0.1 * np.arange(20)])
    read = at_rate(drive(t_s, start_unix_s=1e9, clock_s=7.0), 5.0)
    assert read.segments.size == 3
    assert len(read) <= 22
    assert (read.start_unix_s, read.clock_s) == (1e9 + 0.0125, 7.0125)


def test_uneven_recordings_look_a_recorded_step_ahead_and_no_further():
    t_s = np.cumsum(np.random.default_rng(0).uniform(0.06, 0.16, 200))
    t_s -= t_s[0]
    line = np.stack([10 * t_s, 0 * t_s], axis=1)
    whole = at_rate(build_trajectory("made/1", t_s, line), 5.0)
    seen: list[bool] = []
    for cut in range(50, 150, 7):
        moved = line + np.stack([0 * t_s, t_s >= t_s[cut]], axis=1)
        other = at_rate(build_trajectory("made/1", t_s, moved), 5.0)
        differs = (whole.position_m != other.position_m).any(axis=1)
        read_s = whole.t_s + 0.0125
        assert not differs[read_s < t_s[cut - 1]].any()
        seen.append(bool(differs[read_s < t_s[cut]].any()))
    assert any(seen)


def test_what_was_interpolated_with_samples_ahead_is_told():
    trip = drive([0.0, 0.1, 0.25, 0.3, 0.4, 0.55, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1])
    assert trip.resampled
    assert at_rate(trip, 5.0).reading.repaired["interpolated before, with samples ahead"] > 0
