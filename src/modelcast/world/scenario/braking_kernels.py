"""Compiled step of streams in which vehicles brake hard and those behind them notice late.

Streams move as a highway does, with the same rows and the same following; added are the late notice, brakings
that were drawn, and contacts. A driver reacts to what a leader did a reaction time ago, carried on at the
acceleration seen then, and looks at the second ahead too: the anticipations in time and space of the human
driver model (Treiber, Kesting and Helbing, Physica A 360 (2006) 71, DOI 10.1016/j.physa.2005.05.001; there at
constant speed, and as a sum over those ahead). So a leader that is followed steadily is known well, and what
is missed is what it began since.
"""

from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatCube, FloatMatrix, FloatVector, IntMatrix, IntVector
from modelcast.world.scenario import highway_kernels as highway
from modelcast.world.scenario.following_kernels import FREE_M, JERK_HARD_MPS3, LENGTH, move, respond
from modelcast.world.scenario.highway_kernels import (
    LANE,
    OLD_LANE,
    PEDAL,
    PROGRESS,
    A,
    S,
    V,
    drift,
    is_in,
    move_aside,
    perceived,
    sort_along,
)

__all__ = [
    "BRAKINGS",
    "COLUMNS",
    "CONTACTS",
    "COUNTS",
    "CUT_INS",
    "INTEGERS",
    "NEAR_COLLISIONS",
    "RELEASE_MPS3",
    "Stream",
    "least_drop_mps",
    "noticed",
    "step",
]

WAY, BRAKE_MPS2, BRAKE_TO_MPS, HOLD_S = range(highway.COLUMNS, highway.COLUMNS + 4)
COLUMNS = highway.COLUMNS + 4
"""Rows of the state's numbers: those of the highway; way driven [m]; of the braking that was drawn its
deceleration [m/s²], the speed it ends at [m/s], and how long that is kept [s]."""

DELAY_STEPS, LEADS, PHASE, TOUCHES, NEAR, CUTS_IN = range(3, 9)
INTEGERS = 9
"""Rows of the state's integers: those of the highway; reaction time in steps; whether the vehicle leads a
stream; phase of its drawn braking; whether it touches its leader, and whether it is close to colliding;
whether it is cutting in and has not braked yet."""

DRIVES, PRESSES, RELEASES, HOLDS = range(4)
"""Phases of a drawn braking."""

BRAKINGS, CONTACTS, NEAR_COLLISIONS, CUT_INS = range(4)
COUNTS = 4
"""Of what the state counts."""

RELEASE_MPS3 = 10.0  # how fast the pedal of a drawn braking is let go; ours
HOLD_GAIN_HZ = 2.0
HOLD_MPS2 = 2.0
NEAR_TTC_S = 1.5  # a common bound of critical times to collision
NEAR_CLOSING_MPS = 1.0  # slower is rolling up in a queue
APART_M = 0.5  # from here a contact is over
ALERT_MPS2 = 1.0  # who brakes harder is alert, and reacts within:
ALERT_S = 0.7  # Green (2000), for who expects the braking
TOUCHING_FROM = 0.45  # of a lane change's progress: from here a car of 1.8 m is partly in the new lane


class Stream(NamedTuple):
    """Vehicles of the streams.

    ``numbers`` (COLUMNS, V), ``integers`` (INTEGERS, V), ``order`` (V,) as of the highway; ``history``
    (3, H, V) are way, speed and acceleration of the last H steps, in a ring; ``counts`` (COUNTS,).
    """

    numbers: FloatMatrix
    integers: IntMatrix
    order: IntVector
    history: FloatCube
    counts: IntVector


@kernel
def least_drop_mps(deceleration_mps2: float) -> float:
    """Loss of speed from which on a drawn braking reaches its deceleration."""
    return 0.5 * deceleration_mps2 * deceleration_mps2 * (1.0 / JERK_HARD_MPS3 + 1.0 / RELEASE_MPS3)


@kernel
def noticed(stream: Stream, i: int, j: int, now: int, dt: float) -> tuple[float, float, float]:
    """What driver i takes vehicle j to be: metres ahead of where it is, its speed, its acceleration."""
    history, delay = stream.history, stream.integers[DELAY_STEPS, i]
    if stream.numbers[A, i] < -ALERT_MPS2:
        delay = min(delay, round(ALERT_S / dt))
    row = (now - delay) % history.shape[1]
    v, a, age = history[1, row, j], history[2, row, j], delay * dt
    if v + a * age > 0.0:
        way, speed = v * age + 0.5 * a * age * age, v + a * age
    else:
        way, speed, a = -v * v / (2.0 * a) if a < 0.0 else 0.0, 0.0, 0.0
    return history[0, row, j] + way - stream.numbers[WAY, j], speed, a


