"""What a recording measured, sample by sample: the input of the smoother in `conditioning`.

A value counts once. A grid value repeated over rows, a speed held over rows and a position extrapolated over
rows are each one measurement, at the time they were taken.
"""

from dataclasses import KW_ONLY, dataclass, replace
from itertools import pairwise

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.geodesy import heading_to_velocity
from modelcast.trips.inspection import STOP_SPEED_MPS, TripInspection
from modelcast.trips.recorder import fresh_rows
from modelcast.trips.trajectory import Trajectory

__all__ = ["REST_SPEED_MPS", "Measured", "Recording", "lend_course", "measure", "read_recording"]

REST_SPEED_MPS = 0.1
"""A recorded speed under this for a whole refresh is standstill; steps of 0.02 m/s lie well under it."""

_REST_STD_MPS = 0.005  # how still a stopped car is: it must not wander on the grid
_REST_DRIFT_M = 0.5  # how far a receiver's position may drift in a stop, beyond its grid
_MISSING = -1.0


@dataclass(frozen=True, slots=True)
class Measured:
    """Measurements of every sample.

    Parameters
    ----------
    value
        Position, velocity and velocity at rest of each axis, (T, 2, 3) [m, m/s, m/s]; positions are relative
        to the first of their part.
    variance
        Their known variances, (T, 2, 3); negative where there is no measurement.
    """

    value: FloatArray
    variance: FloatArray


@dataclass(frozen=True, slots=True)
class Recording:
    """A trip together with what is to be believed of it.

    Parameters
    ----------
    trip
        The trip as read.
    fresh
        Rows whose speed and heading are new, (F,).
    velocity_mps
        Velocity of every row as recorded, (T, 2) [m/s]; None where it is not given or not to be believed.
    grid_m
        Grid step of both axes, (2,) [m], 0 for none.
    rest
        Rows at standstill, (T,).
    held, coasted
        Whether values last for several rows; whether positions were extrapolated meanwhile.
    """

    trip: Trajectory
    fresh: IntArray
    _: KW_ONLY
    velocity_mps: FloatArray | None
    grid_m: FloatArray
    rest: BoolArray
    held: bool
    coasted: bool


def read_recording(trip: Trajectory, quality: TripInspection) -> Recording:
    """Decide what counts of a trip, from its inspection.

    Parameters
    ----------
    trip
        The trip as read.
    quality
        Its inspection. An axis that hardly moved shows no grid and takes the other's.
    """
    velocity = None
    if trip.speed_mps is not None and trip.heading_rad is not None and not quality.speed_is_stuck:
        velocity = heading_to_velocity(trip.speed_mps, trip.heading_rad)
    east, north = quality.grid_axis_m
    return Recording(
        trip,
        fresh_rows(trip, quality.held_s),
        velocity_mps=velocity,
        grid_m=np.array([east or north, north or east]),
        rest=_rest_rows(trip, quality),
        held=quality.values_held,
        coasted=velocity is not None and quality.is_coasted,
    )


def lend_course(recording: Recording, course_rad: FloatArray) -> Recording:
    """Return the recording with the velocity of its speed column along a course, fresh rows only.

    Parameters
    ----------
    recording
        One whose trip has a speed.
    course_rad
        Clockwise from north, (T,) [rad].

    Raises
    ------
    ValueError
        Where the trip has no speed.
    """
    if recording.trip.speed_mps is None:
        raise ValueError(f"{recording.trip.trip_id}: no speed to lend a course to")
    velocity = heading_to_velocity(recording.trip.speed_mps, course_rad)
    return replace(recording, velocity_mps=velocity)


def measure(recording: Recording, age_rows: int = 0) -> Measured:
    """Measurements of every sample, fixes put back by their age.

    Parameters
    ----------
    recording
        What counts.
    age_rows
        Age of a new value when it is first recorded, in rows.
    """
    trip, fresh, velocity = recording.trip, recording.fresh, recording.velocity_mps
    value = np.zeros((len(trip), 2, 3))
    variance = np.full((len(trip), 2, 3), _MISSING)
    origin = trip.position_m[trip.segment_start]
    at = np.maximum(fresh - age_rows, trip.segment_start[fresh])
    if velocity is not None and recording.coasted:
        fix, fix_variance = _fixes(trip, fresh, velocity, recording.grid_m)
        back = (trip.t_s[fresh] - trip.t_s[at])[:, None] * velocity[fresh]
        value[at, :, 0] = fix - back - origin[fresh]
        variance[at, :, 0] = fix_variance
    else:
        value[:, :, 0] = trip.position_m - origin
        variance[:, :, 0] = _repeats(trip, recording.grid_m) * recording.grid_m**2 / 12.0
        if not recording.grid_m.any():
            variance[_stale_rows(trip), :, 0] = _MISSING
    if velocity is not None:
        value[at, :, 1] = velocity[fresh]
        variance[at, :, 1] = 0.0
    variance[recording.rest, :, 1] = _MISSING
    variance[recording.rest, :, 2] = _REST_STD_MPS**2
    return Measured(value, variance)


