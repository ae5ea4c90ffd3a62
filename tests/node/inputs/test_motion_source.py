"""Samples aligned onto ticks: causality, order, and what is left when a part fails."""

import math
from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.core.geodesy import Origin, geodetic_to_local, local_to_geodetic
from modelcast.node.inputs.motion import Motion
from modelcast.node.inputs.motion_source import MotionSource
from modelcast.node.inputs.reckoning import DEFAULT_AXIS_M
from modelcast.node.inputs.replay import TripReplay
from modelcast.node.inputs.samples import BusValue, GnssFix, Sample
from modelcast.world.drive import generate_drive

AT = Origin(42.0, -83.0)
SPEED_MPS, YAW_RADPS = 15.0, 0.1
ROUNDING_M = 1e-6
"""Places go through latitude and longitude."""


def place(t_s: float) -> tuple[float, float]:
    """Where a car on a circle to the right is, from north at the origin."""
    radius_m = SPEED_MPS / YAW_RADPS
    return radius_m * (1.0 - math.cos(YAW_RADPS * t_s)), radius_m * math.sin(YAW_RADPS * t_s)


def fix(t_s: float, *, at_s: float | None = None, late_s: float = 0.0, **more: float) -> GnssFix:
    east_north = np.array([place(t_s if at_s is None else at_s)])
    latitude, longitude = local_to_geodetic(east_north, AT)[0].tolist()
    made = GnssFix(
        received_s=t_s + late_s, measured_s=t_s, latitude_deg=latitude, longitude_deg=longitude,
        speed_mps=SPEED_MPS, heading_rad=YAW_RADPS * (t_s if at_s is None else at_s),
    )  # fmt: skip
    return replace(made, **more)


def bus(t_s: float, speed_mps: float = SPEED_MPS, yaw_radps: float = YAW_RADPS) -> list[BusValue]:
    return [BusValue("speed_mps", speed_mps, t_s, t_s), BusValue("yaw_rate_radps", yaw_radps, t_s, t_s)]


def times(begin_s: float, end_s: float, step_s: float) -> list[float]:
    return [begin_s + step_s * at for at in range(round((end_s - begin_s) / step_s) + 1)]


def fed(samples: Iterable[Sample], **rules: float) -> MotionSource:
    source = MotionSource(AT, **rules)
    source.feed(samples)
    return source


def all_bus(begin_s: float, end_s: float, step_s: float = 0.02) -> list[BusValue]:
    return [value for t_s in times(begin_s, end_s, step_s) for value in bus(t_s)]


def error_m(motion: Motion | None, t_s: float) -> float:
    assert motion is not None
    east_m, north_m = place(t_s)
    return math.hypot(motion.position_m[0] - east_m, motion.position_m[1] - north_m)


def same(one: Motion | None, other: Motion | None) -> bool:
    if one is None or other is None:
        return one is other
    numbers = [
        np.array(
            [
                *motion.place_deg, *motion.position_m, motion.speed_mps, motion.heading_rad,
                motion.acceleration_mps2, motion.yaw_rate_radps, *motion.covariance_m2.ravel(), motion.age_s,
            ]
        )
        for motion in (one, other)
    ]  # fmt: skip
    return one.mode == other.mode and np.array_equal(*numbers, equal_nan=True)


def test_a_fix_at_the_tick_is_given_as_it_was_measured():
    trip = generate_drive(2, 90.0).truth
    replay = TripReplay(trip)
    source = MotionSource(replay.origin)
    for at, t_s in enumerate(replay.times_s[:300].tolist()):
        source.feed(replay.take(t_s))
        motion = source.at(t_s)
        assert motion is not None
        assert motion.position_m == tuple(trip.position_m[at].tolist())
        assert motion.heading_rad == trip.heading_rad[at]
        assert (motion.speed_mps, motion.acceleration_mps2, motion.yaw_rate_radps) == (
            trip.speed_mps[at], trip.acceleration_mps2[at], trip.yaw_rate_radps[at]
        )  # fmt: skip
        assert motion.derived == frozenset()
        assert motion.begins == (at == 0)


