"""Compiled predictions of all remotes that a map holds."""

from math import atan2, cos, hypot, sin

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntVector
from modelcast.station.receiver.slot_kernels import (
    TOLD_EAST,
    TOLD_HEADING,
    TOLD_NORTH,
    USED,
    KnownProfiles,
    Slots,
    displace,
)
from modelcast.station.receiver.track_kernels import HELD_FIT_S, is_live

__all__ = [
    "BELIEF_ACCELERATION",
    "BELIEF_COLUMNS",
    "BELIEF_HEADING",
    "BELIEF_SPEED",
    "BELIEF_YAW_RATE",
    "STEP_S",
    "differentiate",
    "live_slots",
    "predict_motions",
    "predict_places",
]

BELIEF_COLUMNS = 8
BELIEF_SPEED, BELIEF_HEADING, BELIEF_ACCELERATION, BELIEF_YAW_RATE = range(4, 8)
"""Columns of a motion after east, north [m] and their velocities [m/s]."""

STEP_S = 0.05
"""Derivatives are central differences of the sub-model's own path over this much to either side [s]."""

STANDS_MPS = 0.1
"""A slower vehicle has no course: its heading is the one stated, its yaw rate is zero."""


@kernel
def live_slots(slots: Slots, t_s: float, expiry_s: float) -> IntVector:
    """Slots of the remotes that have not expired."""
    used = int(slots.ends[USED])
    out = np.empty(used, dtype=np.int64)
    count = 0
    for slot in range(used):
        if is_live(slots.held[slot], t_s, expiry_s):
            out[count] = slot
            count += 1
    return out[:count]


@kernel
def predict_places(
    slots: Slots, known: KnownProfiles, which: IntVector, t_s: float, out: FloatMatrix
) -> None:
    """Where the remotes of N slots are believed to be, into ``out`` (N, 2)."""
    for row in range(which.size):
        slot = int(which[row])
        displace(slots, known, slot, t_s, out[row])
        out[row, 0] += slots.told[slot, TOLD_EAST]
        out[row, 1] += slots.told[slot, TOLD_NORTH]


@kernel(inlined=True)
def _derive(
    slots: Slots, known: KnownProfiles, slot: int, t_s: float, out: FloatVector, path: FloatMatrix
) -> None:
    """Motion of one remote from three places of its path, into ``out`` (BELIEF_COLUMNS,) from column 2.

    A path begins at its fit: up to one step after that it is differentiated at the step, and the velocity is
    carried back.
    """
    at_s = max(t_s, slots.held[slot, HELD_FIT_S] + STEP_S)
    for at in range(3):
        displace(slots, known, slot, at_s + (at - 1) * STEP_S, path[at])
    differentiate(path, t_s - at_s, slots.told[slot, TOLD_HEADING], out)


@kernel
def differentiate(path: FloatMatrix, late_s: float, heading: float, out: FloatVector) -> None:
    """Motion of a remote from three places `STEP_S` apart, ``path`` (3, 2), into ``out`` from column 2.

    It is that ``late_s`` after the middle one; ``heading`` is the one stated, taken where the remote stands.
    """
    east, north = path[1, 0], path[1, 1]
    before_east, before_north = (east - path[0, 0]) / STEP_S, (north - path[0, 1]) / STEP_S
    after_east, after_north = (path[2, 0] - east) / STEP_S, (path[2, 1] - north) / STEP_S
    rate_east, rate_north = (after_east - before_east) / STEP_S, (after_north - before_north) / STEP_S
    velocity_east = 0.5 * (before_east + after_east) + rate_east * late_s
    velocity_north = 0.5 * (before_north + after_north) + rate_north * late_s
    speed = hypot(velocity_east, velocity_north)
    out[2], out[3], out[BELIEF_SPEED] = velocity_east, velocity_north, speed
    if speed < STANDS_MPS:
        out[BELIEF_HEADING], out[BELIEF_YAW_RATE] = heading, 0.0
        out[BELIEF_ACCELERATION] = rate_east * sin(heading) + rate_north * cos(heading)
        return
    out[BELIEF_HEADING] = atan2(velocity_east, velocity_north) % (2.0 * np.pi)
    out[BELIEF_ACCELERATION] = (rate_east * velocity_east + rate_north * velocity_north) / speed
    out[BELIEF_YAW_RATE] = (rate_east * velocity_north - rate_north * velocity_east) / speed**2


@kernel
def predict_motions(
    slots: Slots, known: KnownProfiles, which: IntVector, t_s: float, out: FloatMatrix
) -> None:
    """Where the remotes of N slots are, and how they move, into ``out`` (N, BELIEF_COLUMNS)."""
    scratch, path = np.empty(2), np.empty((3, 2))
    for row in range(which.size):
        slot = int(which[row])
        displace(slots, known, slot, t_s, scratch)
        out[row, 0] = scratch[0] + slots.told[slot, TOLD_EAST]
        out[row, 1] = scratch[1] + slots.told[slot, TOLD_NORTH]
        _derive(slots, known, slot, t_s, out[row], path)
