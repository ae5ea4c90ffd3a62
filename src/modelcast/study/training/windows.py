"""What sub-models are trained on: windows of many trips, and what each vehicle did next."""

from collections.abc import Iterable, Sequence
from dataclasses import KW_ONLY, dataclass
from itertools import pairwise

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.models.base import AbstractMotionModel, Windows
from modelcast.station.sensing.sensing import sample_matrix
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.trips.trajectory import Trajectory

__all__ = ["TrainingWindows", "at_commonest_interval", "survival_s", "training_windows"]


@dataclass(frozen=True, slots=True)
class TrainingWindows:
    """Windows, and the displacements that followed them.

    Parameters
    ----------
    samples
        Windows, (B, n, 9), as in `Windows`.
    future_m
        Displacement from each window's last sample, as the sender measured it, (B, H, 2) [m].
    horizons_s
        When, (H,) [s]: every step from dt to the longest survival that counts.
    dt_s
        Sampling interval [s].

    Raises
    ------
    ValueError
        Where shapes do not fit each other or there is no window.
    """

    samples: FloatArray
    future_m: FloatArray
    _: KW_ONLY
    horizons_s: FloatArray
    dt_s: float

    def __post_init__(self) -> None:
        if len(self.samples) == 0:
            raise ValueError("there is no window to train on: give longer trips or a shorter longest_s")
        wanted = (len(self.samples), self.horizons_s.size, 2)
        if self.future_m.shape != wanted:
            raise ValueError(f"future_m must be {wanted}, got {self.future_m.shape}")

    def __len__(self) -> int:
        return len(self.samples)

    @property
    def windows(self) -> Windows:
        """The windows as models take them."""
        return Windows(self.samples, dt_s=self.dt_s)

    def select(self, rows: BoolArray) -> "TrainingWindows":
        """Return the windows of these rows, (B,)."""
        return TrainingWindows(
            self.samples[rows], self.future_m[rows], horizons_s=self.horizons_s, dt_s=self.dt_s
        )


def at_commonest_interval(trips: Sequence[Trajectory]) -> tuple[float, list[Trajectory]]:
    """The commonest sampling interval of trips, to a millisecond [s], and those sampled at it.

    Parameters
    ----------
    trips
        At least one.
    """
    intervals = np.round([trip.dt_s for trip in trips], 3)
    values, counts = np.unique(intervals, return_counts=True)
    dt_s = float(values[counts.argmax()])
    return dt_s, [trip for trip, own in zip(trips, intervals, strict=True) if own == dt_s]


def training_windows(
    trips: Iterable[Trajectory],
    *,
    samples: int,
    longest_s: float,
    count: int,
    rng: np.random.Generator,
) -> TrainingWindows:
    """Cut windows of trips, drawn with equal odds, each followed by a gapless future.

    Parameters
    ----------
    trips
        What senders see, all at one sampling interval.
    samples
        Window length n.
    longest_s
        Longest future looked at [s].
    count
        How many windows are drawn at most.
    rng
        Draws them.

    Raises
    ------
    ValueError
        Where trips have different sampling intervals, or none is long enough.
    """
    cut: list[tuple[FloatArray, IntArray]] = []
    dt_s = 0.0
    for trip in trips:
        if dt_s and abs(trip.dt_s - dt_s) > 1e-3 * dt_s:
            raise ValueError(
                f"trips must share one sampling interval: {dt_s} s, but {trip.trip_id}: {trip.dt_s} s"
            )
        dt_s = dt_s or trip.dt_s
        cut.append((sample_matrix(trip, velocity_estimator_for(trip)), trip.segments))
    if not cut:
        raise ValueError("there is no trip to train on")
    steps = round(longest_s / dt_s)
    starts: list[tuple[int, int]] = [
        (which, at)
        for which, (_, segments) in enumerate(cut)
        for first, end in pairwise(segments)
        for at in range(int(first) + samples - 1, int(end) - steps)
    ]
    chosen: IntArray = rng.permutation(len(starts))[:count]
    rows = [starts[int(i)] for i in np.sort(chosen)]
    windows = [cut[which][0][at - samples + 1 : at + 1] for which, at in rows]
    future = [cut[which][0][at + 1 : at + 1 + steps, :2] - cut[which][0][at, :2] for which, at in rows]
    return TrainingWindows(
        np.array(windows),
        np.array(future),
        horizons_s=np.arange(1, steps + 1, dtype=np.float64) * dt_s,
        dt_s=dt_s,
    )


def survival_s(model: AbstractMotionModel, training: TrainingWindows, thresholds_m: FloatArray) -> FloatArray:
    """Time until the prediction's error crosses each threshold, (B, thresholds) [s].

    It is interpolated between samples, so that it changes smoothly with the model; a prediction that holds
    to the end counts the longest horizon.

    Parameters
    ----------
    model
        Fitted to every window.
    training
        Windows and futures.
    thresholds_m
        Thresholds [m].
    """
    parameters = model.fit(training.windows)
    off = model.predict(parameters, training.horizons_s, dt_s=training.dt_s) - training.future_m
    error_m = np.hypot(off[..., 0], off[..., 1])
    before_m = np.concatenate([np.zeros((len(training), 1)), error_m[:, :-1]], axis=1)
    out = np.empty((len(training), len(thresholds_m)))
    rows = np.arange(len(training))
    for i, threshold_m in enumerate(thresholds_m):
        failed = error_m >= threshold_m
        first = failed.argmax(axis=1)
        rise_m = error_m[rows, first] - before_m[rows, first]
        rise_m = np.where(rise_m > 0.0, rise_m, 1.0)
        share = np.clip((threshold_m - before_m[rows, first]) / rise_m, 0.0, 1.0)
        crossed_s = training.horizons_s[first] - (1.0 - share) * training.dt_s
        out[:, i] = np.where(failed.any(axis=1), crossed_s, training.horizons_s[-1])
    return out
