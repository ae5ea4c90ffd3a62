"""Compiled search for remotes that go on under another temporary id: the old track of each ends.

A new id takes a track's place where that track has fallen silent, and both agree on place, speed and course
at the instant of the new id's first message. Two vehicles are never that near one another. Each must be the
other's nearest among all that agree, so a track ends for one new id, and a new id ends one track.
"""

from math import hypot

import numpy as np

from modelcast.channel.cells_kernels import build_cells, cell_span, row_span
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntMatrix, IntVector
from modelcast.station.receiver.heard_kernels import EAST, NORTH, RECEIVED, STATED, VEHICLE
from modelcast.station.receiver.slot_kernels import (
    FACT_USER,
    FACT_VEHICLE,
    TOLD_EAST,
    TOLD_NORTH,
    TOLD_VELOCITY_EAST,
    TOLD_VELOCITY_NORTH,
    USED,
    KnownProfiles,
    Slots,
    displace,
)
from modelcast.station.receiver.track_kernels import HELD_FIT_S, HELD_RECEIVED_S, forget, is_live

__all__ = ["end_renamed"]

PLACE_M = 3.0
"""Farthest that the new id may be from where the track is predicted: less than the width of a lane, and than
the length of a car."""

SPEED_MPS = 3.0
"""Most that their speeds may differ."""

COURSE_COSINE = 0.866
"""Their courses differ by at most 30 degrees, where both are faster than `SLOW_MPS`."""

SLOW_MPS = 2.0

SILENT_S = 0.05
"""A track heard later than this before the new id is another vehicle's: nobody sends twice in so short a time
(SAE J2945/1 and ETSI CAM: 0.1 s at least)."""

OLDEST_S = 3.0
"""A model older than this at that instant says too little; its track is left to expire."""

STEP_S = 0.05
_COAST_MPS2 = 10.0


@kernel(inlined=True)
def _distance_m(
    slots: Slots,
    known: KnownProfiles,
    slot: int,
    fresh: int,
    number: FloatVector,
    expiry_s: float,
    scratch: FloatVector,
) -> float:
    """How far a new id in slot ``fresh`` is from where a track is predicted; infinite where they disagree."""
    held, told = slots.held[slot], slots.told[slot]
    if slots.facts[slot, FACT_USER] != slots.facts[fresh, FACT_USER]:
        return np.inf  # of another kind of road user
    age_s, silent_s = number[STATED] - held[HELD_FIT_S], number[RECEIVED] - held[HELD_RECEIVED_S]
    if not (is_live(held, number[RECEIVED], expiry_s) and silent_s >= SILENT_S and 0.0 <= age_s <= OLDEST_S):
        return np.inf
    displace(slots, known, slot, number[STATED], scratch)
    east, north = scratch[0], scratch[1]
    away_m = hypot(told[TOLD_EAST] + east - number[EAST], told[TOLD_NORTH] + north - number[NORTH])
    if not away_m <= PLACE_M:
        return np.inf
    displace(slots, known, slot, number[STATED] + STEP_S, scratch)
    a_east, a_north = (scratch[0] - east) / STEP_S, (scratch[1] - north) / STEP_S
    b_east, b_north = slots.told[fresh, TOLD_VELOCITY_EAST], slots.told[fresh, TOLD_VELOCITY_NORTH]
    a_mps, b_mps = hypot(a_east, a_north), hypot(b_east, b_north)
    if not abs(a_mps - b_mps) <= SPEED_MPS:
        return np.inf
    along = a_east * b_east + a_north * b_north
    if min(a_mps, b_mps) > SLOW_MPS and along < COURSE_COSINE * a_mps * b_mps:
        return np.inf
    return away_m


@kernel
def end_renamed(
    slots: Slots,
    known: KnownProfiles,
    expiry_s: float,
    codes: IntMatrix,
    numbers: FloatMatrix,
    fresh: IntVector,
) -> int:
    """End the tracks that go on under a new id; return how many.

    ``fresh`` (K,) holds the slot of each message that was the first of a new id, and -1 for all others.
    """
    count, used = fresh.size, int(slots.ends[USED])
    place_m = np.full((count, 2), np.nan)
    first_s, last_s = np.inf, -np.inf
    for k in range(count):
        if fresh[k] >= 0 and slots.facts[fresh[k], FACT_VEHICLE] == codes[k, VEHICLE]:
            place_m[k, 0], place_m[k, 1] = numbers[k, EAST], numbers[k, NORTH]
            first_s, last_s = min(first_s, numbers[k, STATED]), max(last_s, numbers[k, STATED])
    cells = build_cells(place_m, 4.0 * PLACE_M)
    nearest_m, track = np.full(count, np.inf), np.full(count, -1, dtype=np.int64)
    chosen = np.full(used, -1, dtype=np.int64)
    scratch = np.empty(2)
    for slot in range(used):
        fit_s, told = slots.held[slot, HELD_FIT_S], slots.told[slot]
        if not (fit_s <= last_s and first_s - fit_s <= OLDEST_S):
            continue
        # It coasts to the middle of the new ids' instants; a vehicle is this far from there at most.
        age_s = 0.5 * (max(first_s, fit_s) + min(last_s, fit_s + OLDEST_S)) - fit_s
        early_s = max(last_s - first_s, 0.0)
        oldest_s = min(last_s - fit_s, OLDEST_S)
        east_mps, north_mps = told[TOLD_VELOCITY_EAST], told[TOLD_VELOCITY_NORTH]
        reach_m = (
            PLACE_M + 0.5 * _COAST_MPS2 * oldest_s * oldest_s + 0.5 * hypot(east_mps, north_mps) * early_s
        )
        east, north = told[TOLD_EAST] + east_mps * age_s, told[TOLD_NORTH] + north_mps * age_s
        left, right, low, high = cell_span(cells, east, north, reach_m)
        if left > right:
            continue
        least_m = np.inf
        for row in range(low, high + 1):
            first, end = row_span(cells, row, left, right)
            for at in range(first, end):
                k = int(cells.order[at])
                if hypot(cells.place[at, 0] - east, cells.place[at, 1] - north) > reach_m or fresh[k] == slot:
                    continue
                away_m = _distance_m(slots, known, slot, int(fresh[k]), numbers[k], expiry_s, scratch)
                if away_m < least_m:
                    least_m, chosen[slot] = away_m, k
                if away_m < nearest_m[k]:
                    nearest_m[k], track[k] = away_m, slot
    ended = 0
    for k in range(count):
        if track[k] >= 0 and chosen[track[k]] == k:
            forget(slots.held[track[k]])
            ended += 1
    return ended
