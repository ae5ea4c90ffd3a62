"""How a recorded vehicle truly moved: what its log lacks is taken from differences on both sides."""

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.scientific import scientific
from modelcast.trips.trajectory import Trajectory
from modelcast.world.sensors import with_motion

__all__ = ["MOTION_COLUMNS", "true_motion"]

MOTION_COLUMNS = ("east_m", "north_m", "speed_mps", "heading_rad", "acceleration_mps2", "yaw_rate_radps")
"""Columns of `true_motion`."""

_SHORTEST = 3


def true_motion(trip: Trajectory, *, smooth_s: float = 0.0) -> FloatArray:
    """Place, speed, course, acceleration along it and yaw rate of every sample, (T, 6).

    The course is unwrapped within each gapless part, so that it can be interpolated. In parts of fewer than
    three samples acceleration and yaw rate are NaN where the log has none.

    Parameters
    ----------
    trip
        Any trip.
    smooth_s
        Acceleration and yaw rate are slopes of parabolas through the speeds and courses up to this long
        before and after [s], since differences of two samples are mostly noise; 0 for those of two steps.

    Raises
    ------
    ValueError
        Where there is neither a column nor a way to make it.
    """
    moving = with_motion(trip)
    if moving.speed_mps is None or moving.heading_rad is None:
        raise ValueError(f"{trip.trip_id} has no speed or no heading")
    found = np.full((len(trip), len(MOTION_COLUMNS)), np.nan)
    found[:, :2], found[:, 2] = trip.position_m, moving.speed_mps
    for column, given in ((4, trip.acceleration_mps2), (5, trip.yaw_rate_radps)):
        if given is not None:
            found[:, column] = given
    for a, b in zip(trip.segments[:-1], trip.segments[1:], strict=True):
        found[a:b, 3] = np.unwrap(moving.heading_rad[a:b])
        if b - a < _SHORTEST:
            continue
        for column, given, of in ((4, trip.acceleration_mps2, 2), (5, trip.yaw_rate_radps, 3)):
            if given is None:
                found[a:b, column] = _slope(found[a:b, of], trip.t_s[a:b], round(smooth_s / trip.dt_s))
    return found


def _slope(values: FloatArray, t_s: FloatArray, reach: int) -> FloatArray:
    """Slopes of values, of parabolas through ``reach`` samples to either side where there are as many."""
    samples = 2 * reach + 1
    if reach < 1 or values.size < samples:
        return np.gradient(values, t_s)
    step_s = float(np.median(np.diff(t_s)))
    signal = scientific("signal", "acceleration and yaw rate of noisy trips")
    return signal.savgol_filter(values, samples, 2, deriv=1, delta=step_s)
