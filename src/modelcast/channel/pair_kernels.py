"""Compiled store of what is known of pairs of vehicles: their shadowing and its place.

Every vehicle owns a small hash table. Half of the pairs with its neighbours are kept there, the other half
at theirs. The store grows with neighbours, not with the square of the fleet; pairs out of range are dropped
when it is written anew.
"""

from typing import NamedTuple

import numpy as np

from modelcast.core.exponential_kernels import fast_exp
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import Float32Cube, Float32Vector, FloatMatrix, IntVector

__all__ = [
    "Pairs",
    "empty_pairs",
    "first_slot",
    "grow_pairs",
    "kept_share",
    "mixed",
    "move_pair",
    "pair_owner",
    "pair_slot",
]

OTHER, VALUE, EAST_M, NORTH_M = 0, 1, 2, 3
"""Columns of a pair: the index of the one that does not own it, -1 for nobody; normalised shadowing; where
the other was from the owner when it was drawn, infinite for a pair of which nothing was drawn yet."""

_FREE = np.float32(-1.0)
_UNKNOWN_M = np.float32(np.inf)
_CELL_SHIFT = np.uint64(52)
_BUCKET = 4
"""Slots that are looked at together: a cache line."""

_FULL_FOURTHS = 3
"""Fourths of a vehicle's table that may be taken."""


class Pairs(NamedTuple):
    """Pairs of V vehicles.

    ``held`` (V, S, 4) are single-precision numbers, S a power of two: a quarter of a cache line a pair;
    ``owned`` (V,) says how many pairs a vehicle owns.
    """

    held: Float32Cube
    owned: IntVector


@kernel
def empty_pairs(vehicles: int, slots: int) -> Pairs:
    """Return an empty store of so many slots a vehicle, a power of two."""
    held = np.zeros((vehicles, slots, 4), dtype=np.float32)
    held[:, :, OTHER] = _FREE
    return Pairs(held, np.zeros(vehicles, dtype=np.int64))


@kernel(inlined=True)
def pair_owner(one: int, other: int) -> int:
    """Return which of two vehicles keeps their pair: the lower index where the sum of both is even."""
    return min(one, other) if (one + other) & 1 == 0 else max(one, other)


@kernel(inlined=True)
def home_slot(other: int, held: Float32Cube) -> int:
    """Return the first of the `_BUCKET` slots where the search for a pair begins."""
    return ((other * 0x9E3779B1) >> 11) & (held.shape[1] - _BUCKET)


@kernel(inlined=True)
def first_slot(owner: int, other: int, held: Float32Cube) -> int:
    """Return the slot of a pair if it is where the search for it begins; else -1."""
    tag, at = np.float32(other), home_slot(other, held)
    slot = -1
    for n in range(_BUCKET):
        slot = at + n if held[owner, at + n, OTHER] == tag else slot
    return slot


@kernel(inlined=True)
def _seek(owner: int, other: int, held: Float32Cube) -> int:
    """Return the slot where a pair is, or where it would go."""
    tag, at = np.float32(other), home_slot(other, held)
    while True:
        # All slots of a bucket are looked at: a branch for each would be guessed wrongly too often.
        slot = -1
        for n in range(_BUCKET):
            slot = at + n if held[owner, at + n, OTHER] == tag else slot
        if slot >= 0:
            return slot
        for n in range(_BUCKET):
            if held[owner, at + n, OTHER] == _FREE:
                return at + n
        at = (at + _BUCKET) & (held.shape[1] - 1)


@kernel(inlined=True)
def pair_slot(owner: int, other: int, pairs: Pairs) -> int:
    """Return the slot of a pair at its owner, a new one where it had none; -1 where there is no room."""
    held = pairs.held
    at = _seek(owner, other, held)
    if held[owner, at, OTHER] == _FREE:
        if 4 * (pairs.owned[owner] + 1) > _FULL_FOURTHS * held.shape[1]:
            return -1
        held[owner, at, OTHER] = np.float32(other)
        held[owner, at, VALUE] = np.float32(0.0)
        held[owner, at, EAST_M] = held[owner, at, NORTH_M] = _UNKNOWN_M
        pairs.owned[owner] += 1
    return at


@kernel(inlined=True)
def move_pair(owner: int, slot: int, east: np.float32, north: np.float32, held: Float32Cube) -> float:
    """Keep where the other of a pair is now; return the square of how far it moved, infinite at first."""
    moved_east = np.float64(east) - held[owner, slot, EAST_M]
    moved_north = np.float64(north) - held[owner, slot, NORTH_M]
    held[owner, slot, EAST_M], held[owner, slot, NORTH_M] = east, north
    return moved_east * moved_east + moved_north * moved_north


@kernel(inlined=True)
def kept_share(moved_m: float, decorrelation_m: float) -> float:
    """Return how much of a pair's shadowing is left after its relative position changed."""
    return fast_exp(-moved_m / decorrelation_m)


@kernel(inlined=True)
def mixed(before: float, kept: float, word: np.uint64, normal: Float32Vector) -> float:
    """Return normalised shadowing of which a share is what it was before; ``word`` is chance."""
    return kept * before + np.sqrt(1.0 - kept * kept) * normal[np.int64(word >> _CELL_SHIFT)]


@kernel
def grow_pairs(pairs: Pairs, position_m: FloatMatrix, range_m: float) -> Pairs:
    """Return a store with the pairs still in range and room for more at every vehicle."""
    held = pairs.held
    vehicles, slots = held.shape[0], held.shape[1]
    keep = np.zeros((vehicles, slots), dtype=np.bool_)
    most = 0
    for owner in range(vehicles):
        live = 0
        for at in range(slots):
            if held[owner, at, OTHER] == _FREE:
                continue
            other = int(held[owner, at, OTHER])
            east = position_m[owner, 0] - position_m[other, 0]
            north = position_m[owner, 1] - position_m[other, 1]
            if east * east + north * north <= range_m * range_m:
                keep[owner, at] = True
                live += 1
        most = max(most, live)
    new_slots = 16
    while 8 * most + 8 > 5 * new_slots:
        new_slots *= 2
    grown = empty_pairs(vehicles, new_slots)
    for owner in range(vehicles):
        for at in range(slots):
            if keep[owner, at]:
                to = _seek(owner, int(held[owner, at, OTHER]), grown.held)
                for column in range(4):
                    grown.held[owner, to, column] = held[owner, at, column]
                grown.owned[owner] += 1
    return grown
