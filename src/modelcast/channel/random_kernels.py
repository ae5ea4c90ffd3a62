"""A small random generator for compiled loops: its whole state is one word that a channel's state can hold.

SplitMix64 (Steele, Lea and Flood 2014, DOI 10.1145/2660193.2660195): one addition, two multiplications a
draw. Values of a distribution come from a table of equally probable cells (`quantile_cells`): twelve bits a
draw.
"""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import UInt64Vector

__all__ = ["CELLS", "CELL_BITS", "LUCK", "next_word", "uniform", "uniform_of", "word_of"]

CELL_BITS = 12
CELLS = 1 << CELL_BITS
LUCK = 1 << 32
"""Apart from the indices of vehicles: a frame's fading and its luck are independent."""

_STEP = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)
_UNIT = 2.0**-53


@kernel(inlined=True)
def _mix(word: np.uint64) -> np.uint64:
    word = (word ^ (word >> np.uint64(30))) * _FIRST
    word = (word ^ (word >> np.uint64(27))) * _SECOND
    return word ^ (word >> np.uint64(31))


@kernel(inlined=True)
def next_word(random: UInt64Vector) -> np.uint64:
    """Return 64 random bits and move the generator ``random`` (1,) on."""
    random[0] += _STEP
    return _mix(random[0])


@kernel(inlined=True)
def uniform(random: UInt64Vector) -> float:
    """Return one number in [0, 1)."""
    return np.float64(next_word(random) >> np.uint64(11)) * _UNIT


@kernel(inlined=True)
def word_of(seed: int, index: int) -> np.uint64:
    """Return 64 random bits that depend on a seed and an index alone, not on what else was drawn."""
    return _mix(np.uint64(seed) + np.uint64(index + 1) * _STEP)


@kernel(inlined=True)
def uniform_of(seed: int, index: int) -> float:
    """Return one number in [0, 1) that depends on a seed and an index alone."""
    return np.float64(word_of(seed, index) >> np.uint64(11)) * _UNIT
