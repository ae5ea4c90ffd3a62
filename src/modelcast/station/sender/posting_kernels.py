"""Compiled posting: the content of a message is written, put into the outbox and accounted for."""

from typing import NamedTuple

import numpy as np

from modelcast.channel.random_kernels import uniform_of
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, FloatMatrix, FloatVector
from modelcast.core.markov_kernels import next_state
from modelcast.messages.stack_kernels import airtime, carries_certificate, frame_bytes
from modelcast.station.arrays import Fits, LaneRules, Lanes, Sensed
from modelcast.station.policy.error_driven_kernels import IDENTIFICATION, UPDATE
from modelcast.station.policy.j2945_kernels import LAST_S, NEXT_S
from modelcast.station.policy.policy_numbers import RULE_J2945, PolicyNumbers
from modelcast.station.sender.expecting_kernels import calls_at_once, error_that_calls, steps_on
from modelcast.station.sender.fitting_kernels import SenderModels
from modelcast.station.sender.message_arrays import (
    AIRTIME_S,
    BELIEF,
    BELIEF_NUMBER,
    CERTIFICATES,
    CONTENT_BYTES,
    CONTENT_EAST_M,
    CONTENT_FIRST,
    CONTENT_FIT_S,
    CONTENT_HEAD,
    CONTENT_KIND,
    CONTENT_MEMBER,
    CONTENT_NAMED_S,
    CONTENT_NORTH_M,
    CONTENT_NUMBER,
    CONTENT_SENT_S,
    CONTENT_SPEED_MPS,
    CONTENT_UPDATE,
    CONTENT_VEHICLE,
    FRAME_BYTES,
    IDENTIFICATIONS,
    MESSAGES,
    MESSAGES_KEPT,
    MODELS,
    PAYLOAD_BYTES,
    POWER_DBM,
    SENDER_BITS,
    Contents,
    FleetNumbers,
    Outbox,
    Senders,
    SentTally,
)
from modelcast.station.sender.motion_kernels import MOTION, state_motion
from modelcast.station.sender.speaking_kernels import compose, expect, followed, forget_lane, hold
from modelcast.station.sender.timed_kernels import (
    Timers,
    start,
)

__all__ = ["SendingStations", "StepInputs", "begin", "has_begun", "post", "post_timed"]


class SendingStations(NamedTuple):
    """All that V stations hold to send; each has as many lanes, the last of which speaks."""

    models: SenderModels
    sensed: Sensed
    fits: Fits
    rules: LaneRules
    lanes: Lanes
    policy: PolicyNumbers
    timers: Timers
    senders: Senders
    numbers: FleetNumbers


class StepInputs(NamedTuple):
    """What stations know in a step.

    ``t_s`` now and ``dt_s`` how long the step is; ``spread_s`` over which new stations begin to send;
    ``started`` and ``critical`` (V,) whose slot has a new vehicle, and who has a critical event;
    ``busy_ratio`` (V,); ``uniforms`` (V, 4) in [0, 1).
    """

    t_s: float
    dt_s: float
    spread_s: float
    started: BoolVector
    critical: BoolVector
    busy_ratio: FloatVector
    uniforms: FloatMatrix


@kernel(inlined=True)
def _write(
    f: SendingStations, v: int, b: int, kind: int, member: int, sent_s: float, row: FloatVector, number: int
) -> None:
    """Write the content of a message: an update of the newest sample, or what an identification names."""
    sample = f.sensed.taken[v] - 1
    ring = f.sensed.stated_m.shape[1]
    offsets = f.models.members.offsets
    row[CONTENT_VEHICLE], row[CONTENT_NUMBER], row[CONTENT_KIND] = f.senders.vehicle[v], number, kind
    row[CONTENT_MEMBER], row[CONTENT_SENT_S] = f.numbers.first_member + member, sent_s
    row[CONTENT_FIRST] = CONTENT_HEAD + (offsets[member] if f.numbers.carries_all else 0)
    motion = row[CONTENT_SPEED_MPS : CONTENT_SPEED_MPS + MOTION]
    row[CONTENT_NAMED_S] = f.sensed.t_s[v, sample % ring]
    if kind == IDENTIFICATION:
        row[CONTENT_UPDATE], row[CONTENT_BYTES] = f.senders.update[v], f.numbers.identification_bytes
        holds = followed(f.rules, f.lanes, b)
        row[CONTENT_FIT_S] = f.lanes.origin[holds, 0]
        row[CONTENT_EAST_M], row[CONTENT_NORTH_M] = f.lanes.origin[holds, 1], f.lanes.origin[holds, 2]
        for i in range(MOTION):
            motion[i] = f.senders.stated[v, i]
        for m in range(offsets.size - 1):
            for i in range(offsets[m], offsets[m + 1]):
                row[CONTENT_HEAD + i] = f.lanes.held[holds, i] if f.lanes.usable[holds, m] else 0.0
        return
    row[CONTENT_UPDATE], row[CONTENT_BYTES] = number, f.models.sizes[member]
    row[CONTENT_FIT_S] = f.sensed.stated_s[v, sample % ring]
    row[CONTENT_EAST_M] = f.sensed.stated_m[v, sample % ring, 0]
    row[CONTENT_NORTH_M] = f.sensed.stated_m[v, sample % ring, 1]
    state_motion(f.models.part_one, f.sensed, f.fits, v, sample, member, f.numbers.carries_all, motion)
    place = sample % f.fits.parameters.shape[1]
    if not f.numbers.carries_all:
        for i in range(offsets[member], offsets[member + 1]):
            row[CONTENT_HEAD + i - offsets[member]] = f.fits.parameters[v, place, i]
        return
    for m in range(offsets.size - 1):
        fitted = f.fits.number[v, place, m] == sample
        for i in range(offsets[m], offsets[m + 1]):
            row[CONTENT_HEAD + i] = f.fits.parameters[v, place, i] if fitted else 0.0


