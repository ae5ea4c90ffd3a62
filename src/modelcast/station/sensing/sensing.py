"""How a vehicle reads its measurements: one causal implementation for recorded trips, fleets and the road."""

from dataclasses import dataclass, replace

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, owned
from modelcast.core.geodesy import Origin, frame_constants
from modelcast.core.geodesy_kernels import FARTHEST_M
from modelcast.station.arrays import Sensed, sensed
from modelcast.station.sensing.motion_filter import HEADING_HOLD_MPS, MotionFilter
from modelcast.station.sensing.noise import DEFAULT_NOISE, NoiseEstimator
from modelcast.station.sensing.rates import NO_RATES_BELOW_MPS, RATES_FROM_VELOCITY, RateEstimator
from modelcast.station.sensing.sensing_kernels import SensingNumbers, sense
from modelcast.station.sensing.velocity import REPORTED, VelocityEstimator
from modelcast.trips.trajectory import GAP_STEPS, Trajectory

__all__ = [
    "NOWHERE",
    "Sensing",
    "measurements",
    "part_begins",
    "position_noise_m",
    "sample_matrix",
    "sensed_trip",
]

NOWHERE = Origin(0.0, 0.0)
"""Where a plane without an origin is laid: a code is worth 1.1 cm there on each axis, and nowhere more."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensing:
    """Estimators that make a window's samples of a vehicle's measurements.

    Parameters
    ----------
    velocity
        Of the velocity.
    rates
        Of acceleration along the course and yaw rate, where they are not measured.
    has_acceleration, has_yaw_rate
        Whether they are.
    noise
        Of the position's white noise.
    motion
        Filter over the measurements, which must then all be there; None for none.
    origin
        Of the plane that positions are measured on, by which a message states them as latitude and longitude;
        None where receivers hold them as they were measured.
    minute_s
        Time at which some minute of UTC began: messages state instants from there, in milliseconds [s].

    Raises
    ------
    ValueError
        Where a filter lacks measurements.
    """

    velocity: VelocityEstimator = REPORTED
    rates: RateEstimator = RATES_FROM_VELOCITY
    has_acceleration: bool = True
    has_yaw_rate: bool = True
    noise: NoiseEstimator = DEFAULT_NOISE
    motion: MotionFilter | None = None
    origin: Origin | None = None
    minute_s: float = 0.0

    def __post_init__(self) -> None:
        if self.motion is not None and not (
            self.velocity.window == 0 and self.has_acceleration and self.has_yaw_rate
        ):
            raise ValueError("a motion filter needs speed, heading, acceleration and yaw rate")

    @classmethod
    def of(cls, trip: Trajectory, velocity: VelocityEstimator, *, quantised: bool = False) -> "Sensing":
        """Estimators for a trip by the columns it has.

        Parameters
        ----------
        trip
            What the sender sees.
        velocity
            Of its velocity.
        quantised
            Whether positions are stated as messages say them; of a trip without an origin as if it were
            `NOWHERE`.

        Raises
        ------
        ValueError
            Where the trip lacks a column that the estimator needs.
        """
        needs_speed = velocity.window == 0 or velocity.direction_only
        if needs_speed and (trip.speed_mps is None or (velocity.window == 0 and trip.heading_rad is None)):
            needed = "speed" if velocity.direction_only else "speed and heading"
            raise ValueError(f"{trip.trip_id}: '{velocity.name}' needs {needed}")
        return cls(
            velocity=velocity,
            has_acceleration=trip.acceleration_mps2 is not None,
            has_yaw_rate=trip.yaw_rate_radps is not None,
            origin=(trip.origin or NOWHERE) if quantised else None,
        )

    def numbers(self, dt_s: float) -> SensingNumbers:
        """Numbers that compiled sensing takes, at a sampling interval [s]."""
        return SensingNumbers(
            self.velocity.window,
            self.velocity.degree,
            self.velocity.direction_only,
            self.rates.window(dt_s),
            self.rates.degree,
            self.has_acceleration,
            self.has_yaw_rate,
            NO_RATES_BELOW_MPS,
            GAP_STEPS * dt_s,
            HEADING_HOLD_MPS,
            np.empty(0) if self.origin is None else frame_constants(self.origin),
            self.minute_s,
            np.empty(0) if self.motion is None else self.motion.constants(),
            self.noise.numbers(dt_s),
        )

    def memory(self, dt_s: float) -> int:
        """Samples that the estimators look back on, the newest among them."""
        rates = 0 if self.has_acceleration and self.has_yaw_rate else self.rates.window(dt_s)
        return max(self.velocity.window, rates, self.noise.order + 1)


def measurements(trip: Trajectory) -> FloatArray:
    """What a trip's columns measure, (T, 6): not a number where it lacks one.

    Parameters
    ----------
    trip
        What the sender sees.
    """
    columns = (trip.speed_mps, trip.heading_rad, trip.acceleration_mps2, trip.yaw_rate_radps)
    nothing = np.full(len(trip), np.nan)
    return np.column_stack([trip.position_m, *(nothing if one is None else one for one in columns)])


def part_begins(trip: Trajectory) -> BoolArray:
    """At which samples a gapless part of a trip begins, (T,).

    Parameters
    ----------
    trip
        Any trip.
    """
    begins = np.zeros(len(trip), dtype=np.bool_)
    begins[trip.segments[:-1]] = True
    return begins


def sensed_trip(trip: Trajectory, sensing: Sensing) -> Sensed:
    """Return what one vehicle holds that drove the whole trip, in rings as long as the trip.

    Parameters
    ----------
    trip
        What the sender sees.
    sensing
        Its estimators.

    Raises
    ------
    ValueError
        Where messages cannot state its positions.

    Examples
    --------
    White noise of 5 cm is found within seconds:

    >>> from modelcast.trips.trajectory import build_trajectory
    >>> from modelcast.station.sensing.velocity import DEFAULT_FROM_POSITIONS
    >>> t = np.arange(0.0, 60.0, 0.1)
    >>> circle = 50.0 * np.stack([np.sin(0.3 * t), np.cos(0.3 * t)], axis=1)
    >>> noise = 0.05 * np.random.default_rng(1).standard_normal(circle.shape)
    >>> trip = build_trajectory("made/1", t, circle + noise)
    >>> held = sensed_trip(trip, Sensing.of(trip, DEFAULT_FROM_POSITIONS))
    >>> held.samples[0, [0, 100, 599], 6].round(2)
    array([0.01, 0.05, 0.05])
    """
    count = len(trip)
    if sensing.origin is not None and np.hypot(*trip.position_m.T).max() > FARTHEST_M:
        raise ValueError(
            f"{trip.trip_id}: messages state positions within {FARTHEST_M / 1e3:g} km of the origin, "
            f"this trip is up to {np.hypot(*trip.position_m.T).max() / 1e3:.0f} km off: cut it"
        )
    held = sensed(1, count)
    vehicle = np.zeros(count, dtype=np.int64)
    sense(held, vehicle, owned(trip.t_s), measurements(trip), part_begins(trip), sensing.numbers(trip.dt_s))
    return held


def sample_matrix(
    trip: Trajectory, velocity: VelocityEstimator, *, rates: RateEstimator = RATES_FROM_VELOCITY
) -> FloatArray:
    """What windows are cut from, (T, 9), each row from its sample and earlier ones.

    East, north [m], their velocities [m/s], acceleration along the course [m/s²], yaw rate, clockwise
    [rad/s], position noise an axis [m], speed [m/s], and what is reported (`point_kernels.REPORTS`).

    Parameters
    ----------
    trip
        What the sender sees.
    velocity, rates
        Estimators; the second where the trip lacks the columns.
    """
    sensing = replace(Sensing.of(trip, velocity), rates=rates)
    return sensed_trip(trip, sensing).samples[0, : len(trip)].copy()


def position_noise_m(trip: Trajectory, noise: NoiseEstimator = DEFAULT_NOISE) -> FloatArray:
    """Noise of the positions at every sample, from that sample and earlier ones, (T,) [m].

    Parameters
    ----------
    trip
        What the sender sees.
    noise
        The estimator.
    """
    held = sensed_trip(trip, Sensing(velocity=_BY_POSITIONS, noise=noise))
    return held.samples[0, : len(trip), 6].copy()


_BY_POSITIONS = VelocityEstimator("line-2", 2)
