"""Compiled step of the Manhattan grid: signals, following across junctions, turns; cost linear in vehicles.

A vehicle's place s on its link runs from 0 to the link's length. Past the stop line it belongs to the next
link at once, and comes up to its beginning on the connector, at negative s.
"""

from math import exp, pi, sin, sqrt

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    BoolVector,
    FloatCube,
    FloatMatrix,
    FloatVector,
    IntCube,
    IntMatrix,
    IntVector,
)
from modelcast.world.scenario.following_kernels import (
    APPROACH_ERROR_HZ,
    DESIRED_SPEED,
    FREE_M,
    GAP,
    GAP_ERROR,
    LENGTH,
    move,
    respond,
    wander,
    wanted,
)
from modelcast.world.scenario.junction_kernels import (
    ROOM,
    SPARE_M,
    alone,
    enters_by_mistake,
    has_gap,
    has_way,
    is_major,
    mark_users,
    to_line,
)
from modelcast.world.scenario.pose_kernels import lateral_clock, place
from modelcast.world.scenario.town_arrays import (
    AMBER_S,
    APPROACH_ERR,
    AT_BEGINNING,
    AT_END,
    CAME_FROM,
    COMMITTED,
    CROSSING_FAR_M,
    CROSSING_NEAR_M,
    CROSSINGS,
    GAP_ERR,
    GREEN_S,
    LINK,
    LINK_M,
    MISJUDGED,
    MISJUDGES,
    MOVE,
    NEXT_MOVE,
    PEDAL,
    PEDAL_NOISE,
    PERCEPTION,
    PRIORITY,
    RUNS,
    STRAIGHT_ON,
    TURN_MPS2,
    WANDER,
    WANDER_1,
    WANDER_2,
    WANDER_M,
    A,
    Roads,
    S,
    Town,
    V,
)

__all__ = ["choose_move", "poses", "sort_by_link", "step"]

WANDER_RATE_HZ = 0.5
ERROR_S = 20.0
PEDAL_S = 3.0
CAN_STOP_MPS2 = 3.0  # who would have to brake harder passes the amber signal
DECIDED_M = 5.0
DECIDED_MPS2 = 2.0
DECIDED_S = 1.0  # where there is no signal: later it would not come to a stop before the line
EASE_MPS2 = 1.2  # braking for a turn
LINE_M = 1.0  # a front stops this far before the line
LOOK_M = 120.0
CLEAR = 0.6  # of its way across: from here a turning vehicle is out of the way of who goes straight on
RUN_S = 4.0  # who misjudges enters up to so long after the signal turned red
RUN_MPS = 5.0
MISTAKES_M = 40.0  # before the line, from where gaps are misjudged


@kernel
def _turn_speed(
    move_kind: int, connectors: FloatVector, drivers: FloatMatrix, i: int, lateral: float
) -> float:
    """Speed across a junction: the sharpest point of the curve, pi / L, at a lateral acceleration."""
    if move_kind == 0:
        return float(drivers[DESIRED_SPEED, i])
    return min(drivers[DESIRED_SPEED, i], sqrt(lateral * connectors[move_kind] / pi))


@kernel
def choose_move(follower: IntMatrix, link: int, straight_on: float, uniform: float) -> int:
    """Draw how to leave a link: straight on with these odds, the rest shared by left and right."""
    weight = np.zeros(3)
    for kind in range(3):
        if follower[link, kind] >= 0:
            weight[kind] = straight_on if kind == 0 else 0.5 * (1.0 - straight_on)
    left = uniform * weight.sum()
    for kind in range(3):
        if weight[kind] > 0.0 and left < weight[kind]:
            return kind
        left -= weight[kind]
    return int(np.argmax(weight))


@kernel
def sort_by_link(numbers: FloatMatrix, integers: IntMatrix, order: IntVector, first: IntVector) -> None:
    """Put the slots in order of link and place; `first[k] : first[k + 1]` are those of link k."""
    links = first.size - 1
    first[:] = 0
    for i in range(order.size):
        first[integers[LINK, i] + 1] += 1
    for k in range(links):
        first[k + 1] += first[k]
    fill = first[:-1].copy()
    old = order.copy()
    for i in old:
        k = integers[LINK, i]
        j = fill[k] - 1
        while j >= first[k] and numbers[S, order[j]] > numbers[S, i]:
            order[j + 1] = order[j]
            j -= 1
        order[j + 1] = i
        fill[k] += 1


