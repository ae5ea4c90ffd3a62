"""Compiled propagation: gain of a link from tables."""

from typing import NamedTuple

import numpy as np

from modelcast.channel.pair_kernels import (
    VALUE,
    empty_pairs,
    grow_pairs,
    kept_share,
    mixed,
    move_pair,
    pair_owner,
    pair_slot,
)
from modelcast.channel.random_kernels import CELL_BITS, next_word
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    Float32Matrix,
    Float32Vector,
    FloatMatrix,
    FloatVector,
    IntVector,
    UInt64Vector,
)

__all__ = [
    "PropagationTables",
    "draw_gains",
    "fading_factor",
    "is_raised",
    "looked_up",
    "median_ln",
]

_CELL_MASK = np.uint64((1 << CELL_BITS) - 1)
_LN10 = np.log(10.0)


class PropagationTables(NamedTuple):
    """Propagation as arrays and numbers; made by `Propagation.tables`.

    ``los_ln`` and ``nlos_ln`` (K,) are natural logarithms of the power gain at multiples of ``1 / per_m``
    metres; ``normal`` (CELLS,) and ``fading`` (3, CELLS) or (3, 1) are equally probable values, in single
    precision, so that a row of them stays at hand. The last ``raised`` stations have antennas above the road:
    ``raised_los_ln`` and ``raised_nlos_ln`` are for links of which one end is raised. ``reach_ln`` is the
    greatest of both on a line of sight from there on, so it never rises.
    """

    los_ln: FloatVector
    nlos_ln: FloatVector
    per_m: float
    nlos_kind: int
    corner_ln: float
    block_m: float
    half_street_m: float
    shadowing_los_ln: float
    shadowing_nlos_ln: float
    decorrelation_m: float
    normal: Float32Vector
    fading: Float32Matrix
    fading_near_m: float
    fading_far_m: float
    raised: int
    raised_los_ln: FloatVector
    raised_nlos_ln: FloatVector
    reach_ln: FloatVector


@kernel(inlined=True)
def is_raised(one: int, other: int, stations: int, raised: int) -> bool:
    """Return whether one end of a link, and not the other, is among the last ``raised`` stations."""
    return (one >= stations - raised) != (other >= stations - raised)


@kernel(inlined=True)
def looked_up(table: FloatVector, at: float) -> float:
    """Return the value of an evenly spaced table between its points."""
    k = min(int(at), table.size - 2)
    part = at - k
    return table[k] + part * (table[k + 1] - table[k])


@kernel(inlined=True)
def _same_street(first: float, second: float, block_m: float, half_m: float) -> bool:
    k = np.round(first / block_m)
    return (
        k == np.round(second / block_m)
        and abs(first - k * block_m) <= half_m
        and abs(second - k * block_m) <= half_m
    )


@kernel(inlined=True)
def _corner_ln(first_m: float, second_m: float, nlos_ln: FloatVector, per_m: float) -> float:
    second_m = max(second_m, 1.0)
    exponent = max(2.8 - 0.0024 * max(first_m, 1.0), 1.84)
    turned_db = 10.0 * exponent * np.log10(second_m) - 12.5 * exponent
    return looked_up(nlos_ln, first_m * per_m) - turned_db * _LN10 / 10.0


@kernel(inlined=True)
def median_ln(
    east: float,
    north: float,
    other_east: float,
    other_north: float,
    distance_m: float,
    raised: bool,
    tables: PropagationTables,
) -> tuple[float, bool]:
    """Return the natural logarithm of the median gain of a link, and whether its ends see each other.

    ``raised`` says whether one end of it is.
    """
    los_ln, nlos_ln, per_m = tables.los_ln, tables.nlos_ln, tables.per_m
    if raised:
        los_ln, nlos_ln = tables.raised_los_ln, tables.raised_nlos_ln
    if tables.nlos_kind == 0:
        return looked_up(los_ln, distance_m * per_m), True
    if _same_street(east, other_east, tables.block_m, tables.half_street_m) or _same_street(
        north, other_north, tables.block_m, tables.half_street_m
    ):
        return looked_up(los_ln, distance_m * per_m), True
    if tables.nlos_kind == 1:
        return looked_up(nlos_ln, distance_m * per_m), False
    first_m, second_m = abs(other_east - east), abs(other_north - north)
    ways = max(_corner_ln(first_m, second_m, nlos_ln, per_m), _corner_ln(second_m, first_m, nlos_ln, per_m))
    return min(ways + tables.corner_ln, 0.0), False


@kernel(inlined=True)
def fading_factor(
    distance_m: float, word: np.uint64, fading: Float32Matrix, near_m: float, far_m: float
) -> float:
    """Return the power factor of fast fading from the low bits of a random word."""
    row = 0 if distance_m < near_m else (1 if distance_m < far_m else 2)
    # One cell, or CELLS of them: both are powers of two.
    return np.float64(fading[row, np.int64(word & _CELL_MASK) & (fading.shape[1] - 1)])


@kernel
def draw_gains(
    position_m: FloatMatrix, one: IntVector, other: IntVector, tables: PropagationTables, random: UInt64Vector
) -> FloatVector:
    """Return power gains of many links in order, (N,), with shadowing that remembers its pair."""
    pairs = empty_pairs(position_m.shape[0], 16)
    gains = np.empty(one.size)
    for n in range(one.size):
        i = pair_owner(one[n], other[n])
        j = one[n] + other[n] - i
        east_m, north_m = position_m[j, 0] - position_m[i, 0], position_m[j, 1] - position_m[i, 1]
        distance_m = np.sqrt(east_m * east_m + north_m * north_m)
        ln, los = median_ln(
            position_m[i, 0],
            position_m[i, 1],
            position_m[j, 0],
            position_m[j, 1],
            distance_m,
            is_raised(i, j, position_m.shape[0], tables.raised),
            tables,
        )
        word = next_word(random)
        slot = pair_slot(i, j, pairs)
        while slot < 0:
            pairs = grow_pairs(pairs, position_m, np.inf)
            slot = pair_slot(i, j, pairs)
        held = pairs.held
        moved_m = np.sqrt(move_pair(i, slot, np.float32(east_m), np.float32(north_m), held))
        kept = kept_share(moved_m, tables.decorrelation_m)
        shadow = mixed(held[i, slot, VALUE], kept, word, tables.normal)
        held[i, slot, VALUE] = np.float32(shadow)
        sigma = tables.shadowing_los_ln if los else tables.shadowing_nlos_ln
        gains[n] = np.exp(ln + sigma * shadow) * fading_factor(
            distance_m, word, tables.fading, tables.fading_near_m, tables.fading_far_m
        )
    return gains
