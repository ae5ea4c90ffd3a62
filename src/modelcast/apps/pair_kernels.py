"""Compiled rules that several applications share: a place along a path, what braking leaves of a gap, chance.

Along a path a vehicle keeps its acceleration until it stands; nobody drives backwards. Nothing here
allocates.
"""

from math import atan2, cos, erfc, hypot, inf, isnan, sin, sqrt
from typing import NamedTuple

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatCube, FloatMatrix, FloatVector, IntVector

__all__ = [
    "CAUTION",
    "NONE",
    "WARNING",
    "Columns",
    "Found",
    "Lane",
    "ahead",
    "chance",
    "closed",
    "closed_by_braking",
    "contact_time",
    "first_root",
    "known",
    "path_offset",
    "path_way",
    "spread",
    "travel",
]

NONE, CAUTION, WARNING = range(3)
"""The values of `modelcast.apps.warnings.Level`."""

STRAIGHT_PER_M = 1e-9
"""A path of less curvature counts as straight [1/m]."""


class Columns(NamedTuple):
    """`modelcast.apps.motions.Motions` as kernels take them; no covariance is one of no rows."""

    position: FloatMatrix
    speed: FloatVector
    heading: FloatVector
    acceleration: FloatVector
    yaw_rate: FloatVector
    length: FloatVector
    width: FloatVector
    covariance: FloatCube
    kind: IntVector


class Lane(NamedTuple):
    """Where a remote counts as ahead in or beside the host's path."""

    aside: float
    longest: float
    cosine: float
    least_speed: float


class Found(NamedTuple):
    """`modelcast.apps.warnings.Warnings` as kernels fill them."""

    level: IntVector
    time: FloatVector
    margin: FloatVector
    certainty: FloatVector


@kernel(inlined=True)
def known(one: Columns, i: int) -> bool:
    """Whether all of a row's motion is known."""
    total = one.position[i, 0] + one.position[i, 1] + one.speed[i] + one.heading[i]
    return not isnan(total + one.acceleration[i] + one.yaw_rate[i])


@kernel(inlined=True)
def path_offset(ahead: float, right: float, curvature: float) -> float:
    """Offset of a point, in a vehicle's frame, to the right of its path; a curvature is positive that way."""
    root = hypot(curvature * ahead, 1.0 - curvature * right)
    return (2.0 * right - curvature * (ahead * ahead + right * right)) / (1.0 + root)


@kernel(inlined=True)
def path_way(ahead: float, right: float, curvature: float) -> tuple[float, float, float]:
    """Way along that path to where a point is beside it, and its gradient by the point's two coordinates."""
    if abs(curvature) < STRAIGHT_PER_M:
        return ahead, 1.0, 0.0
    across, onward = curvature * ahead, 1.0 - curvature * right
    square = across * across + onward * onward
    return atan2(across, onward) / curvature, onward / square, across / square


@kernel(inlined=True)
def travel(speed: float, acceleration: float, time: float) -> float:
    """Way that a vehicle makes in a time: v t + a t²/2, or v²/(-2a) where it stands before."""
    if acceleration < 0.0 and speed + acceleration * time < 0.0:
        return speed * speed / (-2.0 * acceleration)
    return time * (speed + 0.5 * acceleration * time)


@kernel(inlined=True)
def closed(speed: float, acceleration: float, leader_speed: float, leader_acceleration: float) -> float:
    """Most that a follower closes on its leader from now on; infinite where it never ends, at least 0."""
    stop = (
        speed / -acceleration if acceleration < 0.0 else (inf if speed > 0.0 or acceleration > 0.0 else 0.0)
    )
    if leader_acceleration < 0.0:
        leader_stop = leader_speed / -leader_acceleration
    else:
        leader_stop = inf if leader_speed > 0.0 or leader_acceleration > 0.0 else 0.0
    faster, gains = speed - leader_speed, acceleration - leader_acceleration
    if leader_stop < stop:
        if stop == inf:
            return inf
        return max(
            speed * speed / (-2.0 * acceleration) - travel(leader_speed, leader_acceleration, leader_stop),
            0.0,
        )
    if faster > 0.0 > gains:
        return faster * faster / (-2.0 * gains)
    return inf if stop == inf and (gains > 0.0 or faster > 0.0) else 0.0


