"""Compiled choice of the vehicle ahead among the remotes that a host believes in."""

from math import atan2, cos, hypot, pi, sin

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntMatrix, IntVector
from modelcast.models.context_columns import (
    LEADER_ACCELERATION,
    LEADER_ACCELERATION_BEFORE,
    LEADER_GAP,
    LEADER_KNOWN,
    LEADER_RELATIVE_SPEED,
)
from modelcast.models.point_kernels import EAST, NORTH, VELOCITY_EAST, VELOCITY_NORTH, YAW_RATE
from modelcast.station.context.ahead_numbers import (
    BEFORE_S,
    FARTHEST_M,
    HELD_LATERAL_M,
    LATERAL_M,
    MOVES_MPS,
    RING,
    WITHIN_RAD,
    Followers,
)
from modelcast.station.receiver.belief_kernels import (
    BELIEF_ACCELERATION,
    BELIEF_COLUMNS,
    BELIEF_HEADING,
    BELIEF_SPEED,
    live_slots,
    predict_motions,
)
from modelcast.station.receiver.heard_kernels import RECEIVED, Messages
from modelcast.station.receiver.hearing_kernels import Rules, hear_each
from modelcast.station.receiver.slot_kernels import FACT_VEHICLE, KnownProfiles, Slots

__all__ = ["follow", "hear_and_follow"]


@kernel
def _ahead_m(sample: FloatVector, course: float, motion: FloatVector, lateral_m: float) -> float:
    """How far ahead a remote is, antenna to antenna, infinite where it is not on the own arc ahead."""
    off_east, off_north = motion[0] - sample[EAST], motion[1] - sample[NORTH]
    away_m = hypot(off_east, off_north)
    forward = off_east * sin(course) + off_north * cos(course)
    right = off_east * cos(course) - off_north * sin(course)
    if forward <= 0.0 or away_m > FARTHEST_M:
        return np.inf
    speed = hypot(sample[VELOCITY_EAST], sample[VELOCITY_NORTH])
    turned, lateral = 0.0, right
    if speed >= MOVES_MPS and abs(sample[YAW_RATE]) * FARTHEST_M > 1e-6 * speed:
        radius = speed / sample[YAW_RATE]  # the centre lies this far to the right
        turned = atan2(forward, abs(radius) - right * np.sign(radius)) * np.sign(radius)
        lateral = (abs(radius) - hypot(forward, radius - right)) * np.sign(radius)
    angle = (motion[BELIEF_HEADING] - course - turned + pi) % (2.0 * pi) - pi
    if not (abs(lateral) <= lateral_m and abs(angle) <= WITHIN_RAD):
        return np.inf
    return away_m


@kernel
def _remembered(followers: Followers, host: int, t_s: float, vehicle: int, now: float) -> float:
    """What was believed of a leader's acceleration `BEFORE_S` ago; that of now where it was no leader then.

    Remembers that of now.
    """
    ring_s, ring, who = followers.ring_s[host], followers.ring[host], followers.who[host]
    best, best_s = now, -np.inf
    for k in range(RING):
        if who[k] == vehicle and best_s < ring_s[k] <= t_s - BEFORE_S + 1e-6:
            best, best_s = ring[k], ring_s[k]
    oldest = 0
    for k in range(1, RING):
        if ring_s[k] < ring_s[oldest]:
            oldest = k
    if t_s - best_s > 2.0 * BEFORE_S:
        best = now
    ring_s[oldest], ring[oldest], who[oldest] = t_s, now, vehicle
    return best


@kernel
def follow(
    followers: Followers,
    host: int,
    t_s: float,
    sample: FloatVector,
    vehicle: IntVector,
    motion: FloatMatrix,
    out: FloatVector,
) -> None:
    """Write the leader's columns of a host's context (13,) from what it believes of N remotes.

    ``vehicle`` (N,) are their ids, ``motion`` (N, BELIEF_COLUMNS) as `belief_kernels` has it.
    """
    speed = hypot(sample[VELOCITY_EAST], sample[VELOCITY_NORTH])
    if speed >= MOVES_MPS:
        followers.course[host] = atan2(sample[VELOCITY_EAST], sample[VELOCITY_NORTH])
    for column in range(LEADER_KNOWN + 1):
        out[column] = 0.0
    course = followers.course[host]
    if np.isnan(course):
        return
    nearest_m, leader = np.inf, -1
    for n in range(vehicle.size):
        held = vehicle[n] == followers.leader[host]
        ahead_m = _ahead_m(sample, course, motion[n], HELD_LATERAL_M if held else LATERAL_M)
        if ahead_m < nearest_m:
            nearest_m, leader = ahead_m, n
    if leader < 0:
        followers.leader[host] = -1
        return
    followers.leader[host] = vehicle[leader]
    acceleration = motion[leader, BELIEF_ACCELERATION]
    out[LEADER_GAP] = nearest_m
    out[LEADER_RELATIVE_SPEED] = motion[leader, BELIEF_SPEED] - speed
    out[LEADER_ACCELERATION] = acceleration
    out[LEADER_ACCELERATION_BEFORE] = _remembered(followers, host, t_s, int(vehicle[leader]), acceleration)
    out[LEADER_KNOWN] = 1.0


@kernel
def hear_and_follow(
    messages: Messages,
    slots: Slots,
    known: KnownProfiles,
    rules: Rules,
    counts: IntMatrix,
    followers: Followers,
    t_s: FloatVector,
    samples: FloatMatrix,
    out: FloatMatrix,
) -> None:
    """Take host 0 through T samples: it hears what has arrived by then, and follows who is ahead.

    ``messages`` (K) are those that arrive, in order; ``counts`` (2, S) takes receipts and events.
    """
    codes, numbers, parameters = messages
    receipt = np.empty(1, dtype=np.int64)
    arriving = 0
    for j in range(t_s.size):
        while arriving < numbers.shape[0] and numbers[arriving, RECEIVED] <= t_s[j] + 1e-9:
            one = Messages(
                codes[arriving : arriving + 1],
                numbers[arriving : arriving + 1],
                parameters[arriving : arriving + 1],
            )
            hear_each(one, slots, known, rules, counts[0], counts[1], receipt)
            arriving += 1
        which = live_slots(slots, t_s[j], rules.expiry_s)
        vehicle = np.empty(which.size, dtype=np.int64)
        for n in range(which.size):
            vehicle[n] = slots.facts[which[n], FACT_VEHICLE]
        motion = np.empty((which.size, BELIEF_COLUMNS))
        predict_motions(slots, known, which, t_s[j], motion)
        follow(followers, 0, t_s[j], samples[j], vehicle, motion, out[j])
