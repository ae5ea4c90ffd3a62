"""Compiled shadowing of a step: that of every pair with a vehicle that may send, in one sweep.

Positions are held for a step, so the shadowing of a pair is worked out once. The sweep goes through the
owners of pairs in the order of the cells: an owner's table is then at hand for all its pairs, and what is
written for its neighbours lies beside what the owner before it wrote. A frame reads its sender's row.
"""

from typing import NamedTuple

import numpy as np

from modelcast.channel.cells_kernels import Cells, build_cells, cell_row, cell_span, row_span
from modelcast.channel.pair_kernels import (
    OTHER,
    VALUE,
    Pairs,
    first_slot,
    home_slot,
    kept_share,
    mixed,
    move_pair,
    pair_owner,
    pair_slot,
)
from modelcast.channel.propagation_kernels import PropagationTables
from modelcast.channel.random_kernels import word_of
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    BoolVector,
    Float32Cube,
    Float32Vector,
    FloatMatrix,
    FloatVector,
    IntMatrix,
    IntVector,
)

__all__ = ["SILENT", "ShadowRows", "Sweep", "lay_out", "sweep_part"]

SILENT = -1.0
"""Squared reach of a vehicle that will not send."""

_FEW = 16
"""Where fewer than one in so many sends, they look up their pairs one by one: there is little to share."""

_OTHER, _PLACE, _SLOT, _WORD = 0, 1, 2, 3
_EAST_M, _NORTH_M, _KEPT, _VALUE = 0, 1, 2, 3


class ShadowRows(NamedTuple):
    """Normalised shadowing between senders and their neighbours.

    That of vehicle ``v`` and of who stands at ``k`` in the order of the cells, in row ``r`` of cells, is
    ``value[start[first[v] + r] + k]``. ``first`` (V,), ``start`` a number for every sender and row of cells
    that its range touches, ``value`` a number for every vehicle in those cells: a shadowing for those within
    its reach only.
    """

    first: IntVector
    start: IntVector
    value: Float32Vector


class Sweep(NamedTuple):
    """What a step's sweep starts from, and where it writes.

    ``reach_m2`` (V, 2), ``position_m`` (V, 2), ``weak`` (V,) and ``range_m`` as `lay_out` is given them;
    ``cells`` of all, ``senders`` of those who send, ``rows`` of their values, ``longest_m`` (2,) above all
    reaches of pairs without a weak antenna, and with one.
    """

    reach_m2: FloatMatrix
    position_m: FloatMatrix
    weak: BoolVector
    cells: Cells
    senders: Cells
    rows: ShadowRows
    range_m: float
    longest_m: FloatVector


@kernel
def _row_starts(reach_m2: FloatMatrix, position_m: FloatMatrix, cells: Cells, range_m: float) -> ShadowRows:
    """Return rows for all senders, whose values are yet to be written."""
    vehicles = reach_m2.shape[0]
    first = np.zeros(vehicles, dtype=np.int64)
    rows = 0
    for v in range(vehicles):
        if reach_m2[v, 0] >= 0.0:
            _, _, row_from, row_to = cell_span(cells, position_m[v, 0], position_m[v, 1], range_m)
            first[v] = rows - row_from
            rows += row_to - row_from + 1
    start = np.empty(rows, dtype=np.int64)
    length = 0
    for v in range(vehicles):
        if reach_m2[v, 0] >= 0.0:
            left, right, row_from, row_to = cell_span(cells, position_m[v, 0], position_m[v, 1], range_m)
            for row in range(row_from, row_to + 1):
                low, high = row_span(cells, row, left, right)
                start[first[v] + row] = length - low
                length += high - low
    return ShadowRows(first, start, np.empty(length, dtype=np.float32))


@kernel(inlined=True)
def _word(seed: np.uint64, owner: int, other: int, before: float, east_m: np.float32) -> np.uint64:
    """Return chance that depends on a pair, its last value and its new place alone."""
    value, place = np.float32(before).view(np.uint32), np.float32(east_m).view(np.uint32)
    key = seed ^ (np.uint64(value) << np.uint64(32)) ^ np.uint64(place)
    return word_of(int(key), (owner << 32) + other)


