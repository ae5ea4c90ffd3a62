"""Compiled tables of the local dynamic map: one slot a remote, found by its temporary id.

There are C slots and a hashed index of them, as in `modelcast.station.policy.neighbours_kernels`. A slot
keeps its remote, also after the track has expired, until another remote needs it: then that which was heard
least lately gives way. A list through all slots in the order of their last renewal makes that one step.
"""

from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntMatrix, IntVector
from modelcast.models.member_kernels import Members, predict_member
from modelcast.station.policy.neighbours_kernels import place
from modelcast.station.receiver.track_kernels import HELD_FIT_S, HELD_MEMBER, forget

__all__ = [
    "FACT_COLUMNS",
    "FACT_PROFILE",
    "FACT_USER",
    "FACT_VEHICLE",
    "NEWEST",
    "OLDEST",
    "PART_I_ACCELERATION",
    "PART_I_EAST",
    "PART_I_NORTH",
    "PART_I_YAW_RATE",
    "TOLD_ACCELERATION",
    "TOLD_COLUMNS",
    "TOLD_EAST",
    "TOLD_HEADING",
    "TOLD_LENGTH",
    "TOLD_NORTH",
    "TOLD_SPEED",
    "TOLD_VELOCITY_EAST",
    "TOLD_VELOCITY_NORTH",
    "TOLD_WIDTH",
    "TOLD_YAW_RATE",
    "USED",
    "KnownProfiles",
    "Slots",
    "columns_of",
    "displace",
    "find_slot",
    "fit_times",
    "new_slot",
    "predict_row",
    "renew_slot",
]

(
    TOLD_EAST,  # position stated by the update held [m]
    TOLD_NORTH,
    TOLD_VELOCITY_EAST,  # velocity stated, or of its sub-model over the first sampling interval [m/s]
    TOLD_VELOCITY_NORTH,
    TOLD_SPEED,  # as stated, NaN for unknown; so are the next five [m/s]
    TOLD_HEADING,  # [rad]
    TOLD_ACCELERATION,  # [m/s²]
    TOLD_YAW_RATE,  # [rad/s]
    TOLD_LENGTH,  # [m]
    TOLD_WIDTH,  # [m]
) = range(10)
TOLD_COLUMNS = 10

(
    FACT_VEHICLE,  # temporary id
    FACT_PROFILE,  # the profile that predicts, -1 for Part I
    FACT_USER,  # kind of road user
    _OLDER,  # the slot renewed just before this one, -1 for none
    _NEWER,  # that renewed just after
) = range(5)
FACT_COLUMNS = 5

PART_I_EAST, PART_I_NORTH, PART_I_ACCELERATION, PART_I_YAW_RATE = range(4)
"""Values of Part I in the order of `modelcast.models.payload.CORE_PARAMETERS`."""

USED, OLDEST, NEWEST = range(3)
"""Of ``ends``: slots ever used; the two ends of the list, -1 for an empty one."""

_NOBODY = -1


class Slots(NamedTuple):
    """C slots, one remote each.

    ``held`` (C, TRACK_COLUMNS) are the tracks; ``told`` (C, TOLD_COLUMNS), ``facts`` (C, FACT_COLUMNS);
    ``parameters`` (C, P) of all sub-models of the profile; ``judged`` (C, COLUMNS) what plausibility keeps;
    ``lookup`` (X,) slots by hash, -1 for none; ``ends`` (3,).
    """

    held: FloatMatrix
    told: FloatMatrix
    facts: IntMatrix
    parameters: FloatMatrix
    judged: FloatMatrix
    lookup: IntVector
    ends: IntVector


class KnownProfiles(NamedTuple):
    """Sub-models of all profiles held in one table; ``first`` (profiles + 2,) is the first of each.

    Profile -1 is Part I: member 0, by which plain messages are coasted. ``stated`` (P,) says which value of
    Part I each of its parameters is, `PART_I_EAST` to `PART_I_YAW_RATE`.
    """

    members: Members
    first: IntVector
    stated: IntVector


@kernel(inlined=True)
def find_slot(slots: Slots, vehicle: int) -> int:
    """Slot of a remote, -1 where it has none."""
    length = slots.lookup.size
    at = place(vehicle, length)
    while True:
        slot = int(slots.lookup[at])
        if slot < 0 or slots.facts[slot, FACT_VEHICLE] == vehicle:
            return slot
        at = (at + 1) & (length - 1)


