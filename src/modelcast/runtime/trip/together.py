"""Trips that were recorded together: whose clock began when, and where one was in the frame of another."""

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import geodetic_to_local, local_to_geodetic
from modelcast.trips.trajectory import Trajectory

__all__ = ["begins_after_s", "placed"]


def begins_after_s(first: Trajectory, second: Trajectory) -> float | None:
    """How much later a trip begins than another, None where they share no clock or no frame [s].

    Parameters
    ----------
    first, second
        The trip that begins earlier, and the other; negative where it is the other way round.
    """
    if (first.origin is None) != (second.origin is None):
        return None
    one_file = first.trip_id.rpartition("/")[0] == second.trip_id.rpartition("/")[0]
    if first.start_unix_s is not None and second.start_unix_s is not None:
        if first.origin is None and not one_file:
            return None
        return second.start_unix_s - first.start_unix_s
    if first.clock_s is None or second.clock_s is None or not one_file:
        return None
    return second.clock_s - first.clock_s


def placed(numbers: FloatArray, first: Trajectory, second: Trajectory) -> FloatArray:
    """Rows whose first columns are a place, east and north, from one trip's frame to another's.

    Parameters
    ----------
    numbers
        (N, C), C at least 2; the first two in metres.
    first, second
        Trip whose frame they are in, and that whose frame is wanted; of one without an origin, the same.
    """
    if first.origin is None or second.origin is None or first.origin == second.origin:
        return numbers
    found = numbers.copy()
    found[:, :2] = geodetic_to_local(local_to_geodetic(numbers[:, :2], first.origin), second.origin)
    return found