@kernel(inlined=True)
def _look_up(
    v: int,
    reach_m2: FloatVector,
    weak: BoolVector,
    position_m: FloatMatrix,
    cells: Cells,
    seed: np.uint64,
    tables: PropagationTables,
    rows: ShadowRows,
    pairs: Pairs,
) -> bool:
    """Renew the pairs of a sender one by one, wherever they are kept; return whether there was room."""
    held = pairs.held
    east, north = position_m[v, 0], position_m[v, 1]
    farthest_m2 = reach_m2[0]
    for k in range(1, reach_m2.size):
        farthest_m2 = max(farthest_m2, reach_m2[k])
    left, right, row_from, row_to = cell_span(cells, east, north, np.sqrt(farthest_m2))
    for row in range(row_from, row_to + 1):
        low, high = row_span(cells, row, left, right)
        start = rows.start[rows.first[v] + row]
        # First look at every pair once, without a branch: so all cache misses overlap.
        for k in range(low, high):
            owner = pair_owner(v, int(cells.order[k]))
            home = home_slot(v + int(cells.order[k]) - owner, held)
            rows.value[start + k] = held[owner, home, OTHER]
        for k in range(low, high):
            j = int(cells.order[k])
            away_east, away_north = cells.place[k, 0] - east, cells.place[k, 1] - north
            if j == v or away_east * away_east + away_north * away_north > reach_m2[int(weak[j])]:
                continue
            owner = pair_owner(v, j)
            other, sign = v + j - owner, 1.0 if owner == v else -1.0
            slot = pair_slot(owner, other, pairs)
            if slot < 0:
                return False
            before, to_east = held[owner, slot, VALUE], np.float32(sign * away_east)
            moved_m = np.sqrt(move_pair(owner, slot, to_east, np.float32(sign * away_north), held))
            kept = kept_share(moved_m, tables.decorrelation_m)
            word = _word(seed, owner, other, before, to_east)
            value = np.float32(mixed(before, kept, word, tables.normal))
            held[owner, slot, VALUE] = rows.value[start + k] = value
    return True


@kernel(inlined=True)
def _find_owned(
    owner: int,
    reach_m2: FloatMatrix,
    weak: BoolVector,
    position_m: FloatMatrix,
    cells: Cells,
    range_m: float,
    rows: ShadowRows,
    found: IntMatrix,
    way: FloatMatrix,
) -> int:
    """Write who is in reach and belongs to ``owner``, and where from it, into ``found`` and ``way``.

    ``cells`` hold the candidates: everybody where the owner sends. Returns how many there are.
    """
    east, north = position_m[owner, 0], position_m[owner, 1]
    reach, to_weak, own = reach_m2[owner, 0], reach_m2[owner, 1], int(weak[owner])
    left, right, row_from, row_to = cell_span(cells, east, north, range_m)
    count = 0
    for row in range(row_from, row_to + 1):
        low, high = row_span(cells, row, left, right)
        start = rows.start[rows.first[owner] + row] if reach >= 0.0 else 0
        before = count
        for k in range(low, high):
            other = int(cells.order[k])
            away_east, away_north = cells.place[k, 0] - east, cells.place[k, 1] - north
            square = away_east * away_east + away_north * away_north
            found[_PLACE, count] = k
            # As `pair_owner` has it, without a branch.
            owned = (other > owner) ^ (((owner + other) & 1) == 1)
            mine = to_weak if weak[other] else reach
            count += int((other != owner) & owned & (square <= max(mine, reach_m2[other, own])))
        for n in range(before, count):
            k = found[_PLACE, n]
            found[_OTHER, n], found[_PLACE, n] = cells.order[k], start + k
            way[_EAST_M, n], way[_NORTH_M, n] = cells.place[k, 0] - east, cells.place[k, 1] - north
    return count


@kernel(inlined=True)
def _find_slots(owner: int, count: int, found: IntMatrix, pairs: Pairs) -> bool:
    """Write the slots of an owner's pairs with those found; return whether there was room for all."""
    # First look at the slots where each pair begins, without a branch: so all cache misses overlap.
    missed = 0
    for n in range(count):
        found[_SLOT, n] = first_slot(owner, found[_OTHER, n], pairs.held)
        found[_WORD, missed] = n
        missed += int(found[_SLOT, n] < 0)
    for m in range(missed):
        n = found[_WORD, m]
        found[_SLOT, n] = pair_slot(owner, found[_OTHER, n], pairs)
        if found[_SLOT, n] < 0:
            return False
    return True


