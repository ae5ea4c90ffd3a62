"""Compiled step of the highway: lane changes, following, motion; cost linear in the vehicles.

Vehicles of a carriageway are kept in order of their place along it. One pass from front to rear carries the
last vehicle seen in every lane, so that each vehicle finds its leaders at once.
"""

from math import exp, sqrt

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntMatrix, IntVector
from modelcast.world.scenario.following_kernels import (
    APPROACH_ERROR_HZ,
    DESIRED_SPEED,
    FREE_M,
    GAP,
    GAP_ERROR,
    LENGTH,
    POLITENESS,
    follow_freely,
    move,
    respond,
    wander,
    wanted,
)
from modelcast.world.scenario.pose_kernels import lateral_clock, place

__all__ = [
    "COLUMNS",
    "LEFT_OLD_LANE",
    "NORMALS",
    "drift",
    "is_in",
    "move_aside",
    "perceived",
    "poses",
    "sort_along",
    "step",
]

S, V, A, PROGRESS, SINCE_CHANGE_S, WANDER, WANDER_1, WANDER_2, GAP_ERR, APPROACH_ERR, PEDAL = range(11)
COLUMNS = 11
"""Rows of the state's numbers: place along the road [m], speed, acceleration, progress of the lane change
(1 = none) and time since the last, lane-keeping error with two derivatives, the driver's errors."""

LANE, OLD_LANE, ID = range(3)

NORMALS = 4
"""Normal numbers a vehicle and step."""

LENGTH_M, WIDTH_M, MEDIAN_M, CHANGE_S, RADIUS_M, WANDER_M, PEDAL_NOISE, PERCEPTION, KEEP_RIGHT, RING = range(
    10
)
"""The road's settings, as one vector."""

DECIDE_STEPS = 10  # a driver thinks about changing lanes once a second
THRESHOLD_MPS2 = 0.3  # of MOBIL; Kesting, Treiber and Helbing, Transp. Res. Rec. 1999 (2007) 86, take 0.1
SAFE_MPS2 = 2.5
REST_S = 4.0  # between two changes of one driver
LEFT_OLD_LANE = 0.65  # of the progress: from here no part of a car is in its old lane
LOOK_M = 250.0
WANDER_RATE_HZ = 0.5
ERROR_S = 20.0  # Treiber, Kesting and Helbing (2006)
PEDAL_S = 3.0


@kernel
def is_in(lane: int, numbers: FloatMatrix, integers: IntMatrix, i: int) -> bool:
    """Whether any part of a vehicle may be in a lane."""
    if integers[LANE, i] == lane:
        return True
    return integers[OLD_LANE, i] == lane and numbers[PROGRESS, i] < LEFT_OLD_LANE


@kernel
def _neighbour(
    numbers: FloatMatrix,
    integers: IntMatrix,
    order: IntVector,
    first: int,
    end: int,
    k: int,
    lane: int,
    ahead: int,
    length: float,
) -> tuple[int, float]:
    """Nearest other vehicle in a lane, ahead (1) or behind (-1) of the k-th, and the distance of middles."""
    own = numbers[S, order[k]]
    count = end - first
    for hop in range(1, count):
        j = order[first + (k - first + ahead * hop) % count]
        distance = ahead * (numbers[S, j] - own)
        if distance < 0.0:
            distance += length
        if distance > LOOK_M:
            break
        if is_in(lane, numbers, integers, j):
            return j, distance
    return -1, FREE_M


@kernel
def _behind(numbers: FloatMatrix, drivers: FloatMatrix, i: int, j: int, distance: float) -> float:
    """Acceleration that driver i wants at a distance behind vehicle j (-1: nobody)."""
    if j < 0:
        return follow_freely(numbers[V, i], drivers[DESIRED_SPEED, i], drivers[2, i], drivers[3, i])
    gap = distance - 0.5 * (drivers[LENGTH, i] + drivers[LENGTH, j])
    return wanted(drivers, i, numbers[V, i], gap, numbers[V, j], numbers[A, j], drivers[DESIRED_SPEED, i])


@kernel
def _gain(
    numbers: FloatMatrix,
    integers: IntMatrix,
    order: IntVector,
    drivers: FloatMatrix,
    first: int,
    end: int,
    k: int,
    lane: int,
    length: float,
) -> float:
    """What a change to a lane is worth (MOBIL), minus infinity where it is not safe [m/s²]."""
    i = order[k]
    leader, front = _neighbour(numbers, integers, order, first, end, k, lane, 1, length)
    follower, rear = _neighbour(numbers, integers, order, first, end, k, lane, -1, length)
    if leader >= 0 and front - 0.5 * (drivers[LENGTH, i] + drivers[LENGTH, leader]) < drivers[GAP, i]:
        return -np.inf
    own = _behind(numbers, drivers, i, leader, front)
    if own < -SAFE_MPS2:
        return -np.inf
    others = 0.0
    if follower >= 0:
        if rear - 0.5 * (drivers[LENGTH, i] + drivers[LENGTH, follower]) < drivers[GAP, i]:
            return -np.inf
        after = _behind(numbers, drivers, follower, i, rear)
        if after < -SAFE_MPS2:
            return -np.inf
        others += after - _behind(numbers, drivers, follower, leader, rear + front)
    here = integers[LANE, i]
    old_leader, old_front = _neighbour(numbers, integers, order, first, end, k, here, 1, length)
    old_follower, old_rear = _neighbour(numbers, integers, order, first, end, k, here, -1, length)
    if old_follower >= 0:
        others += _behind(numbers, drivers, old_follower, old_leader, old_rear + old_front)
        others -= _behind(numbers, drivers, old_follower, i, old_rear)
    return own - _behind(numbers, drivers, i, old_leader, old_front) + drivers[POLITENESS, i] * others