@kernel
def _perceived(
    numbers: FloatMatrix, drivers: FloatMatrix, i: int, j: int, gap: float, v0: float, perception: float
) -> float:
    """Acceleration that driver i, with the errors of the moment, wants behind j."""
    if gap > LOOK_M:
        return wanted(drivers, i, numbers[V, i], FREE_M, 0.0, 0.0, v0)
    seen = gap * exp(perception * GAP_ERROR * numbers[GAP_ERR, i])
    error = perception * APPROACH_ERROR_HZ * max(gap, 0.0) * numbers[APPROACH_ERR, i]
    return wanted(drivers, i, numbers[V, i], seen, max(0.0, numbers[V, j] - error), numbers[A, j], v0)


@kernel(inlined=True)
def _wander_errors(
    town: Town, drivers: FloatMatrix, normals: FloatMatrix, dt: float, taken: FloatVector
) -> None:
    """Let what drivers perceive and press wander; add up the room taken on every link, ``taken`` (K,)."""
    numbers, integers = town.numbers, town.integers
    kept, pedal_kept = exp(-dt / ERROR_S), exp(-dt / PEDAL_S)
    fresh, pedal_fresh = sqrt(1.0 - kept * kept), sqrt(1.0 - pedal_kept * pedal_kept)
    for i in range(town.order.size):
        numbers[GAP_ERR, i] = kept * numbers[GAP_ERR, i] + fresh * normals[0, i]
        numbers[APPROACH_ERR, i] = kept * numbers[APPROACH_ERR, i] + fresh * normals[1, i]
        numbers[PEDAL, i] = pedal_kept * numbers[PEDAL, i] + pedal_fresh * normals[2, i]
        taken[integers[LINK, i]] += ROOM * (drivers[LENGTH, i] + drivers[GAP, i])


@kernel
def _passes_signal(
    town: Town, drivers: FloatMatrix, roads: Roads, i: int, room: bool, t_s: float, settings: FloatVector
) -> bool:
    """Whether the first vehicle of a link drives over the stop line; it may make up its mind to.

    ``room`` says whether the junction and the link beyond it have room.
    """
    v, ahead, integers = town.numbers[V, i], to_line(town, drivers, i, settings), town.integers
    link = integers[LINK, i]
    phase = (t_s - roads.green_start[link]) % roads.cycle[link]
    green = phase < settings[GREEN_S]
    amber = not green and phase < settings[GREEN_S] + settings[AMBER_S]
    must_brake = v * v / (2.0 * ahead)
    if amber and must_brake > CAN_STOP_MPS2:
        integers[COMMITTED, i] = 1
    passes = green and (room or must_brake > CAN_STOP_MPS2)
    if town.numbers[S, i] + 0.5 * drivers[LENGTH, i] > settings[LINK_M] or integers[COMMITTED, i] == 1:
        passes = True
    elif not green and integers[MISJUDGES, i] == 1 and v >= RUN_MPS and room:
        red_for = phase + ahead / v - settings[GREEN_S] - settings[AMBER_S]
        if 0.0 < red_for < RUN_S:
            passes = True
            integers[COMMITTED, i] = 1
            integers[RUNS, i] = 1
            town.counts[MISJUDGED] += 1
    if passes and (ahead < DECIDED_M or must_brake > DECIDED_MPS2):
        integers[COMMITTED, i] = 1  # a start is not broken off because somebody else is late
    return passes


