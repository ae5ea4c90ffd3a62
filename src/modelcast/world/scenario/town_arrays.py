"""What the compiled steps of a Manhattan grid work on: rows of its arrays, its roads, its settings."""

from typing import NamedTuple

from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntCube, IntMatrix, IntVector

__all__ = [
    "AT_BEGINNING",
    "AT_END",
    "COLUMNS",
    "COUNTS",
    "CROSSING_FAR_M",
    "CROSSING_NEAR_M",
    "INTEGERS",
    "NORMALS",
    "Roads",
    "Town",
]

S, V, A, WANDER, WANDER_1, WANDER_2, GAP_ERR, APPROACH_ERR, PEDAL = range(9)
COLUMNS = 9
"""Rows of the state's numbers."""

LINK, MOVE, NEXT_MOVE, COMMITTED, CAME_FROM, MISJUDGES, RUNS = range(7)
INTEGERS = 7
"""Rows of the state's integers: link; how the vehicle came onto it, and how it will leave it (0 straight on,
1 left, 2 right); whether it has made up its mind to pass the stop line; the link it came from, -1 before its
first junction; whether its driver misjudges the next junction; whether it enters, or is in, a junction at
which it should have waited."""

CROSSINGS, MISJUDGED = range(2)
COUNTS = 2
"""Of what the state counts: vehicles that went straight on over a major street, or passed a signal; and those
of them that should have waited."""

NORMALS = 4

AT_END, AT_BEGINNING = range(2)
"""Rows of `Roads.busy`."""

CROSSING_FAR_M, CROSSING_NEAR_M = 5.0, 2.0
"""A crossing lies between these distances from the stop line, towards the middle of the junction [m]."""

LINK_M, GREEN_S, AMBER_S, TURN_MPS2, WANDER_M, PEDAL_NOISE, PERCEPTION, LANE_M, PRIORITY, STRAIGHT_ON = range(
    10
)
"""The grid's settings, as one vector."""


class Town(NamedTuple):
    """Vehicles of a grid: rows of the state, (COLUMNS, V) and (INTEGERS, V), and who is on which link.

    ``order`` (V,) are the slots by link and place, of which link k has those from ``first[k]`` (K + 1,);
    ``left_last`` (K,) is the vehicle that left each link last, -1 for none; ``counts`` (COUNTS,).
    """

    numbers: FloatMatrix
    integers: IntMatrix
    order: IntVector
    first: IntVector
    left_last: IntVector
    counts: IntVector


class Roads(NamedTuple):
    """What is driven on, as in `Streets`, the signals' times those of the clock of the step.

    ``busy`` (2, K) says for how long people still are on the lane [s], 0 for nobody: row `AT_END` where the
    pavement's line crosses each link's way into the junction at its end, row `AT_BEGINNING` where it crosses
    its way out of the junction at its beginning.
    """

    follower: IntMatrix
    connectors: FloatVector
    ends: IntVector
    green_start: FloatVector
    cycle: FloatVector
    direction: IntVector
    approach: IntMatrix
    conflicts: IntCube
    busy: FloatMatrix