def test_between_fixes_the_place_is_carried_on_along_the_arc():
    source = fed([fix(t_s, late_s=0.07) for t_s in times(0.0, 3.0, 0.1)] + all_bus(0.0, 3.2))
    for t_s in times(1.03, 3.03, 0.1):
        motion = source.at(t_s)
        assert error_m(motion, t_s) < ROUNDING_M + 1e-4  # the arc is summed in pieces of 20 ms
        assert motion.heading_rad == pytest.approx(YAW_RADPS * t_s, abs=1e-9)
        assert motion.mode == "gnss+can"


def test_fixes_alone_give_speed_and_turn_by_their_slopes():
    source = fed([fix(t_s) for t_s in times(0.0, 3.0, 0.1)])
    motion = source.at(3.05)
    assert motion.mode == "gnss"
    assert motion.yaw_rate_radps == pytest.approx(YAW_RADPS, abs=1e-6)
    assert motion.acceleration_mps2 == pytest.approx(0.0, abs=1e-6)
    assert error_m(motion, 3.05) < 1e-3
    assert motion.derived == {"speed_mps", "heading_rad", "acceleration_mps2", "yaw_rate_radps"}


@pytest.mark.parametrize(("step_s", "stale_s"), [(0.05, 0.3), (0.1, 0.3), (0.2, 0.6), (1.0, 1.0)])
def test_a_fix_is_stale_after_three_periods_and_never_given_as_fresh(step_s: float, stale_s: float):
    last_s = times(0.0, 5.0, step_s)[-1]
    samples = [fix(t_s) for t_s in times(0.0, 5.0, step_s)] + all_bus(0.0, 12.0)
    assert fed(samples).at(last_s + stale_s - 0.01).mode == "gnss+can"
    assert fed(samples).at(last_s + stale_s + 0.01).mode == "can"
    assert fed([one for one in samples if isinstance(one, GnssFix)]).at(last_s + stale_s + 0.01) is None


def test_without_fixes_the_bus_carries_on_for_the_stated_time_then_there_is_silence():
    source = fed([fix(t_s) for t_s in times(0.0, 15.0, 0.1)] + all_bus(0.0, 30.0), dead_reckoning_s=5.0)
    radii: list[float] = []
    for t_s in times(15.0, 20.0, 0.1):
        motion = source.at(t_s)
        assert error_m(motion, t_s) < 0.01
        radii.append(motion.ellipse[0])
    assert radii[0] == pytest.approx(DEFAULT_AXIS_M)
    assert all(later > sooner for sooner, later in pairwise(radii[4:]))
    assert source.at(20.1) is None
    assert [(one.before, one.after) for one in source.events()] == [
        ("silent", "gnss+can"), ("gnss+can", "can"), ("can", "silent"),
    ]  # fmt: skip
    assert "too long" in source.health.why


def test_what_the_bus_is_off_by_is_learnt_while_there_are_fixes():
    off = [value for t_s in times(0.0, 20.0, 0.02) for value in bus(t_s, SPEED_MPS / 1.05, YAW_RADPS + 0.02)]
    source = fed([fix(t_s) for t_s in times(0.0, 15.0, 0.1)] + off)
    source.at(15.0)
    assert error_m(source.at(20.0), 20.0) < 0.05


@pytest.mark.parametrize(("stands_s", "largest_m"), [(20.0, 0.1), (60.0, math.inf)])
def test_a_car_that_drives_off_in_an_outage_after_a_stop_knows_its_course_or_says_that_it_does_not(
    stands_s: float, largest_m: float
):
    """Courses of a standing antenna are noise; the one it stopped with holds."""
    rng = np.random.default_rng(3)
    lost_s = 12.0 + stands_s
    drives = [fix(t_s) for t_s in times(0.0, 12.0, 0.1)]
    stands = [
        fix(t_s, at_s=12.0, speed_mps=0.1, heading_rad=float(rng.uniform(0.0, 6.0)))
        for t_s in times(12.1, lost_s, 0.1)
    ]
    goes = lost_s + 0.5
    values = [
        value
        for t_s in times(0.0, lost_s + 3.0, 0.02)
        for value in (bus(t_s) if t_s <= 12.0 or t_s > goes else bus(t_s, 0.0, 0.0))
    ]
    source = fed(drives + stands + values)
    driven_s = 2.5
    motion = source.at(goes + driven_s)
    assert motion.mode == "can"
    error = error_m(motion, 12.0 + driven_s)
    assert error < largest_m + 0.4  # the bus begins to move between two of its values
    if largest_m == math.inf:
        assert motion.ellipse[0] > SPEED_MPS * driven_s