@kernel
def _passes_priority(
    town: Town,
    drivers: FloatMatrix,
    roads: Roads,
    i: int,
    taken: FloatVector,
    used: IntCube,
    noticed: IntCube,
    settings: FloatVector,
    dt: float,
) -> bool:
    """Whether the first vehicle of a link drives over a line without a signal; it may make up its mind to.

    Once it has, the ways that cross its own are closed to others until it has left the junction.
    """
    v, ahead, integers = town.numbers[V, i], to_line(town, drivers, i, settings), town.integers
    link, kind = integers[LINK, i], integers[NEXT_MOVE, i]
    direction = int(roads.direction[link])
    if integers[COMMITTED, i] == 1:  # a front a little over the line may still wait
        return True
    if taken[roads.follower[link, kind]] + drivers[LENGTH, i] + drivers[GAP, i] + SPARE_M > settings[LINK_M]:
        return False
    first_rank = is_major(direction) and kind == 0
    passes = has_way(noticed if first_rank else used, roads, link, kind, True) and has_gap(
        town, drivers, roads, i, taken, settings, True
    )
    near = ahead < DECIDED_M + DECIDED_S * v or v * v / (2.0 * ahead) > DECIDED_MPS2
    mistaken = False
    if not passes and integers[MISJUDGES, i] == 1 and kind == 0 and ahead < MISTAKES_M:
        mistaken = (
            not is_major(direction)
            and has_way(used, roads, link, kind, False)
            and has_gap(town, drivers, roads, i, taken, settings, False)
            and enters_by_mistake(town, drivers, roads, i, settings, dt)
        )
    if mistaken or (passes and near):
        integers[COMMITTED, i] = 1
        used[roads.ends[link], direction, kind] += 1
        if mistaken:
            integers[RUNS, i] = 1
            town.counts[MISJUDGED] += 1
        else:
            noticed[roads.ends[link], direction, kind] += 1
    return passes or mistaken


@kernel(inlined=True)
def _wish_across(
    town: Town, drivers: FloatMatrix, roads: Roads, i: int, v0: float, settings: FloatVector
) -> tuple[float, float]:
    """Acceleration wanted over a junction, and the gap: behind the next link's last, and who turns ahead."""
    numbers, integers, first = town.numbers, town.integers, town.first
    link, kind = integers[LINK, i], integers[NEXT_MOVE, i]
    following, half, to_end = roads.follower[link, kind], 0.5 * drivers[LENGTH, i], settings[LINK_M]
    v, s, seen = numbers[V, i], numbers[S, i], FREE_M
    wish = wanted(drivers, i, v, FREE_M, 0.0, 0.0, v0)
    if first[following] < first[following + 1]:
        j = int(town.order[first[following]])
        seen = to_end - s + roads.connectors[kind] + numbers[S, j] - half - 0.5 * drivers[LENGTH, j]
        wish = min(wish, _perceived(numbers, drivers, i, j, seen, v0, settings[PERCEPTION]))
    j = int(town.left_last[link])
    if j >= 0 and numbers[S, j] < 0.0 and integers[CAME_FROM, j] == link:
        gone = roads.connectors[integers[MOVE, j]] + numbers[S, j]
        if gone < CLEAR * roads.connectors[integers[MOVE, j]]:
            gap = to_end - s + gone - half - 0.5 * drivers[LENGTH, j]
            wish = min(wish, _perceived(numbers, drivers, i, j, gap, v0, settings[PERCEPTION]))
            seen = min(seen, gap)
    return wish, seen


@kernel(inlined=True)
def _wish_before(drivers: FloatMatrix, i: int, v: float, ahead: float, v0: float) -> tuple[float, float]:
    """Acceleration wanted to stop before a place ahead, and the gap."""
    gap = ahead + drivers[GAP, i] - LINE_M
    must_brake = v * v / (2.0 * ahead)
    return max(wanted(drivers, i, v, gap, 0.0, 0.0, v0), -must_brake - 0.5), gap


@kernel(inlined=True)
def _wish_at_line(
    town: Town, drivers: FloatMatrix, i: int, v0: float, settings: FloatVector
) -> tuple[float, float]:
    """Acceleration wanted to stop at the line, and the gap."""
    return _wish_before(drivers, i, town.numbers[V, i], to_line(town, drivers, i, settings), v0)


