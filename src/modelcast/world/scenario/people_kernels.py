"""Compiled steps of people in a grid: what vehicles are about to do, walking, riding.

Nobody sees the future: people judge vehicles by place, speed and the way that they show (the indicator), and
who steps out is seen by the vehicles from the next step on (`town_kernels`).
"""

from math import atan2, exp, inf, pi, sqrt

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntMatrix, IntVector
from modelcast.world.scenario.following_kernels import (
    DESIRED_SPEED,
    FREE_M,
    GAP,
    LENGTH,
    move,
    respond,
    wander,
    wanted,
)
from modelcast.world.scenario.junction_kernels import is_major
from modelcast.world.scenario.people_arrays import (
    ACCELERATION,
    BACK,
    CARELESS,
    CARELESS_RATIO,
    DIRECTION,
    EAST_OFFSET,
    FREE_SPEED,
    LEFT,
    NEXT,
    NODE,
    NORTH_OFFSET,
    PACE,
    PACE_NOISE,
    PATIENCE,
    SIGNALS,
    SPARE,
    SPEED,
    STAGE,
    STEPPED_CARELESSLY,
    STEPPED_OUT,
    TURN,
    TURN_RATE,
    TURNED_BACK,
    TURNS_BACK,
    WAITED,
    Walkers,
    Ways,
)
from modelcast.world.scenario.pose_kernels import lateral_clock
from modelcast.world.scenario.town_arrays import (
    AT_BEGINNING,
    AT_END,
    CAME_FROM,
    COMMITTED,
    CROSSING_FAR_M,
    CROSSING_NEAR_M,
    LINK,
    LINK_M,
    MOVE,
    NEXT_MOVE,
    PEDAL,
    PEDAL_NOISE,
    RUNS,
    STRAIGHT_ON,
    WANDER,
    WANDER_M,
    A,
    Roads,
    S,
    Town,
    V,
)
from modelcast.world.scenario.town_kernels import choose_move, sort_by_link

__all__ = ["foresee", "ride", "walk", "walking_poses"]

STANDS_MPS = 0.5
GAINS_MPS2 = 1.0
STOPS_MPS2 = 4.0  # what a vehicle is trusted to brake by
NOTICES_S = 0.6
BAND_M = (0.4, 3.1)  # of a lane, from the middle of the street: a car, its wander and a person's half width
POINTS_M = (-6.8, -3.5, 0.0)  # where people wait: at the kerb, before the near lane, between the lanes
START_S = 0.5
HARD_SPARE_S = 0.7
WALK_BRAKE_MPS2, WALK_GAIN_MPS2 = 3.0, 1.5  # from walking to standing within a step of half a second
TURN_RADPS = 3.0
PACE_S = 3.0
ABREAST_M = 0.8
RIDE_BRAKE_MPS2 = 1.3
RIDE_LINE_M = 0.5
RIDE_TURN_MPS2 = 0.8
RIDE_SPARE_S = 1.5
RIDE_PATIENCE_S = 10.0  # then a cyclist goes as soon as every vehicle can stop for it
PEDAL_S = 3.0
WANDER_HZ = 0.5


@kernel(inlined=True)
def _due(
    soon: FloatMatrix, hard: FloatMatrix, row: int, link: int, ahead: float, v: float, sure: bool
) -> None:
    """Take in a vehicle whose front is that far from a crossing."""
    arrives = (sqrt(v * v + 2.0 * GAINS_MPS2 * ahead) - v) / GAINS_MPS2
    soon[row, link] = min(soon[row, link], arrives)
    room = ahead - 1.5 - NOTICES_S * v
    if sure or v * v > 2.0 * STOPS_MPS2 * max(room, 0.0):
        hard[row, link] = min(hard[row, link], arrives)


