"""What a sender sees of the truth: a GNSS receiver and a vehicle bus, as a few stated errors.

Truth may have looked ahead (`modelcast.trips.conditioning`, or differences of positions on both sides of an
instant); a sender may not. `sense` puts between the two the errors of a `SensorModel` and nothing else.
"""

from dataclasses import dataclass, replace

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import wrap_angle_rad
from modelcast.station.sensing.motion_filter import HEADING_HOLD_MPS, MotionFilter
from modelcast.trips.trajectory import Trajectory

__all__ = ["AUTOMOTIVE_GNSS", "IDEAL", "SensorModel", "filter_for", "sense", "with_motion"]

_FINEST = {"position_m": 1e-3, "speed_mps": 1e-3, "heading_rad": 1e-4, "acceleration_mps2": 1e-2}


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorModel:
    """Errors between truth and what a sender sees; the defaults are the measured protocol.

    The defaults are a receiver with carrier-phase corrections and wheel-based speed: white position noise of
    1 cm an axis, 0.05 m/s, 0.2°. A slow error common to all samples of a few seconds moves sender and
    receiver of a message alike and hardly changes when a message is due, so it is off by default.

    Parameters
    ----------
    position_noise_m
        White noise an axis, standard deviation [m].
    slow_position_noise_m
        Slowly varying position error an axis (orbit, troposphere, multipath): stationary first-order
        Gauss-Markov process, standard deviation [m].
    slow_correlation_s
        Its correlation time [s].
    speed_noise_mps
        White noise of the speed, standard deviation [m/s].
    heading_noise_rad
        White noise of the heading, standard deviation [rad].
    acceleration_noise_mps2, yaw_rate_noise_radps
        White noise of those columns where the truth has them; the order of an automotive inertial sensor.
    latency_s
        The input of time t shows the truth of t - latency [s].

    Raises
    ------
    ValueError
        Where a value is negative or not finite, or the correlation time is not positive.
    """

    position_noise_m: float = 0.01
    slow_position_noise_m: float = 0.0
    slow_correlation_s: float = 300.0
    speed_noise_mps: float = 0.05
    heading_noise_rad: float = 0.2 * np.pi / 180.0
    acceleration_noise_mps2: float = 0.05
    yaw_rate_noise_radps: float = 0.1 * np.pi / 180.0
    latency_s: float = 0.0

    def __post_init__(self) -> None:
        for name in self.__slots__:
            value = float(getattr(self, name))
            if not np.isfinite(value) or value < 0.0:
                raise ValueError(f"{name} must be finite and at least 0, got {value}")
        if self.slow_correlation_s == 0.0:
            raise ValueError("slow_correlation_s must be positive; set slow_position_noise_m = 0 instead")


IDEAL = SensorModel(
    position_noise_m=0.0,
    speed_noise_mps=0.0,
    heading_noise_rad=0.0,
    acceleration_noise_mps2=0.0,
    yaw_rate_noise_radps=0.0,
)
"""No errors: the input is the truth."""

AUTOMOTIVE_GNSS = SensorModel(
    slow_position_noise_m=0.5, heading_noise_rad=0.5 * np.pi / 180.0, speed_noise_mps=0.1, latency_s=0.1
)
"""A stand-alone automotive receiver: half a metre that wanders by 1.3 cm a step at 10 Hz, 0.1 s late.

Well inside the 1.5 m that SAE J2945/1 asks of a position, and with the smoothness of a carrier-smoothed one.
"""


def sense(truth: Trajectory, model: SensorModel, rng: np.random.Generator) -> Trajectory:
    """Input of a sender that drives the truth, at the same times.

    Parameters
    ----------
    truth
        The driven path. Without speed or heading these are first taken from its positions by `with_motion`.
    model
        The errors.
    rng
        Source of all noise. The same number of draws is made whatever the model, so that two models seen
        through generators of one seed differ by their sizes only.

    Returns
    -------
    Trajectory
        Delayed by linear interpolation inside each part; the first ``latency_s`` of a part show its first
        sample. Speed is never negative; heading keeps its last value, noise included, below
        `HEADING_HOLD_MPS`. `up_m` is delayed and free of noise.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.trips.trajectory import build_trajectory
    >>> t = np.arange(0.0, 50.0, 0.1)
    >>> truth = build_trajectory("made/1", t, np.stack([10.0 * t, 0.0 * t], axis=1))
    >>> seen = sense(truth, SensorModel(latency_s=0.2), np.random.default_rng(1))
    >>> lag_m = (truth.position_m - seen.position_m)[:, 0]
    >>> round(float(lag_m[5:].mean()), 2), round(float(lag_m[5:].std()), 2)
    (2.0, 0.01)
    """
    seen = _delayed(with_motion(truth), model.latency_s)
    noise = rng.standard_normal((8, len(truth)))
    position = seen.position_m + model.position_noise_m * noise[0:2].T
    if model.slow_position_noise_m > 0.0:
        position = position + model.slow_position_noise_m * _gauss_markov(
            seen.t_s, model.slow_correlation_s, noise[2:4].T
        )
    speed, heading = _required(seen.speed_mps), _required(seen.heading_rad)
    return replace(
        seen,
        position_m=position,
        speed_mps=np.maximum(speed + model.speed_noise_mps * noise[4], 0.0),
        heading_rad=_held_heading(
            speed, wrap_angle_rad(heading + model.heading_noise_rad * noise[5]), ahead=False
        ),
        acceleration_mps2=_noisy(seen.acceleration_mps2, model.acceleration_noise_mps2 * noise[6]),
        yaw_rate_radps=_noisy(seen.yaw_rate_radps, model.yaw_rate_noise_radps * noise[7]),
    )


