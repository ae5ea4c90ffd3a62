"""Which remote counts as the vehicle ahead, and what is remembered of it."""

from math import pi
from typing import NamedTuple

import numpy as np

from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntMatrix, IntVector

__all__ = [
    "BEFORE_S",
    "FARTHEST_M",
    "HELD_LATERAL_M",
    "LATERAL_M",
    "MOVES_MPS",
    "RING",
    "WITHIN_RAD",
    "Followers",
    "followers",
]

FARTHEST_M = 120.0
"""A leader is at most this far ahead, antenna to antenna [m]."""

LATERAL_M, HELD_LATERAL_M = 2.5, 4.0
"""It lies within this of the arc that the own yaw rate tells [m]; the second holds for the leader so far."""

WITHIN_RAD = pi / 6.0
"""Its course is within this of the arc's there [rad]."""

MOVES_MPS = 1.0
"""A slower car keeps the course it had, and its arc is straight [m/s]."""

BEFORE_S = 0.5
"""How long ago the acceleration before was believed [s]."""

RING = 64
"""Accelerations remembered: more than there are samples in twice `BEFORE_S`, up to 50 Hz."""


class Followers(NamedTuple):
    """What V hosts remember of who was ahead.

    ``course`` (V,) own course, held at standstill, not a number before the first motion [rad]; ``leader``
    (V,) id of the leader, -1 for none; ``ring_s`` (V, RING) times [s], ``ring`` (V, RING) accelerations
    [m/s²] and ``who`` (V, RING) leaders that they are of, -1 for none.
    """

    course: FloatVector
    leader: IntVector
    ring_s: FloatMatrix
    ring: FloatMatrix
    who: IntMatrix


def followers(vehicles: int) -> Followers:
    """Return hosts that remember nobody.

    Parameters
    ----------
    vehicles
        V.
    """
    return Followers(
        np.full(vehicles, np.nan),
        np.full(vehicles, -1, dtype=np.int64),
        np.full((vehicles, RING), -np.inf),
        np.zeros((vehicles, RING)),
        np.full((vehicles, RING), -1, dtype=np.int64),
    )
