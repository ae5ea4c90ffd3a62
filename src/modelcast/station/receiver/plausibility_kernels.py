"""Compiled judgement of one report after another."""

from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntVector

__all__ = [
    "COLUMNS",
    "IN_FUTURE",
    "JUMP",
    "MISMATCH",
    "OVERTAKEN",
    "PLAUSIBLE",
    "REPEATED",
    "STALE",
    "STUCK",
    "Limits",
    "judge",
    "judge_one",
]

COLUMNS = 15
"""Numbers a remote: those named below."""

(
    _T,  # time of its last report that entered here [s]; the next four are of the same report
    _EAST,
    _NORTH,
    _VELOCITY_EAST,
    _VELOCITY_NORTH,
    _START,  # time at which the window began [s]
    _START_EAST,
    _START_NORTH,
    _STATED_EAST,  # way since then by the stated velocities [m]
    _STATED_NORTH,
    _ALLOWED,  # what unseen acceleration may add to it [m]
    _FAILED,  # 1 where the last whole window failed
    _SAME_SINCE,  # time since which the stated speed is the same [s]
    _SPEED,  # that speed [m/s]
    _FAILED_SPEED,  # the speed stated all through the last window, where that failed [m/s]
) = range(COLUMNS)

PLAUSIBLE, IN_FUTURE, STALE, REPEATED, OVERTAKEN, JUMP, MISMATCH, STUCK = range(8)
"""What is found, as `modelcast.station.receiver.plausibility.Finding`."""


class Limits(NamedTuple):
    """The fields of `modelcast.station.receiver.plausibility_limits.PlausibilityLimits`."""

    max_ahead_s: float
    max_age_s: float
    max_speed_mps: float
    max_acceleration_mps2: float
    position_tolerance_m: float
    speed_tolerance_mps: float
    window_s: float
    stuck_after_s: float
    stuck_window_s: float
    speed_step_mps: float


@kernel
def _begin(row: FloatVector, t_s: float, position_m: FloatVector) -> None:
    """Begin a window at a report."""
    row[_START] = t_s
    row[_START_EAST] = position_m[0]
    row[_START_NORTH] = position_m[1]
    row[_STATED_EAST] = 0.0
    row[_STATED_NORTH] = 0.0
    row[_ALLOWED] = 0.0


@kernel
def _enter(row: FloatVector, t_s: float, position_m: FloatVector, velocity_mps: FloatVector) -> None:
    """Keep a report as the last one."""
    row[_T] = t_s
    row[_EAST] = position_m[0]
    row[_NORTH] = position_m[1]
    row[_VELOCITY_EAST] = velocity_mps[0]
    row[_VELOCITY_NORTH] = velocity_mps[1]


@kernel
def judge_one(
    row: FloatVector,
    t_s: float,
    position_m: FloatVector,
    velocity_mps: FloatVector,
    received_s: float,
    limits: Limits,
) -> int:
    """Judge one report by the row of its remote, which is written; NaN in its first column is nothing."""
    (
        ahead_s, age_s, speed_max_mps, acceleration_mps2, position_tolerance_m, speed_tolerance_mps,
        window_s, stuck_after_s, stuck_window_s, speed_step_mps,
    ) = limits  # fmt: skip
    if t_s > received_s + ahead_s:
        return IN_FUTURE
    if t_s < received_s - age_s:
        return STALE
    # Not a number, where nothing is known, is neither.
    elapsed_s = t_s - row[_T]
    if elapsed_s == 0.0:
        return REPEATED
    if elapsed_s < 0.0:
        return OVERTAKEN
    moved_m = np.hypot(position_m[0] - row[_EAST], position_m[1] - row[_NORTH])
    if moved_m > speed_max_mps * elapsed_s + position_tolerance_m:
        return JUMP
    speed_mps = np.hypot(velocity_mps[0], velocity_mps[1])
    if speed_mps > speed_max_mps:
        return MISMATCH
    if np.isnan(row[_T]):
        _enter(row, t_s, position_m, velocity_mps)
        _begin(row, t_s, position_m)
        row[_FAILED] = 0.0
        row[_SAME_SINCE] = t_s
        row[_SPEED] = speed_mps
        row[_FAILED_SPEED] = np.nan
        return PLAUSIBLE
    mean_east = 0.5 * (velocity_mps[0] + row[_VELOCITY_EAST])
    mean_north = 0.5 * (velocity_mps[1] + row[_VELOCITY_NORTH])
    _enter(row, t_s, position_m, velocity_mps)
    # Not a number compares as another speed: a velocity not stated is not stuck, and ends the window.
    if not abs(speed_mps - row[_SPEED]) <= speed_step_mps:
        row[_SAME_SINCE] = t_s
        row[_SPEED] = speed_mps
    if np.isnan(mean_east + mean_north):
        _begin(row, t_s, position_m)
        row[_FAILED] = 0.0
        return PLAUSIBLE
    row[_STATED_EAST] += mean_east * elapsed_s
    row[_STATED_NORTH] += mean_north * elapsed_s
    row[_ALLOWED] += 0.25 * acceleration_mps2 * elapsed_s**2
    lasted_s = t_s - row[_START]
    gone_m = np.hypot(position_m[0] - row[_START_EAST], position_m[1] - row[_START_NORTH])
    stated_m = np.hypot(row[_STATED_EAST], row[_STATED_NORTH])
    allowed_m = position_tolerance_m + speed_tolerance_mps * lasted_s + row[_ALLOWED]
    fails = abs(gone_m - stated_m) > allowed_m
    finding = PLAUSIBLE
    if fails or row[_FAILED] == 1.0:
        finding = STUCK if t_s - row[_SAME_SINCE] >= stuck_after_s else MISMATCH
    # While the speed stays the same the window goes on: a small error shows over a longer way. After a
    # failure only the speed that failed does that: one good window clears a speed that recovered.
    same = row[_SAME_SINCE] <= row[_START]
    goes_on = same and lasted_s < stuck_window_s
    if row[_FAILED] == 1.0 and not abs(speed_mps - row[_FAILED_SPEED]) <= speed_step_mps:
        goes_on = False
    if lasted_s >= window_s and (fails or not goes_on):
        row[_FAILED] = 1.0 if fails else 0.0
        row[_FAILED_SPEED] = speed_mps if fails and same else np.nan
        _begin(row, t_s, position_m)
    return finding


@kernel
def judge(
    rows: FloatMatrix,
    of: IntVector,
    t_s: FloatVector,
    position_m: FloatMatrix,
    velocity_mps: FloatMatrix,
    received_s: FloatVector,
    limits: Limits,
    out: IntVector,
) -> None:
    """Judge reports in turn, each by the row of its remote; rows and findings are written.

    Parameters
    ----------
    rows
        What is known of each remote, (V, `COLUMNS`); not a number in the first column for nothing.
    of
        Row of each report, (B,).
    t_s, position_m, velocity_mps, received_s
        The reports, (B,), (B, 2), (B, 2), (B,).
    limits
        Ten numbers, a tuple, as `PlausibilityLimits.numbers`.
    out
        Findings, (B,).
    """
    for b in range(t_s.size):
        out[b] = judge_one(rows[of[b]], t_s[b], position_m[b], velocity_mps[b], received_s[b], limits)
