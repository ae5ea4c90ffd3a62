"""Platoons as they move: the drive in closed form, its limits, and what leaders drive."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.trips.trajectory import build_trajectory
from modelcast.world.platoon.dynamics import Drive, PlatoonState, driven
from modelcast.world.platoon.leaders import (
    BEGINS_S,
    AbstractLeader,
    Braking,
    RecordedSpeed,
    Sinusoid,
    Steady,
    recorded_leader,
)
from modelcast.world.platoon.platoons import Platoons

ROUNDING = 1e-9
"""A thousand steps in double precision, at places of some hundred metres."""


def state(speed_mps: float = 20.0, acceleration_mps2: float = 0.0) -> PlatoonState:
    start = Platoons(2, 3).init(np.full((2, 2), 5.0), speed_mps)
    return replace(start, acceleration_mps2=np.full((2, 3), acceleration_mps2))


def drive_for(seconds: float, steps: int, asked: float, lag_s: float = 0.5) -> PlatoonState:
    now, drive = state(), Drive(lag_s=lag_s)
    for _ in range(steps):
        now = driven(now, np.full((2, 2), asked), 20.0, seconds / steps, drive)
    return now


@pytest.mark.parametrize("steps", [1, 7, 300])
def test_a_command_reaches_the_road_through_a_first_order_lag(steps: int) -> None:
    """From rest of the drive: a = u (1 - e^(-t/tau)), and its integrals, in however many steps."""
    t_s, lag_s, asked = 2.0, 0.5, 1.5
    gone = np.exp(-t_s / lag_s)
    now = drive_for(t_s, steps, asked)
    assert now.acceleration_mps2[:, 1:] == pytest.approx(asked * (1.0 - gone), abs=ROUNDING)
    speed = 20.0 + asked * (t_s - lag_s * (1.0 - gone))
    assert now.speed_mps[:, 1:] == pytest.approx(speed, abs=ROUNDING)
    way = 20.0 * t_s + asked * (0.5 * t_s**2 - lag_s * t_s + lag_s**2 * (1.0 - gone))
    assert now.along_m[:, 1:] - state().along_m[:, 1:] == pytest.approx(way, abs=ROUNDING)
    assert now.along_m[:, 0] == pytest.approx(40.0, abs=ROUNDING)


def test_without_a_lag_a_command_is_done_at_once() -> None:
    now = drive_for(2.0, 4, 1.5, lag_s=0.0)
    assert now.speed_mps[:, 1:] == pytest.approx(23.0)
    assert now.along_m[:, 1:] - state().along_m[:, 1:] == pytest.approx(43.0)


@pytest.mark.parametrize(("asked", "done"), [(10.0, 2.5), (-30.0, -9.0)])
def test_no_more_is_done_than_the_drive_can(asked: float, done: float) -> None:
    now = driven(state(), np.full((2, 2), asked), 20.0, 0.1, Drive())
    assert now.commanded_mps2[:, 1:].tolist() == [[done] * 2] * 2


def test_who_brakes_comes_to_a_stop_and_stays() -> None:
    now, most = state(1.0, -3.0), 0.0
    for _ in range(50):
        before, now = now, driven(now, np.full((2, 2), -3.0), 1.0, 0.1, Drive())
        most = max(most, float((before.along_m - now.along_m)[:, 1:].max()))
    assert now.speed_mps[:, 1:].tolist() == [[0.0, 0.0]] * 2
    assert now.acceleration_mps2[:, 1:].tolist() == [[0.0, 0.0]] * 2
    assert most <= 0.0


def test_leaders_have_the_speed_they_are_given_and_its_acceleration() -> None:
    now = driven(state(), np.zeros((2, 2)), 20.5, 0.1, Drive())
    assert now.speed_mps[:, 0].tolist() == [20.5, 20.5]
    assert now.acceleration_mps2[:, 0] == pytest.approx([5.0, 5.0])
    assert now.along_m[:, 0] == pytest.approx([2.025, 2.025])


def test_a_frame_has_every_vehicle_in_its_slot_east_of_the_one_behind() -> None:
    platoons = Platoons(2, 3, length_m=4.5, apart_m=100.0)
    gap_m = np.array([[5.0, 6.0], [7.0, 8.0]])
    frame = platoons.frame(platoons.init(gap_m, 20.0))
    assert frame.position_m[:, 1].tolist() == [0.0] * 3 + [100.0] * 3
    assert frame.position_m[:, 0].tolist() == [0.0, -9.5, -20.0, 0.0, -11.5, -24.0]
    assert frame.heading_rad == pytest.approx(np.pi / 2.0)
    assert platoons.gap_m(platoons.init(gap_m, 20.0)).tolist() == gap_m.tolist()
    own, ahead, leader = platoons.pairs
    assert own.tolist() == [1, 2, 4, 5]
    assert ahead.tolist() == [0, 1, 3, 4]
    assert leader.tolist() == [0, 0, 3, 3]


def test_a_sinusoid_swings_by_its_amplitude_after_the_wait() -> None:
    leader = Sinusoid(20.0, 2.0, 0.25)
    t_s = np.array([0.0, BEGINS_S, BEGINS_S + 1.0, BEGINS_S + 3.0, BEGINS_S + 4.0])
    assert leader.speed_mps(t_s) == pytest.approx([20.0, 20.0, 22.0, 18.0, 20.0])


def test_a_braking_leader_stops_at_its_deceleration_and_stays() -> None:
    """Long after the lag: v0 - d (t - tau)."""
    leader = Braking(30.0, 3.0, 0.5)
    t_s = np.array([BEGINS_S, BEGINS_S + 6.0, BEGINS_S + 8.0, BEGINS_S + 20.0])
    assert leader.speed_mps(t_s) == pytest.approx([30.0, 30.0 - 3.0 * 5.5, 30.0 - 3.0 * 7.5, 0.0], abs=1e-4)


def test_a_recorded_leader_drives_the_longest_part_without_a_gap() -> None:
    t_s = np.concatenate([np.arange(10), 30.0 + np.arange(20)]) * 0.1
    speed = np.concatenate([np.full(10, 5.0), np.linspace(10.0, 12.0, 20)])
    trip = build_trajectory("a/1", t_s, np.column_stack([5.0 * t_s, 0.0 * t_s]), speed_mps=speed)
    leader = recorded_leader(trip)
    assert leader.speed_mps(np.array([0.0, BEGINS_S, BEGINS_S + 1.9, 99.0])).tolist() == [
        10.0,
        10.0,
        12.0,
        12.0,
    ]
    assert leader.lasts_s == pytest.approx(BEGINS_S + 1.9)
    assert leader.name == "a/1"


@pytest.mark.parametrize("leader", [Steady(), Sinusoid(), Braking()])
def test_leaders_wait_at_their_mean(leader: AbstractLeader) -> None:
    assert np.ptp(leader.speed_mps(np.linspace(0.0, BEGINS_S, 20))) < ROUNDING


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda: Steady(0.0), "mean_mps"),
        (lambda: Sinusoid(10.0, 11.0), "amplitude_mps"),
        (lambda: Sinusoid(frequency_hz=-1.0), "frequency_hz"),
        (lambda: Braking(deceleration_mps2=0.0), "deceleration_mps2"),
        (lambda: RecordedSpeed("a", np.zeros(1), np.zeros(1)), "T >= 2"),
        (lambda: RecordedSpeed("a", np.zeros(2), np.zeros(2)), "increase"),
        (lambda: Drive(lag_s=-0.1), "lag_s"),
        (lambda: Drive(hardest_mps2=0.0), "hardest_mps2"),
        (lambda: Platoons(0, 2), "two vehicles"),
        (lambda: Platoons(1, 1), "two vehicles"),
        (lambda: Platoons(1, 2, apart_m=0.0), "apart_m"),
        (lambda: replace(state(), speed_mps=np.zeros((2, 2))), "speed_mps"),
    ],
)
def test_impossible_platoons_are_refused(make: type, match: str) -> None:
    with pytest.raises(ValueError, match=match):
        make()