@kernel
def _pedal(numbers: FloatMatrix, integers: IntMatrix, i: int, dt: float) -> float:
    """Acceleration after a step of a drawn braking: pressed and let go with bounded jerk, then held."""
    v, a = numbers[V, i], numbers[A, i]
    excess = v - numbers[BRAKE_TO_MPS, i]
    if integers[PHASE, i] == PRESSES and excess <= 0.5 * a * a / RELEASE_MPS3 - a * dt:
        integers[PHASE, i] = RELEASES
    if integers[PHASE, i] == RELEASES and a >= -RELEASE_MPS3 * dt:
        integers[PHASE, i] = HOLDS
    if integers[PHASE, i] == PRESSES:
        least = -numbers[BRAKE_MPS2, i]
        if a < least:
            return min(a + RELEASE_MPS3 * dt, least)
        return max(a - JERK_HARD_MPS3 * dt, least)
    if integers[PHASE, i] == RELEASES:
        return min(a + RELEASE_MPS3 * dt, 0.0)
    numbers[HOLD_S, i] -= dt
    if numbers[HOLD_S, i] <= 0.0:
        integers[PHASE, i] = DRIVES
    wish = min(max(-HOLD_GAIN_HZ * excess, -HOLD_MPS2), HOLD_MPS2)
    return min(max(wish, a - RELEASE_MPS3 * dt), a + RELEASE_MPS3 * dt)


@kernel
def _touches_lane(lane: int, numbers: FloatMatrix, integers: IntMatrix, i: int) -> bool:
    """Whether a vehicle's body is partly in a lane."""
    if integers[LANE, i] == lane and integers[OLD_LANE, i] != lane:
        return bool(numbers[PROGRESS, i] >= TOUCHING_FROM)
    return is_in(lane, numbers, integers, i)


@kernel
def _find_leaders(
    stream: Stream, bounds: IntVector, length: float, lanes: int, leaders: IntMatrix, shifts: FloatMatrix
) -> None:
    """Write who is ahead of whom in every lane, (lanes, V), and what wrapping adds to its place.

    -1 where the vehicle is not in the lane; a vehicle alone in a lane is ahead of itself.
    """
    numbers, integers, order = stream.numbers, stream.integers, stream.order
    last = np.empty(lanes, np.int64)
    for c in range(bounds.size - 1):
        last[:] = -1
        for turn in range(2):
            for k in range(bounds[c + 1] - 1, bounds[c] - 1, -1):
                i = order[k]
                for lane in range(lanes):
                    inside = is_in(lane, numbers, integers, i)
                    if turn == 1:
                        leaders[lane, i] = last[lane] if inside else -1
                        wrapped = inside and numbers[S, last[lane]] <= numbers[S, i]
                        shifts[lane, i] = length if wrapped else 0.0
                    if inside:
                        last[lane] = i


@kernel
def _gap(stream: Stream, drivers: FloatMatrix, i: int, j: int, shift: float) -> float:
    """From the front of i to the rear of j."""
    return float(
        stream.numbers[S, j] + shift - stream.numbers[S, i] - 0.5 * (drivers[LENGTH, i] + drivers[LENGTH, j])
    )


@kernel
def _wish(
    stream: Stream,
    drivers: FloatMatrix,
    leaders: IntMatrix,
    shifts: FloatMatrix,
    i: int,
    settings: FloatVector,
    now: int,
    dt: float,
) -> tuple[float, float]:
    """Acceleration that driver i wants behind the two ahead that it noticed, and the gap to the nearest.

    Of the second ahead it sees the distance, less the body in between.
    """
    numbers, integers = stream.numbers, stream.integers
    wish, least = np.inf, FREE_M
    for lane in range(leaders.shape[0]):
        if leaders[lane, i] < 0:
            continue
        j, shift = leaders[lane, i], shifts[lane, i]
        came = numbers[PROGRESS, j] * settings[highway.CHANGE_S]
        comes = integers[LANE, j] == lane and numbers[PROGRESS, j] < 1.0
        if comes and came < integers[DELAY_STEPS, i] * dt:
            shift += shifts[lane, j]
            j = leaders[lane, j]
        gap = _gap(stream, drivers, i, j, shift)
        least = min(least, gap)
        for _ahead in range(2):
            further, speed, acceleration = noticed(stream, i, j, now, dt)
            wish = min(
                wish,
                perceived(
                    numbers, drivers, i, gap + further, speed, acceleration, settings[highway.PERCEPTION]
                ),
            )
            gap += _gap(stream, drivers, j, leaders[lane, j], shifts[lane, j])
            j = leaders[lane, j]
    return wish, least


