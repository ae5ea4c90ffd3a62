"""Compiled drive: positions become cells of the road memory, and each sample gets what is remembered there.

A vehicle's path is measured off in *marks*, one a metre, straight between positions that lie a metre or more
apart; a standing or creeping car adds none. A cell's place is the mean of the marks within `SMOOTH` metres of
it, and its heading the direction between two such means, `CHORD` metres behind and ahead of it, so that
neither noise nor a single bad fix bends the road. A cell is stored `HELD_S` seconds and `HELD_M` metres after
it was passed: a car does not find the path that it is just driving.
"""

from math import atan2, hypot, pi
from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatCube, FloatMatrix, FloatVector, IntMatrix, IntVector
from modelcast.models.point_kernels import EAST, NORTH, VELOCITY_EAST, VELOCITY_NORTH
from modelcast.station.context.road_kernels import CELL_M, Roads, read_road, store_cell

__all__ = [
    "HELD_M",
    "HELD_S",
    "MARKS",
    "NUMBERS",
    "PASS",
    "PLACES",
    "Drives",
    "drive_each",
    "drive_through",
    "end_drive",
]

SMOOTH, CHORD = 5, 8
HELD_S, HELD_M = 10.0, 50
"""How long [s] and how far [m] a cell waits until it is stored."""

MARKS = 1024
"""Marks kept: more than are passed in `HELD_S` at any speed of a car."""

COUNT, NEXT, PASS, MATCHED = range(4)
NUMBERS = 5
"""Whole numbers of a drive: marks of this part so far, mark of the next cell, number of the pass, and the
cells matched last in the own and the shared memory."""

KNOT_T, KNOT_EAST, KNOT_NORTH, COURSE, LAST_HEADING = range(5)
PLACES = 5
"""Numbers of a drive: time and place of the last position measured off, course held [rad] and heading of the
last cell [rad]; not a number where there is none."""

_MOVES_MPS = 1.0
_LONGEST_GAP_S = 3.0
_FASTEST_MPS = 80.0
_SHORTEST_CHORD_M = 6.0
_MARKS_A_CELL = int(CELL_M)


class Drives(NamedTuple):
    """V vehicles on their way.

    ``marks`` (V, MARKS, 3): time, east and north of each, in a ring; ``numbers`` (V, NUMBERS) and
    ``places`` (V, PLACES) as named in this module.
    """

    marks: FloatCube
    numbers: IntMatrix
    places: FloatMatrix


@kernel(inlined=True)
def _mean(marks: FloatMatrix, middle: int) -> tuple[float, float]:
    """Mean place of the marks round one."""
    east, north = 0.0, 0.0
    for k in range(middle - SMOOTH, middle + SMOOTH + 1):
        east += marks[k % MARKS, 1]
        north += marks[k % MARKS, 2]
    return east / (2 * SMOOTH + 1), north / (2 * SMOOTH + 1)


@kernel
def _release(drives: Drives, v: int, roads: Roads, r: int, now_s: float, held_m: int, held_s: float) -> None:
    """Store the cells of vehicle ``v`` that have waited long enough."""
    marks, numbers, places = drives.marks[v], drives.numbers[v], drives.places[v]
    while True:
        k = int(numbers[NEXT])
        last = int(numbers[COUNT]) - 1
        if k + max(held_m, CHORD + SMOOTH) > last or now_s - marks[k % MARKS, 0] < held_s:
            return
        numbers[NEXT] = k + _MARKS_A_CELL
        behind_east, behind_north = _mean(marks, k - CHORD)
        ahead_east, ahead_north = _mean(marks, k + CHORD)
        east, north = ahead_east - behind_east, ahead_north - behind_north
        if hypot(east, north) < _SHORTEST_CHORD_M:  # it turned round on the spot: the pass ends
            numbers[PASS] += 1
            places[LAST_HEADING] = np.nan
            continue
        heading = atan2(east, north)
        before = places[LAST_HEADING]
        if not np.isnan(before):
            heading = before + (heading - before + pi) % (2.0 * pi) - pi
        places[LAST_HEADING] = heading
        at_east, at_north = _mean(marks, k)
        store_cell(roads, r, at_east, at_north, heading, int(numbers[PASS]))