@kernel(inlined=True)
def _remove(slots: Slots, slot: int) -> None:
    """Take a slot out of the index; those behind it that it pushed on move up."""
    index, mask = slots.lookup, slots.lookup.size - 1
    hole = place(int(slots.facts[slot, FACT_VEHICLE]), index.size)
    while index[hole] != slot:
        hole = (hole + 1) & mask
    at = (hole + 1) & mask
    while index[at] >= 0:
        home = place(int(slots.facts[index[at], FACT_VEHICLE]), index.size)
        if (at - home) & mask >= (at - hole) & mask:
            index[hole] = index[at]
            hole = at
        at = (at + 1) & mask
    index[hole] = _NOBODY


@kernel(inlined=True)
def _unlink(slots: Slots, slot: int) -> None:
    older, newer = slots.facts[slot, _OLDER], slots.facts[slot, _NEWER]
    if older >= 0:
        slots.facts[older, _NEWER] = newer
    else:
        slots.ends[OLDEST] = newer
    if newer >= 0:
        slots.facts[newer, _OLDER] = older
    else:
        slots.ends[NEWEST] = older


@kernel(inlined=True)
def _append(slots: Slots, slot: int) -> None:
    newest = slots.ends[NEWEST]
    slots.facts[slot, _OLDER], slots.facts[slot, _NEWER] = newest, _NOBODY
    if newest >= 0:
        slots.facts[newest, _NEWER] = slot
    else:
        slots.ends[OLDEST] = slot
    slots.ends[NEWEST] = slot


@kernel(inlined=True)
def renew_slot(slots: Slots, slot: int) -> None:
    """Put a slot last in the order in which they give way."""
    _unlink(slots, slot)
    _append(slots, slot)


@kernel(inlined=True)
def new_slot(slots: Slots, vehicle: int) -> int:
    """Slot of a remote that has none, empty: an unused one, or that of the remote longest unheard."""
    index = slots.lookup
    if slots.ends[USED] < slots.facts.shape[0]:
        slot = int(slots.ends[USED])
        slots.ends[USED] += 1
    else:
        slot = int(slots.ends[OLDEST])
        _unlink(slots, slot)
        _remove(slots, slot)
    at = place(vehicle, index.size)
    while index[at] >= 0:
        at = (at + 1) & (index.size - 1)
    index[at] = slot
    slots.facts[slot, FACT_VEHICLE] = vehicle
    forget(slots.held[slot])
    slots.judged[slot, 0] = np.nan
    _append(slots, slot)
    return slot


@kernel(inlined=True)
def columns_of(known: KnownProfiles, profile: int, in_use: int) -> tuple[int, int]:
    """Bounds of one sub-model's parameters in a row of all of its profile."""
    offsets, first = known.members.offsets, known.first[profile + 1]
    return int(offsets[first + in_use] - offsets[first]), int(offsets[first + in_use + 1] - offsets[first])


@kernel(inlined=True)
def predict_row(
    known: KnownProfiles, profile: int, in_use: int, row: FloatVector, age_s: float, out: FloatVector
) -> None:
    """Displacement by one sub-model out of a row of parameters of all of its profile, into ``out`` (2,)."""
    begin, end = columns_of(known, profile, in_use)
    predict_member(known.members, known.first[profile + 1] + in_use, row[begin:end], age_s, out)


@kernel(inlined=True)
def displace(slots: Slots, known: KnownProfiles, slot: int, t_s: float, out: FloatVector) -> None:
    """Displacement of a remote from the place it stated, into ``out`` (2,)."""
    profile, in_use = int(slots.facts[slot, FACT_PROFILE]), int(slots.held[slot, HELD_MEMBER])
    predict_row(known, profile, in_use, slots.parameters[slot], t_s - slots.held[slot, HELD_FIT_S], out)


@kernel
def fit_times(slots: Slots, vehicle: IntVector, out: FloatVector) -> None:
    """Instant of the fit that is held of each remote, NaN where nothing is, (K,)."""
    for k in range(vehicle.size):
        slot = find_slot(slots, vehicle[k])
        out[k] = slots.held[slot, HELD_FIT_S] if slot >= 0 else np.nan
