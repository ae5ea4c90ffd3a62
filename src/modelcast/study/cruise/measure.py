"""What became of driven platoons: does a disturbance grow, is there room, is it pleasant."""

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.runtime.platoon.drive import PlatoonTrace
from modelcast.study.table import Row, TableSchema, count, quantity, ratio

__all__ = ["DRIVE", "measure_drive", "speed_change_ratio"]


DRIVE = TableSchema(
    "drive",
    "Figures of driven platoons; what is one number a platoon is the mean over them.",
    (
        quantity(
            "speed_amplification",
            "1",
            "Largest peak of a follower's speed, off the leader's mean, over the leader's own.",
        ),
        quantity(
            "spacing_amplification",
            "1",
            "Largest peak of the spacing error of the second follower and those behind, over the first's.",
        ),
        ratio(
            "stable_ratio",
            "Share of the platoons in which the spacing error does not grow: that ratio is at most 1.",
        ),
        quantity("spacing_peak_m", "m", "Largest spacing error over all followers."),
        quantity("spacing_rms_m", "m", "Root mean square of the spacing error over all followers."),
        quantity("gap_min_m", "m", "Smallest gap of all platoons."),
        count("collisions", "Followers that ran into the vehicle ahead."),
        count("followers", "Of how many."),
        quantity("acceleration_rms_mps2", "m/s²", "Root mean square of the followers' acceleration."),
        quantity("jerk_rms_mps3", "m/s³", "Root mean square of the followers' jerk."),
        ratio("fell_back_ratio", "Share of the time in which a follower's law knew too little."),
        quantity(
            "age_s",
            "s",
            "Mean age of what was known of the vehicle ahead.",
            missing="nothing ever was known",
        ),
    ),
)
"""What became of platoons: columns of `modelcast.study.cruise.run.CRUISE`."""


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _over(part: FloatArray, whole: FloatArray) -> FloatArray:
    """Ratios, (B,); 0 / 0 is 1, since nothing grew."""
    still = whole <= _STILL
    return np.where(still & (part <= _STILL), 1.0, part / np.where(still, _STILL, whole))


_STILL = 1e-9
"""Peaks below are rounding [m], [m/s]."""


def measure_drive(trace: PlatoonTrace, *, from_s: float) -> Row:
    """Figures of what platoons drove.

    Parameters
    ----------
    trace
        What they drove.
    from_s
        What came before is left out [s].

    Raises
    ------
    ValueError
        Where fewer than two frames are left.
    """
    kept = trace.t_s >= from_s - 1e-9
    if kept.sum() < 2:
        raise ValueError(f"from_s must leave two frames or more of {trace.t_s[-1]} s, got {from_s}")
    speed, error = trace.speed_mps[kept], trace.too_near_m[kept]
    mean = speed[:, :, :1].mean(axis=0)
    off = np.abs(speed - mean).max(axis=0)
    peaks = np.abs(error).max(axis=0)
    spacing = _over(peaks[:, 1:].max(axis=1), peaks[:, 0])
    acceleration = trace.acceleration_mps2[kept][:, :, 1:]
    step_s = float(np.diff(trace.t_s).mean())
    age_s = trace.age_s[kept]
    known = ~np.isnan(age_s)
    return DRIVE.row(
        speed_amplification=float(_over(off[:, 1:].max(axis=1), off[:, 0]).mean()),
        spacing_amplification=float(spacing.mean()),
        stable_ratio=float((spacing <= 1.0).mean()),
        spacing_peak_m=float(peaks.max(axis=1).mean()),
        spacing_rms_m=_rms(error),
        gap_min_m=float(trace.gap_m[kept].min()),
        collisions=int((trace.gap_m[kept].min(axis=0) <= 0.0).sum()),
        followers=int(peaks.size),
        acceleration_rms_mps2=_rms(acceleration),
        jerk_rms_mps3=_rms(np.diff(acceleration, axis=0) / step_s),
        fell_back_ratio=float(trace.fell_back[kept].mean()),
        age_s=float(age_s[known].mean()) if known.any() else None,
    )


def speed_change_ratio(trace: PlatoonTrace, other: PlatoonTrace, *, from_s: float) -> float:
    """Mean difference of the followers' speeds between two runs, over their mean speed in the other.

    Parameters
    ----------
    trace, other
        Two runs of as many platoons, vehicles and frames; a single platoon stands for all.
    from_s
        What came before is left out [s].

    Raises
    ------
    ValueError
        Where they differ.
    """
    platoons, others = trace.speed_mps.shape[1], other.speed_mps.shape[1]
    alike = trace.speed_mps.shape[::2] == other.speed_mps.shape[::2]
    if not alike or (platoons != others and 1 not in {platoons, others}):
        raise ValueError(f"runs must be alike, got {trace.speed_mps.shape} and {other.speed_mps.shape}")
    kept = trace.t_s >= from_s - 1e-9
    driven, meant = trace.speed_mps[kept][:, :, 1:], other.speed_mps[kept][:, :, 1:]
    return float(np.abs(driven - meant).mean() / meant.mean())
