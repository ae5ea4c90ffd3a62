"""Stops and hard brakes: what the speed tells."""

import numpy as np

from modelcast.core.arrays import BoolArray
from modelcast.trips.inspection import STOP_SPEED_MPS
from modelcast.trips.manoeuvres.base import FoundManoeuvre, ManoeuvreKind
from modelcast.trips.manoeuvres.motion import Motion
from modelcast.trips.recorder import WINDOW_S, parts, rows_around

__all__ = ["DRIVEN_M", "HARD_BRAKE_MPS2", "MIN_STAND_S", "find_hard_brakes", "find_stops"]

HARD_BRAKE_MPS2 = 0.4 * 9.80665
"""SAE J2735 calls braking over 0.4 g hard (its event flag for hard braking)."""

MIN_STAND_S = 2.0
"""A stop stands at least this long; a shorter one is a change of direction or of gear."""

DRIVEN_M = 5.0
"""A stop ends a way of at least this, a car's length: moving up in a queue is no new stop."""


def find_stops(motion: Motion) -> list[FoundManoeuvre]:
    """Return each time the vehicle stands after it has moved.

    It stands from a speed under `STOP_SPEED_MPS` until one over twice that. A trip that begins at rest does
    not begin with a stop.

    Parameters
    ----------
    motion
        How the vehicle moved.
    """
    t_s, found = motion.trip.t_s, list[FoundManoeuvre]()
    for part in parts(motion.trip):
        speed = motion.speed_mps[part]
        way_m = np.concatenate([[0.0], np.cumsum(np.diff(t_s[part]) * 0.5 * (speed[1:] + speed[:-1]))])
        left_m = 0.0
        for a, b in _standing(speed < STOP_SPEED_MPS, speed < 2.0 * STOP_SPEED_MPS):
            start, end = float(t_s[part.start + a]), float(t_s[part.start + b - 1])
            if end - start < MIN_STAND_S:
                continue
            if way_m[a] - left_m >= DRIVEN_M:
                found.append(FoundManoeuvre(ManoeuvreKind.STOP, start, end, size=end - start))
            left_m = float(way_m[b - 1])
    return found


def find_hard_brakes(motion: Motion) -> list[FoundManoeuvre]:
    """Return each stretch in which the speed falls faster than `HARD_BRAKE_MPS2` over one second.

    Parameters
    ----------
    motion
        How the vehicle moved.

    References
    ----------
    SAE J2735, DE_VehicleEventFlags, eventHardBraking: deceleration over 0.4 g.
    """
    trip = motion.trip
    before, after = rows_around(trip, WINDOW_S)
    elapsed = trip.t_s[after] - trip.t_s[before]
    fell = motion.speed_mps[before] - motion.speed_mps[after]
    # At the ends of a part the span is shorter, and noise would count for more.
    rate = np.where(elapsed > 0.75 * WINDOW_S, fell / np.maximum(elapsed, 1e-9), 0.0)
    found = list[FoundManoeuvre]()
    for part in parts(trip):
        here = rate[part]
        for a, b in _standing(here > HARD_BRAKE_MPS2, here > 0.5 * HARD_BRAKE_MPS2):
            rows = slice(part.start + a, part.start + b)
            start, end = float(trip.t_s[rows][0]), float(trip.t_s[rows][-1])
            size = float(rate[rows].max())
            found.append(FoundManoeuvre(ManoeuvreKind.HARD_BRAKE, start, end, size=size))
    return found


def _standing(core: BoolArray, around: BoolArray) -> list[tuple[int, int]]:
    """First and one-past-last row of the runs of ``around`` that hold a row of ``core``, from that row on."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], around, [False]]).astype(np.int8)))
    found = list[tuple[int, int]]()
    for a, b in edges.reshape(-1, 2):
        inside = np.flatnonzero(core[a:b])
        if inside.size:
            found.append((int(a + inside[0]), int(b)))
    return found
