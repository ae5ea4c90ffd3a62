"""Compiled rules of junctions: who is in them, who yields to whom, which gaps are accepted.

At junctions without signals the streets from west to east are major. Who goes straight on or turns right on
them yields to nobody, who turns left from them to those who come towards it; from the minor streets drivers
yield to both, and among each other it is first come, first served. A driver enters when no way that crosses
its own is in use and the next one with priority is a critical gap away.
"""

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntCube
from modelcast.world.scenario.following_kernels import (
    DESIRED_SPEED,
    FREE_M,
    GAP,
    LENGTH,
    follow_freely,
    move,
    respond,
)
from modelcast.world.scenario.town_arrays import (
    CAME_FROM,
    COMMITTED,
    LANE_M,
    LINK,
    LINK_M,
    MOVE,
    NEXT_MOVE,
    RUNS,
    A,
    Roads,
    S,
    Town,
    V,
)

__all__ = ["alone", "enters_by_mistake", "has_gap", "has_way", "is_major", "mark_users", "to_line"]

MINOR_STRAIGHT_GAP_S, MINOR_LEFT_GAP_S, MINOR_RIGHT_GAP_S = 6.5, 7.1, 6.2
"""Critical gaps from a minor street [s]: base values of the Highway Capacity Manual
(2010), two-way stop control, major street of two lanes."""

MAJOR_LEFT_GAP_S = 4.1  # the same, left turn from the major street
SLOW_MPS = 8.0  # who is slower counts as coming this fast: it may accelerate
STANDS_MPS = 1.0
ROOM = 1.15  # of length and gap: what a standing vehicle takes up
SPARE_M = 16.0  # kept free for those who are too close to stop when a link fills up
WIDTH_M = 1.8
LEAST_MARGIN_S = 0.25  # of a gap that is too short: by how much it still suffices
MOST_MARGIN_S = 0.85  # from here on nobody comes close
STEADY = 0.85  # of the desired speed: from here a vehicle keeps its speed
CLEAR_AHEAD_M = 25.0
LONGEST_S = 12.0


@kernel(inlined=True)
def to_line(town: Town, drivers: FloatMatrix, i: int, settings: FloatVector) -> float:
    """How far a front is from the stop line, at least 0.1 m."""
    return max(settings[LINK_M] - town.numbers[S, i] - 0.5 * drivers[LENGTH, i], 0.1)


@kernel(inlined=True)
def is_major(direction: int) -> bool:
    """Whether a direction is one of a major street."""
    return direction % 2 == 0


@kernel
def mark_users(town: Town, drivers: FloatMatrix, roads: Roads, used: IntCube, noticed: IntCube) -> None:
    """Count who is in each junction or has made up its mind to enter, by direction and move, (J, 4, 3).

    ``noticed`` leaves out those who should have waited.
    """
    numbers, integers = town.numbers, town.integers
    used[:] = 0
    noticed[:] = 0
    for i in range(town.order.size):
        came, here = integers[CAME_FROM, i], integers[LINK, i]
        inside = came >= 0 and numbers[S, i] < 0.5 * drivers[LENGTH, i]
        seen = 1 - integers[RUNS, i]
        if inside:
            used[roads.ends[came], roads.direction[came], integers[MOVE, i]] += 1
            noticed[roads.ends[came], roads.direction[came], integers[MOVE, i]] += seen
        if integers[COMMITTED, i] == 1:
            used[roads.ends[here], roads.direction[here], integers[NEXT_MOVE, i]] += 1
            noticed[roads.ends[here], roads.direction[here], integers[NEXT_MOVE, i]] += seen
        elif not inside:
            integers[RUNS, i] = 0


@kernel
def alone(users: IntCube, junction: int, direction: int) -> bool:
    """Whether nobody of another approach is in a junction or bound to be."""
    for other in range(4):
        if other != direction:
            for kind in range(3):
                if users[junction, other, kind] > 0:
                    return False
    return True


@kernel
def has_way(users: IntCube, roads: Roads, link: int, kind: int, straight_counts: bool) -> bool:
    """Whether no way in use crosses or meets the own; straight on along the major street may not count."""
    direction, junction = roads.direction[link], roads.ends[link]
    for turn in range(1, 4):
        other = (direction + turn) % 4
        for move_kind in range(3):
            if roads.conflicts[turn, kind, move_kind] == 0 or users[junction, other, move_kind] == 0:
                continue
            if straight_counts or move_kind != 0 or not is_major(other):
                return False
    return True


@kernel(inlined=True)
def _rank(direction: int, kind: int) -> int:
    """Place in the order in which ways yield: 0 yields to nobody."""
    if not is_major(direction):
        return 2
    return 1 if kind == 1 else 0


@kernel(inlined=True)
def _critical_gap_s(direction: int, kind: int) -> float:
    if is_major(direction):
        return MAJOR_LEFT_GAP_S
    if kind == 1:
        return MINOR_LEFT_GAP_S
    return MINOR_STRAIGHT_GAP_S if kind == 0 else MINOR_RIGHT_GAP_S


