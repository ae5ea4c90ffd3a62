"""Compiled errors of sensors: one instant after another, all vehicles of each.

The same loop serves a whole trip (many instants, one vehicle) and a fleet (one instant, many vehicles).
"""

from math import exp, pi, sqrt
from typing import NamedTuple

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    BoolMatrix,
    FloatCube,
    FloatMatrix,
    FloatVector,
    IntVector,
    UInt8Matrix,
)

__all__ = ["DRAWS", "NEW", "PART", "Errors", "Samples", "Sizes", "sense", "wander"]

PART, NEW = 1, 2
"""What begins at a sample: a part that does not connect with the last, or another vehicle."""

# Random numbers by row: two of each position error, for east and north.
_WHITE, _SLOW, _SPEED, _HEADING, _ACCELERATION, _YAW_RATE, _MULTIPATH = 0, 2, 4, 5, 6, 7, 8
DRAWS = 10


class Sizes(NamedTuple):
    """Fields of `SensorModel` in their order, and the speed below which a heading is held."""

    position_m: float
    slow_m: float
    slow_s: float
    multipath_m: float
    multipath_s: float
    speed_mps: float
    heading_rad: float
    acceleration_mps2: float
    yaw_rate_radps: float
    latency_s: float
    shared_slow_ratio: float
    hold_mps: float


class Samples(NamedTuple):
    """Truth at T instants of V vehicles.

    Times (T,); motion (T, V, C): east, north, speed, heading, acceleration, yaw rate, and columns that are
    only late; what begins, (T, V); which slots hold a vehicle, (T, V).
    """

    t_s: FloatVector
    motion: FloatCube
    begins: UInt8Matrix
    active: BoolMatrix


class Errors(NamedTuple):
    """What sensors keep: slow and multipath errors over their sizes (V, 4), headings last shown (V,)."""

    wandering: FloatMatrix
    heading_rad: FloatVector


@kernel
def sense(
    sizes: Sizes,
    samples: Samples,
    before_s: float,
    noise: FloatCube,
    errors: Errors,
    first: IntVector,
    out: FloatCube,
) -> None:
    """Write what is seen at the last instants, `out` (T, V, C), from `noise` (DRAWS, T, V).

    Earlier samples are there for the latency. `before_s` is the time of the last instant seen; `errors` move
    on; `first` is room for V numbers, zero at first.
    """
    earlier = samples.t_s.size - out.shape[0]
    old = 0
    for now in range(samples.t_s.size):
        t_s = samples.t_s[now]
        for v in range(first.size):
            if samples.begins[now, v]:
                first[v] = now
        if now < earlier:
            continue
        at_s = t_s - sizes.latency_s
        while old < now and samples.t_s[old + 1] <= at_s:
            old += 1
        share = 0.0
        if old < now and at_s > samples.t_s[old]:
            share = (at_s - samples.t_s[old]) / (samples.t_s[old + 1] - samples.t_s[old])
        slow_kept = exp(-(t_s - before_s) / sizes.slow_s)
        multipath_kept = exp(-(t_s - before_s) / sizes.multipath_s)
        before_s = t_s
        row = now - earlier
        for v in range(first.size):
            _late(samples.motion, old, share, first[v], v, out, row)
            if samples.active[now, v]:
                _err(sizes, samples.begins[now, v], slow_kept, multipath_kept, noise, errors, v, out, row)
            else:
                out[row, v, :] = 0.0
                errors.heading_rad[v] = 0.0


@kernel
def wander(
    correlation_s: float, t_s: FloatVector, before_s: float, held: FloatVector, path: FloatMatrix
) -> None:
    """Turn draws into a Gauss-Markov process of size 1 at some instants, ``path`` (T, N).

    ``held`` (N,) is where it was at ``before_s``, and then where it has come.
    """
    for row in range(t_s.size):
        kept = exp(-(t_s[row] - before_s) / correlation_s)
        before_s = t_s[row]
        for column in range(held.size):
            held[column] = _wandered(kept, held[column], path[row, column])
            path[row, column] = held[column]


@kernel(inlined=True)
def _wandered(kept: float, before: float, draw: float) -> float:
    """Next value of a Gauss-Markov process of size 1 that keeps so much of the last."""
    return kept * before + sqrt(1.0 - kept * kept) * draw


@kernel(inlined=True)
def _wrapped(angle_rad: float) -> float:
    wrapped = (angle_rad + pi) % (2.0 * pi) - pi
    return -pi if wrapped >= pi else wrapped


@kernel(inlined=True)
def _late(motion: FloatCube, old: int, share: float, first: int, v: int, out: FloatCube, row: int) -> None:
    """Write the motion a share of the way from one sample to the next, but not before a vehicle's first."""
    a = max(old, first)
    for column in range(out.shape[2]):
        value = motion[a, v, column]
        if a == old and share > 0.0:
            change = motion[a + 1, v, column] - value
            value += share * (_wrapped(change) if column == 3 else change)
        out[row, v, column] = value


@kernel(inlined=True)
def _err(
    sizes: Sizes,
    begins: int,
    slow_kept: float,
    multipath_kept: float,
    noise: FloatCube,
    errors: Errors,
    v: int,
    out: FloatCube,
    row: int,
) -> None:
    """Add one vehicle's errors to its late motion."""
    if begins == NEW:  # an error of its own: a process that keeps nothing is its own noise
        slow_kept = multipath_kept = 0.0
    for axis in range(2):
        slow = _wandered(slow_kept, errors.wandering[v, axis], noise[_SLOW + axis, row, v])
        multipath = _wandered(multipath_kept, errors.wandering[v, 2 + axis], noise[_MULTIPATH + axis, row, v])
        errors.wandering[v, axis] = slow
        errors.wandering[v, 2 + axis] = multipath
        out[row, v, axis] += sizes.position_m * noise[_WHITE + axis, row, v]
        out[row, v, axis] += sizes.slow_m * slow
        out[row, v, axis] += sizes.multipath_m * multipath
    if begins or out[row, v, 2] >= sizes.hold_mps:
        errors.heading_rad[v] = _wrapped(out[row, v, 3] + sizes.heading_rad * noise[_HEADING, row, v])
    out[row, v, 2] = max(out[row, v, 2] + sizes.speed_mps * noise[_SPEED, row, v], 0.0)
    out[row, v, 3] = errors.heading_rad[v]
    out[row, v, 4] += sizes.acceleration_mps2 * noise[_ACCELERATION, row, v]
    out[row, v, 5] += sizes.yaw_rate_radps * noise[_YAW_RATE, row, v]
