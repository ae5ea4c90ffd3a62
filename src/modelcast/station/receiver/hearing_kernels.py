"""Compiled taking in of messages: each is checked, judged, and changes its sender's track or nothing."""

from math import cos, isfinite, isnan, sin
from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector, IntVector
from modelcast.core.kinds import Kind
from modelcast.models.member_kernels import absorb_member
from modelcast.station.receiver import heard_kernels as heard
from modelcast.station.receiver import plausibility_kernels as plausible
from modelcast.station.receiver.heard_kernels import Messages
from modelcast.station.receiver.plausibility_kernels import Limits, judge_one
from modelcast.station.receiver.renaming_kernels import end_renamed
from modelcast.station.receiver.slot_kernels import (
    FACT_PROFILE,
    FACT_USER,
    OLDEST,
    PART_I_ACCELERATION,
    PART_I_EAST,
    PART_I_NORTH,
    PART_I_YAW_RATE,
    TOLD_EAST,
    TOLD_NORTH,
    TOLD_SPEED,
    TOLD_VELOCITY_EAST,
    TOLD_VELOCITY_NORTH,
    TOLD_WIDTH,
    USED,
    KnownProfiles,
    Slots,
    columns_of,
    find_slot,
    new_slot,
    predict_row,
    renew_slot,
)
from modelcast.station.receiver.track_kernels import (
    ACCEPTED,
    HELD_CONTENT,
    HELD_FIT_S,
    HELD_MEMBER,
    HELD_RECEIVED_S,
    IN_FUTURE,
    OLDER,
    REPEATED,
    STALE,
    UNKNOWN_UPDATE,
    is_live,
    is_timely,
    take_identification,
    take_update,
)

__all__ = [
    "BY_PART_I",
    "EVENTS",
    "GAVE_WAY",
    "MALFORMED",
    "OTHER_KIND",
    "POSITION_JUMP",
    "RENAMED",
    "SPEED_MISMATCH",
    "STATUSES",
    "STUCK_SPEED",
    "Rules",
    "hear_each",
]

MALFORMED, POSITION_JUMP, SPEED_MISMATCH, STUCK_SPEED, OTHER_KIND = range(6, 11)
"""What becomes of a message, beside what `track_kernels` says."""

STATUSES = 11
BY_PART_I, GAVE_WAY, RENAMED = range(3)
"""Events counted: updates without a profile held; live tracks that gave way; tracks ended by a new id."""

EVENTS = 3

_VEHICLE = int(Kind.VEHICLE)
_IDS = 2**32
_COUNTS = 2**53
_REACH_M = 2e7
_LONGEST_LOOK_S = 60.0
_FASTEST_MPS, _TURN_RAD, _HARDEST_MPS2, _SPIN_RADPS, _LONGEST_M = 200.0, 6.2832, 100.0, 10.0, 100.0


class Rules(NamedTuple):
    """Settings of a map: times [s], whether messages are judged, and by which limits."""

    expiry_s: float
    max_ahead_s: float
    max_age_s: float
    dt_s: float
    judges: bool
    memory_s: float
    limits: Limits


@kernel(inlined=True)
def _is_unknown_or_within(value: float, low: float, high: float) -> bool:
    return isnan(value) or low <= value <= high


@kernel(inlined=True)
def _is_possible(code: IntVector, number: FloatVector, known: KnownProfiles) -> bool:
    """Whether the numbers of a message are such as a sender can send at all."""
    profile, in_use = int(code[heard.PROFILE]), int(code[heard.IN_USE])
    if not (
        heard.UPDATE <= code[heard.KIND] <= heard.IDENTIFICATION
        and 0 <= code[heard.VEHICLE] < _IDS
        and 0 <= code[heard.COUNT] < _COUNTS
        and isfinite(number[heard.STATED])
    ):
        return False
    if code[heard.KIND] == heard.IDENTIFICATION:
        return in_use >= 0
    if code[heard.KIND] == heard.UPDATE:
        if not -1 <= profile < known.first.size - 2:
            return False
        if profile >= 0 and not 0 <= in_use < known.first[profile + 2] - known.first[profile + 1]:
            return False
    return (
        abs(number[heard.EAST]) <= _REACH_M
        and abs(number[heard.NORTH]) <= _REACH_M
        and _is_unknown_or_within(number[heard.SPEED], 0.0, _FASTEST_MPS)
        and _is_unknown_or_within(number[heard.HEADING], -_TURN_RAD, _TURN_RAD)
        and _is_unknown_or_within(number[heard.ACCELERATION], -_HARDEST_MPS2, _HARDEST_MPS2)
        and _is_unknown_or_within(number[heard.YAW_RATE], -_SPIN_RADPS, _SPIN_RADPS)
        and _is_unknown_or_within(number[heard.LENGTH], 0.0, _LONGEST_M)
        and _is_unknown_or_within(number[heard.WIDTH], 0.0, _LONGEST_M)
    )


