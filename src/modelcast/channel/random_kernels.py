"""A small random generator for compiled loops: its whole state is one word that a channel's state can hold.

SplitMix64 (Steele, Lea and Flood 2014, DOI 10.1145/2660193.2660195): one addition, two multiplications a
draw. Values of a distribution come from a table of equally probable cells (`quantile_cells`): twelve bits a
draw.
"""

from typing import Any

import numpy as np

from modelcast.channel.borrowing_kernels import borrowing

__all__ = ["CELLS", "CELL_BITS", "next_word", "uniform"]

CELL_BITS = 12
CELLS = 1 << CELL_BITS
_STEP = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)
_UNIT = 2.0**-53


@borrowing
def next_word(random: Any) -> Any:
    """Return 64 random bits and move the generator ``random`` (1,) on."""
    random[0] += _STEP
    word = random[0]
    word = (word ^ (word >> np.uint64(30))) * _FIRST
    word = (word ^ (word >> np.uint64(27))) * _SECOND
    return word ^ (word >> np.uint64(31))


@borrowing
def uniform(random: Any) -> float:
    """Return one number in [0, 1)."""
    return np.float64(next_word(random) >> np.uint64(11)) * _UNIT
