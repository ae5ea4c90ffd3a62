"""Where people walk and ride in a grid: pavements along the blocks, crossings over the arms of junctions.

A street is 30 m from building to building: two lanes, a cycle lane on either side, kerbs 6 m from its middle,
and pavements that people walk along 11.5 m from it. Every junction has four corners; a footway leads from a
corner to the next, along a block or over an arm of the junction. Corners are numbered anticlockwise from the
north-eastern one, four a junction; directions are those of `streets`.
"""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.world.scenario.streets import Streets
from modelcast.world.scenario.town_arrays import AT_BEGINNING, AT_END

__all__ = ["CYCLE_LANE_M", "FOOTWAY_M", "KERB_M", "STREET_HALF_M", "Footways", "make_footways"]

STREET_HALF_M = 15.0
"""From the middle of a street to the buildings [m]."""

FOOTWAY_M = 11.5
"""From the middle of a street to where people walk along it [m]."""

KERB_M = 6.0
"""From the middle of a street to its kerbs [m]."""

CYCLE_LANE_M = (4.2, 5.2)
"""From the middle of a street to where cyclists ride [m]."""

_CORNERS = ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))
_STEPS = ((1, 0), (0, 1), (-1, 0), (0, -1))


@dataclass(frozen=True, slots=True)
class Footways:
    """Tables of footways between N = 4 J corners, in a grid with K links.

    Parameters
    ----------
    corner_m
        Places of the corners, (N, 2) [m].
    onto
        Corner that each direction leads to from each corner, -1 for none, (N, 4).
    length_m
        Length of that footway, (N, 4) [m].
    lanes
        The lanes that it crosses, the near one first: row of `town_arrays.Roads.busy` and link of each, link
        -1 where it crosses none, (N, 4, 4).
    """

    corner_m: FloatArray
    onto: IntArray
    _: KW_ONLY
    length_m: FloatArray
    lanes: IntArray


def make_footways(streets: Streets, *, columns: int, rows: int, block_m: float) -> Footways:
    """Return the footways of a grid.

    Parameters
    ----------
    streets
        Its streets.
    columns, rows, block_m
        As `make_streets` had them.
    """
    departure = np.full((columns * rows, 4), -1, dtype=np.int64)
    for link in range(streets.direction.size):
        direction = int(streets.direction[link])
        dx, dy = _STEPS[direction]
        departure[int(streets.ends[link]) - dx - columns * dy, direction] = link
    corners = 4 * columns * rows
    place = np.zeros((corners, 2))
    onto = np.full((corners, 4), -1, dtype=np.int64)
    length = np.zeros((corners, 4))
    lanes = np.full((corners, 4, 4), -1, dtype=np.int64)
    for node in range(corners):
        junction, corner = divmod(node, 4)
        y, x = divmod(junction, columns)
        side = _CORNERS[corner]
        place[node] = x * block_m + side[0] * FOOTWAY_M, y * block_m + side[1] * FOOTWAY_M
        for direction, step in enumerate(_STEPS):
            axis = direction % 2
            beyond = (side[0] * (-1.0 if axis == 0 else 1.0), side[1] * (-1.0 if axis == 1 else 1.0))
            target = _CORNERS.index(beyond)
            if side[axis] * step[axis] < 0.0:
                onto[node, direction], length[node, direction] = 4 * junction + target, 2.0 * FOOTWAY_M
                arm = (1 if side[1] > 0.0 else 3) if axis == 0 else (0 if side[0] > 0.0 else 2)
                ways = (
                    (AT_END, streets.approach[junction, (arm + 2) % 4]),
                    (AT_BEGINNING, departure[junction, arm]),
                )
                if departure[junction, arm] >= 0:
                    near = 0 if direction == (arm + 3) % 4 else 1
                    lanes[node, direction] = *ways[near], *ways[1 - near]
            elif 0 <= x + step[0] < columns and 0 <= y + step[1] < rows:
                onto[node, direction] = 4 * (junction + step[0] + columns * step[1]) + target
                length[node, direction] = block_m - 2.0 * FOOTWAY_M
    return Footways(place, onto, length_m=length, lanes=lanes)