@kernel
def foresee(town: Town, lengths: FloatVector, roads: Roads, ways: Ways, link_m: float) -> None:
    """Fill `Ways.soon`, `Ways.hard` and `Ways.inside` from where vehicles are."""
    numbers, integers, soon, hard = town.numbers, town.integers, ways.soon, ways.hard
    soon[:], hard[:], ways.inside[:] = inf, inf, 0
    for i in range(town.order.size):
        link, kind, v = integers[LINK, i], integers[NEXT_MOVE, i], numbers[V, i]
        front, rear = numbers[S, i] + 0.5 * lengths[i], numbers[S, i] - 0.5 * lengths[i]
        moves = v >= STANDS_MPS or integers[COMMITTED, i] == 1
        runs = integers[RUNS, i] == 1
        ahead = link_m + CROSSING_NEAR_M - front
        if ahead <= 0.0:
            soon[AT_END, link], hard[AT_END, link] = 0.0, 0.0
        elif moves:
            _due(soon, hard, AT_END, link, ahead, v, runs)
        if front > link_m:
            ways.inside[roads.ends[link]] += 1
        came = integers[CAME_FROM, i]
        if came >= 0 and rear < 0.0:
            ways.inside[roads.ends[came]] += 1
            if rear + roads.connectors[integers[MOVE, i]] < CROSSING_FAR_M + 0.5:
                soon[AT_END, came], hard[AT_END, came] = 0.0, 0.0
        if rear < -CROSSING_NEAR_M + 0.5:
            ahead = -CROSSING_FAR_M - front
            if ahead <= 0.0:
                soon[AT_BEGINNING, link], hard[AT_BEGINNING, link] = 0.0, 0.0
            else:  # who stands in a junction may set off at any time
                _due(soon, hard, AT_BEGINNING, link, ahead, v, runs)
        if moves:
            ahead = link_m + roads.connectors[kind] - CROSSING_FAR_M - front
            _due(soon, hard, AT_BEGINNING, int(roads.follower[link, kind]), max(ahead, 0.0), v, runs)


@kernel(inlined=True)
def _draw_next(onto: IntMatrix, node: int, direction: int, uniform: float) -> int:
    """Direction taken at a corner: straight on with odds 0.5, else to a side; back only at a dead end."""
    left, right = (direction + 1) % 4, (direction + 3) % 4
    ahead = 0.5 if onto[node, direction] >= 0 else 0.0
    aside = 0.25 if onto[node, left] >= 0 else 0.0
    other = 0.25 if onto[node, right] >= 0 else 0.0
    drawn = uniform * (ahead + aside + other)
    if drawn < ahead:
        return direction
    if drawn < ahead + aside:
        return left
    return right if other > 0.0 else (direction + 2) % 4


@kernel(inlined=True)
def _over(i: int, walkers: Walkers, ways: Ways) -> tuple[int, int, float]:
    """Corner that a pedestrian came from, its direction, and its place from the middle of the street."""
    direction = int(walkers.integers[DIRECTION, i])
    node = int(walkers.integers[NODE, i])
    origin = int(ways.onto[node, (direction + 2) % 4])
    offset = walkers.traits[EAST_OFFSET if direction % 2 == 0 else NORTH_OFFSET, i]
    along = 0.5 * ways.length[origin, direction] - walkers.numbers[LEFT, i]
    return origin, direction, along + (offset if direction < 2 else -offset)


@kernel(inlined=True)
def _may_pass(
    stage: int, place: float, speed: float, pause: float, ways: Ways, lanes: IntVector, careless: bool,
    green: bool, settings: FloatVector,
) -> bool:  # fmt: skip
    """Whether a pedestrian goes on at the kerb, before the near lane, or between the lanes."""
    near = (-BAND_M[0] - place) / speed + pause
    far = (BAND_M[1] - place) / speed + pause
    soon, hard = ways.soon, ways.hard
    if stage == 2:
        return bool(hard[lanes[2], lanes[3]] > far + HARD_SPARE_S)
    if stage == 1:
        return bool(hard[lanes[0], lanes[1]] > near + HARD_SPARE_S)
    if careless or green:
        return bool(
            hard[lanes[0], lanes[1]] > near + HARD_SPARE_S and hard[lanes[2], lanes[3]] > far + HARD_SPARE_S
        )
    if settings[SIGNALS] > 0.0:
        return False
    spare = settings[SPARE]
    return bool(soon[lanes[0], lanes[1]] > near + spare and soon[lanes[2], lanes[3]] > far + spare)


@kernel(inlined=True)
def _turn_back(i: int, walkers: Walkers, ways: Ways, uniform: float) -> None:
    """Turn round on the spot."""
    numbers, integers = walkers.numbers, walkers.integers
    direction, node = int(integers[DIRECTION, i]), int(integers[NODE, i])
    back = (direction + 2) % 4
    origin = int(ways.onto[node, back])
    numbers[LEFT, i] = ways.length[origin, direction] - numbers[LEFT, i]
    integers[NODE, i], integers[DIRECTION, i] = origin, back
    integers[NEXT, i] = _draw_next(ways.onto, origin, back, uniform)
    integers[STAGE, i], integers[BACK, i] = 3, 0
    numbers[TURN, i], numbers[WAITED, i] = pi, 0.0
    walkers.counts[TURNED_BACK] += 1