@kernel
def _choose_lane(
    numbers: FloatMatrix,
    integers: IntMatrix,
    order: IntVector,
    drivers: FloatMatrix,
    settings: FloatVector,
    first: int,
    end: int,
    k: int,
    lanes: int,
) -> None:
    """Begin a lane change where it is worth more than the threshold; lane 0 is the rightmost."""
    i = order[k]
    here = integers[LANE, i]
    best, best_gain = here, THRESHOLD_MPS2
    for lane in (here - 1, here + 1):
        if lane < 0 or lane >= lanes:
            continue
        gain = _gain(numbers, integers, order, drivers, first, end, k, lane, settings[LENGTH_M])
        gain += settings[KEEP_RIGHT] if lane < here else -settings[KEEP_RIGHT]
        if gain > best_gain:
            best, best_gain = lane, gain
    if best != here:
        integers[OLD_LANE, i] = here
        integers[LANE, i] = best
        numbers[PROGRESS, i] = 0.0


@kernel
def perceived(
    numbers: FloatMatrix,
    drivers: FloatMatrix,
    i: int,
    gap: float,
    leader_v: float,
    leader_a: float,
    perception: float,
) -> float:
    """Acceleration that driver i, with the errors of the moment, wants behind a leader."""
    seen = gap * exp(perception * GAP_ERROR * numbers[GAP_ERR, i])
    error = perception * APPROACH_ERROR_HZ * min(max(gap, 0.0), 100.0) * numbers[APPROACH_ERR, i]
    if gap > LOOK_M:
        seen = FREE_M
    speed = max(0.0, leader_v - error)
    return wanted(drivers, i, numbers[V, i], seen, speed, leader_a, drivers[DESIRED_SPEED, i])


@kernel
def _behind_in_lane(
    numbers: FloatMatrix, drivers: FloatMatrix, i: int, j: int, shift: float, perception: float
) -> tuple[float, float]:
    """Acceleration that driver i wants behind j; and the gap."""
    gap = numbers[S, j] + shift - numbers[S, i] - 0.5 * (drivers[LENGTH, i] + drivers[LENGTH, j])
    return perceived(numbers, drivers, i, gap, numbers[V, j], numbers[A, j], perception), gap


@kernel
def drift(numbers: FloatMatrix, normals: FloatMatrix, dt: float) -> None:
    """Let what drivers perceive and press wander by a step; normal numbers in the first three rows."""
    kept, pedal_kept = exp(-dt / ERROR_S), exp(-dt / PEDAL_S)
    fresh, pedal_fresh = sqrt(1.0 - kept * kept), sqrt(1.0 - pedal_kept * pedal_kept)
    for i in range(numbers.shape[1]):
        numbers[GAP_ERR, i] = kept * numbers[GAP_ERR, i] + fresh * normals[0, i]
        numbers[APPROACH_ERR, i] = kept * numbers[APPROACH_ERR, i] + fresh * normals[1, i]
        numbers[PEDAL, i] = pedal_kept * numbers[PEDAL, i] + pedal_fresh * normals[2, i]


@kernel
def move_aside(
    numbers: FloatMatrix, integers: IntMatrix, i: int, settings: FloatVector, normal: float, dt: float
) -> None:
    """Go on with a change of lane, if there is one, and wander in the lane, by a step."""
    clock = lateral_clock(numbers[V, i]) * dt
    if numbers[PROGRESS, i] < 1.0:
        numbers[PROGRESS, i] = min(1.0, numbers[PROGRESS, i] + clock / settings[CHANGE_S])
        if numbers[PROGRESS, i] >= 1.0:
            integers[OLD_LANE, i] = integers[LANE, i]
            numbers[SINCE_CHANGE_S, i] = 0.0
    else:
        numbers[SINCE_CHANGE_S, i] += dt
    wander(numbers, WANDER, i, clock, settings[WANDER_M], WANDER_RATE_HZ, normal)


@kernel
def sort_along(numbers: FloatMatrix, order: IntVector, bounds: IntVector) -> None:
    """Put the vehicles of each carriageway in order of their place; quick where they nearly are."""
    for c in range(bounds.size - 1):
        for k in range(bounds[c] + 1, bounds[c + 1]):
            i = order[k]
            s = numbers[S, i]
            j = k - 1
            while j >= bounds[c] and numbers[S, order[j]] > s:
                order[j + 1] = order[j]
                j -= 1
            order[j + 1] = i


