"""What the compiled steps of people in a grid work on: rows of their arrays."""

from typing import NamedTuple

from modelcast.core.kernel_types import BoolVector, FloatMatrix, IntCube, IntMatrix, IntVector

__all__ = ["COUNTS", "NORMALS", "WALKING_COLUMNS", "WALKING_INTEGERS", "Walkers", "Ways"]

LEFT, SPEED, ACCELERATION, PACE, WAITED, TURN, TURN_RATE = range(7)
WALKING_COLUMNS = 7
"""Rows of pedestrians' numbers: way left to the next corner [m], speed, acceleration, unsteadiness, time
waited [s], how far they still have to turn [rad, anticlockwise], and how fast they do."""

NODE, DIRECTION, NEXT, STAGE, CARELESS, BACK = range(6)
WALKING_INTEGERS = 6
"""Rows of pedestrians' integers: the corner they walk to, in which direction, the direction they take there;
how far they have come over lanes (0 before the kerb, 1 on the carriageway, 2 on the near lane, 3 on the far
lane or beyond), whether they are careless at this crossing, and whether they are about to turn back."""

FREE_SPEED, EAST_OFFSET, NORTH_OFFSET, PATIENCE = range(4)
"""Rows of their traits."""

SPARE, TURNS_BACK, CARELESS_RATIO, PACE_NOISE, SIGNALS = range(5)
"""Settings, as one vector."""

NORMALS = 1
STEPPED_OUT, STEPPED_CARELESSLY, TURNED_BACK = range(3)
COUNTS = 3
"""Of what is counted: who stepped onto a carriageway, who of them carelessly, who turned back."""


class Walkers(NamedTuple):
    """Pedestrians: numbers (WALKING_COLUMNS, P), integers (WALKING_INTEGERS, P), traits (4, P), counts."""

    numbers: FloatMatrix
    integers: IntMatrix
    traits: FloatMatrix
    counts: IntVector


class Ways(NamedTuple):
    """Where people are: footways as in `Footways`, and what vehicles do.

    ``soon`` and ``hard`` (2, K) say when the next moving vehicle is on a crossing, and when the next that
    cannot stop before it any more [s]; rows as in `town_arrays.Roads.busy`. ``inside`` (J,) counts vehicles
    in each junction; ``walk`` (J,) says where people have green.
    """

    corner: FloatMatrix
    onto: IntMatrix
    length: FloatMatrix
    lanes: IntCube
    soon: FloatMatrix
    hard: FloatMatrix
    inside: IntVector
    walk: BoolVector