@kernel(inlined=True)
def _wish_for_people(
    town: Town, drivers: FloatMatrix, roads: Roads, i: int, v0: float, settings: FloatVector
) -> tuple[float, float]:
    """Acceleration wanted to let people cross, and the gap: those still there when it comes, 1 s to spare."""
    v, front = town.numbers[V, i], town.numbers[S, i] + 0.5 * drivers[LENGTH, i]
    link, kind = town.integers[LINK, i], town.integers[NEXT_MOVE, i]
    wish, gap = FREE_M, FREE_M
    ahead = settings[LINK_M] + CROSSING_NEAR_M - front
    if ahead > 0.0 and roads.busy[AT_END, link] > 0.0 and ahead < v * (roads.busy[AT_END, link] + 1.0) + 5.0:
        wish, gap = _wish_before(drivers, i, v, max(ahead, 0.1), v0)
    onto = roads.follower[link, kind]
    for way in range(2):
        if way == 0:
            ahead, busy = -CROSSING_FAR_M - front, roads.busy[AT_BEGINNING, link]
        else:
            ahead = settings[LINK_M] + roads.connectors[kind] - CROSSING_FAR_M - front
            busy = roads.busy[AT_BEGINNING, onto]
        if ahead > 0.0 and busy > 0.0 and ahead < v * (busy + 1.0) + 5.0:
            other, room = _wish_before(drivers, i, v, max(ahead, 0.1), v0)
            wish, gap = min(wish, other), min(gap, room)
    return wish, gap


@kernel(inlined=True)
def _move_on(
    town: Town,
    roads: Roads,
    i: int,
    target: float,
    gap: float,
    normal: float,
    uniform: float,
    misjudges: bool,
    settings: FloatVector,
    dt: float,
) -> None:
    """Move one vehicle by a step, onto its next link past the stop line."""
    numbers, integers = town.numbers, town.integers
    v, a = numbers[V, i], numbers[A, i]
    unsteady = settings[PEDAL_NOISE] * numbers[PEDAL, i] * min(1.0, v / 5.0)
    a_next = respond(v, a, target + unsteady, gap, dt)
    along, v, a = move(v, a, a_next, dt)
    numbers[V, i], numbers[A, i] = v, a
    clock = lateral_clock(v) * dt
    wander(numbers, WANDER, i, clock, settings[WANDER_M], WANDER_RATE_HZ, normal)
    numbers[S, i] += along
    if numbers[S, i] >= settings[LINK_M]:
        link, kind = int(integers[LINK, i]), int(integers[NEXT_MOVE, i])
        town.left_last[link] = i
        numbers[S, i] -= settings[LINK_M] + roads.connectors[kind]
        integers[LINK, i] = roads.follower[link, kind]
        integers[MOVE, i] = kind
        onto = int(roads.follower[link, kind])
        integers[NEXT_MOVE, i] = choose_move(roads.follower, onto, settings[STRAIGHT_ON], uniform)
        integers[COMMITTED, i] = 0
        integers[CAME_FROM, i] = link
        integers[MISJUDGES, i] = 1 if misjudges else 0
        if settings[PRIORITY] == 0.0 or (kind == 0 and not is_major(roads.direction[link])):
            town.counts[CROSSINGS] += 1