def test_a_bus_that_missed_turns_is_trusted_less():
    def jittering(yaw_radps: float) -> list[BusValue]:
        jitter = [1e-6 * (at % 2) for at in range(1001)]
        return [one for at, by in enumerate(jitter) for one in bus(0.02 * at, yaw_radps=yaw_radps + by)]

    fixes = [fix(t_s) for t_s in times(0.0, 15.0, 0.1)]
    good, blind = (fed(fixes + jittering(yaw_radps)).at(18.0) for yaw_radps in (YAW_RADPS, 0.0))
    assert good.mode == blind.mode == "can"
    assert blind.ellipse[0] > 1.5 * good.ellipse[0]


def test_between_slow_fixes_the_speed_follows_their_slope():
    fixes = [fix(t_s, speed_mps=10.0 + 2.0 * t_s) for t_s in times(0.0, 5.0, 0.4)]
    motion = fed(fixes).at(5.1)
    assert motion.mode == "gnss"
    assert motion.speed_mps == pytest.approx(10.0 + 2.0 * 5.1)
    braking = [fix(t_s, speed_mps=max(8.0 - 2.0 * t_s, 0.1)) for t_s in times(0.0, 4.0, 0.4)]
    assert fed(braking).at(4.6).speed_mps == 0.0  # and never backwards


def test_the_course_of_a_car_that_stands_is_no_turn():
    rng = np.random.default_rng(1)
    standing = [
        fix(t_s, at_s=0.0, speed_mps=0.2, heading_rad=float(rng.uniform(0.0, 6.0)))
        for t_s in times(0.0, 3.0, 0.1)
    ]
    assert fed(standing).at(3.0).yaw_rate_radps == 0.0


def test_a_bus_without_yaw_rate_does_not_carry_on():
    values = [one for one in all_bus(0.0, 10.0) if one.quantity == "speed_mps"]
    source = fed([fix(t_s) for t_s in times(0.0, 5.0, 0.1)] + values)
    assert source.at(5.0).mode == "gnss"
    assert source.at(5.5) is None


def test_a_lost_bus_leaves_fixes_and_each_change_is_told():
    source = fed([fix(t_s) for t_s in times(0.0, 10.0, 0.1)] + all_bus(0.0, 5.0))
    modes = [source.at(t_s).mode for t_s in times(0.0, 10.0, 0.1)]
    assert modes == ["gnss+can"] * 54 + ["gnss"] * 47
    change = source.events()[-1]
    assert (change.after, change.why) == ("gnss", "bus lost")
    assert change.t_s == pytest.approx(5.4)


def test_after_silence_and_after_a_jump_a_part_begins():
    lost = [fix(t_s) for t_s in [*times(0.0, 5.0, 0.1), *times(9.0, 10.0, 0.1)]]
    source = fed(lost)
    begins = [motion.begins for t_s in times(0.0, 10.0, 0.1) if (motion := source.at(t_s)) is not None]
    assert [at for at, one in enumerate(begins) if one] == [0, 54]
    moved = [fix(t_s, at_s=t_s + 0.5) for t_s in times(7.0, 10.0, 0.1)]
    source = fed([fix(t_s) for t_s in times(0.0, 5.0, 0.1)] + moved + all_bus(0.0, 10.0))
    motions = [source.at(t_s) for t_s in times(0.0, 10.0, 0.1)]
    assert [at for at, one in enumerate(motions) if one.begins] == [0, 70]


def test_an_old_fix_of_a_backlog_is_left_out():
    source = fed([fix(t_s, late_s=60.0 - t_s) for t_s in times(0.0, 30.0, 0.1)])
    assert source.at(60.0) is None
    assert source.health.counts["late"] == 301
    assert source.health.why == "no fix yet"


