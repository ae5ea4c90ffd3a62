"""The causal acceleration along the course and yaw rate that the kinematic models hold constant.

A log that has the column reports it, as a basic safety message does. Otherwise both follow from the
velocities that the trip's velocity estimator gives at the newest sample and before
(`modelcast.station.sensing.velocity`). Of the estimators tried, `RATES_FROM_VELOCITY` needed the fewest
messages on the development trips (``docs/decisions/008-acceleration-and-yaw-rate.md`` has the table).
"""

from dataclasses import dataclass
from math import isfinite

__all__ = [
    "NO_RATES_BELOW_MPS",
    "RATES_FROM_VELOCITY",
    "RateEstimator",
]

NO_RATES_BELOW_MPS = 0.5
"""A slower car stands: its course is noise, and it counts as neither accelerating nor turning."""


@dataclass(frozen=True, slots=True)
class RateEstimator:
    """A named causal rate of change of the velocity.

    The first velocity of a part is left out: from positions it is zero for want of a second one. So the first
    two samples of a part have no acceleration.

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
        if not (self.span_s > 0.0 and isfinite(self.span_s)):
            raise ValueError(f"span_s must be positive and finite, got {self.span_s}")

    def window(self, dt_s: float) -> int:
        """Velocities used at a sampling interval.

        Parameters
        ----------
        dt_s
            Sampling interval [s].
        """
        return max(self.degree + 2, round(self.span_s / dt_s) + 1)


RATES_FROM_VELOCITY = RateEstimator("velocity-quadratic-1.9", 1.9, degree=2)
"""End slope of a quadratic through the velocities of the last 1.9 s, twenty at 10 Hz."""
