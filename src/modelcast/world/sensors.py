"""What a sender sees of the truth: a GNSS receiver and a vehicle bus, as a few stated errors.

Truth may have looked ahead (`modelcast.trips.conditioning`, or differences of positions on both sides of an
instant); a sender may not. `Sensors` puts between the two the errors of a `SensorModel` and nothing else, for
any number of vehicles, as time goes on; `sense` does so for a trip at once. Models with a name are in
`modelcast.world.named_sensors`.
"""

from dataclasses import KW_ONLY, astuple, dataclass, replace
from math import sqrt

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import wrap_angle_rad
from modelcast.station.sensing.motion_filter import HEADING_HOLD_MPS, MotionFilter
from modelcast.trips.trajectory import Trajectory
from modelcast.world import sensor_kernels as kernels
from modelcast.world.sensor_kernels import PART, Samples

__all__ = ["IDEAL", "SensorModel", "SensorState", "Sensors", "filter_for", "sense", "with_motion"]

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
        Slowly varying position error an axis (orbit, clocks, troposphere): stationary first-order
        Gauss-Markov process, standard deviation [m].
    slow_correlation_s
        Its correlation time [s].
    multipath_noise_m, multipath_correlation_s
        A second such process, of errors that come and go with the surroundings [m], [s].
    speed_noise_mps
        White noise of the speed, standard deviation [m/s].
    heading_noise_rad
        White noise of the heading, standard deviation [rad].
    acceleration_noise_mps2, yaw_rate_noise_radps
        White noise of those columns where the truth has them; the order of an automotive inertial sensor.
    latency_s
        The input of time t shows the truth of t - latency [s].
    shared_slow_ratio
        Share of the slow error's variance, 0..1, that all vehicles that are seen together have in common, as
        receivers near each other have that of satellites' orbits and clocks, ionosphere and troposphere; the
        rest is each one's own. A vehicle alone errs as much whatever the share.

    Raises
    ------
    ValueError
        Where a value is negative or not finite, a correlation time is not positive, or a ratio is above 1.

    Notes
    -----
    By the sizes of range errors in NovAtel, An Introduction to GNSS, chapter 4, table 13 (satellite clocks
    2 m, orbits 2.5 m, ionosphere 5 m, troposphere 0.5 m; multipath 1 m, receiver 0.3 m) receivers without
    corrections share 0.97 of the variance.
    """

    position_noise_m: float = 0.01
    slow_position_noise_m: float = 0.0
    slow_correlation_s: float = 300.0
    multipath_noise_m: float = 0.0
    multipath_correlation_s: float = 60.0
    speed_noise_mps: float = 0.05
    heading_noise_rad: float = 0.2 * np.pi / 180.0
    acceleration_noise_mps2: float = 0.05
    yaw_rate_noise_radps: float = 0.1 * np.pi / 180.0
    latency_s: float = 0.0
    shared_slow_ratio: float = 0.0

    def __post_init__(self) -> None:
        for name in self.__slots__:
            value = float(getattr(self, name))
            if not np.isfinite(value) or value < 0.0:
                raise ValueError(f"{name} must be finite and at least 0, got {value}")
        for process, size in (("slow", "slow_position"), ("multipath", "multipath")):
            if getattr(self, f"{process}_correlation_s") == 0.0:
                raise ValueError(f"{process}_correlation_s must be positive; set {size}_noise_m = 0 instead")
        if self.shared_slow_ratio > 1.0:
            raise ValueError(f"shared_slow_ratio must be 0..1, got {self.shared_slow_ratio}")


IDEAL = SensorModel(
    position_noise_m=0.0,
    speed_noise_mps=0.0,
    heading_noise_rad=0.0,
    acceleration_noise_mps2=0.0,
    yaw_rate_noise_radps=0.0,
)
"""No errors: the input is the truth."""


@dataclass(frozen=True, slots=True)
class SensorState:
    """Sensors between two instants.

    Parameters
    ----------
    errors
        Errors that last.
    recent
        Samples that the latency still needs, oldest first.
    t_s
        Time of the last sample [s].
    rng
        Source of all noise but the shared.
    shared
        The slow error that all have in common, over its size, east and north, (2,).
    shared_rng
        Its source; None where nothing is shared.
    """

    errors: kernels.Errors
    recent: Samples | None
    _: KW_ONLY
    t_s: float
    rng: np.random.Generator
    shared: FloatArray
    shared_rng: np.random.Generator | None


@dataclass(frozen=True, slots=True)
class Sensors:
    """Receivers and vehicle buses of V vehicles, all of one model.

    Parameters
    ----------
    model
        The errors.

    Notes
    -----
    A sample takes as many random numbers whatever the model and whatever happens, so two models seen through
    generators of one seed differ by their sizes only. What is shared has a generator of its own, spawned from
    the first, so that it changes no other error. Any number of instants may be given at once. Their
    random numbers are drawn by kind, each for all of them: the same instants one by one show the same from
    the same numbers, but a generator of the same seed gives other numbers to other instants.
    """

    model: SensorModel

    def init(self, vehicles: int, rng: np.random.Generator) -> SensorState:
        """State before the first instant.

        Parameters
        ----------
        vehicles
            Number of vehicles V.
        rng
            Source of all noise; the state keeps it.
        """
        errors = kernels.Errors(np.zeros((vehicles, 4)), np.zeros(vehicles))
        shared_rng = rng.spawn(1)[0] if self.model.shared_slow_ratio > 0.0 else None
        return SensorState(errors, None, t_s=-np.inf, rng=rng, shared=np.zeros(2), shared_rng=shared_rng)

    def sense(self, state: SensorState, truth: Samples) -> tuple[FloatArray, SensorState]:
        """Return what is seen, (T, V, C), and the next state.

        Parameters
        ----------
        state
            As `init` or `sense` gave it.
        truth
            Samples later than the last.

        Returns
        -------
        FloatArray
            Delayed by linear interpolation; a vehicle, and a part of its samples, shows its first sample
            until the latency is over. Speed is never negative. Below `HEADING_HOLD_MPS` the heading keeps its
            last value, noise included; a new part takes a heading of its own. The errors that wander go on
            from part to part, as time does, and are drawn anew for a new vehicle. Slots without a vehicle
            are zero.
        """
        latency_s = self.model.latency_s
        seen = np.empty_like(truth.motion)
        noise = state.rng.standard_normal((kernels.DRAWS, *truth.active.shape))
        rows = truth if state.recent is None else _joined(state.recent, truth)
        errors = kernels.Errors(state.errors.wandering.copy(), state.errors.heading_rad.copy())
        own = replace(
            self.model,
            slow_position_noise_m=self.model.slow_position_noise_m * sqrt(1.0 - self.model.shared_slow_ratio),
        )
        sizes = kernels.Sizes(*map(float, (*astuple(own), HEADING_HOLD_MPS)))
        first = np.zeros(truth.active.shape[1], dtype=np.int64)
        kernels.sense(sizes, rows, state.t_s, noise, errors, first, seen)
        shared = self._share(state, truth, seen)
        last_s = float(rows.t_s[-1])
        recent = None
        if latency_s > 0.0:
            oldest = max(int(np.searchsorted(rows.t_s, last_s - latency_s, side="right")) - 1, 0)
            recent = Samples(
                rows.t_s[oldest:], rows.motion[oldest:], rows.begins[oldest:], rows.active[oldest:]
            )
        return seen, replace(state, errors=errors, recent=recent, t_s=last_s, shared=shared)

    def _share(self, state: SensorState, truth: Samples, seen: FloatArray) -> FloatArray:
        """Add the error in common to all that is seen; returns where it has come."""
        if state.shared_rng is None:
            return state.shared
        path, held = state.shared_rng.standard_normal((truth.t_s.size, 2)), state.shared.copy()
        kernels.wander(self.model.slow_correlation_s, truth.t_s, state.t_s, held, path)
        size_m = self.model.slow_position_noise_m * sqrt(self.model.shared_slow_ratio)
        seen[:, :, :2] += np.where(truth.active[:, :, None], size_m * path[:, None, :], 0.0)
        return held


def _joined(before: Samples, after: Samples) -> Samples:
    return Samples(
        np.concatenate((before.t_s, after.t_s)),
        np.concatenate((before.motion, after.motion)),
        np.concatenate((before.begins, after.begins)),
        np.concatenate((before.active, after.active)),
    )


def sense(truth: Trajectory, model: SensorModel, rng: np.random.Generator) -> Trajectory:
    """Input of a sender that drives the truth, at the same times.

    Parameters
    ----------
    truth
        The driven path. Without speed or heading these are first taken from its positions by `with_motion`.
    model
        The errors.
    rng
        Source of all noise.

    Returns
    -------
    Trajectory
        What `Sensors` show of a fleet of one, whose parts are those of the trip. `up_m` is delayed and free
        of noise.

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
    trip = with_motion(truth)
    names = ["speed_mps", "heading_rad", "acceleration_mps2", "yaw_rate_radps", "up_m"]
    found = {name: column for name, column in trip.columns().items() if name in names}
    motion = np.zeros((len(trip), 1, 2 + len(names)))
    motion[:, 0, :2] = trip.position_m
    for name, column in found.items():
        motion[:, 0, 2 + names.index(name)] = column
    begins = np.zeros((len(trip), 1), dtype=np.uint8)
    begins[trip.segments[:-1]] = PART
    sensors = Sensors(model)
    samples = Samples(np.ascontiguousarray(trip.t_s), motion, begins, np.ones((len(trip), 1), dtype=np.bool_))
    seen, _ = sensors.sense(sensors.init(1, rng), samples)
    columns = {name: seen[:, 0, 2 + names.index(name)].copy() for name in found}
    return replace(trip, position_m=seen[:, 0, :2].copy(), **columns)


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
    # A slow sample has the course of the last fast one before it, or else of the first in motion.
    fast = np.flatnonzero(speed >= HEADING_HOLD_MPS)
    first = int(fast[0]) if fast.size else 0
    latest = np.maximum.accumulate(np.where(speed >= HEADING_HOLD_MPS, np.arange(speed.size), first))
    course = np.arctan2(velocity[:, 0], velocity[:, 1])[latest]
    return replace(
        trip,
        speed_mps=speed if trip.speed_mps is None else trip.speed_mps,
        heading_rad=wrap_angle_rad(course) if trip.heading_rad is None else trip.heading_rad,
    )


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
