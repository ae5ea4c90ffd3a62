"""The causal acceleration along the course and yaw rate that the kinematic models hold constant.

A log that has the column reports it, as a basic safety message does. Otherwise both follow from the
velocities that the trip's velocity estimator gives at the newest sample and before
(`modelcast.station.sensing.velocity`). Of the estimators tried, `RATES_FROM_VELOCITY` needed the fewest
messages on the development trips (``docs/decisions/008-acceleration-and-yaw-rate.md`` has the table).
"""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.station.sensing.velocity_kernels import end_slopes
from modelcast.trips.trajectory import Trajectory

__all__ = [
    "NO_RATES_BELOW_MPS",
    "RATES_FROM_VELOCITY",
    "RateEstimator",
    "course_rates",
]

NO_RATES_BELOW_MPS = 0.5
"""A slower car stands: its course is noise, and it counts as neither accelerating nor turning."""


@dataclass(frozen=True, slots=True)
class RateEstimator:
    """A named causal rate of change of the velocity.

    Parameters
    ----------
    name
        As in tables.
    span_s
        Time between the oldest and the newest velocity used [s]; at least two more velocities than the degree
        are used however long their steps.
    degree
        Degree of the polynomial whose slope at the newest sample is taken: 1 or 2.

    Raises
    ------
    ValueError
        Where the degree is another or the span not positive and finite.
    """

    name: str
    span_s: float
    degree: int

    def __post_init__(self) -> None:
        if self.degree not in (1, 2):
            raise ValueError(f"degree must be 1 or 2, got {self.degree}")
        if not (self.span_s > 0.0 and np.isfinite(self.span_s)):
            raise ValueError(f"span_s must be positive and finite, got {self.span_s}")

    def window(self, dt_s: float) -> int:
        """Velocities used at a sampling interval.

        Parameters
        ----------
        dt_s
            Sampling interval [s].
        """
        return max(self.degree + 2, round(self.span_s / dt_s) + 1)

    def acceleration(self, trip: Trajectory, velocity_mps: FloatArray) -> FloatArray:
        """Acceleration vector at every sample from its velocity and earlier ones, (T, 2) [m/s²].

        The first velocity of a part is left out: from positions it is zero for want of a second one. So the
        first two samples of a part have no acceleration.

        Parameters
        ----------
        trip
            What the sender sees.
        velocity_mps
            East and north velocity of its estimator, (T, 2) [m/s].
        """
        slopes = np.empty_like(velocity_mps)
        end_slopes(
            trip.t_s, velocity_mps, trip.segment_start + 1, self.window(trip.dt_s), self.degree, slopes
        )
        return slopes


RATES_FROM_VELOCITY = RateEstimator("velocity-quadratic-1.9", 1.9, degree=2)
"""End slope of a quadratic through the velocities of the last 1.9 s, twenty at 10 Hz."""


def course_rates(
    trip: Trajectory,
    velocity_mps: FloatArray,
    *,
    acceleration: RateEstimator = RATES_FROM_VELOCITY,
    yaw_rate: RateEstimator = RATES_FROM_VELOCITY,
) -> FloatArray:
    """Acceleration along the course and yaw rate, clockwise, at every sample, (T, 2) [m/s², rad/s].

    Both are zero below `NO_RATES_BELOW_MPS`.

    Parameters
    ----------
    trip
        What the sender sees. Its columns of acceleration and yaw rate are taken where it has them.
    velocity_mps
        East and north velocity of its estimator, (T, 2) [m/s].
    acceleration, yaw_rate
        Estimators where it lacks them.
    """
    east, north = velocity_mps.T
    speed = np.hypot(east, north)
    safe = np.maximum(speed, NO_RATES_BELOW_MPS)
    along, turn = trip.acceleration_mps2, trip.yaw_rate_radps
    if along is None:
        along = (acceleration.acceleration(trip, velocity_mps) * velocity_mps).sum(axis=1) / safe
    if turn is None:
        change = yaw_rate.acceleration(trip, velocity_mps)
        turn = (change[:, 0] * north - change[:, 1] * east) / safe**2
    moving = speed >= NO_RATES_BELOW_MPS
    return np.stack([np.where(moving, along, 0.0), np.where(moving, turn, 0.0)], axis=1)
