"""Claims about who is ahead."""

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.models.context_columns import (
    CONTEXT_COLUMNS,
    LEADER_ACCELERATION,
    LEADER_ACCELERATION_BEFORE,
    LEADER_GAP,
    LEADER_KNOWN,
    LEADER_RELATIVE_SPEED,
)
from modelcast.station.context.ahead_kernels import follow
from modelcast.station.context.ahead_numbers import FARTHEST_M, Followers, followers
from modelcast.station.receiver.belief_kernels import (
    BELIEF_ACCELERATION,
    BELIEF_COLUMNS,
    BELIEF_HEADING,
    BELIEF_SPEED,
)

NORTH_AT_20 = np.array([0.0, 0.0, 0.0, 20.0, 0.0, 0.0, 0.0])


def remote(
    east: float, north: float, heading: float = 0.0, speed: float = 15.0, a: float = 0.0
) -> FloatArray:
    """How one remote is believed to move."""
    motion = np.zeros(BELIEF_COLUMNS)
    motion[:2] = east, north
    motion[BELIEF_SPEED], motion[BELIEF_HEADING], motion[BELIEF_ACCELERATION] = speed, heading, a
    return motion


def told(
    sample: FloatArray, remotes: list[FloatArray], *, held: Followers | None = None, t_s: float = 0.0
) -> FloatArray:
    """Context of a host among remotes 0, 1, ..."""
    out = np.zeros(CONTEXT_COLUMNS)
    motion = np.array(remotes).reshape(-1, BELIEF_COLUMNS)
    who = np.arange(len(remotes), dtype=np.int64)
    follow(followers(1) if held is None else held, 0, t_s, sample, who, motion, out)
    return out


def test_the_nearest_ahead_is_the_leader() -> None:
    found = told(NORTH_AT_20, [remote(0.0, 80.0), remote(1.0, 30.0, speed=18.0, a=-2.0), remote(0.0, -10.0)])
    assert found[LEADER_GAP] == pytest.approx(np.hypot(1.0, 30.0))
    assert found[LEADER_RELATIVE_SPEED] == -2.0
    assert found[LEADER_ACCELERATION] == found[LEADER_ACCELERATION_BEFORE] == -2.0
    assert found[LEADER_KNOWN] == 1.0
    assert not found[LEADER_KNOWN + 1 :].any()


@pytest.mark.parametrize(
    "other",
    [
        remote(0.0, -10.0),
        remote(3.0, 30.0),
        remote(-3.0, 30.0),
        remote(0.0, FARTHEST_M + 1.0),
        remote(0.0, 30.0, heading=np.pi),
        remote(0.0, 30.0, heading=0.6),
    ],
    ids=["behind", "lane to the right", "lane to the left", "too far", "oncoming", "crossing"],
)
def test_who_is_not_on_the_own_way_is_no_leader(other: FloatArray) -> None:
    assert not told(NORTH_AT_20, [other]).any()


@pytest.mark.parametrize("clockwise", [1.0, -1.0])
def test_in_a_bend_the_leader_is_on_the_arc_and_not_on_the_tangent(clockwise: float) -> None:
    radius_m, angle = 100.0, 0.5
    sample = NORTH_AT_20.copy()
    sample[5] = clockwise * 20.0 / radius_m
    on_arc = remote(
        clockwise * radius_m * (1.0 - np.cos(angle)), radius_m * np.sin(angle), heading=clockwise * angle
    )
    on_tangent = remote(0.0, radius_m * np.sin(angle), heading=0.0)
    assert told(sample, [on_arc])[LEADER_GAP] == pytest.approx(2.0 * radius_m * np.sin(angle / 2.0))
    assert not told(sample, [on_tangent]).any()


def test_a_standing_car_keeps_its_course_and_one_that_never_moved_has_none() -> None:
    standing = np.zeros(7)
    ahead = [remote(0.0, 8.0, speed=0.0)]
    assert not told(standing, ahead).any()
    held = followers(1)
    told(NORTH_AT_20, ahead, held=held)
    assert told(standing, ahead, held=held, t_s=1.0)[LEADER_KNOWN] == 1.0


def test_a_leader_that_drifts_is_kept_for_longer_than_a_new_one_is_taken() -> None:
    held = followers(1)
    told(NORTH_AT_20, [remote(0.0, 30.0)], held=held)
    assert told(NORTH_AT_20, [remote(3.0, 30.0)], held=held, t_s=0.1)[LEADER_KNOWN] == 1.0
    assert told(NORTH_AT_20, [remote(4.1, 30.0)], held=held, t_s=0.2)[LEADER_KNOWN] == 0.0
    assert told(NORTH_AT_20, [remote(3.0, 30.0)], held=held, t_s=0.3)[LEADER_KNOWN] == 0.0


def test_the_acceleration_before_is_what_was_believed_half_a_second_ago() -> None:
    held = followers(1)
    found = [
        told(NORTH_AT_20, [remote(0.0, 30.0, a=float(k))], held=held, t_s=0.1 * k)[LEADER_ACCELERATION_BEFORE]
        for k in range(200)
    ]
    assert found[:5] == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert found[5:] == [float(k - 5) for k in range(5, 200)]
    another = [remote(0.0, 60.0, a=1.0), remote(0.0, 20.0, a=7.0)]
    assert told(NORTH_AT_20, another, held=held, t_s=20.0)[LEADER_ACCELERATION_BEFORE] == 7.0