@kernel(inlined=True)
def _state_velocity(number: FloatVector, out: FloatVector) -> None:
    """Velocity by the speed and heading stated, NaN where unknown, into ``out`` (2,)."""
    speed, heading = number[heard.SPEED], number[heard.HEADING]
    if speed == 0.0:
        out[0], out[1] = 0.0, 0.0
    else:
        out[0], out[1] = speed * sin(heading), speed * cos(heading)


@kernel(inlined=True)
def _state_part_i(known: KnownProfiles, number: FloatVector, velocity: FloatVector, out: FloatVector) -> None:
    """Parameters by Part I alone into ``out`` (P,); an acceleration or a turn that is not stated is none."""
    for i in range(known.stated.size):
        value = 0.0
        if known.stated[i] == PART_I_EAST:
            value = velocity[0]
        elif known.stated[i] == PART_I_NORTH:
            value = velocity[1]
        elif known.stated[i] == PART_I_ACCELERATION and not isnan(number[heard.ACCELERATION]):
            value = number[heard.ACCELERATION]
        elif known.stated[i] == PART_I_YAW_RATE and not isnan(number[heard.YAW_RATE]):
            value = number[heard.YAW_RATE]
        out[i] = value


@kernel(inlined=True)
def _predicts(
    known: KnownProfiles, profile: int, in_use: int, row: FloatVector, rules: Rules, out: FloatVector
) -> bool:
    """Whether a sub-model gives a place on Earth for as long as it may be asked; ``out`` (2,) is used."""
    begin, end = columns_of(known, profile, in_use)
    for i in range(begin, end):
        if not isfinite(row[i]):
            return False
    for age_s in (0.0, min(rules.expiry_s, _LONGEST_LOOK_S)):
        predict_row(known, profile, in_use, row, age_s, out)
        if not (abs(out[0]) <= _REACH_M and abs(out[1]) <= _REACH_M):
            return False
    return True


@kernel(inlined=True)
def _receipt_of(finding: int) -> int:
    """What becomes of a message of which plausibility found this."""
    if finding == plausible.IN_FUTURE:
        return IN_FUTURE
    if finding == plausible.STALE:
        return STALE
    if finding == plausible.REPEATED:
        return REPEATED
    if finding == plausible.OVERTAKEN:
        return OLDER
    if finding == plausible.JUMP:
        return POSITION_JUMP
    return SPEED_MISMATCH if finding == plausible.MISMATCH else STUCK_SPEED


@kernel(inlined=True)
def _identify(
    code: IntVector,
    number: FloatVector,
    slots: Slots,
    known: KnownProfiles,
    rules: Rules,
    scratch: FloatVector,
) -> int:
    """Take in an identification that is possible and timely."""
    slot = find_slot(slots, int(code[heard.VEHICLE]))
    if slot < 0:
        return UNKNOWN_UPDATE
    profile, in_use, held = int(slots.facts[slot, FACT_PROFILE]), int(code[heard.IN_USE]), slots.held[slot]
    if profile < 0:
        in_use = 0  # of a profile not held: it tells that the remote is alive
    elif held[HELD_CONTENT] == code[heard.COUNT] and not (
        in_use < known.first[profile + 2] - known.first[profile + 1]
        and _predicts(known, profile, in_use, slots.parameters[slot], rules, scratch)
    ):
        return MALFORMED
    status = take_identification(
        held, int(code[heard.COUNT]), in_use, number[heard.STATED], number[heard.RECEIVED], rules.expiry_s
    )
    if status == ACCEPTED:
        renew_slot(slots, slot)
    return status


@kernel
def _keep(
    slots: Slots,
    slot: int,
    code: IntVector,
    what: tuple[int, int, bool],
    number: FloatVector,
    row: FloatVector,
    velocity: FloatVector,
    known: KnownProfiles,
    moved: FloatVector,
) -> None:
    """Write down what an accepted update tells.

    ``what`` is its profile and sub-model, and whether it continues one of the same; then ``moved`` (3,) is
    the time [s] and the way [m] between them.
    """
    profile, in_use, continues = what
    told = slots.told[slot]
    told[TOLD_EAST : TOLD_EAST + 2] = number[heard.EAST : heard.NORTH + 1]
    told[TOLD_VELOCITY_EAST], told[TOLD_VELOCITY_NORTH] = velocity[0], velocity[1]
    told[TOLD_SPEED : TOLD_WIDTH + 1] = number[heard.SPEED : heard.WIDTH + 1]
    slots.facts[slot, FACT_PROFILE] = profile
    slots.facts[slot, FACT_USER] = code[heard.USER]
    first, count = known.first[profile + 1], known.first[profile + 2] - known.first[profile + 1]
    for m in range(count):
        begin, end = columns_of(known, profile, m)
        held = slots.parameters[slot, begin:end]
        absorb_member(known.members, first + m, row[begin:end], moved, continues and m == in_use, held)


@kernel(inlined=True)
def _is_other_kind(slots: Slots, slot: int, user: int, received_s: float, rules: Rules) -> bool:
    """Whether a person takes the temporary id of a vehicle that is tracked, or a vehicle a person's."""
    held = slots.facts[slot, FACT_USER]
    if user < 0 or held < 0 or (user == _VEHICLE) == (held == _VEHICLE):
        return False
    return is_live(slots.held[slot], received_s, rules.expiry_s)