def test_a_clock_that_goes_back_begins_anew():
    source = fed([fix(t_s) for t_s in times(100.0, 101.0, 0.1)])
    assert source.at(101.0) is not None
    assert source.at(50.0) is None
    source.feed(fix(t_s) for t_s in times(50.0, 51.0, 0.1))
    assert source.at(51.0) is not None
    assert source.health.counts["clock went back"] == 1


def test_a_place_that_freezes_while_the_bus_drives_is_reckoned_on_from_where_it_froze():
    frozen = [
        fix(t_s, at_s=min(t_s, 5.0), speed_mps=0.0) if t_s > 5.0 else fix(t_s) for t_s in times(0.0, 9.0, 0.1)
    ]
    source = fed(frozen + all_bus(0.0, 9.0))
    motions = {round(t_s, 1): source.at(t_s) for t_s in times(0.0, 9.0, 0.1)}
    assert motions[5.3].mode == "gnss+can"  # it does not show yet
    assert [motions[t_s].mode for t_s in (5.5, 7.0, 9.0)] == ["can"] * 3
    assert error_m(motions[9.0], 9.0) < 0.1
    assert "place" in source.health.frozen
    assert ("frozen", "place") in [(one.what, one.after) for one in source.events()]


def test_a_car_that_stands_is_not_frozen():
    standing = [fix(t_s, at_s=0.0, speed_mps=0.0) for t_s in times(0.0, 9.0, 0.1)]
    values = [value for t_s in times(0.0, 9.0, 0.02) for value in bus(t_s, 0.0, 0.0)]
    source = fed(standing + values)
    assert source.at(9.0).mode == "gnss+can"
    assert source.health.frozen == frozenset()


def test_a_speed_on_cruise_control_is_not_frozen_and_one_that_contradicts_the_fixes_is():
    steady = fed([fix(t_s) for t_s in times(0.0, 5.0, 0.1)] + all_bus(0.0, 5.0))
    assert steady.at(5.0).mode == "gnss+can"
    stuck = [value for t_s in times(0.0, 5.0, 0.02) for value in bus(t_s, 5.68)]
    source = fed([fix(t_s) for t_s in times(0.0, 5.0, 0.1)] + stuck)
    motion = source.at(5.0)
    assert motion.mode == "gnss"
    assert motion.speed_mps == SPEED_MPS
    assert source.health.frozen == {"speed_mps"}
    assert source.health.why == "speed_mps frozen"


@pytest.mark.parametrize(("after_s", "mode"), [(0.9, "gnss+can"), (1.1, "gnss")])
def test_a_speed_that_hangs_shows_when_the_fixes_have_contradicted_it_for_a_second(after_s: float, mode: str):
    last_s = 4.0 + after_s
    stuck = [value for t_s in times(0.0, last_s, 0.02) for value in bus(t_s, SPEED_MPS)]
    fixes = [
        fix(t_s, speed_mps=SPEED_MPS - (2.0 if t_s > 4.0 - 1e-6 else 0.0)) for t_s in times(0.0, last_s, 0.1)
    ]
    assert fed(fixes + stuck).at(last_s).mode == mode


def test_a_yaw_rate_that_misses_a_turn_is_frozen():
    straight = [value for t_s in times(0.0, 5.0, 0.02) for value in bus(t_s, yaw_radps=0.0)]
    source = fed([fix(t_s) for t_s in times(0.0, 5.0, 0.1)] + straight)
    assert source.at(5.0).mode == "gnss"
    assert source.health.frozen == {"yaw_rate_radps"}


def test_two_sentences_of_one_instant_are_one_fix_the_later_one():
    source = fed([fix(1.0), fix(1.0, late_s=0.01, altitude_m=7.0)])
    assert source.at(1.02).altitude_m == 7.0


def test_an_ellipse_that_is_not_stated_is_unavailable_and_one_that_is_is_kept():
    assert not fed([fix(1.0)]).at(1.0).ellipse_known
    stated = fix(1.0, semi_major_m=2.0, semi_minor_m=1.0, ellipse_orientation_rad=0.3)
    motion = fed([stated]).at(1.0)
    assert motion.ellipse_known
    assert motion.ellipse == pytest.approx((2.0, 1.0, 0.3))