@kernel(inlined=True)
def _begin(drives: Drives, v: int, t_s: float, east: float, north: float) -> None:
    """Begin a new pass at a place."""
    numbers, places = drives.numbers[v], drives.places[v]
    numbers[COUNT], numbers[NEXT] = 1, CHORD + SMOOTH
    numbers[PASS] += 1
    drives.marks[v, 0, 0], drives.marks[v, 0, 1], drives.marks[v, 0, 2] = t_s, east, north
    places[KNOT_T], places[KNOT_EAST], places[KNOT_NORTH] = t_s, east, north
    places[LAST_HEADING] = np.nan


@kernel
def _measure_off(drives: Drives, v: int, t_s: float, east: float, north: float) -> None:
    """Add the marks between the last position measured off and this one."""
    marks, numbers, places = drives.marks[v], drives.numbers[v], drives.places[v]
    away_m = hypot(east - places[KNOT_EAST], north - places[KNOT_NORTH])
    elapsed_s = t_s - places[KNOT_T]
    if numbers[COUNT] == 0 or elapsed_s < 0.0 or away_m > _FASTEST_MPS * max(elapsed_s, 0.1):
        _begin(drives, v, t_s, east, north)
        return
    if away_m < 1.0:
        return
    if away_m > _LONGEST_GAP_S * _FASTEST_MPS or (elapsed_s > _LONGEST_GAP_S and away_m > 5.0):
        _begin(drives, v, t_s, east, north)
        return
    steps = int(away_m)
    from_s, from_east, from_north = places[KNOT_T], places[KNOT_EAST], places[KNOT_NORTH]
    for step in range(1, steps + 1):
        share = step / away_m
        at = int(numbers[COUNT]) % MARKS
        marks[at, 0] = from_s + share * (t_s - from_s)
        marks[at, 1] = from_east + share * (east - from_east)
        marks[at, 2] = from_north + share * (north - from_north)
        numbers[COUNT] += 1
    share = steps / away_m
    places[KNOT_T] = from_s + share * (t_s - from_s)
    places[KNOT_EAST] = from_east + share * (east - from_east)
    places[KNOT_NORTH] = from_north + share * (north - from_north)


@kernel
def drive_each(
    drives: Drives,
    own: Roads,
    shared: Roads,
    vehicle: IntVector,
    t_s: float,
    samples: FloatMatrix,
    out: FloatMatrix,
) -> None:
    """Take in K vehicles' newest samples (K, 9), and write the road's columns of their context (K, 13).

    Vehicle ``v`` remembers in memory ``v`` of ``own``.
    """
    for k in range(vehicle.size):
        v = int(vehicle[k])
        sample, places = samples[k], drives.places[v]
        speed = hypot(sample[VELOCITY_EAST], sample[VELOCITY_NORTH])
        if speed >= _MOVES_MPS:
            places[COURSE] = atan2(sample[VELOCITY_EAST], sample[VELOCITY_NORTH])
            _measure_off(drives, v, t_s, sample[EAST], sample[NORTH])
        _release(drives, v, own, v, t_s, HELD_M, HELD_S)
        if not np.isnan(places[COURSE]):
            read_road(own, v, shared, sample, places[COURSE], speed, drives.numbers[v, MATCHED:], out[k])


@kernel
def drive_through(
    drives: Drives, own: Roads, shared: Roads, t_s: FloatVector, samples: FloatMatrix, out: FloatMatrix
) -> None:
    """Take vehicle 0 through T samples (T, 9), each with its context's road columns into ``out`` (T, 13)."""
    vehicle = np.zeros(1, dtype=np.int64)
    for j in range(t_s.size):
        drive_each(drives, own, shared, vehicle, t_s[j], samples[j : j + 1], out[j : j + 1])


@kernel
def end_drive(drives: Drives, v: int, roads: Roads, r: int) -> None:
    """Store all cells of vehicle ``v`` that wait: it has left."""
    _release(drives, v, roads, r, np.inf, 0, 0.0)
    drives.numbers[v, COUNT] = 0
