"""Compiled expectation of a sender's own next message: when its error will call for one again.

An error is taken to grow with the square of a message's age, as `hindsight` does. So what was held until now,
``age`` old and in error by ``error``, held for ``age·sqrt(threshold/error)``; the message that takes its
place is expected to hold as long. Stations ask once a step, so a time is a whole number of steps on.
"""

from math import ceil, hypot, sqrt

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector
from modelcast.models.point_kernels import VELOCITY_EAST, VELOCITY_NORTH
from modelcast.station.policy import cam_kernels
from modelcast.station.policy.j2945_kernels import (
    DENSITY,
    MAX_TRACKING_ERROR_M,
    MIN_TRACKING_ERROR_M,
    TRACKING_ERROR_TRIGGER,
    error_growth,
)

__all__ = ["calls_at_once", "error_that_calls", "life_of", "steps_on", "until_cam"]

_SLACK = 1e-6


@kernel(inlined=True)
def life_of(age_s: float, error_m: float, threshold_m: float) -> float:
    """Return how long a message holds whose error at an age is known; infinite where it has none."""
    if not (age_s > 0.0 and error_m < np.inf):
        return np.inf
    return age_s * sqrt(threshold_m / error_m) if error_m > 0.0 else np.inf


@kernel(inlined=True)
def steps_on(t_s: float, life_s: float, dt_s: float) -> float:
    """Return the first instant at which a station asks once a life is over, one step on at least."""
    if not life_s < np.inf:
        return np.inf
    return t_s + max(ceil(life_s / dt_s - _SLACK), 1.0) * dt_s


@kernel(inlined=True)
def calls_at_once(c: FloatVector) -> bool:
    """Whether an error calls for a message for certain from a bound on: below it never, as when relaxed."""
    certain = c[MIN_TRACKING_ERROR_M] == c[MAX_TRACKING_ERROR_M]
    return bool(c[TRACKING_ERROR_TRIGGER] != 0.0 and certain)


@kernel(inlined=True)
def error_that_calls(row: FloatVector, c: FloatVector) -> float:
    """Return the tracking error that calls for a message at the density that a station counts [m]."""
    return c[MIN_TRACKING_ERROR_M] * error_growth(row[DENSITY], c)


@kernel(inlined=True)
def until_cam(row: FloatVector, sample: FloatVector, shortest_s: float, c: FloatVector) -> float:
    """Return how long until an awareness message: by the way at this speed, or by T_GenCam [s]."""
    speed = hypot(sample[VELOCITY_EAST], sample[VELOCITY_NORTH])
    far_s = c[cam_kernels.DISTANCE_M] / speed if speed > 0.0 else np.inf
    return max(min(far_s, row[cam_kernels.INTERVAL_S]), shortest_s)
