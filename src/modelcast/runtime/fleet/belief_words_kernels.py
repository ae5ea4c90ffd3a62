"""Compiled words of what a message makes its holders believe: worked out once a step, whoever holds it.

One word has the step and the bins of tracking error and age, another the step and the error as a vector,
which a host needs to say how wrong it is about the remote's place relative to its own.
"""

from math import hypot, sqrt
from typing import NamedTuple

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, FloatMatrix, FloatVector, IntVector
from modelcast.models.member_kernels import Members
from modelcast.runtime.fleet.bins_kernels import bin_of
from modelcast.station.sender.message_arrays import CONTENT_EAST_M, CONTENT_FIT_S, CONTENT_NORTH_M

__all__ = [
    "Tracking",
    "bins_of",
    "error_units",
    "error_word",
    "found_bins",
    "gone_words",
    "relative_bin",
    "units_bin",
    "word_of",
]

_BIN_BITS = 10
_BIN_MASK = (1 << _BIN_BITS) - 1

_AXIS_BITS = 22
_AXIS_MASK = (1 << _AXIS_BITS) - 1
_AXIS_MIDDLE = 1 << (_AXIS_BITS - 1)
_STEP_MASK = (1 << (63 - 2 * _AXIS_BITS)) - 1
_A_METRE = 1e4
"""Units of an error's word: 0.1 mm, so that an axis reaches 209 m; what is farther counts as that."""


class Tracking(NamedTuple):
    """What tracks are sampled with.

    Members of all senders' banks; time, number of the step; silence after which a track is lost [s]; width of
    the bins of distance [m]; first and end bin of the middle distances; who is where, (V,) and (V, 2); by how
    much vehicles are wrong about their own place, (V, 2) [m]; whose tracks count, (V,); who is a person,
    (V,), and the square of how far apart a pair with one may be that counts [m²].
    """

    members: Members
    t_s: float
    step: int
    expiry_s: float
    distance_bin_m: float
    middle: tuple[int, int]
    vehicle: IntVector
    truth_m: FloatMatrix
    own_error_m: FloatMatrix
    counted: BoolVector
    person: BoolVector
    people_m2: float


@kernel(inlined=True)
def bins_of(belief: int) -> tuple[int, int]:
    """Bins of tracking error and age that a word says; the first is -1 where the sender has left."""
    return ((belief >> _BIN_BITS) & _BIN_MASK) - 1, belief & _BIN_MASK


@kernel(inlined=True)
def found_bins(x: Tracking, belief: int, error: int) -> bool:
    """Whether both words were worked out in this step; a thread may have written the second alone so far."""
    return belief >> (2 * _BIN_BITS) == x.step and error >> (2 * _AXIS_BITS) == x.step & _STEP_MASK


@kernel(inlined=True)
def _units(value_m: float) -> int:
    """An axis of an error in whole units, within its bits; no number counts as the farthest."""
    if not abs(value_m) * _A_METRE < _AXIS_MIDDLE - 1.0:
        return _AXIS_MASK if value_m > 0.0 else 1
    return int(value_m * _A_METRE + _AXIS_MIDDLE + 0.5)


@kernel(inlined=True)
def error_word(x: Tracking, sender: int, row: FloatVector, displaced: FloatVector) -> int:
    """Error of what a message makes its holders believe, as a vector, and the step, in one word."""
    east = _units(displaced[0] + row[CONTENT_EAST_M] - x.truth_m[sender, 0])
    north = _units(displaced[1] + row[CONTENT_NORTH_M] - x.truth_m[sender, 1])
    return ((x.step & _STEP_MASK) << (2 * _AXIS_BITS)) | (east << _AXIS_BITS) | north


@kernel(inlined=True)
def error_units(word: int) -> tuple[float, float]:
    """East and north of the error that a word says, in its units."""
    return float(((word >> _AXIS_BITS) & _AXIS_MASK) - _AXIS_MIDDLE), float(
        (word & _AXIS_MASK) - _AXIS_MIDDLE
    )


@kernel(inlined=True)
def units_bin(east: float, north: float, own_east_m: float, own_north_m: float) -> int:
    """Bin of a remote's error as its host sees it, which is wrong about its own place by so much [m]."""
    away_east, away_north = east / _A_METRE - own_east_m, north / _A_METRE - own_north_m
    return bin_of(sqrt(away_east * away_east + away_north * away_north))


@kernel(inlined=True)
def relative_bin(word: int, own_east_m: float, own_north_m: float) -> int:
    """Bin of what a word says, for a host that is wrong about its own place by so much [m]."""
    east, north = error_units(word)
    return units_bin(east, north, own_east_m, own_north_m)


@kernel(inlined=True)
def word_of(x: Tracking, sender: int, row: FloatVector, displaced: FloatVector) -> int:
    """Word of what a message makes its holders believe, from how far its sender is believed to have come."""
    east, north = displaced[0] + row[CONTENT_EAST_M], displaced[1] + row[CONTENT_NORTH_M]
    error_bin = bin_of(hypot(east - x.truth_m[sender, 0], north - x.truth_m[sender, 1])) + 1
    return (x.step << (2 * _BIN_BITS)) | (error_bin << _BIN_BITS) | bin_of(x.t_s - row[CONTENT_FIT_S])


@kernel(inlined=True)
def gone_words(x: Tracking) -> tuple[int, int]:
    """Both words of a message whose sender has left."""
    return x.step << (2 * _BIN_BITS), (x.step & _STEP_MASK) << (2 * _AXIS_BITS)