@kernel(inlined=True)
def _renew(
    owner: int,
    count: int,
    seed: np.uint64,
    found: IntMatrix,
    way: FloatMatrix,
    held: Float32Cube,
    tables: PropagationTables,
) -> None:
    """Write what the shadowing of an owner's pairs is now, into ``way`` and into their slots."""
    for n in range(count):
        slot, east = found[_SLOT, n], np.float32(way[_EAST_M, n])
        before = held[owner, slot, VALUE]
        way[_VALUE, n] = before
        way[_KEPT, n] = move_pair(owner, slot, east, np.float32(way[_NORTH_M, n]), held)
        found[_WORD, n] = np.int64(_word(seed, owner, found[_OTHER, n], before, east))
    # A loop that touches no other array: so it runs several at a time.
    for n in range(count):
        way[_KEPT, n] = kept_share(np.sqrt(way[_KEPT, n]), tables.decorrelation_m)
    for n in range(count):
        word = np.uint64(found[_WORD, n])
        value = np.float32(mixed(way[_VALUE, n], way[_KEPT, n], word, tables.normal))
        way[_VALUE, n] = held[owner, found[_SLOT, n], VALUE] = value


@kernel
def lay_out(reach_m2: FloatMatrix, position_m: FloatMatrix, weak: BoolVector, range_m: float) -> Sweep:
    """Return the sweep of a step, whose values are yet to be written.

    Parameters
    ----------
    reach_m2
        Square of the distance up to which each vehicle may be heard in this step, by stations with a
        vehicle's antenna and by weak ones, `SILENT` where it does not send, (V, 2) [m²].
    position_m
        Where everybody is, NaN for nobody, (V, 2) [m].
    weak
        Whose antenna is weaker than a vehicle's, (V,).
    range_m
        No reach is longer; the cells are made for it [m].
    """
    cells = build_cells(position_m, range_m)
    longest_m2 = np.zeros(2)
    for v in range(weak.size):
        one_end = int(weak[v])
        longest_m2[one_end] = max(longest_m2[one_end], reach_m2[v, 0])
        longest_m2[1] = max(longest_m2[1], reach_m2[v, 1])
    longest_m = np.sqrt(longest_m2) + 1.0  # so that no rounding keeps anybody out
    where_m = np.full((weak.size, 2), np.nan)
    sending = np.flatnonzero(reach_m2[:, 0] >= 0.0)
    where_m[sending] = position_m[sending]
    return Sweep(
        reach_m2,
        position_m,
        weak,
        cells,
        build_cells(where_m, longest_m.max()),
        _row_starts(reach_m2, position_m, cells, range_m),
        range_m,
        longest_m,
    )


@kernel
def _sweep_few(sweep: Sweep, pairs: Pairs, seed: np.uint64, tables: PropagationTables) -> bool:
    """Renew the pairs of few senders; return whether there was too little room."""
    for v in range(sweep.weak.size):
        reach_m2 = sweep.reach_m2[v]
        if reach_m2[0] >= 0.0 and not _look_up(
            v, reach_m2, sweep.weak, sweep.position_m, sweep.cells, seed, tables, sweep.rows, pairs
        ):
            return True
    return False


@kernel
def sweep_part(
    sweep: Sweep, pairs: Pairs, seed: np.uint64, tables: PropagationTables, part: int, parts: int
) -> bool:
    """Renew the pairs of a part of the owners; return whether an owner had too little room for its pairs.

    The others are renewed then, that one is left out. Parts write to different places.
    """
    cells, rows, reach_m2, weak = sweep.cells, sweep.rows, sweep.reach_m2, sweep.weak
    present = cells.order.size
    if _FEW * sweep.senders.order.size <= present:
        return part == 0 and _sweep_few(sweep, pairs, seed, tables)
    found, way = np.empty((4, present + 1), dtype=np.int64), np.empty((4, present + 1))
    short = False
    for k in range(part * present // parts, (part + 1) * present // parts):
        owner = int(cells.order[k])
        sends = reach_m2[owner, 0] >= 0.0
        among = cells if sends else sweep.senders
        longest_m = sweep.longest_m[1] if weak[owner] else sweep.longest_m.max()
        count = _find_owned(owner, reach_m2, weak, sweep.position_m, among, longest_m, rows, found, way)
        if not _find_slots(owner, count, found, pairs):
            short = True
            continue
        _renew(owner, count, seed, found, way, pairs.held, tables)
        row = cell_row(cells, sweep.position_m[owner, 1])
        for n in range(count):
            other, value = found[_OTHER, n], np.float32(way[_VALUE, n])
            if sends:
                rows.value[found[_PLACE, n]] = value
            if reach_m2[other, 0] >= 0.0:
                rows.value[rows.start[rows.first[other] + row] + k] = value
    return short