def with_motion(trip: Trajectory) -> Trajectory:
    """Return the trip with speed and heading, taken from its positions where it lacks them.

    The differences look half a step to either side: right for truth, forbidden for a sender.

    Parameters
    ----------
    trip
        Any trip; columns it has are kept.
    """
    if trip.speed_mps is not None and trip.heading_rad is not None:
        return trip
    velocity = np.zeros_like(trip.position_m)
    for a, b in zip(trip.segments[:-1], trip.segments[1:], strict=True):
        if b - a > 1:
            velocity[a:b] = np.gradient(trip.position_m[a:b], trip.t_s[a:b], axis=0)
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    course = _held_heading(speed, np.arctan2(velocity[:, 0], velocity[:, 1]), ahead=True)
    return replace(
        trip,
        speed_mps=speed if trip.speed_mps is None else trip.speed_mps,
        heading_rad=wrap_angle_rad(course) if trip.heading_rad is None else trip.heading_rad,
    )


def _required(column: FloatArray | None) -> FloatArray:
    if column is None:
        raise ValueError("the trip has no speed or no heading: call with_motion first")
    return column


def _noisy(column: FloatArray | None, noise: FloatArray) -> FloatArray | None:
    return None if column is None else column + noise


def _held_heading(speed_mps: FloatArray, heading_rad: FloatArray, *, ahead: bool) -> FloatArray:
    """Headings with each slow sample replaced by the last fast one before it.

    Before a car first moves it keeps its first heading or, where looking ahead is allowed, shows the first in
    motion.
    """
    fast = np.flatnonzero(speed_mps >= HEADING_HOLD_MPS)
    first = int(fast[0]) if ahead and fast.size else 0
    latest = np.maximum.accumulate(np.where(speed_mps >= HEADING_HOLD_MPS, np.arange(speed_mps.size), first))
    return heading_rad[latest]


def _delayed(trip: Trajectory, latency_s: float) -> Trajectory:
    """Return each column as it was ``latency_s`` earlier, within its part."""
    if latency_s == 0.0:
        return trip
    at_s = np.maximum(trip.t_s - latency_s, trip.t_s[trip.segment_start])

    def at(column: FloatArray) -> FloatArray:
        return np.interp(at_s, trip.t_s, column)

    def maybe(column: FloatArray | None) -> FloatArray | None:
        return None if column is None else at(column)

    return replace(
        trip,
        position_m=np.stack([at(trip.position_m[:, 0]), at(trip.position_m[:, 1])], axis=1),
        speed_mps=maybe(trip.speed_mps),
        heading_rad=wrap_angle_rad(at(np.unwrap(_required(trip.heading_rad)))),
        acceleration_mps2=maybe(trip.acceleration_mps2),
        yaw_rate_radps=maybe(trip.yaw_rate_radps),
        up_m=maybe(trip.up_m),
    )


def _gauss_markov(t_s: FloatArray, correlation_s: float, noise: FloatArray) -> FloatArray:
    """Unit-variance first-order Gauss-Markov process at the given times, from white noise, (T, 2)."""
    kept = np.exp(-np.diff(t_s) / correlation_s)
    fresh = np.sqrt(1.0 - kept**2)
    out = noise.copy()
    for i in range(1, t_s.size):
        out[i] = kept[i - 1] * out[i - 1] + fresh[i - 1] * noise[i]
    return out


def filter_for(sensor: SensorModel) -> MotionFilter:
    """The filter of a vehicle that knows its sensors' white noise, as their maker states it.

    Parameters
    ----------
    sensor
        The sensors. Slow errors and latency are not known to the filter; noise of zero counts as a little.
    """
    return MotionFilter(
        max(sensor.position_noise_m, _FINEST["position_m"]),
        max(sensor.speed_noise_mps, _FINEST["speed_mps"]),
        heading_rad=max(sensor.heading_noise_rad, _FINEST["heading_rad"]),
        acceleration_mps2=max(sensor.acceleration_noise_mps2, _FINEST["acceleration_mps2"]),
        yaw_rate_radps=max(sensor.yaw_rate_noise_radps, _FINEST["heading_rad"]),
    )
