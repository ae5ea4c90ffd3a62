"""Compiled memory of roads: cells of paths driven before, found by place and course.

A memory is a ring of cells, one every `CELL_M` metres of a *pass*, one uninterrupted drive along a road.
Cells of a pass stand one after another, so that what lies ahead of a place is read off the cells that follow.
The oldest cells give way. Cells are numbered from 0 as they come; a hashed grid of square buckets holds the
newest cell of each bucket, and every cell names the one before it in its bucket.
"""

from math import cos, floor, pi, sin
from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import Float32Cube, FloatMatrix, FloatVector, Int32Matrix, IntVector
from modelcast.models.context_columns import ROAD_HEADING, ROAD_KNOWN, ROAD_TURN, ROAD_TURN_HORIZONS

__all__ = [
    "CELL_EAST",
    "CELL_HEADING",
    "CELL_M",
    "CELL_NORTH",
    "CELL_NUMBERS",
    "NOWHERE",
    "Roads",
    "read_road",
    "store_cell",
    "store_cells",
]

CELL_M = 5.0
"""Length of road that a cell stands for [m]."""

CELL_EAST, CELL_NORTH, CELL_HEADING = range(3)
CELL_NUMBERS = 3
"""Columns of a cell: east, north [m]; heading, clockwise from north and unwrapped along the pass [rad]."""

NOWHERE = -1
"""Number of no cell."""

_BUCKET_M = 8.0
_NEAR_M = 6.0
"""A path is remembered at a place where a cell lies within this [m]; it is less than a bucket."""

_ALONG_RAD = pi / 6.0
"""And where its heading is within this of the own course [rad]."""

_MOST_LOOKED_AT = 64
_TOLD_S = 2.0
"""The road is known where it is remembered at least this far ahead at the present speed [s]."""

_UNIT_M, _UNIT_RAD, _SHORT_COST, _STAYS = 2.0, pi / 18.0, 4.0, 0.5
"""What a cell costs: (distance over 2 m)² + (angle over 10 degrees)² + 4 times the share of the way ahead
that it lacks; half of that on the pass matched before, so that a car does not change passes on noise."""


class Roads(NamedTuple):
    """R memories of N cells each.

    ``cells`` (R, N, 3) numbers of each cell; ``passes`` (R, N) the pass each belongs to; ``older`` (R, N) the
    number of the cell before it in its bucket, -1 for none; ``heads`` (R, B) the newest cell of each bucket,
    -1 for none; ``filled`` (R,) cells stored so far.
    """

    cells: Float32Cube
    passes: Int32Matrix
    older: Int32Matrix
    heads: Int32Matrix
    filled: IntVector


@kernel(inlined=True)
def _bucket(column: int, row: int, buckets: int) -> int:
    """Which bucket a square of the grid falls into."""
    return ((column * 73856093) ^ (row * 19349663)) % buckets


@kernel(inlined=True)
def _turned(angle_rad: float) -> float:
    """An angle in [-pi, pi)."""
    return (angle_rad + pi) % (2.0 * pi) - pi


@kernel
def store_cell(roads: Roads, r: int, east: float, north: float, heading: float, passed: int) -> None:
    """Store the next cell of a pass in memory ``r``; the oldest cell gives way."""
    number = roads.filled[r]
    place = number % roads.passes.shape[1]
    roads.cells[r, place, CELL_EAST] = east
    roads.cells[r, place, CELL_NORTH] = north
    roads.cells[r, place, CELL_HEADING] = heading
    roads.passes[r, place] = passed
    at = _bucket(floor(east / _BUCKET_M), floor(north / _BUCKET_M), roads.heads.shape[1])
    roads.older[r, place] = roads.heads[r, at]
    roads.heads[r, at] = number
    roads.filled[r] = number + 1


@kernel
def store_cells(roads: Roads, r: int, cells: FloatMatrix, passes: IntVector) -> None:
    """Store K cells (K, 3) and their passes (K,) in turn."""
    for k in range(passes.size):
        store_cell(
            roads, r, cells[k, CELL_EAST], cells[k, CELL_NORTH], cells[k, CELL_HEADING], int(passes[k])
        )


@kernel(inlined=True)
def _reach(roads: Roads, r: int, number: int, most: int) -> int:
    """Cells of the same pass behind a cell, up to ``most``."""
    length = roads.passes.shape[1]
    passed = roads.passes[r, number % length]
    ahead = 0
    while (
        ahead < most
        and number + ahead + 1 < roads.filled[r]
        and roads.passes[r, (number + ahead + 1) % length] == passed
    ):
        ahead += 1
    return ahead