def _fixes(
    trip: Trajectory, fresh: IntArray, velocity: FloatArray, grid_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Position at each fresh row, averaged over the rows extrapolated from it, and its grid variance.

    Rounding errors average out only as far as the rows cross grid lines.
    """
    travelled = np.concatenate(
        [np.zeros((1, 2)), np.cumsum(velocity[:-1] * np.diff(trip.t_s)[:, None], axis=0)]
    )
    lengths = np.diff(np.append(fresh, len(trip)))[:, None]
    residual = trip.position_m - travelled
    mean = np.add.reduceat(residual, fresh, axis=0) / lengths
    extent = np.abs(travelled[fresh + lengths[:, 0] - 1] - travelled[fresh])
    crossed = 1.0 + extent / np.where(grid_m > 0.0, grid_m, np.inf)
    return mean + travelled[fresh], grid_m**2 / 12.0 / np.minimum(lengths, crossed)


def _repeats(trip: Trajectory, grid_m: FloatArray) -> FloatArray:
    """Length of the run of equal grid values that each sample lies in, (T, 2); 1 without a grid."""
    count = len(trip)
    found = np.ones((count, 2))
    for axis in range(2):
        if grid_m[axis] > 0.0:
            moves = np.abs(np.diff(trip.position_m[:, axis])) > 0.3 * grid_m[axis]
            moves[trip.segments[1:-1] - 1] = True
            edges = np.concatenate([[0], np.flatnonzero(moves) + 1, [count]])
            found[:, axis] = np.repeat(np.diff(edges), np.diff(edges))
    return found


def _stale_rows(trip: Trajectory) -> BoolArray:
    """Rows that repeat a position while the vehicle moves on, as the jump that follows shows."""
    stale = np.zeros(len(trip), dtype=np.bool_)
    step = np.hypot(*np.diff(trip.position_m, axis=0).T)
    step[trip.segments[1:-1] - 1] = np.nan  # a jump over a gap shows nothing
    moves = np.flatnonzero(step != 0.0)
    for a, b in pairwise(np.append(0, moves + 1)):
        if b - a > 1 and step[b - 1] > STOP_SPEED_MPS * (trip.t_s[b] - trip.t_s[a]):
            stale[a + 1 : b] = True
    return stale


def _rest_rows(trip: Trajectory, quality: TripInspection) -> BoolArray:
    """Rows at standstill, less the last refresh of a stop, in which the car may have moved off."""
    if trip.speed_mps is None or quality.speed_is_stuck:
        return _still_rows(trip, quality)
    rest = trip.speed_mps < REST_SPEED_MPS
    for _ in range(max(1, round(quality.held_s / trip.dt_s))):
        rest = rest & np.append(rest[1:], [False])
    return _unmoved(trip, rest, 2.0 * quality.grid_m + _REST_DRIFT_M)


def _unmoved(trip: Trajectory, rest: BoolArray, limit_m: float) -> BoolArray:
    """Rest without the stretches in which the positions travelled: there the speed is wrong."""
    ends = np.zeros(len(trip) + 1, dtype=np.bool_)
    ends[trip.segments] = True
    ends[1:-1] |= rest[1:] != rest[:-1]
    edges = np.flatnonzero(ends)
    keep = rest.copy()
    for a, b in pairwise(edges):
        if rest[a] and np.ptp(trip.position_m[a:b], axis=0).max() > limit_m:
            keep[a:b] = False
    return keep


def _still_rows(trip: Trajectory, quality: TripInspection) -> BoolArray:
    """Rows inside a stretch of 2 s or more in which a position without a speed does not move at all."""
    grid = quality.grid_m
    rest = np.zeros(len(trip), dtype=np.bool_)
    if grid == 0.0:
        return rest
    moves = np.abs(np.diff(trip.position_m, axis=0)).max(axis=1) > 0.1 * grid
    moves[trip.segments[1:-1] - 1] = True
    edges = np.concatenate([[0], np.flatnonzero(moves) + 1, [len(trip)]])
    margin = max(1, round(0.5 / trip.dt_s))
    for a, b in pairwise(edges):
        if trip.t_s[b - 1] - trip.t_s[a] >= 2.0:
            rest[a + margin : b - margin] = True
    return rest
