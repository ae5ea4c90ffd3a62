"""Compiled store of what is known of pairs of vehicles: their shadowing and its place.

Every vehicle owns a small hash table. Half of the pairs with its neighbours are kept there, the other half
at theirs. So half of what a frame asks for lies side by side. The store grows with neighbours, not with the
square of the fleet; pairs out of range are dropped when it is written anew.

``pairs`` (V, S, 4) holds single-precision numbers, S a power of two: a quarter of a cache line a pair.
``pair_count`` (V,) says how many pairs a vehicle owns.
"""

import numpy as np

from modelcast.channel.random_kernels import CELL_BITS
from modelcast.core.exponential_kernels import fast_exp
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import Float32Cube, FloatMatrix, FloatVector, IntMatrix, IntVector

__all__ = ["empty_pairs", "find_pairs", "grow_pairs", "pair_owner", "pair_shadowing", "pair_slot"]

OTHER, VALUE, EAST_M, NORTH_M = 0, 1, 2, 3
"""Columns of a pair: the index of the one that does not own it, -1 for nobody; normalised shadowing; relative
position when it was drawn, infinite for a pair of which nothing was drawn yet."""

_FREE = np.float32(-1.0)
_UNKNOWN_M = np.float32(np.inf)
_CELL_MASK = np.uint64((1 << CELL_BITS) - 1)
_FULL_FOURTHS = 3
"""Fourths of a vehicle's table that may be taken."""


@kernel
def empty_pairs(vehicles: int, slots: int) -> tuple[Float32Cube, IntVector]:
    """Return an empty store of so many slots a vehicle, a power of two, and its counts."""
    pairs = np.zeros((vehicles, slots, 4), dtype=np.float32)
    pairs[:, :, OTHER] = _FREE
    return pairs, np.zeros(vehicles, dtype=np.int64)


@kernel(inlined=True)
def pair_owner(one: int, other: int) -> int:
    """Return which of two vehicles keeps their pair: the lower index where the sum of both is even."""
    return min(one, other) if (one + other) & 1 == 0 else max(one, other)


@kernel(inlined=True)
def _home(other: int, slots: int) -> int:
    """Return the slot where the search for a pair begins."""
    return ((other * 0x9E3779B1) >> 11) & (slots - 1)


@kernel(inlined=True)
def _seek(owner: int, other: int, pairs: Float32Cube) -> int:
    """Return the slot where a pair is, or where it would go."""
    mask = pairs.shape[1] - 1
    tag = np.float32(other)
    at = _home(other, pairs.shape[1])
    while pairs[owner, at, OTHER] != _FREE and pairs[owner, at, OTHER] != tag:
        at = (at + 1) & mask
    return at


@kernel(inlined=True)
def pair_slot(one: int, other: int, pairs: Float32Cube, pair_count: IntVector) -> int:
    """Return the slot of a pair at its owner, a new one where it had none; -1 where there is no room."""
    owner = pair_owner(one, other)
    at = _seek(owner, one + other - owner, pairs)
    if pairs[owner, at, OTHER] == _FREE:
        if 4 * (pair_count[owner] + 1) > _FULL_FOURTHS * pairs.shape[1]:
            return -1
        pairs[owner, at, OTHER] = np.float32(one + other - owner)
        pairs[owner, at, VALUE] = np.float32(0.0)
        pairs[owner, at, EAST_M] = pairs[owner, at, NORTH_M] = _UNKNOWN_M
        pair_count[owner] += 1
    return at


@kernel(inlined=True)
def find_pairs(
    v: int, order: IntVector, near: IntMatrix, count: int, pairs: Float32Cube, pair_count: IntVector
) -> bool:
    """Write the slots of a vehicle's pairs with its neighbours; return whether there was room for all.

    ``near`` (N, 2): its first column says where in ``order`` each of ``count`` neighbours stands, the second
    is written.
    """
    # First look at every pair once, without a branch: so all cache misses overlap.
    for n in range(count):
        other = int(order[near[n, 0]])
        owner = pair_owner(v, other)
        near[n, 1] = np.int64(pairs[owner, _home(v + other - owner, pairs.shape[1]), OTHER])
    for n in range(count):
        near[n, 1] = pair_slot(v, int(order[near[n, 0]]), pairs, pair_count)
        if near[n, 1] < 0:
            return False
    return True


@kernel(inlined=True)
def pair_shadowing(
    one: int,
    other: int,
    slot: int,
    east_m: float,
    north_m: float,
    word: np.uint64,
    normal: FloatVector,
    decorrelation_m: float,
    pairs: Float32Cube,
) -> float:
    """Return the pair's normalised shadowing now, and keep it in its slot.

    ``east_m`` and ``north_m`` are where ``other`` is from ``one``.
    """
    owner = pair_owner(one, other)
    sign = 1.0 if one < other else -1.0
    east, north = np.float32(sign * east_m), np.float32(sign * north_m)
    moved_east = np.float64(east) - pairs[owner, slot, EAST_M]
    moved_north = np.float64(north) - pairs[owner, slot, NORTH_M]
    moved_m = np.sqrt(moved_east * moved_east + moved_north * moved_north)
    kept = fast_exp(-moved_m / decorrelation_m)
    fresh = normal[np.int64((word >> np.uint64(CELL_BITS)) & _CELL_MASK)]
    value = np.float32(kept * pairs[owner, slot, VALUE] + np.sqrt(1.0 - kept * kept) * fresh)
    pairs[owner, slot, VALUE] = value
    pairs[owner, slot, EAST_M], pairs[owner, slot, NORTH_M] = east, north
    return np.float64(value)


@kernel
def grow_pairs(pairs: Float32Cube, position_m: FloatMatrix, range_m: float) -> tuple[Float32Cube, IntVector]:
    """Return a store with the pairs still in range and room for more at every vehicle, and its counts."""
    vehicles, slots = pairs.shape[0], pairs.shape[1]
    keep = np.zeros((vehicles, slots), dtype=np.bool_)
    most = 0
    for owner in range(vehicles):
        live = 0
        for at in range(slots):
            if pairs[owner, at, OTHER] == _FREE:
                continue
            other = int(pairs[owner, at, OTHER])
            east = position_m[owner, 0] - position_m[other, 0]
            north = position_m[owner, 1] - position_m[other, 1]
            if east * east + north * north <= range_m * range_m:
                keep[owner, at] = True
                live += 1
        most = max(most, live)
    new_slots = 16
    while 8 * most + 8 > 5 * new_slots:
        new_slots *= 2
    fresh, count = empty_pairs(vehicles, new_slots)
    for owner in range(vehicles):
        for at in range(slots):
            if keep[owner, at]:
                to = _seek(owner, int(pairs[owner, at, OTHER]), fresh)
                for column in range(4):
                    fresh[owner, to, column] = pairs[owner, at, column]
                count[owner] += 1
    return fresh, count