@kernel(inlined=True)
def post(
    f: SendingStations,
    v: int,
    b: int,
    what: tuple[int, int],
    how: tuple[float, float, bool, int],
    next_s: float,
    contents: Contents,
    out: Outbox,
    tally: SentTally,
) -> None:
    """Put a message into the outbox and account for it.

    ``what`` is its kind and sub-model; ``how`` when it goes to the radio, its power, whether it is believed
    received, its cause; ``next_s`` when the next one is expected.
    """
    kind, member = what
    sent_s, power_dbm, believed, cause = how
    s, stack = f.senders, f.numbers.stack
    number, group = s.number[v], v * tally.sums.shape[0] // s.number.size
    ring = number % MESSAGES_KEPT
    row = contents.rows[v, ring]
    _write(f, v, b, kind, member, sent_s, row, number)
    frames = f.numbers.frames
    if frames.size_bytes.size:
        s.size_state[v] = next_state(s.size_state[v], uniform_of(s.word[v], number), frames.up_to)
        row[CONTENT_BYTES] = frames.size_bytes[s.size_state[v]] - stack.around_bytes
    contents.beliefs[v, ring, BELIEF_NUMBER], contents.beliefs[v, ring, BELIEF] = number, -1
    certificate = carries_certificate(stack.rule, stack.interval_s, sent_s, s.sent_s[v], s.certified_s[v])
    frame = frame_bytes(int(row[CONTENT_BYTES]), certificate, stack)
    k = out.filled[0]
    out.sender[k], out.ready_s[k], out.size_bytes[k] = v, sent_s, frame
    out.power_dbm[k], out.message_id[k], out.next_s[k] = power_dbm, (number << SENDER_BITS) | v, next_s
    out.grant[k] = f.numbers.grant
    out.filled[0] = k + 1
    if believed and kind != IDENTIFICATION:
        s.update[v] = number
        for i in range(MOTION):
            s.stated[v, i] = row[CONTENT_SPEED_MPS + i]
    if certificate:
        s.certified_s[v] = sent_s
        tally.sums[group, CERTIFICATES] += 1.0
    s.sent_s[v], s.number[v] = sent_s, number + 1
    tally.causes[cause] += 1
    tally.sums[group, MESSAGES] += 1.0
    if kind == IDENTIFICATION:
        tally.sums[group, IDENTIFICATIONS] += 1.0
    elif not f.numbers.plain[member]:
        tally.sums[group, MODELS] += 1.0
    tally.sums[group, PAYLOAD_BYTES] += row[CONTENT_BYTES]
    tally.sums[group, FRAME_BYTES] += frame
    tally.sums[group, AIRTIME_S] += airtime(frame, stack)
    tally.sums[group, POWER_DBM] += power_dbm


@kernel(inlined=True)
def _next_j2945(f: SendingStations, v: int, b: int, number: int, dt_s: float, scratch: FloatVector) -> float:
    """When a station under SAE J2945/1 sends next: by its timer, or before that by its error."""
    row, c = f.timers.rows[v], f.policy.constants
    due_s = float(row[NEXT_S])
    if not calls_at_once(c) or f.lanes.update[b] < 0:
        return due_s
    ring = f.sensed.stated_m.shape[1]
    at = number % ring + ring
    expect(f.models, f.sensed, f.rules, f.lanes, b, at, error_that_calls(row, c), scratch)
    # Rate control runs once a step; what an error calls for leaves within its jitter.
    return min(due_s, steps_on(row[LAST_S], f.lanes.life_s[b], dt_s))


@kernel(inlined=True)
def post_timed(
    f: SendingStations,
    v: int,
    b: int,
    how: tuple[float, float, bool, int],
    next_s: float,
    dt_s: float,
    contents: Contents,
    out: Outbox,
    tally: SentTally,
    scratch: FloatVector,
) -> None:
    """Compose a message of the newest sample that a timer called for, and post it.

    ``next_s`` is when the next is expected; the rules of SAE J2945/1 say so themselves.
    """
    number = f.sensed.taken[v] - 1
    if f.policy.rule == RULE_J2945:
        next_s = _next_j2945(f, v, b, number, dt_s, scratch)
    member = compose(f.models, f.sensed, f.fits, f.rules, f.lanes, b, number, scratch)
    if how[2]:
        hold(f.models, f.sensed, f.fits, f.rules, f.lanes, b, number, member)
    post(f, v, b, (UPDATE, member), how, next_s, contents, out, tally)


@kernel(inlined=True)
def begin(f: SendingStations, v: int, t_s: float) -> None:
    """Let the station of a slot have sent nothing."""
    each = f.rules.vehicle.size // f.senders.vehicle.size
    for b in range(v * each, (v + 1) * each):
        forget_lane(f.lanes, b)
    f.senders.update[v] = -1
    f.senders.sent_s[v] = f.senders.certified_s[v] = -np.inf
    f.senders.size_state[v] = -1
    start(f.timers, f.policy, v, t_s)


@kernel(inlined=True)
def has_begun(f: SendingStations, v: int, x: StepInputs) -> bool:
    """Whether the station of a slot sends by now; one that begins has sent nothing."""
    if f.senders.vehicle[v] < 0:
        return False
    if x.started[v]:
        f.timers.begins_s[v], f.timers.begun[v] = x.t_s + x.spread_s * x.uniforms[v, 3], False
        begin(f, v, x.t_s)
    if not f.timers.begun[v]:
        if x.t_s < f.timers.begins_s[v]:
            return False
        f.timers.begun[v] = True
        begin(f, v, x.t_s)
    return True