@kernel(inlined=True)
def closed_by_braking(
    speed: float,
    acceleration: float,
    leader_speed: float,
    leader_acceleration: float,
    delay: float,
    braking: float,
) -> float:
    """What a follower has closed where it is nearest, if it brakes after a delay; negative: drawn away."""
    by_then = travel(speed, acceleration, delay) - travel(leader_speed, leader_acceleration, delay)
    left = max(leader_speed + leader_acceleration * delay, 0.0)
    pull = leader_acceleration if left > 0.0 else 0.0
    return by_then + closed(max(speed + acceleration * delay, 0.0), -braking, left, pull)


@kernel(inlined=True)
def first_root(half: float, speed: float, way: float) -> float:
    """First time at which half t² + speed t reaches a way that is positive; infinite where never."""
    square = speed * speed + 4.0 * half * way
    if square < 0.0:
        return inf
    below = speed + sqrt(square)
    return 2.0 * way / below if below > 0.0 else inf


@kernel(inlined=True)
def contact_time(
    gap: float, speed: float, acceleration: float, leader_speed: float, leader_acceleration: float
) -> float:
    """When a follower touches its leader if both keep on until they stand; 0 where they touch."""
    if gap <= 0.0:
        return 0.0
    stop = speed / -acceleration if acceleration < 0.0 else inf
    leader_stop = leader_speed / -leader_acceleration if leader_acceleration < 0.0 else inf
    if leader_acceleration <= 0.0 and leader_speed <= 0.0:
        leader_stop = 0.0
    together = min(stop, leader_stop)
    time = first_root(0.5 * (acceleration - leader_acceleration), speed - leader_speed, gap)
    if time <= together:
        return time
    if leader_stop >= stop:
        return inf
    left = gap + travel(leader_speed, leader_acceleration, together) - travel(speed, acceleration, together)
    after = first_root(0.5 * acceleration, speed + acceleration * together, left)
    return together + after if together + after <= stop else inf


@kernel(inlined=True)
def spread(host: Columns, remote: Columns, i: int, east: float, north: float) -> float:
    """Standard deviation of a margin whose gradient by the remote's place is given; 0 without covariance.

    A margin depends on the difference of the two places, so their covariances add.
    """
    variance = 0.0
    if remote.covariance.shape[0] > 0:
        c = remote.covariance
        variance += (
            east * east * c[i, 0, 0] + east * north * (c[i, 0, 1] + c[i, 1, 0]) + north * north * c[i, 1, 1]
        )
    if host.covariance.shape[0] > 0:
        c = host.covariance
        variance += (
            east * east * c[i, 0, 0] + east * north * (c[i, 0, 1] + c[i, 1, 0]) + north * north * c[i, 1, 1]
        )
    return sqrt(variance) if variance > 0.0 else 0.0


@kernel(inlined=True)
def chance(margin: float, deviation: float) -> float:
    """Probability that a normal margin is not positive; 0 or 1 where it has no deviation."""
    if deviation > 0.0:
        return 0.5 * erfc(margin / (deviation * sqrt(2.0)))
    return 1.0 if margin <= 0.0 else 0.0


@kernel(inlined=True)
def ahead(host: Columns, remote: Columns, lane: Lane, i: int) -> tuple[float, float, float, float]:
    """Gap along the host's path, bumper to bumper, the remote's offset, and the gradient of the gap.

    The gap is infinite where the remote's middle is not ahead, is too far away or aside, or its course is not
    the path's. The path bends by yaw rate over speed where the host is at least so fast; straight otherwise.
    """
    east = remote.position[i, 0] - host.position[i, 0]
    north = remote.position[i, 1] - host.position[i, 1]
    sizes = 0.5 * (host.length[i] + remote.length[i])
    farthest = lane.longest + sizes
    if east * east + north * north > farthest * farthest:
        return inf, inf, 0.0, 0.0
    forth_east, forth_north = sin(host.heading[i]), cos(host.heading[i])
    onward, right = east * forth_east + north * forth_north, east * forth_north - north * forth_east
    speed = host.speed[i]
    curvature = host.yaw_rate[i] / speed if speed >= lane.least_speed and speed > 0.0 else 0.0
    offset = path_offset(onward, right, curvature)
    if abs(offset) > lane.aside:
        return inf, offset, 0.0, 0.0
    way, by_onward, by_right = path_way(onward, right, curvature)
    turn = remote.heading[i] - host.heading[i] - curvature * way
    if not (way > 0.0 and way <= farthest and cos(turn) >= lane.cosine):
        return inf, offset, 0.0, 0.0
    by_east = by_onward * forth_east + by_right * forth_north
    return way - sizes, offset, by_east, by_onward * forth_north - by_right * forth_east
