"""The streets of a Manhattan grid as tables: directed links, what follows on what, signals, curves of turns.

Streets lie a block apart, with one lane each way, on the right. A link leads from one junction's exit to the
next junction's stop line. Links are numbered; directions are 0 east, 1 north, 2 west, 3 south.
"""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray

__all__ = ["AMBER_S", "CLEARING_S", "LANE_M", "Streets", "make_streets", "turn_curve"]

LANE_M = 3.5
"""Width of a lane [m]."""

AMBER_S = 3.0
"""Amber [s]: what German and US practice take at 50 km/h (RiLSA; MUTCD 3 to 6 s)."""

CLEARING_S = 2.0
"""All red after it [s]."""

CURVE_POINTS = 129
_APART_M = 2.6
"""Between the middles of two cars of 1.8 m that turn and wander in their lanes [m]."""

_STEPS = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))


@dataclass(frozen=True, slots=True)
class Streets:
    """Tables of a grid with K links.

    Parameters
    ----------
    start_m
        Where each link's lane begins, (K, 2) [m].
    direction
        Direction of each link, (K,).
    length_m
        Length of every link [m].
    follower
        The link taken after each by going straight on, left, right; -1 where there is none, (K, 3).
    ends
        Number of the junction each link leads to, (K,).
    green_start_s, cycle_s
        When a link's signal turns green within its cycle, (K,); the cycle's length, (K,) [s].
    green_s
        Length of green [s].
    connector_m
        Length of the way across a junction straight on, left, right, (3,) [m].
    curve
        The left turn driven from the origin eastwards at `CURVE_POINTS` equal steps of its length, (., 3):
        east, north [m], tangent [rad]; the second such table is the right turn, (2, ., 3).
    approach
        The link that leads to each junction in each direction, -1 for none, (J, 4).
    conflicts
        Whether a way across a junction (straight on, left, right) comes too close to another, of the approach
        whose direction is some quarter turns further anticlockwise: 1 or 0, (4, 3, 3), [turns, own, other].
    """

    start_m: FloatArray
    direction: IntArray
    _: KW_ONLY
    length_m: float
    follower: IntArray
    ends: IntArray
    green_start_s: FloatArray
    cycle_s: FloatArray
    green_s: float
    connector_m: FloatArray
    curve: FloatArray
    approach: IntArray
    conflicts: IntArray


def turn_curve(tangent_m: float) -> tuple[float, FloatArray]:
    """Length of a smooth right-angled left turn and its points, (CURVE_POINTS, 3).

    The curvature is (pi / L) sin²(pi s / L): it and its slope are zero at both ends.

    Parameters
    ----------
    tangent_m
        Distance from the beginning, and from the end, to where the two lanes' axes cross [m].

    Examples
    --------
    >>> length_m, points = turn_curve(10.0)
    >>> round(length_m, 2), points[-1].round(6)
    (17.11, array([10.      , 10.      ,  1.570796]))
    """
    fine = 16
    share = (np.arange((CURVE_POINTS - 1) * fine) + 0.5) / ((CURVE_POINTS - 1) * fine)
    angle = 0.5 * np.pi * (share - np.sin(2.0 * np.pi * share) / (2.0 * np.pi))
    steps = np.stack([np.cos(angle), np.sin(angle)], axis=1) / share.size
    unit = np.concatenate([np.zeros((1, 2)), steps.cumsum(axis=0)])[::fine]
    length_m = tangent_m / float(unit[-1, 0])
    at = np.linspace(0.0, 1.0, CURVE_POINTS)
    tangent = 0.5 * np.pi * (at - np.sin(2.0 * np.pi * at) / (2.0 * np.pi))
    return length_m, np.concatenate([unit * length_m, tangent[:, None]], axis=1)


def make_streets(
    columns: int, rows: int, *, block_m: float, junction_m: float, green_s: float, people_s: float = 0.0
) -> Streets:
    """Return the tables of a grid of junctions, the south-western one at the origin.

    Parameters
    ----------
    columns, rows
        Junctions from west to east and from south to north.
    block_m
        Distance between junctions [m].
    junction_m
        From a junction's middle to its stop lines [m].
    green_s
        Green for each approach [s]; approaches have green one after the other, so that no ways cross.
    people_s
        At the end of each cycle, when all vehicles have red and people cross [s].
    """
    links = [
        (x, y, d)
        for y in range(rows)
        for x in range(columns)
        for d, (dx, dy) in enumerate(_STEPS)
        if 0 <= x + dx < columns and 0 <= y + dy < rows
    ]
    number = {key: k for k, key in enumerate(links)}
    start: list[tuple[float, float]] = []
    follower: list[list[int]] = []
    ends: list[int] = []
    begin: list[float] = []
    cycle: list[float] = []
    phase_s = green_s + AMBER_S + CLEARING_S
    for x, y, d in links:
        dx, dy = _STEPS[d]
        start.append(
            (
                x * block_m + dx * junction_m + dy * LANE_M / 2,
                y * block_m + dy * junction_m - dx * LANE_M / 2,
            )
        )
        end = (x + round(dx), y + round(dy))
        follower.append([number.get((*end, (d + turn) % 4), -1) for turn in (0, 1, -1)])
        ends.append(end[1] * columns + end[0])
        came = [a for a in range(4) if (end[0] - _STEPS[a][0], end[1] - _STEPS[a][1], a) in number]
        begin.append(came.index(d) * phase_s)
        cycle.append(len(came) * phase_s + people_s)
    approach = np.full((columns * rows, 4), -1, dtype=np.int64)
    for k, (_, _, d) in enumerate(links):
        approach[ends[k], d] = k
    left_m, left = turn_curve(junction_m + LANE_M / 2)
    right_m, right = turn_curve(junction_m - LANE_M / 2)
    curve = np.stack([left, right * np.array([1.0, -1.0, -1.0])])
    return Streets(
        np.array(start),
        np.array([d for _, _, d in links], dtype=np.int64),
        length_m=block_m - 2.0 * junction_m,
        follower=np.array(follower, dtype=np.int64),
        ends=np.array(ends, dtype=np.int64),
        green_start_s=np.array(begin),
        cycle_s=np.array(cycle),
        green_s=green_s,
        connector_m=np.array([2.0 * junction_m, left_m, right_m]),
        curve=curve,
        approach=approach,
        conflicts=_conflicts(curve, junction_m),
    )


def _conflicts(curve: FloatArray, junction_m: float) -> IntArray:
    """Return which ways across a junction come closer than two cars are wide, (4, 3, 3)."""
    ahead = np.linspace(0.0, 2.0 * junction_m, CURVE_POINTS)
    straight = np.stack([ahead, np.zeros_like(ahead)], axis=1)
    ways = np.stack([straight, curve[0, :, :2], curve[1, :, :2]]) - [junction_m, LANE_M / 2]
    found = np.zeros((4, 3, 3), dtype=np.int64)
    for turns in range(1, 4):
        cos, sin = _STEPS[turns]
        turned = ways @ np.array([[cos, sin], [-sin, cos]])
        apart = np.hypot(*np.moveaxis(ways[:, None, :, None] - turned[None, :, None], -1, 0))
        found[turns] = apart.min(axis=(2, 3)) < _APART_M
    return found