@kernel
def step(
    town: Town,
    drivers: FloatMatrix,
    roads: Roads,
    settings: FloatVector,
    normals: FloatMatrix,
    uniforms: FloatVector,
    misjudges: BoolVector,
    t_s: float,
    dt: float,
) -> None:
    """Advance all vehicles by a step, in place.

    Parameters
    ----------
    town
        The vehicles.
    drivers
        (TRAITS, V).
    roads
        What they drive on.
    settings
        The grid, (10,).
    normals, uniforms
        Random numbers, (NORMALS, V) and (V,).
    misjudges
        Who misjudges the junction after the one that it enters in this step, if it does, (V,).
    t_s
        Now.
    """
    numbers, integers, order, first, _, _ = town
    vehicles, links = order.size, roads.follower.shape[0]
    length, taken, junctions = settings[LINK_M], np.zeros(links), roads.approach.shape[0]
    _wander_errors(town, drivers, normals, dt, taken)
    used, noticed = np.zeros((junctions, 4, 3), np.int64), np.zeros((junctions, 4, 3), np.int64)
    mark_users(town, drivers, roads, used, noticed)
    target, gaps = np.empty(vehicles), np.full(vehicles, FREE_M)
    for link in range(links):
        for k in range(first[link], first[link + 1]):
            i = order[k]
            v, s, half = numbers[V, i], numbers[S, i], 0.5 * drivers[LENGTH, i]
            kind = integers[NEXT_MOVE, i]
            v0 = drivers[DESIRED_SPEED, i]
            if s < 0.0:
                v0 = _turn_speed(integers[MOVE, i], roads.connectors, drivers, i, settings[TURN_MPS2])
            ease = _turn_speed(kind, roads.connectors, drivers, i, settings[TURN_MPS2])
            if k + 1 < first[link + 1]:
                j = order[k + 1]
                gap = numbers[S, j] - s - half - 0.5 * drivers[LENGTH, j]
                wish, gaps[i] = _perceived(numbers, drivers, i, j, gap, v0, settings[PERCEPTION]), gap
            else:
                if settings[PRIORITY] > 0.0:
                    passes = _passes_priority(town, drivers, roads, i, taken, used, noticed, settings, dt)
                else:
                    beyond = taken[roads.follower[link, kind]] + drivers[LENGTH, i] + drivers[GAP, i]
                    room = beyond + SPARE_M <= length and alone(
                        noticed, roads.ends[link], roads.direction[link]
                    )
                    passes = _passes_signal(town, drivers, roads, i, room, t_s, settings)
                if passes:
                    wish, gaps[i] = _wish_across(town, drivers, roads, i, v0, settings)
                else:
                    wish, gaps[i] = _wish_at_line(town, drivers, i, v0, settings)
            if v > ease:
                needed = (v * v - ease * ease) / (2.0 * max(length - s, 0.5))
                if needed > 0.9 * EASE_MPS2:
                    wish = min(wish, -needed)
            for_people, room_m = _wish_for_people(town, drivers, roads, i, v0, settings)
            target[i], gaps[i] = min(wish, for_people), min(gaps[i], room_m)
    for i in range(vehicles):
        _move_on(town, roads, i, target[i], gaps[i], normals[3, i], uniforms[i], misjudges[i], settings, dt)
    sort_by_link(numbers, integers, order, first)


@kernel
def poses(
    numbers: FloatMatrix,
    integers: IntMatrix,
    start: FloatMatrix,
    direction: IntVector,
    connectors: FloatVector,
    curve: FloatCube,
    out: FloatMatrix,
) -> None:
    """Write the vehicles' motion on the plane, (6, V)."""
    points = curve.shape[1]
    for i in range(numbers.shape[1]):
        link, kind, s = integers[LINK, i], integers[MOVE, i], numbers[S, i]
        d = direction[link]
        ex, ey = (1 - d) * ((d + 1) % 2), (2 - d) * (d % 2)
        curvature, slope, tangent = 0.0, 0.0, 0.5 * pi * d
        east, north = start[link, 0] + ex * s, start[link, 1] + ey * s
        if s < 0.0 and kind > 0:
            length = connectors[kind]
            share = (s + length) / length
            side = 1.0 if kind == 1 else -1.0
            curvature = side * pi / length * sin(pi * share) ** 2
            slope = side * (pi / length) ** 2 * sin(2.0 * pi * share)
            table = curve[kind - 1]
            cell = min(int(share * (points - 1)), points - 2)
            u = share * (points - 1) - cell
            h = length / (points - 1)
            # cubic Hermite between the table's points, whose tangents are known
            b0, b1 = (1.0 + 2.0 * u) * (1.0 - u) ** 2, u * u * (3.0 - 2.0 * u)
            m0, m1 = u * (1.0 - u) ** 2 * h, -u * u * (1.0 - u) * h
            p, q = table[cell], table[cell + 1]
            x = b0 * p[0] + b1 * q[0] + m0 * np.cos(p[2]) + m1 * np.cos(q[2])
            y = b0 * p[1] + b1 * q[1] + m0 * np.sin(p[2]) + m1 * np.sin(q[2])
            # the curve ends at the link's start: go back from there, turned into the old direction
            x -= table[points - 1, 0]
            y -= table[points - 1, 1]
            turned = tangent - side * 0.5 * pi
            east = start[link, 0] + x * np.cos(turned) - y * np.sin(turned)
            north = start[link, 1] + x * np.sin(turned) + y * np.cos(turned)
            tangent = turned + side * 0.5 * pi * (share - sin(2.0 * pi * share) / (2.0 * pi))
        place(
            out, i, east, north, float(tangent), float(curvature), float(slope), numbers[V, i], numbers[A, i],
            numbers[WANDER, i], numbers[WANDER_1, i], numbers[WANDER_2, i],
        )  # fmt: skip