@kernel
def _keep_apart(stream: Stream, drivers: FloatMatrix, leaders: IntMatrix, shifts: FloatMatrix) -> None:
    """Let who would drive into a leader touch it, and stay behind at no more than its speed; count."""
    numbers, integers, order = stream.numbers, stream.integers, stream.order
    for sweep in range(2):  # the second for who is behind one that came round the end and was held back
        for k in range(order.size - 1, -1, -1):
            i = order[k]
            touches, near, least = 0, 0, FREE_M
            for lane in range(leaders.shape[0]):
                j = leaders[lane, i]
                if j < 0 or j == i or not _touches_lane(lane, numbers, integers, i):
                    continue
                if not _touches_lane(lane, numbers, integers, j):
                    continue
                gap = _gap(stream, drivers, i, j, shifts[lane, i])
                closing = numbers[V, i] - numbers[V, j]
                if closing > NEAR_CLOSING_MPS and gap < NEAR_TTC_S * closing:
                    near = 1
                if gap < 0.0:
                    touches = 1
                    numbers[S, i] += gap
                    numbers[WAY, i] += gap
                    numbers[V, i] = min(numbers[V, i], numbers[V, j])
                    numbers[A, i] = min(max(numbers[A, i], numbers[A, j]), 0.0)
                least = min(least, gap)
            if touches > integers[TOUCHES, i]:
                stream.counts[CONTACTS] += 1
            if near > integers[NEAR, i]:
                stream.counts[NEAR_COLLISIONS] += 1
            if touches == 1 or least > APART_M:
                integers[TOUCHES, i] = touches
            if near == 1 or sweep == 0:
                integers[NEAR, i] = near


@kernel
def step(
    stream: Stream,
    drivers: FloatMatrix,
    bounds: IntVector,
    settings: FloatVector,
    normals: FloatMatrix,
    now: int,
    next_id: int,
    lanes: int,
    dt: float,
) -> int:
    """Advance all vehicles by a step, in place, and return the next identifier to give out.

    Parameters
    ----------
    stream
        The vehicles.
    drivers
        (TRAITS, V).
    bounds
        Where each carriageway begins in the order, (C + 1,).
    settings
        The road, as of the highway, (10,).
    normals
        Standard normal numbers, (NORMALS, V).
    now
        Row of the history that holds the present.
    """
    numbers, integers, order, history, _ = stream
    vehicles, length = order.size, settings[highway.LENGTH_M]
    drift(numbers, normals, dt)
    leaders, shifts = np.empty((lanes, vehicles), np.int64), np.empty((lanes, vehicles))
    _find_leaders(stream, bounds, length, lanes, leaders, shifts)
    following = np.empty(vehicles)
    for i in range(vehicles):
        wish, gap = _wish(stream, drivers, leaders, shifts, i, settings, now, dt)
        unsteady = settings[highway.PEDAL_NOISE] * numbers[PEDAL, i] * min(1.0, numbers[V, i] / 5.0)
        following[i] = respond(numbers[V, i], numbers[A, i], wish + unsteady, gap, dt)
        if integers[PHASE, i] != DRIVES:
            drawn = _pedal(numbers, integers, i, dt)
            if wish >= drawn:
                following[i] = drawn
    for i in range(vehicles):
        along, v, a = move(numbers[V, i], numbers[A, i], following[i], dt)
        numbers[V, i], numbers[A, i] = v, a
        move_aside(numbers, integers, i, settings, normals[3, i], dt)
        numbers[S, i] += along
        numbers[WAY, i] += along
    _keep_apart(stream, drivers, leaders, shifts)
    after = (now + 1) % history.shape[1]
    for i in range(vehicles):
        if numbers[S, i] >= length:
            numbers[S, i] -= length
            integers[highway.ID, i] = next_id
            next_id += 1
        history[0, after, i], history[1, after, i] = numbers[WAY, i], numbers[V, i]
        history[2, after, i] = numbers[A, i]
    sort_along(numbers, order, bounds)
    return next_id
