"""Truth from a coarse recording: a fixed-interval smoother whose noises the recording itself decides.

Where positions lie on a grid, speeds are held or positions are only extrapolated between fixes, the
recorder's error would be counted as the model's. `condition` returns the most likely path instead, with
speed, heading, acceleration and yaw rate that belong to it. It looks ahead, so it is *truth*: no sender may
see it; what a sender sees comes from `modelcast.world.sensors`.
"""

from dataclasses import KW_ONLY, dataclass, replace

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.core.geodesy import wrap_angle_rad
from modelcast.trips import conditioning_kernels as kernels
from modelcast.trips.inspection import TripInspection, inspect
from modelcast.trips.measurements import (
    REST_SPEED_MPS,
    Measured,
    Recording,
    lend_course,
    measure,
    read_recording,
)
from modelcast.trips.trajectory import Trajectory

__all__ = ["Conditioning", "condition"]

_START_STD = np.array([100.0, 60.0, 5.0])  # unknown first state about the part's first position [m, s]
_START = np.log([2.0, 0.05, 0.2])  # jerk density [m²/s⁵], position noise [m], velocity noise [m/s]
_LOW = np.log([1e-4, 1e-3, 5e-3])
_HIGH = np.log([1e4, 20.0, 10.0])
_MAX_AGE_S = 0.6  # a fix older than this would be seen as one epoch earlier


@dataclass(frozen=True, slots=True)
class Conditioning:
    """How a trip was conditioned: the fitted noises, and how well the innovations agree with them.

    Parameters
    ----------
    jerk_density_m2ps5
        Spectral density of the white jerk [m²/s⁵]; over a time T it changes the acceleration by sqrt(q T).
    position_noise_m
        White noise of a measured position an axis, beyond the grid's own [m].
    velocity_noise_mps
        White noise of a measured velocity an axis [m/s]; NaN where no velocity was used.
    fix_age_s
        Age of a new value when it is first recorded, the most likely multiple of the step [s].
    coasted
        True where positions between fixes were extrapolated, so that each fix counts once.
    log_likelihood
        Of all counted innovations.
    position_nis, velocity_nis
        Mean normalised innovation squared a measured component: 1 where the noises are right; NaN without.
    position_rows, velocity_rows, rest_rows
        Samples whose position or velocity was used, and samples taken as standstill.
    correction_rms_m
        Root mean square distance between recorded and conditioned positions [m].
    evaluations
        Likelihoods computed by the search.
    """

    jerk_density_m2ps5: float
    position_noise_m: float
    _: KW_ONLY
    velocity_noise_mps: float
    fix_age_s: float
    coasted: bool
    log_likelihood: float
    position_nis: float
    velocity_nis: float
    position_rows: int
    velocity_rows: int
    rest_rows: int
    correction_rms_m: float
    evaluations: int


@dataclass(frozen=True, slots=True)
class _Fitted:
    """The fitted parameters, (3,) in logarithms, and what the likelihood said of them."""

    log_parameters: FloatArray
    cost: float
    sums: FloatArray
    evaluations: int