@kernel
def _search(
    roads: Roads, r: int, east: float, north: float, course: float, needed: int, stays: int
) -> tuple[float, int]:
    """Cost and number of the cell that fits a place and course best, `NOWHERE` for none.

    ``needed`` cells ahead are wished for; ``stays`` is the cell matched before, or `NOWHERE`.
    """
    length, buckets = roads.passes.shape[1], roads.heads.shape[1]
    best_cost, best = np.inf, NOWHERE
    oldest = roads.filled[r] - length
    kept = -1
    if stays >= max(oldest, 0):
        kept = roads.passes[r, stays % length]
    column, row = floor(east / _BUCKET_M), floor(north / _BUCKET_M)
    for square in range(9):
        to, up = column + square // 3 - 1, row + square % 3 - 1
        number = int(roads.heads[r, _bucket(to, up, buckets)])
        looked = 0
        while number >= max(oldest, 0) and looked < _MOST_LOOKED_AT:
            place = number % length
            looked += 1
            cell_east, cell_north = roads.cells[r, place, CELL_EAST], roads.cells[r, place, CELL_NORTH]
            off_east, off_north = east - cell_east, north - cell_north
            square_m2 = off_east * off_east + off_north * off_north
            angle = _turned(roads.cells[r, place, CELL_HEADING] - course)
            # Another square may share the bucket: its cells are looked at there, not twice.
            inside = floor(cell_east / _BUCKET_M) == to and floor(cell_north / _BUCKET_M) == up
            if inside and square_m2 <= _NEAR_M * _NEAR_M and abs(angle) <= _ALONG_RAD:
                short = 1.0 - _reach(roads, r, number, needed) / needed
                cost = square_m2 / (_UNIT_M * _UNIT_M) + (angle / _UNIT_RAD) ** 2 + _SHORT_COST * short
                if roads.passes[r, place] == kept and number >= stays - 1:
                    cost *= _STAYS
                if cost < best_cost:
                    best_cost, best = cost, number
            number = int(roads.older[r, place])
    return best_cost, best


@kernel(inlined=True)
def _follows(roads: Roads, r: int, number: int) -> bool:
    """Whether the cell before a cell is held too, and of the same pass."""
    length = roads.passes.shape[1]
    if number == 0 or number - 1 < roads.filled[r] - length:
        return False
    return roads.passes[r, (number - 1) % length] == roads.passes[r, number % length]


@kernel(inlined=True)
def _along(roads: Roads, r: int, number: int, east: float, north: float) -> float:
    """How far along its heading a place lies from a cell."""
    place = number % roads.passes.shape[1]
    heading = float(roads.cells[r, place, CELL_HEADING])
    off_east, off_north = east - roads.cells[r, place, CELL_EAST], north - roads.cells[r, place, CELL_NORTH]
    return off_east * sin(heading) + off_north * cos(heading)


@kernel
def _heading_at(roads: Roads, r: int, number: int, along_m: float, ahead: int) -> float:
    """Heading of a pass ``along_m`` behind a cell that ``ahead`` more follow, held beyond the last one."""
    length = roads.passes.shape[1]
    at = min(max(along_m / CELL_M, 0.0), float(ahead))
    first = min(int(at), max(ahead - 1, 0))
    heading = float(roads.cells[r, (number + first) % length, CELL_HEADING])
    if ahead == 0:
        return heading
    following = float(roads.cells[r, (number + first + 1) % length, CELL_HEADING])
    return heading + (at - first) * (following - heading)


@kernel
def read_road(
    own: Roads,
    r: int,
    shared: Roads,
    sample: FloatVector,
    course: float,
    speed: float,
    matched: IntVector,
    out: FloatVector,
) -> None:
    """Write the road's columns of a context (13,) as remembered at a place, east and north of ``sample``.

    Memory ``r`` of ``own`` and the first of ``shared`` are looked up. ``matched`` (2,) is the cell of each
    that fitted last, and is renewed.
    """
    for column in range(ROAD_TURN, ROAD_KNOWN + 1):
        out[column] = 0.0
    needed = int(speed * ROAD_TURN_HORIZONS / CELL_M) + 2
    own_cost, own_number = _search(own, r, sample[0], sample[1], course, needed, int(matched[0]))
    shared_cost, shared_number = _search(shared, 0, sample[0], sample[1], course, needed, int(matched[1]))
    matched[0], matched[1] = own_number, shared_number
    if own_number < 0 and shared_number < 0:
        return
    roads, of, number = shared, 0, shared_number
    if own_cost <= shared_cost:
        roads, of, number = own, r, own_number
    along_m = _along(roads, of, number, sample[0], sample[1])
    if along_m < 0.0 and _follows(roads, of, number):
        number -= 1
        along_m += CELL_M
    ahead = _reach(roads, of, number, needed)
    if ahead * CELL_M < _TOLD_S * speed + along_m:
        return
    here = _heading_at(roads, of, number, along_m, ahead)
    for horizon in range(ROAD_TURN_HORIZONS):
        there_m = along_m + speed * (horizon + 1.0)
        out[ROAD_TURN + horizon] = _heading_at(roads, of, number, there_m, ahead) - here
    out[ROAD_HEADING] = _turned(here - course)
    out[ROAD_KNOWN] = 1.0