@kernel
def _update(
    code: IntVector,
    number: FloatVector,
    row: FloatVector,
    slots: Slots,
    known: KnownProfiles,
    rules: Rules,
    events: IntVector,
    judged: FloatVector,
    velocity: FloatVector,
    scratch: FloatVector,
) -> tuple[int, int]:
    """Take in an update or plain message that is timely: what becomes of it, and the slot of a new id.

    That is -1 where the remote was known. ``judged``, ``velocity`` and ``scratch`` are used.
    """
    vehicle, received_s = int(code[heard.VEHICLE]), number[heard.RECEIVED]
    profile = int(code[heard.PROFILE]) if code[heard.KIND] == heard.UPDATE else -1
    in_use = int(code[heard.IN_USE]) if profile >= 0 else 0
    _state_velocity(number, velocity)
    if profile < 0:
        row = np.empty(known.stated.size)
        _state_part_i(known, number, velocity, row)
    if not _predicts(known, profile, in_use, row, rules, scratch):
        return MALFORMED, -1
    if isnan(velocity[0]):
        predict_row(known, profile, in_use, row, rules.dt_s, velocity)
        velocity[0] /= rules.dt_s
        velocity[1] /= rules.dt_s
    slot = find_slot(slots, vehicle)
    about = judged
    if slot >= 0:
        if _is_other_kind(slots, slot, int(code[heard.USER]), received_s, rules):
            return OTHER_KIND, -1
        about = slots.judged[slot]
    else:
        judged[0] = np.nan
    if rules.judges:
        if not about[0] >= received_s - rules.memory_s:
            about[0] = np.nan
        finding = judge_one(
            about,
            number[heard.STATED],
            number[heard.EAST : heard.NORTH + 1],
            velocity,
            received_s,
            rules.limits,
        )
        if finding != plausible.PLAUSIBLE:
            return _receipt_of(finding), -1
    is_new = slot < 0 or not is_live(slots.held[slot], received_s, rules.expiry_s)
    if slot < 0:
        if slots.ends[USED] == slots.facts.shape[0] and is_live(
            slots.held[slots.ends[OLDEST]], received_s, rules.expiry_s
        ):
            events[GAVE_WAY] += 1
        slot = new_slot(slots, vehicle)
        slots.judged[slot] = judged
    told, held = slots.told[slot], slots.held[slot]
    continues = not is_new and slots.facts[slot, FACT_PROFILE] == profile and held[HELD_MEMBER] == in_use
    moved = np.empty(3)
    moved[0] = number[heard.STATED] - held[HELD_FIT_S]
    moved[1], moved[2] = number[heard.EAST] - told[TOLD_EAST], number[heard.NORTH] - told[TOLD_NORTH]
    status = take_update(
        held, int(code[heard.COUNT]), in_use, number[heard.STATED], received_s, rules.expiry_s
    )
    if status != OLDER and held[HELD_RECEIVED_S] == received_s:
        renew_slot(slots, slot)
    if status == ACCEPTED:
        _keep(slots, slot, code, (profile, in_use, continues), number, row, velocity, known, moved)
        if profile < 0:
            events[BY_PART_I] += 1
    return status, slot if is_new else -1


@kernel
def hear_each(
    messages: Messages,
    slots: Slots,
    known: KnownProfiles,
    rules: Rules,
    receipts: IntVector,
    events: IntVector,
    out: IntVector,
) -> None:
    """Take in K messages in turn; what becomes of each is counted in ``receipts``, and in ``out`` (K,)."""
    codes, numbers, parameters = messages
    judged, velocity, scratch = np.empty(slots.judged.shape[1]), np.empty(2), np.empty(2)
    fresh = np.full(out.size, -1, dtype=np.int64)
    newcomers = 0
    for k in range(out.size):
        code, number = codes[k], numbers[k]
        if not _is_possible(code, number, known):
            out[k] = MALFORMED
            continue
        t_s, received_s = number[heard.STATED], number[heard.RECEIVED]
        out[k] = is_timely(t_s, received_s, rules.max_ahead_s, rules.max_age_s)
        if out[k] != ACCEPTED:
            continue
        if code[heard.KIND] != heard.IDENTIFICATION:
            out[k], fresh[k] = _update(
                code, number, parameters[k], slots, known, rules, events, judged, velocity, scratch
            )
            if fresh[k] >= 0:
                newcomers += 1
            continue
        if rules.judges:
            out[k] = is_timely(t_s, received_s, rules.limits.max_ahead_s, rules.limits.max_age_s)
        if out[k] == ACCEPTED:
            out[k] = _identify(code, number, slots, known, rules, scratch)
    for k in range(out.size):
        receipts[out[k]] += 1
    if newcomers > 0:
        events[RENAMED] += end_renamed(slots, known, rules.expiry_s, codes, numbers, fresh)
