"""Claims about a node's time."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.node.clock import ManualClock, SteeredClock, SystemClock, read_together


def test_it_begins_within_a_minute_of_utc():
    clock = SteeredClock(1_764_000_123.25)
    assert clock.minute_utc_s % 60.0 == 0.0
    assert 0.0 <= clock.at(0.0) < 60.0
    assert clock.utc_s(7.0) == 1_764_000_130.25


@given(
    st.lists(
        st.tuples(st.floats(0.0, 100.0), st.floats(-5.0, 5.0), st.lists(st.floats(0.0, 20.0), max_size=4)),
        max_size=8,
    )
)
def test_it_never_goes_back_whatever_utc_is_said_to_be(
    course: list[tuple[float, float, list[float]]],
) -> None:
    clock, counted_s, seen = SteeredClock(0.0), 0.0, [0.0]
    for wait_s, off_s, asked in course:
        counted_s += wait_s
        seen.append(clock.at(counted_s))
        clock.steer(counted_s, utc_s=counted_s + off_s)
        for later_s in asked:
            counted_s += later_s
            seen.append(clock.at(counted_s))
    assert seen == sorted(seen)
    assert all(math.isfinite(one) for one in seen)


@pytest.mark.parametrize("error_s", [-0.2, -0.01, 0.01, 0.2])
def test_a_small_error_is_taken_back_at_one_per_cent(error_s: float) -> None:
    clock = SteeredClock(0.0)
    clock.steer(10.0, utc_s=10.0 + error_s)
    needed_s = abs(error_s) / 0.01
    assert clock.at(10.0) == 10.0
    half_s = 10.0 + needed_s / 2
    assert clock.at(half_s) == pytest.approx(half_s + error_s / 2)
    assert clock.at(10.0 + 2 * needed_s) == pytest.approx(10.0 + 2 * needed_s + error_s)
    assert clock.steps == 0


def test_far_behind_it_steps_and_far_ahead_it_waits() -> None:
    clock = SteeredClock(0.0)
    clock.steer(10.0, utc_s=13.0)
    assert clock.at(10.0) == 13.0
    clock.steer(20.0, utc_s=20.0)
    assert [clock.at(20.0), clock.at(22.9), clock.at(24.0)] == [23.0, 23.0, 24.0]
    assert clock.steps == 2


def test_what_is_no_number_does_not_steer() -> None:
    clock = SteeredClock(0.0)
    clock.steer(5.0, utc_s=math.nan)
    assert clock.at(6.0) == 6.0
    with pytest.raises(ValueError, match="utc_s must be finite"):
        SteeredClock(math.inf)


def test_the_machines_clock_grows_and_is_the_machines_utc() -> None:
    clock = SystemClock()
    one = clock.now_s()
    clock.follow_system()
    assert 0.0 <= clock.now_s() - one < 5.0
    assert clock.steps == 0


def test_a_clock_set_by_hand_is_not_set_back() -> None:
    clock = ManualClock(3.0)
    clock.set(4.0)
    with pytest.raises(ValueError, match=r"not before 4\.0"):
        clock.set(3.5)
    assert clock.now_s() == 4.0


def test_a_clock_that_is_read_while_others_run_is_read_again() -> None:
    """Of readings that took 50, 20 and 0.05 ms the last counts, and no more are made."""
    counted = iter([0.0, 0.05, 1.0, 1.02, 2.0, 2.00005])
    utc = iter([100.049, 101.0, 102.00001])
    counted_s, utc_s = read_together(lambda: next(counted), lambda: next(utc))
    assert utc_s - counted_s == pytest.approx(100.0, abs=5e-5)


def test_where_a_machine_is_always_busy_the_quickest_reading_counts() -> None:
    counted = iter([0.0, 0.5, 1.0, 1.1, 2.0, 2.9])
    utc = iter([100.4, 101.06, 102.1])
    counted_s, utc_s = read_together(lambda: next(counted), lambda: next(utc), most=3)
    assert utc_s - counted_s == pytest.approx(100.0, abs=0.05)