def test_without_any_heading_there_is_silence_until_places_tell_one():
    silent = [fix(t_s, heading_rad=math.nan) for t_s in times(0.0, 1.0, 0.1)]
    source = fed(silent)
    assert source.at(0.0) is None
    assert source.health.why == "no heading yet"
    assert source.at(1.0).heading_rad == pytest.approx(YAW_RADPS * 0.95, abs=0.02)


@pytest.mark.slow
def test_events_and_waiting_samples_are_bounded():
    source = MotionSource(AT)
    source.feed(fix(0.0, late_s=0.5) for _ in range(70_000))
    assert source.health.counts["overrun"] == 70_000 - 65_536
    for at in range(1000):
        t_s = float(10 * at)
        source.feed([fix(t_s)])
        source.at(t_s)
        source.at(t_s + 5.0)
    assert len(source.events()) == 256
    assert source.events() == []


SAMPLES: list[Sample] = sorted(
    [fix(t_s, late_s=0.05) for t_s in [*times(0.0, 1.5, 0.1), *times(3.0, 4.0, 0.1)]]
    + all_bus(0.0, 3.5, 0.05),
    key=lambda one: one.received_s,
)
TICKS = times(0.0, 4.0, 0.1)


@settings(max_examples=30)
@given(st.floats(0.0, 4.0), st.randoms(use_true_random=False))
def test_what_was_given_out_does_not_change_with_what_comes_later(cut_s: float, random):
    until_cut = [one for one in SAMPLES if one.received_s <= cut_s]
    later = [one for one in SAMPLES if one.received_s > cut_s]
    wild = [one for one in later if random.random() < 0.5]
    wild += [fix(cut_s + 0.2 * random.random() + 0.01, at_s=30.0 * random.random()) for _ in range(3)]
    known, other = fed(until_cut), fed(until_cut + wild)
    for t_s in TICKS:
        if t_s <= cut_s:
            assert same(known.at(t_s), other.at(t_s))


@settings(max_examples=30)
@given(st.randoms(use_true_random=False))
def test_the_order_of_samples_between_ticks_does_not_matter(random):
    shuffled = SAMPLES.copy()
    random.shuffle(shuffled)
    for one, other in [(fed(SAMPLES), fed(shuffled))]:
        for t_s in TICKS:
            assert same(one.at(t_s), other.at(t_s))


@settings(max_examples=30)
@given(st.lists(st.floats(0.0, 0.4), min_size=len(SAMPLES), max_size=len(SAMPLES)))
def test_samples_that_come_late_give_what_they_give_in_time_once_all_are_there(delays: list[float]):
    late = [replace(one, received_s=one.received_s + by_s) for one, by_s in zip(SAMPLES, delays, strict=True)]
    for until_s in (2.3, 2.4):  # in the outage that begins at 1.5 s, for what was measured up to 1.9 s
        in_time = [one for one in SAMPLES if one.measured_s <= 1.9]
        too_late = [one for one in late if one.measured_s <= 1.9]
        assert same(fed(in_time).at(until_s), _after_ticks(too_late, until_s))


def _after_ticks(samples: list[Sample], until_s: float) -> Motion | None:
    source = fed(samples)
    for t_s in times(0.0, until_s - 0.1, 0.1):
        source.at(t_s)
    return source.at(until_s)


def test_a_place_on_the_trips_plane_is_not_taken_for_one_on_its_own() -> None:
    """Without an origin the plane begins at the first fix used, wherever the trip's own plane begins."""
    trip = generate_drive(1, 90.0).truth
    replay = TripReplay(trip)
    source = MotionSource()
    replay.take(19.95)  # what came before is lost
    for tick in range(200, 230):
        source.feed(replay.take(tick * 0.1))
        motion = source.at(tick * 0.1)
    assert motion is not None
    assert source.origin is not None
    assert source.origin != replay.origin
    wanted = geodetic_to_local(np.array([motion.place_deg]), source.origin)[0]
    assert np.allclose(motion.position_m, wanted, atol=1e-6)
