"""The one causal velocity that constant velocity and the baseline coast with.

A log with speed and heading reports its velocity, as a basic safety message does. A log without heading has
only past positions; of the estimators below, `DEFAULT_FROM_POSITIONS` needed the fewest baseline messages on
the development trips (``docs/decisions/007-velocity-estimator.md`` has the table). Sub-model and baseline
always share one estimator.
"""

from dataclasses import dataclass

from modelcast.core.exceptions import ConfigError
from modelcast.station.sensing.rules import VelocityRule
from modelcast.trips.trajectory import Trajectory

__all__ = [
    "DEFAULT_FROM_POSITIONS",
    "REPORTED",
    "VelocityEstimator",
    "velocity_estimator_for",
]


@dataclass(frozen=True, slots=True)
class VelocityEstimator:
    """A named causal velocity estimate.

    Parameters
    ----------
    name
        As in tables.
    window
        Past samples used; 0 for the reported speed and heading.
    degree
        Degree of the polynomial whose slope at the newest sample is taken: 1 or 2.
    direction_only
        Take the speed from the log and only the direction from the positions.

    Raises
    ------
    ValueError
        Where the window cannot carry the degree.
    """

    name: str
    window: int
    degree: int = 1
    direction_only: bool = False

    def __post_init__(self) -> None:
        if self.degree not in (1, 2):
            raise ValueError(f"degree must be 1 or 2, got {self.degree}")
        if self.window and self.window <= self.degree:
            raise ValueError(f"window must exceed the degree {self.degree}, got {self.window}")


REPORTED = VelocityEstimator("reported", 0)
"""Speed along heading, as the log (or the vehicle's CAN and GNSS) reports them."""

DEFAULT_FROM_POSITIONS = VelocityEstimator("quadratic-4", 4, degree=2)
"""For logs without heading: the end slope of a quadratic through the newest four positions."""


_NAMED = {
    "reported": REPORTED,
    "slope-2": VelocityEstimator("slope-2", 2),
    "quadratic-4": DEFAULT_FROM_POSITIONS,
}


def velocity_estimator_for(
    trip: Trajectory, *, speed_is_stuck: bool = False, rule: VelocityRule = "auto"
) -> VelocityEstimator:
    """Return `REPORTED` where the trip has a speed and a heading to trust, else `DEFAULT_FROM_POSITIONS`.

    Parameters
    ----------
    trip
        What the sender sees.
    speed_is_stuck
        True where the speed column plainly contradicts the positions: a sensor fault would otherwise make
        the baseline look far worse than it is.
    rule
        ``auto`` for that, or the estimator to take whatever the trip has.

    Raises
    ------
    ConfigError
        Where the reported velocity is asked for and the trip has none.

    Examples
    --------
    >>> from modelcast.world.drive import generate_drive
    >>> trip = generate_drive(1, 90.0).truth
    >>> velocity_estimator_for(trip).name, velocity_estimator_for(trip, rule="slope-2").name
    ('reported', 'slope-2')
    """
    if rule == "reported" and (trip.speed_mps is None or trip.heading_rad is None):
        raise ConfigError(
            f"{trip.trip_id} has no speed and heading to take its velocity from: leave out --velocity, or "
            "name slope-2 or quadratic-4"
        )
    if rule != "auto":
        return _NAMED[rule]
    reported = trip.speed_mps is not None and trip.heading_rad is not None and not speed_is_stuck
    return REPORTED if reported else DEFAULT_FROM_POSITIONS