@kernel
def has_gap(
    town: Town,
    drivers: FloatMatrix,
    roads: Roads,
    i: int,
    taken: FloatVector,
    settings: FloatVector,
    straight_counts: bool,
) -> bool:
    """Whether all with priority are a critical gap later at the junction, but those who cannot leave it."""
    link, kind = town.integers[LINK, i], town.integers[NEXT_MOVE, i]
    direction, junction = int(roads.direction[link]), roads.ends[link]
    own = to_line(town, drivers, i, settings) / max(town.numbers[V, i], SLOW_MPS)
    critical = _critical_gap_s(direction, kind)
    for turn in range(1, 4):
        other = roads.approach[junction, (direction + turn) % 4]
        if other < 0:
            continue
        for k in range(town.first[other + 1] - 1, town.first[other] - 1, -1):
            j = town.order[k]
            way = town.integers[NEXT_MOVE, j]
            v = town.numbers[V, j]
            if k == town.first[other + 1] - 1 and v < STANDS_MPS:
                beyond = taken[roads.follower[other, way]] + drivers[LENGTH, j] + drivers[GAP, j] + SPARE_M
                if beyond > settings[LINK_M]:
                    break
            if to_line(town, drivers, j, settings) / max(v, SLOW_MPS) - own >= critical:
                break
            rank = _rank((direction + turn) % 4, way)
            minds = rank < _rank(direction, kind) and roads.conflicts[turn, kind, way] == 1
            if minds and (straight_counts or way != 0):
                return False
            if rank > 0:
                break  # it yields itself, and who is behind it has to wait for it
    return True


@kernel
def _crossing_times(
    town: Town, drivers: FloatMatrix, i: int, enters_m: float, leaves_m: float, dt: float
) -> tuple[float, float]:
    """When a vehicle that starts now has its front, and its rear, at two distances ahead of its front."""
    v, a, way, t, enters = town.numbers[V, i], town.numbers[A, i], 0.0, 0.0, -1.0
    while t < LONGEST_S:
        wish = follow_freely(v, drivers[DESIRED_SPEED, i], drivers[2, i], drivers[3, i])
        along, v, a = move(v, a, respond(v, a, wish, FREE_M, dt), dt)
        way += along
        t += dt
        if enters < 0.0 and way >= enters_m:
            enters = t
        if way >= leaves_m:
            return enters, t
    return LONGEST_S, LONGEST_S


@kernel
def enters_by_mistake(
    town: Town, drivers: FloatMatrix, roads: Roads, i: int, settings: FloatVector, dt: float
) -> bool:
    """Whether a driver who misjudges goes straight on over the major street although the gap is too short.

    It still gets across `LEAST_MARGIN_S` before the next that drives there straight on, or after the last,
    but with less than `MOST_MARGIN_S` to one of them.
    """
    numbers, integers = town.numbers, town.integers
    link, half_box = integers[LINK, i], 0.5 * roads.connectors[0]
    direction, junction = roads.direction[link], roads.ends[link]
    following = roads.follower[link, 0]
    ahead = town.order[town.first[following]] if town.first[following] < town.first[following + 1] else -1
    if ahead >= 0 and numbers[S, ahead] < CLEAR_AHEAD_M:
        return False
    margin = MOST_MARGIN_S
    for turn in (1, 3):
        other = roads.approach[junction, (direction + turn) % 4]
        if other < 0:
            continue
        # who comes from the left (3) drives in the nearer lane, and has farther to go to the own lane
        side = 0.5 * settings[LANE_M] * (1.0 if turn == 1 else -1.0)
        middle = to_line(town, drivers, i, settings) + half_box + side
        enters, leaves = _crossing_times(
            town, drivers, i, middle - 0.5 * WIDTH_M, middle + 0.5 * WIDTH_M + drivers[LENGTH, i], dt
        )
        last = int(town.left_last[other])
        inside = last >= 0 and numbers[S, last] < 0.5 * drivers[LENGTH, last]
        unclear = integers[MOVE, last] != 0 or numbers[V, last] < SLOW_MPS
        if inside and unclear and integers[CAME_FROM, last] == other:
            return False
        for k in range(town.first[other + 1] - 1, town.first[other] - 1, -1):
            j = town.order[k]
            if integers[NEXT_MOVE, j] != 0:
                continue
            way = to_line(town, drivers, j, settings) + half_box - side - 0.5 * WIDTH_M
            v = numbers[V, j]
            if way / drivers[DESIRED_SPEED, j] > leaves + MOST_MARGIN_S:
                break
            if v < STEADY * drivers[DESIRED_SPEED, j]:
                return False  # when it will be there cannot be told
            before = way / v - leaves
            after = enters - (way + WIDTH_M + drivers[LENGTH, j]) / v
            margin = min(margin, max(before, after))
    return LEAST_MARGIN_S <= margin < MOST_MARGIN_S