@kernel(inlined=True)
def _take_corner(i: int, walkers: Walkers, ways: Ways, uniforms: FloatMatrix, careless: float) -> None:
    """Begin the next footway; who has to turn stands."""
    numbers, integers = walkers.numbers, walkers.integers
    node, direction, onward = int(integers[NODE, i]), int(integers[DIRECTION, i]), int(integers[NEXT, i])
    quarter = (onward - direction) % 4
    if quarter != 0:
        numbers[TURN, i] = 0.5 * pi if quarter == 1 else (-0.5 * pi if quarter == 3 else pi)
    target = int(ways.onto[node, onward])
    numbers[LEFT, i] += ways.length[node, onward]
    integers[NODE, i], integers[DIRECTION, i] = target, onward
    integers[NEXT, i] = _draw_next(ways.onto, target, onward, uniforms[0, i])
    integers[STAGE, i] = 0 if ways.lanes[node, onward, 1] >= 0 else 3
    integers[CARELESS, i], integers[BACK, i] = 1 if uniforms[1, i] < careless else 0, 0
    numbers[WAITED, i] = 0.0


@kernel
def walk(
    walkers: Walkers, ways: Ways, settings: FloatVector, normals: FloatVector, uniforms: FloatMatrix,
    busy: FloatMatrix, dt: float,
) -> None:  # fmt: skip
    """Advance pedestrians by a step, in place, and say in ``busy`` for how long they are on each lane."""
    numbers, integers = walkers.numbers, walkers.integers
    kept = exp(-dt / PACE_S)
    for i in range(numbers.shape[1]):
        numbers[PACE, i] = kept * numbers[PACE, i] + sqrt(1.0 - kept * kept) * normals[i]
        numbers[TURN_RATE, i] = 0.0
        v = numbers[SPEED, i]
        if numbers[TURN, i] != 0.0:
            step = min(max(numbers[TURN, i], -TURN_RADPS * dt), TURN_RADPS * dt)
            numbers[TURN, i] = 0.0 if step == numbers[TURN, i] else numbers[TURN, i] - step
            numbers[TURN_RATE, i], numbers[SPEED, i], numbers[ACCELERATION, i] = step / dt, 0.0, 0.0
            continue
        free = walkers.traits[FREE_SPEED, i]
        stop = numbers[LEFT, i] if integers[NEXT, i] != integers[DIRECTION, i] else FREE_M
        origin, direction, place = _over(i, walkers, ways)
        lanes = ways.lanes[origin, direction]
        stage = int(integers[STAGE, i])
        if stage < 3:
            ahead = POINTS_M[stage] - place
            if ahead <= 0.5 * v * v / WALK_BRAKE_MPS2 + v * dt + 0.05:
                pause = START_S if v < 0.3 else 0.0
                careless, green = integers[CARELESS, i] == 1, ways.walk[origin // 4]
                if _may_pass(stage, place, 0.85 * free, pause, ways, lanes, careless, green, settings):
                    if stage == 0:
                        walkers.counts[STEPPED_OUT] += 1
                        walkers.counts[STEPPED_CARELESSLY] += 1 if careless and not green else 0
                    integers[STAGE, i], numbers[WAITED, i] = stage + 1, 0.0
                else:
                    stop = min(stop, max(ahead, 0.0))
                    numbers[WAITED, i] += dt
                    if stage == 0 and v == 0.0 and numbers[WAITED, i] > walkers.traits[PATIENCE, i]:
                        _turn_back(i, walkers, ways, uniforms[0, i])
                        continue
        if lanes[1] < 0 and uniforms[2, i] < settings[TURNS_BACK] * dt:
            integers[BACK, i] = 1
        if integers[BACK, i] == 1 and v == 0.0:
            _turn_back(i, walkers, ways, uniforms[0, i])
            continue
        if integers[BACK, i] == 1:
            free = 0.0
        wish = free * (1.0 + settings[PACE_NOISE] * numbers[PACE, i])
        wish = max(min(wish, sqrt(2.0 * WALK_BRAKE_MPS2 * stop)), 0.0)
        after = min(max(wish, v - WALK_BRAKE_MPS2 * dt), v + WALK_GAIN_MPS2 * dt)
        way = 0.5 * (v + after) * dt
        if way >= stop or stop < 0.02:
            way, after = min(stop, 0.02 + way), 0.0
        numbers[SPEED, i], numbers[ACCELERATION, i] = after, (after - v) / dt
        numbers[LEFT, i] -= way
        if numbers[LEFT, i] <= 0.0:
            _take_corner(i, walkers, ways, uniforms, settings[CARELESS_RATIO])
            continue
        if integers[STAGE, i] >= 1 and lanes[1] >= 0:
            place += way
            if place < -BAND_M[0]:
                left = (-BAND_M[0] - place) / (0.85 * free)
                busy[lanes[0], lanes[1]] = max(busy[lanes[0], lanes[1]], left)
            if place < BAND_M[1]:
                left = (BAND_M[1] - place) / (0.85 * free)
                busy[lanes[2], lanes[3]] = max(busy[lanes[2], lanes[3]], left)


@kernel
def walking_poses(walkers: Walkers, ways: Ways, out: FloatMatrix) -> None:
    """Write pedestrians' motion on the plane, (6, P)."""
    numbers, integers = walkers.numbers, walkers.integers
    for i in range(numbers.shape[1]):
        node, d = integers[NODE, i], integers[DIRECTION, i]
        ex, ey = (1 - d) * ((d + 1) % 2), (2 - d) * (d % 2)
        out[0, i] = ways.corner[node, 0] - ex * numbers[LEFT, i] + walkers.traits[EAST_OFFSET, i]
        out[1, i] = ways.corner[node, 1] - ey * numbers[LEFT, i] + walkers.traits[NORTH_OFFSET, i]
        out[2, i] = numbers[SPEED, i]
        heading = atan2(float(ex), float(ey)) + numbers[TURN, i]
        out[3, i] = (heading + pi) % (2.0 * pi) - pi
        out[4, i] = numbers[ACCELERATION, i]
        out[5, i] = -numbers[TURN_RATE, i]


@kernel(inlined=True)
def _ride_speed(kind: int, connectors: FloatVector, desired: float) -> float:
    """Speed across a junction, at a bearable lateral acceleration."""
    return desired if kind == 0 else min(desired, sqrt(RIDE_TURN_MPS2 * connectors[kind] / pi))


@kernel(inlined=True)
def _may_ride(junction: int, needs: float, roads: Roads, ways: Ways, signals: bool, first: bool) -> bool:
    """Whether a cyclist enters a junction: it is empty, and stays so for as long as it takes to cross.

    For who has green or is the ``first`` to go, vehicles that still can stop will.
    """
    if ways.inside[junction] > 0 or (signals and not ways.walk[junction]):
        return False
    for direction in range(4):
        link = roads.approach[junction, direction]
        if link < 0:
            continue
        arrives = ways.hard[AT_END, link] if signals or first else ways.soon[AT_END, link]
        if arrives < needs + RIDE_SPARE_S:
            return False
    return True


@kernel(inlined=True)
def _claim(i: int, town: Town, riders: FloatMatrix, roads: Roads, busy: FloatMatrix, link_m: float) -> None:
    """Keep vehicles out of the junction that a cyclist is in, or has made up its mind to enter.

    Who turns right stays beside the lanes.
    """
    s, half, v = town.numbers[S, i], 0.5 * riders[LENGTH, i], town.numbers[V, i]
    junction, left = -1, 0.0
    if town.integers[CAME_FROM, i] >= 0 and s - half < 0.0 and town.integers[MOVE, i] != 2:
        junction, left = int(roads.ends[town.integers[CAME_FROM, i]]), half - s
    elif town.integers[COMMITTED, i] == 1 and town.integers[NEXT_MOVE, i] != 2:
        kind = int(town.integers[NEXT_MOVE, i])
        junction = int(roads.ends[town.integers[LINK, i]])
        left = link_m - s + roads.connectors[kind] + half
    if junction >= 0:
        for direction in range(4):
            link = roads.approach[junction, direction]
            if link >= 0:
                busy[AT_END, link] = max(busy[AT_END, link], left / max(v, 1.5))


@kernel
def ride(
    town: Town, riders: FloatMatrix, aside: FloatVector, waited: FloatVector, roads: Roads, ways: Ways,
    settings: FloatVector,
    normals: FloatMatrix, uniforms: FloatVector, signals: bool, busy: FloatMatrix, dt: float,
) -> None:  # fmt: skip
    """Advance cyclists by a step, in place, and say in ``busy`` for how long they are in each junction.

    They ride beside the lanes; who comes up behind another follows where they are not ``ABREAST_M`` apart.
    """
    numbers, integers, order, first = town.numbers, town.integers, town.order, town.first
    kept = exp(-dt / PEDAL_S)
    link_m = settings[LINK_M]
    target, gaps = np.empty(order.size), np.full(order.size, FREE_M)
    for link in range(first.size - 1):
        for k in range(first[link], first[link + 1]):
            i = order[k]
            s, v, desired = numbers[S, i], numbers[V, i], riders[DESIRED_SPEED, i]
            half, kind = 0.5 * riders[LENGTH, i], int(integers[NEXT_MOVE, i])
            v0 = _ride_speed(int(integers[MOVE, i]), roads.connectors, desired) if s < 0.0 else desired
            wish = wanted(riders, i, v, FREE_M, 0.0, 0.0, v0)
            for n in range(k + 1, first[link + 1]):
                j = order[n]
                if abs(aside[j] - aside[i]) < ABREAST_M:
                    room = max(float(numbers[S, j] - s - riders[LENGTH, i]), 0.1)
                    gaps[i] = room
                    wish = min(wish, wanted(riders, i, v, room, numbers[V, j], numbers[A, j], v0))
                    break
            across = _ride_speed(kind, roads.connectors, desired)
            to_line = link_m - RIDE_LINE_M - s - half
            ahead = max(to_line, 0.1)
            if integers[COMMITTED, i] == 0:
                if ahead < v * v / (2.0 * RIDE_BRAKE_MPS2) + v + 1.0:
                    way = ahead + RIDE_LINE_M + roads.connectors[kind] + 2.0 * half
                    needs = way / max(0.5 * (v + across), 0.6 * across) + (0.0 if v > 1.0 else 1.0)
                    first_rank = kind == 0 and is_major(int(roads.direction[link]))
                    insists = first_rank or bool(waited[i] > RIDE_PATIENCE_S)
                    if (kind == 2 and not signals) or _may_ride(
                        int(roads.ends[link]), needs, roads, ways, signals, insists
                    ):
                        integers[COMMITTED, i], waited[i] = 1, 0.0
                    elif v < STANDS_MPS:
                        waited[i] += dt
                if integers[COMMITTED, i] == 0:
                    gap = float(max(to_line, -0.5) + riders[GAP, i])
                    wish = min(
                        wish, max(wanted(riders, i, v, gap, 0.0, 0.0, v0), -v * v / (2.0 * ahead) - 0.5)
                    )
                    gaps[i] = min(gaps[i], gap)
            elif v > across and (v * v - across * across) / (2.0 * max(ahead, 0.5)) > 0.9 * RIDE_BRAKE_MPS2:
                wish = min(wish, -(v * v - across * across) / (2.0 * max(ahead, 0.5)))
            target[i] = wish
    for i in range(order.size):
        numbers[PEDAL, i] = kept * numbers[PEDAL, i] + sqrt(1.0 - kept * kept) * normals[0, i]
        v, a = numbers[V, i], numbers[A, i]
        unsteady = settings[PEDAL_NOISE] * numbers[PEDAL, i] * min(1.0, v / 5.0)
        along, v, a = move(v, a, respond(v, a, target[i] + unsteady, gaps[i], dt), dt)
        room = link_m - 0.5 * riders[LENGTH, i] - numbers[S, i]
        if integers[COMMITTED, i] == 0 and along > room:  # its front is at the line
            along, v, a = max(room, 0.0), 0.0, 0.0
        numbers[V, i], numbers[A, i] = v, a
        wander(numbers, WANDER, i, lateral_clock(v) * dt, settings[WANDER_M], WANDER_HZ, normals[1, i])
        numbers[S, i] += along
        link, kind = int(integers[LINK, i]), int(integers[NEXT_MOVE, i])
        if numbers[S, i] >= link_m:
            onto = int(roads.follower[link, kind])
            numbers[S, i] -= link_m + roads.connectors[kind]
            integers[LINK, i], integers[MOVE, i] = onto, kind
            integers[NEXT_MOVE, i] = choose_move(roads.follower, onto, settings[STRAIGHT_ON], uniforms[i])
            integers[COMMITTED, i], integers[CAME_FROM, i] = 0, link
        _claim(i, town, riders, roads, busy, link_m)
    sort_by_link(numbers, integers, order, first)