@kernel
def step(
    numbers: FloatMatrix,
    integers: IntMatrix,
    order: IntVector,
    bounds: IntVector,
    drivers: FloatMatrix,
    settings: FloatVector,
    normals: FloatMatrix,
    number: int,
    next_id: int,
    lanes: int,
    dt: float,
) -> int:
    """Advance all vehicles by a step, in place, and return the next identifier to give out.

    Parameters
    ----------
    numbers, integers
        (COLUMNS, V), (3, V).
    order
        Slots by place along the road, carriageway after carriageway, (V,).
    bounds
        Where each carriageway begins in `order`, (C + 1,).
    drivers
        (TRAITS, V).
    settings
        The road, (10,).
    normals
        Standard normal numbers, (NORMALS, V).
    number
        Number of the step.
    """
    length = settings[LENGTH_M]
    vehicles = order.size
    target = np.empty(vehicles)
    gaps = np.empty(vehicles)
    drift(numbers, normals, dt)
    last = np.empty(lanes, np.int64)
    shift = np.empty(lanes)
    for c in range(bounds.size - 1):
        first, end = bounds[c], bounds[c + 1]
        if lanes > 1:
            for k in range(first, end):
                i = order[k]
                ready = numbers[PROGRESS, i] >= 1.0 and numbers[SINCE_CHANGE_S, i] >= REST_S
                if ready and (i * 7 + number) % DECIDE_STEPS == 0:
                    _choose_lane(numbers, integers, order, drivers, settings, first, end, k, lanes)
        last[:] = -1
        shift[:] = length
        for k in range(end - 1, first - 1, -1):
            for lane in range(lanes):
                if is_in(lane, numbers, integers, order[k]):
                    last[lane] = order[k]
        for k in range(end - 1, first - 1, -1):
            i = order[k]
            target[i] = np.inf
            gaps[i] = FREE_M
            for lane in range(lanes):
                if not is_in(lane, numbers, integers, i):
                    continue
                if last[lane] < 0:
                    continue
                wish, gap = _behind_in_lane(
                    numbers, drivers, i, last[lane], shift[lane], settings[PERCEPTION]
                )
                target[i] = min(target[i], wish)
                gaps[i] = min(gaps[i], gap)
                last[lane] = i
                shift[lane] = 0.0
    for i in range(vehicles):
        v, a = numbers[V, i], numbers[A, i]
        unsteady = settings[PEDAL_NOISE] * numbers[PEDAL, i] * min(1.0, v / 5.0)
        a_next = respond(v, a, target[i] + unsteady, gaps[i], dt)
        along, v, a = move(v, a, a_next, dt)
        numbers[V, i], numbers[A, i] = v, a
        move_aside(numbers, integers, i, settings, normals[3, i], dt)
        numbers[S, i] += along
        if numbers[S, i] >= length:
            numbers[S, i] -= length
            if settings[RING] == 0.0:
                integers[ID, i] = next_id
                next_id += 1
    sort_along(numbers, order, bounds)
    return next_id


@kernel
def poses(
    numbers: FloatMatrix,
    integers: IntMatrix,
    forward: int,
    settings: FloatVector,
    lanes: int,
    out: FloatMatrix,
) -> None:
    """Write the vehicles' motion on the plane, (6, V); the first `forward` drive east (or anticlockwise)."""
    width, change = settings[WIDTH_M], settings[CHANGE_S]
    for i in range(numbers.shape[1]):
        lane, old = integers[LANE, i], integers[OLD_LANE, i]
        p = numbers[PROGRESS, i]
        offset = -(0.5 * settings[MEDIAN_M] + (lanes - 0.5 - lane) * width)
        rate, rate2 = 0.0, 0.0
        if p < 1.0:
            # the quintic of least jerk: position, speed and acceleration are continuous at both ends
            d = (lane - old) * width
            offset += d * (p * p * p * (10.0 - 15.0 * p + 6.0 * p * p) - 1.0)
            rate = d * 30.0 * p * p * (1.0 - p) * (1.0 - p) / change
            rate2 = d * 60.0 * p * (1.0 - p) * (1.0 - 2.0 * p) / (change * change)
        ahead = i < forward
        s = numbers[S, i]
        if settings[RING] == 0.0:
            east = s if ahead else settings[LENGTH_M] - s
            north, curvature = 0.0, 0.0
            tangent = 0.0 if ahead else np.pi
        else:
            r = settings[RADIUS_M]
            angle = s / r if ahead else -s / r
            east, north = r * np.cos(angle), r * np.sin(angle)
            curvature = 1.0 / r if ahead else -1.0 / r
            tangent = angle + (0.5 * np.pi if ahead else -0.5 * np.pi)
        place(
            out, i, east, north, tangent, curvature, 0.0, numbers[V, i], numbers[A, i],
            offset + numbers[WANDER, i], rate + numbers[WANDER_1, i], rate2 + numbers[WANDER_2, i],
        )  # fmt: skip
