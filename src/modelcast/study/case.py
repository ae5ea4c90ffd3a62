"""One trip made ready for evaluation: which protocol holds, what is true, and what the sender sees."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, replace

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.core.chance import child_generator
from modelcast.station.sensing.velocity import VelocityEstimator, velocity_estimator_for
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.conditioning import Conditioning, condition
from modelcast.trips.inspection import TripInspection, inspect
from modelcast.trips.judgement import judge
from modelcast.trips.trajectory import Trajectory
from modelcast.world.sensors import sense

__all__ = ["STANDING_SPEED_MPS", "SensedTrip", "TripCase", "make_case", "too_short"]

STANDING_SPEED_MPS = 0.5
"""Below this speed a vehicle counts as standing [m/s]."""


@dataclass(frozen=True, slots=True)
class SensedTrip:
    """A trip whose truth is known apart from what the sender saw, as in a generated drive.

    Parameters
    ----------
    truth, seen
        The same trip id and times.

    Raises
    ------
    ValueError
        Where identifiers or times differ.
    """

    truth: Trajectory
    seen: Trajectory

    def __post_init__(self) -> None:
        if self.truth.trip_id != self.seen.trip_id:
            raise ValueError(f"truth is trip {self.truth.trip_id}, input is trip {self.seen.trip_id}")
        if not np.array_equal(self.truth.t_s, self.seen.t_s):
            raise ValueError(f"{self.truth.trip_id}: truth and input must share their times")


@dataclass(frozen=True, slots=True)
class TripCase:
    """One trip made ready.

    Parameters
    ----------
    recorded
        The trip as read.
    truth, seen
        What the host's error is measured against, and what the sender measures. Sample by sample, they share
        their times.
    protocol
        ``recorded`` or ``sensor``.
    inspection
        Quality of the recording.
    conditioning
        How the truth was smoothed; None where it was not.
    estimator
        The causal velocity of constant velocity and baseline.
    direction
        Unit vectors of the true course, held through standstill, (T, 2).
    standing
        Samples at which the true speed is below `STANDING_SPEED_MPS`, (T,).
    warnings
        What must be known of the recording before any figure, by kind.
    """

    recorded: Trajectory
    truth: Trajectory
    _: KW_ONLY
    seen: Trajectory
    protocol: str
    inspection: TripInspection
    conditioning: Conditioning | None
    estimator: VelocityEstimator
    direction: FloatArray
    standing: BoolArray
    warnings: Mapping[str, str]


def make_case(trip: Trajectory | SensedTrip, settings: EvaluationSettings) -> TripCase:
    """Inspect a trip, choose its protocol and prepare truth and input.

    In the ``recorded`` protocol the log is both. In the ``sensor`` protocol the truth is the smoothed log,
    where the log needs smoothing, and the input is that truth through the stated sensor model; a speed column
    that is stuck is no part of the truth.

    Parameters
    ----------
    trip
        The trip as read, or truth and input where both are known; that is always the ``sensor`` protocol.
    settings
        Protocol, sensor model, seed, and where velocities come from.

    Raises
    ------
    ConfigError
        As for `velocity_estimator_for`.
    """
    conditioning = None
    if isinstance(trip, SensedTrip):
        recorded, truth, seen = trip.seen, trip.truth, trip.seen
        inspection = inspect(recorded)
        protocol = "sensor"
    else:
        recorded = truth = seen = trip
        inspection = inspect(recorded)
        protocol = inspection.recommended_protocol if settings.protocol == "auto" else settings.protocol
        if protocol == "sensor":
            if inspection.recommended_protocol == "sensor":
                truth, conditioning = condition(recorded, inspection)
            if inspection.speed_is_stuck:
                # It contradicts the positions: a sensor made of it would mislead every sub-model.
                truth = replace(truth, speed_mps=None)
            rng = child_generator(settings.seed, 0, recorded.trip_id, "sensor")
            seen = sense(truth, settings.sensor, rng)
    estimator = velocity_estimator_for(
        seen,
        speed_is_stuck=protocol == "recorded" and inspection.speed_is_stuck,
        rule=settings.velocity,
    )
    if protocol == "recorded" and inspection.speed_is_stuck and estimator.window:
        seen = replace(seen, speed_mps=None)  # no sub-model takes it either
    direction, speed_mps = _course(truth)
    return TripCase(
        recorded,
        truth,
        seen=seen,
        protocol=protocol,
        inspection=inspection,
        conditioning=conditioning,
        estimator=estimator,
        direction=direction,
        standing=speed_mps < STANDING_SPEED_MPS,
        warnings=judge(inspection, settings.thresholds_m, smoothed=conditioning is not None),
    )


def _course(truth: Trajectory) -> tuple[FloatArray, FloatArray]:
    """Unit vectors along the true track, and speeds, from differences over two steps."""
    count = len(truth)
    ahead = np.minimum(np.arange(count) + 1, np.repeat(truth.segments[1:], np.diff(truth.segments)) - 1)
    behind = np.maximum(np.arange(count) - 1, truth.segment_start)
    moved = truth.position_m[ahead] - truth.position_m[behind]
    elapsed = np.maximum(truth.t_s[ahead] - truth.t_s[behind], truth.dt_s)
    distance = np.hypot(moved[:, 0], moved[:, 1])
    speed_mps = distance / elapsed
    # A standing vehicle keeps the course it had; before it first moves, the course it will take.
    moving = np.flatnonzero(speed_mps >= STANDING_SPEED_MPS)
    if moving.size == 0:
        return np.tile([1.0, 0.0], (count, 1)), speed_mps
    held = moving[np.maximum(np.searchsorted(moving, np.arange(count), side="right") - 1, 0)]
    return moved[held] / distance[held][:, None], speed_mps


def too_short(trip: Trajectory, window: int) -> str | None:
    """Why a trip holds no window; None where it holds one.

    Parameters
    ----------
    trip
        The trip.
    window
        Samples that some part of it must hold.
    """
    longest = int(np.diff(trip.segments).max())
    return (
        None
        if longest >= window
        else f"its longest part has {longest} samples, a window needs {window}: record longer"
    )
