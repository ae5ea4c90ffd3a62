"""Messages as compiled loops take them: `modelcast.station.receiver.heard.Heard` in three arrays."""

from typing import NamedTuple

from modelcast.core.kernel_types import FloatMatrix, IntMatrix

__all__ = [
    "ACCELERATION",
    "COUNT",
    "EAST",
    "HEADING",
    "IDENTIFICATION",
    "IN_USE",
    "KIND",
    "LENGTH",
    "NORTH",
    "PROFILE",
    "RECEIVED",
    "SPEED",
    "STATED",
    "UPDATE",
    "USER",
    "VEHICLE",
    "WIDTH",
    "YAW_RATE",
    "Messages",
]

KIND, VEHICLE, COUNT, PROFILE, IN_USE, USER = range(6)
"""Columns of the whole numbers."""

STATED, RECEIVED, EAST, NORTH, SPEED, HEADING, ACCELERATION, YAW_RATE, LENGTH, WIDTH = range(10)
"""Columns of the other numbers: instant stated and arrival first."""

UPDATE, PLAIN, IDENTIFICATION = range(3)
"""Kinds, as `HeardKind`."""


class Messages(NamedTuple):
    """K messages: ``codes`` (K, 6), ``numbers`` (K, 10), ``parameters`` (K, P)."""

    codes: IntMatrix
    numbers: FloatMatrix
    parameters: FloatMatrix
