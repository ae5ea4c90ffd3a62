"""How a recorder wrote a trip down: its grid, its refresh, its extrapolation, its noise.

Each function reads one trait off the values of a trip; `modelcast.trips.inspection` puts them together.
"""

from itertools import pairwise

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.geodesy import heading_to_velocity
from modelcast.trips.trajectory import Trajectory

__all__ = [
    "WINDOW_S",
    "change_rate_hz",
    "changed_rows",
    "coasted_ratio",
    "fresh_rows",
    "grid_step_m",
    "held_s",
    "noise_span_s",
    "parts",
    "position_rate_hz",
    "quadratic_residual_m",
    "rows_around",
    "velocity_over",
]

WINDOW_S = 1.0
"""Span of the fits and differences: long against a sample, short against a manoeuvre."""

_WINDOWS_AT_ONCE = 16_384
"""Windows fitted at a time: all of a long trip at once would take 800 bytes a sample."""

MAX_HELD_RATIO = 0.34
"""A column is held where a value lasts three samples or more in the median, that is, changes this often."""

_MOVING_MPS = 0.5  # a slower vehicle's values may rest because it does
_MIN_CHANGES = 10
_MIN_LATTICE_SCORE = 0.6  # 1 on an exact grid, 0 +- 0.1 off any; float32 degrees in 6 decimals score 0.8
_NOTHING_M = 0.003  # curvature bends a grid by less than this between two samples


def changed_rows(trip: Trajectory) -> BoolArray:
    """Rows where speed, acceleration or yaw rate takes a new value, (T,); the first row of a part counts.

    Heading is asked only where none of these is there: a unit may turn a held heading on by itself.
    """
    columns = [c for c in (trip.speed_mps, trip.acceleration_mps2, trip.yaw_rate_radps) if c is not None]
    if not columns and trip.heading_rad is not None:
        columns = [trip.heading_rad]
    changed = np.zeros(len(trip), dtype=np.bool_)
    for column in columns:
        changed[1:] |= np.diff(column) != 0.0
    changed[trip.segments[:-1]] = True
    return changed