def condition(trip: Trajectory, inspection: TripInspection | None = None) -> tuple[Trajectory, Conditioning]:
    """Most likely path of a recording, and how it was found.

    Parameters
    ----------
    trip
        As the reader returned it. Its positions are used on every row, or once a fix where they were
        extrapolated between fixes; its speed and heading only where they are fresh, and not at all where
        they contradict the positions.
    inspection
        What `inspect` found of it, where that is known already.

    Returns
    -------
    tuple[Trajectory, Conditioning]
        The trip with conditioned positions, speed, heading, acceleration and yaw rate at the same times,
        and the fitted noises. Heading is the course over ground, held through standstill.

    Notes
    -----
    Each axis moves with white jerk of density q. A grid of step g has error variance g²/12, multiplied by the
    number of samples that repeat one grid value, since a repeated value tells nothing new. q, an added
    position noise and the velocity noise maximise the likelihood of the innovations over both axes.

    References
    ----------
    H. E. Rauch, F. Tung, C. T. Striebel, "Maximum likelihood estimates of linear dynamic systems", AIAA
    Journal 3(8), 1965, DOI 10.2514/3.3166.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.trips.trajectory import build_trajectory
    >>> t = np.arange(0.0, 40.0, 0.1)
    >>> path = np.stack([10.0 * t, 5.0 * np.sin(0.3 * t)], axis=1)
    >>> truth, how = condition(build_trajectory("made/1", t, np.round(path / 0.5) * 0.5))
    >>> bool(np.sqrt(((truth.position_m - path) ** 2).sum(axis=1).mean()) < 0.06)
    True
    """
    quality = inspect(trip) if inspection is None else inspection
    recording = read_recording(trip, quality)
    if recording.velocity_mps is None and trip.speed_mps is not None and not quality.speed_is_stuck:
        # A speed alone has no direction: a first pass over the positions lends it one.
        measured = measure(recording)
        state = _smoothed(trip, measured, _fit(trip, measured, _START))
        recording = lend_course(recording, np.arctan2(state[:, 0, 1], state[:, 1, 1]))
    measured, age_rows, fitted = _fit_age(recording)
    truth = _with_motion(trip, _smoothed(trip, measured, fitted), recording.rest)
    correction = np.hypot(*(truth.position_m - trip.position_m).T)
    counted = np.maximum(fitted.sums[:, 1], 1e-9)
    nis = np.where(fitted.sums[:, 1] > 0, fitted.sums[:, 0] / counted, np.nan)
    parameters = np.exp(fitted.log_parameters)
    return truth, Conditioning(
        float(parameters[0]),
        float(parameters[1]),
        velocity_noise_mps=float(parameters[2]) if fitted.sums[1, 1] > 0 else float("nan"),
        fix_age_s=age_rows * trip.dt_s,
        coasted=recording.coasted,
        log_likelihood=-fitted.cost,
        position_nis=float(nis[0]),
        velocity_nis=float(nis[1]),
        position_rows=int((measured.variance[:, 0, 0] >= 0).sum()),
        velocity_rows=int((measured.variance[:, 0, 1] >= 0).sum()),
        rest_rows=int(recording.rest.sum()),
        correction_rms_m=float(np.sqrt((correction**2).mean())),
        evaluations=fitted.evaluations,
    )


def _fit_age(recording: Recording) -> tuple[Measured, int, _Fitted]:
    """Fit the noises for one age of the fixes after another while that pays, each from the last optimum."""
    trip = recording.trip
    has_age = recording.held and recording.velocity_mps is not None
    age_rows = 0
    measured = measure(recording)
    fitted = _fit(trip, measured, _START)
    evaluations = fitted.evaluations
    for older in range(1, int(_MAX_AGE_S / trip.dt_s) + 1 if has_age else 1):
        trial = measure(recording, older)
        found = _fit(trip, trial, fitted.log_parameters)
        evaluations += found.evaluations
        if found.cost >= fitted.cost:
            break
        measured, age_rows, fitted = trial, older, found
    return measured, age_rows, replace(fitted, evaluations=evaluations)


def _fit(trip: Trajectory, measured: Measured, start: FloatArray) -> _Fitted:
    best, sums = start.copy(), np.zeros((2, 2))
    cost, evaluations = kernels.search(
        trip.t_s, trip.segments, measured.value, measured.variance, _START_STD, best, _LOW, _HIGH, sums
    )
    return _Fitted(best, float(cost), sums, int(evaluations))


def _smoothed(trip: Trajectory, measured: Measured, fitted: _Fitted) -> FloatArray:
    """Smoothed position, velocity and acceleration of both axes, (T, 2, 3)."""
    out = np.empty((len(trip), 2, 3))
    kernels.smooth(
        trip.t_s, trip.segments, measured.value, measured.variance, _START_STD, fitted.log_parameters, out
    )
    out[:, :, 0] += trip.position_m[trip.segment_start]
    return out


def _with_motion(trip: Trajectory, state: FloatArray, rest: BoolArray) -> Trajectory:
    """Return the trip with the smoothed state in its columns."""
    velocity, acceleration = state[:, :, 1], state[:, :, 2]
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    moving = (speed > REST_SPEED_MPS) & ~rest
    course = np.arctan2(velocity[:, 0], velocity[:, 1])
    known = np.flatnonzero(moving)
    if known.size:
        latest = np.maximum(np.cumsum(moving) - 1, 0)
        course = course[known[latest]]
    elif trip.heading_rad is not None:
        course = trip.heading_rad
    along = np.stack([np.sin(course), np.cos(course)], axis=1)
    turning = acceleration[:, 0] * velocity[:, 1] - acceleration[:, 1] * velocity[:, 0]
    return replace(
        trip,
        position_m=np.ascontiguousarray(state[:, :, 0]),
        speed_mps=np.where(rest, 0.0, speed),
        heading_rad=wrap_angle_rad(course),
        acceleration_mps2=np.where(rest, 0.0, (acceleration * along).sum(axis=1)),
        yaw_rate_radps=np.where(moving, turning / np.where(moving, speed**2, 1.0), 0.0),
    )