def fresh_rows(trip: Trajectory, lasting_s: float) -> IntArray:
    """Rows at which the unit took new values, (F,); every row where ``lasting_s`` is 0.

    A value that comes out the same is new all the same: where nothing changes for longer than a refresh,
    rows at the unit's beat are taken.

    Parameters
    ----------
    trip
        The trip.
    lasting_s
        How long a value lasts, from `held_s` [s].
    """
    if lasting_s == 0.0:
        return np.arange(len(trip))
    beat = round(lasting_s / trip.dt_s)
    fresh = np.append(np.flatnonzero(changed_rows(trip)), len(trip))
    filled: list[IntArray] = [
        np.arange(int(a), max(int(b) - beat // 2, int(a) + 1), beat) for a, b in pairwise(fresh)
    ]
    return np.concatenate(filled)


def change_rate_hz(trip: Trajectory, column: FloatArray | None) -> float | None:
    """Changes a second while moving [Hz]; NaN where the vehicle never moves, None without a column."""
    return None if column is None else _rate_hz(trip, np.diff(column) != 0.0)


def position_rate_hz(trip: Trajectory) -> float:
    """New positions a second while moving [Hz]; NaN where the vehicle never moves."""
    return _rate_hz(trip, (np.diff(trip.position_m, axis=0) != 0.0).any(axis=1))


def _rate_hz(trip: Trajectory, changed: BoolArray) -> float:
    velocity = velocity_over(trip, WINDOW_S)[1:]
    moving = np.hypot(velocity[:, 0], velocity[:, 1]) > _MOVING_MPS
    return float(changed[moving].mean() / trip.dt_s) if moving.any() else float("nan")


def held_s(trip: Trajectory) -> float:
    """Median time a value lasts where the columns are held at a steady beat, else 0 [s]."""
    fresh = np.flatnonzero(changed_rows(trip))
    runs = np.diff(fresh)
    if runs.size < _MIN_CHANGES:
        return 0.0
    median = float(np.median(runs))
    steady = (np.abs(runs - median) <= 1.0).mean() >= 0.5
    return median * trip.dt_s if steady and median * MAX_HELD_RATIO >= 1.0 else 0.0


def coasted_ratio(trip: Trajectory, lasting_s: float) -> float:
    """Share of the motion missed by the held velocity that is made up by a jump at its next change.

    Measured positions leave the held velocity's line gradually; extrapolated ones keep to it and jump.
    """
    if trip.speed_mps is None or trip.heading_rad is None:
        return float("nan")
    velocity = heading_to_velocity(trip.speed_mps, trip.heading_rad)
    travelled = np.cumsum(velocity[:-1] * np.diff(trip.t_s)[:, None], axis=0)
    residual = trip.position_m - np.concatenate([np.zeros((1, 2)), travelled])
    fresh = fresh_rows(trip, lasting_s)
    start, following = fresh[:-1], fresh[1:]
    same = (trip.segment_start[start] == trip.segment_start[following]) & (following - start > 2)
    start, following = start[same], following[same]
    drift = residual[following - 1] - residual[start]
    jump = residual[following] - residual[following - 1]
    change = velocity[following] - velocity[start]
    energy = float((change**2).sum())
    explained, scatter = float(((drift + jump) * change).sum()), float((drift**2 + jump**2).mean())
    if energy == 0.0 or explained <= 3.0 * np.sqrt(scatter * energy):
        return float("nan")
    return float(np.clip((jump * change).sum() / explained, 0.0, 1.0))


def grid_step_m(trip: Trajectory, noise_m: FloatArray) -> tuple[float, float]:
    """Grid step of both axes [m], 0 where the differences lie on none."""
    inside = np.ones(len(trip) - 1, dtype=np.bool_)
    inside[trip.segments[1:-1] - 1] = False
    steps = np.abs(np.diff(trip.position_m, axis=0))[inside]
    # Rounding to a grid leaves about 0.25 steps of noise an axis after a fit; where there is less, equal
    # differences come from steady driving, not from a grid that coarse.
    limit_m = 5.0 * float(np.percentile(noise_m, 90)) if noise_m.size else 0.0
    east, north = (_lattice_step_m(steps[:, axis], limit_m) for axis in range(2))
    return east, north


def _lattice_step_m(steps_m: FloatArray, limit_m: float) -> float:
    """Largest g such that most differences lie near its multiples (Schuster's periodogram), else 0."""
    moved = steps_m[steps_m > _NOTHING_M]
    if moved.size < _MIN_CHANGES:
        return 0.0
    smallest = float(np.percentile(moved, 2.0))
    candidates = np.geomspace(0.02, 2.5, 600)
    candidates = candidates[(candidates < 1.3 * smallest) & (candidates < limit_m)]
    moved = moved[:: 1 + moved.size // 1000]
    score = np.zeros(candidates.size)
    for i, g in enumerate(candidates):
        near = moved[moved < 6.5 * g]  # further multiples add up the grid's own unevenness
        if near.size >= max(_MIN_CHANGES, 0.05 * moved.size):
            score[i] = np.cos(2.0 * np.pi * near / g).mean()
    # A fraction of the step scores as well as the step, or better where decimals cut it: take the largest.
    good = np.flatnonzero((score > _MIN_LATTICE_SCORE) & (score > 0.75 * score.max(initial=0.0)))
    if good.size == 0:
        return 0.0
    best = float(candidates[good[-1]])
    near = moved[moved < 6.5 * best]
    multiple = np.round(near / best)
    return float((multiple * near).sum() / (multiple**2).sum())


def _noise_rows(trip: Trajectory) -> int:
    return max(5, round(WINDOW_S / trip.dt_s) + 1)


def noise_span_s(trip: Trajectory) -> float:
    """Span of the windows of `quadratic_residual_m`: 1 s, or four steps where these are longer [s]."""
    return (_noise_rows(trip) - 1) * trip.dt_s


def quadratic_residual_m(trip: Trajectory) -> FloatArray:
    """Root mean square distance from a quadratic fit in every window of `noise_span_s`, (W,) [m]."""
    count = _noise_rows(trip)
    found: list[FloatArray] = []
    for part in parts(trip):
        if part.stop - part.start < count:
            continue
        t = np.lib.stride_tricks.sliding_window_view(trip.t_s[part], count)
        y = np.lib.stride_tricks.sliding_window_view(trip.position_m[part], count, axis=0)
        for first in range(0, len(t), _WINDOWS_AT_ONCE):
            some = slice(first, first + _WINDOWS_AT_ONCE)
            found.append(_residual_m(t[some], y[some]))
    return np.concatenate(found) if found else np.empty(0)


def _residual_m(t: FloatArray, y: FloatArray) -> FloatArray:
    """Distance of windows of positions, (W, 2, N), from a quadratic over (W, N) times, (W,) [m]."""
    s = t - t.mean(axis=1, keepdims=True)
    basis = np.linalg.qr(np.stack([np.ones_like(s), s, s * s], axis=2))[0]
    y = y - y.mean(axis=2, keepdims=True)
    residual = y - np.einsum("wnk,wak->wan", basis, np.einsum("wnk,wan->wak", basis, y))
    return np.sqrt((residual**2).sum(axis=(1, 2)) / t.shape[1])


def parts(trip: Trajectory) -> list[slice]:
    """Return the trip's gapless parts."""
    return [slice(int(a), int(b)) for a, b in zip(trip.segments[:-1], trip.segments[1:], strict=True)]


def rows_around(trip: Trajectory, span_s: float) -> tuple[IntArray, IntArray]:
    """Index of the samples about half a span before and after each sample, inside its part."""
    half = max(1, round(0.5 * span_s / trip.dt_s))
    at = np.arange(len(trip))
    first = trip.segment_start
    last = np.repeat(trip.segments[1:] - 1, np.diff(trip.segments))
    return np.maximum(at - half, first), np.minimum(at + half, last)


def velocity_over(trip: Trajectory, span_s: float) -> FloatArray:
    """Velocity differenced over a span, (T, 2) [m/s]; zero in a part of one sample."""
    before, after = rows_around(trip, span_s)
    elapsed = np.maximum(trip.t_s[after] - trip.t_s[before], 1e-9)
    return (trip.position_m[after] - trip.position_m[before]) / elapsed[:, None]
