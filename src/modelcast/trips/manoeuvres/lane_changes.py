"""Lane changes: a shift to one side against the smoothed course, however the road bends meanwhile.

A lane change leaves the course and comes back to it. In the course over time it is a bump whose integral,
times the speed, is the lateral shift. So at every instant the course of the seconds around it is fitted by
that of a road of one radius, straight or bent, and a bump of each of several durations. The bump counts
where it explains what the road leaves, where a road of three radii one after the other (a bend between
straights, an S-bend) explains it worse, and where the shift is that of a lane.
"""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cache
from itertools import combinations

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.trips.manoeuvres.base import FoundManoeuvre, ManoeuvreKind
from modelcast.trips.manoeuvres.motion import Motion
from modelcast.trips.recorder import parts

__all__ = ["DURATIONS_S", "MAX_SHIFT_M", "MIN_SHIFT_M", "MIN_SPEED_MPS", "find_lane_changes"]

DURATIONS_S = (3.0, 4.0, 5.5, 7.5)
"""Durations of the bumps: most lane changes take 3 s to 8 s, 4.6 s in the mean (Toledo and Zohar, 2007)."""

MIN_SHIFT_M = 2.2
"""Least shift: lanes are 2.7 m to 3.6 m wide (AASHTO), and drivers cut some of it."""

MAX_SHIFT_M = 5.2
"""Largest shift of one lane; two lanes in one go, or a bend of the road, shift more."""

MIN_SPEED_MPS = 5.0
"""Slower vehicles do not change lanes here: they park, queue and turn."""

EXPLAINED_RATIO = 0.9
"""Least share that the bump explains of what the course of the road leaves."""

MAX_BEND_RATIO = 0.7
"""The bump leaves at most this share of what the best road of three radii would leave."""

MAX_RATE_RADPS = 0.1
"""Fastest turning of the road under a lane change: 100 m of radius at 10 m/s. In tighter bends drivers steer
too unevenly to tell."""

_GRID_S = 0.2
_CHORD_S = 1.0  # course over this long: long against noise, short against a lane change
_FLANK_S = 2.0  # course before and after the bump that tells the road's


@dataclass(frozen=True, slots=True)
class _Shape:
    """Orthonormal bases of one duration: rows of the window, and the bump by which a shift is measured."""

    rows: int
    road: FloatArray
    bump: FloatArray
    _: KW_ONLY
    bump_norm: float
    weights: FloatArray
    bends: FloatArray
    core: int


@dataclass(frozen=True, slots=True)
class _Candidate:
    start_s: float
    end_s: float
    _: KW_ONLY
    shift_m: float  # to the right positive
    score: float


def find_lane_changes(motion: Motion) -> list[FoundManoeuvre]:
    """Return lane changes, left and right.

    Parameters
    ----------
    motion
        How the vehicle moved.

    Notes
    -----
    With course psi (clockwise), speed v and a bump g of integral 1, psi(t) = a + b t + (D / v) g(t), D
    the shift to the right. A bend of the road that shifts the vehicle by a lane's width and goes on as before
    looks the same: without a map nobody can tell.

    References
    ----------
    T. Toledo, D. Zohar, "Modeling duration of lane changes", Transportation Research Record 1999, 2007, DOI
    10.3141/1999-08.
    """
    found = list[FoundManoeuvre]()
    for part in parts(motion.trip):
        for t_s, course, speed in _stretches(motion, part):
            candidates = [
                one for duration in DURATIONS_S for one in _fitted(t_s, course, speed, _shape(duration))
            ]
            found += _distinct(candidates)
    return found


def _stretches(motion: Motion, part: slice) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
    """Times, course and speed every `_GRID_S` of the stretches that are fast enough throughout."""
    t_s, position = motion.trip.t_s[part], motion.trip.position_m[part]
    span_s = float(t_s[-1] - t_s[0]) - _CHORD_S
    if span_s <= 0.0:
        return []
    at = t_s[0] + 0.5 * _CHORD_S + _GRID_S * np.arange(int(span_s / _GRID_S + 1e-9) + 1)
    half_s = 0.5 * _CHORD_S
    chord = _place(at + half_s, t_s, position) - _place(at - half_s, t_s, position)
    speed = np.hypot(chord[:, 0], chord[:, 1]) / _CHORD_S
    course = np.arctan2(chord[:, 0], chord[:, 1])
    edges = np.flatnonzero(np.diff(np.concatenate([[False], speed > MIN_SPEED_MPS, [False]]).astype(np.int8)))
    return [(at[a:b], np.unwrap(course[a:b]), speed[a:b]) for a, b in edges.reshape(-1, 2)]


def _place(at_s: FloatArray, t_s: FloatArray, position: FloatArray) -> FloatArray:
    return np.stack([np.interp(at_s, t_s, position[:, axis]) for axis in (0, 1)], axis=1)


@cache
def _shape(duration_s: float) -> _Shape:
    half = round((0.5 * duration_s + 0.5 * _CHORD_S + _FLANK_S) / _GRID_S)
    t = np.asarray(np.arange(-half, half + 1) * _GRID_S, dtype=np.float64)
    bump = _bump(t, duration_s)
    road = _orthonormal(np.ones_like(t), t)
    left = bump - road @ (road.T @ bump)
    norm = float(np.linalg.norm(left))
    kinks = [np.maximum(t - at, 0.0) for at in np.arange(t[0] + 1.0, t[-1] - 0.9, 0.5)]
    bends = [_orthonormal(np.ones_like(t), t, one, other)[:, 2:] for one, other in combinations(kinks, 2)]
    return _Shape(
        t.size,
        road,
        left / norm,
        bump_norm=norm,
        weights=bump / bump.sum(),
        bends=np.stack(bends),
        core=round(0.5 * duration_s / _GRID_S),
    )


def _orthonormal(*columns: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.qr(np.stack(columns, axis=1))[0], dtype=np.float64)


def _bump(t_s: FloatArray, duration_s: float) -> FloatArray:
    """Raised cosine of integral 1 as chords see it, that is, averaged over `_CHORD_S` [1/s]."""

    def integral(at: FloatArray) -> FloatArray:
        u = np.clip(at / duration_s, -0.5, 0.5)
        return u + 0.5 + np.sin(2.0 * np.pi * u) / (2.0 * np.pi)

    return (integral(t_s + 0.5 * _CHORD_S) - integral(t_s - 0.5 * _CHORD_S)) / _CHORD_S


def _fitted(t_s: FloatArray, course: FloatArray, speed: FloatArray, shape: _Shape) -> list[_Candidate]:
    """Return the bumps of one duration that count as lane changes."""
    if t_s.size < shape.rows:
        return []
    course = course - course.mean()  # large angles would cost digits in the differences below
    amount = np.correlate(course, shape.bump, "valid")
    road = np.stack([np.correlate(course, column, "valid") for column in shape.road.T])
    energy = np.correlate(course**2, np.ones(shape.rows), "valid")
    left = np.maximum(energy - (road**2).sum(axis=0), 1e-12)
    speeds = np.correlate(speed, shape.weights, "valid")
    unexplained = np.maximum(left - amount**2, 0.0)
    shift = speeds * amount / shape.bump_norm
    good = (
        (np.abs(shift) > MIN_SHIFT_M)
        & (np.abs(shift) < MAX_SHIFT_M)
        & (unexplained < (1.0 - EXPLAINED_RATIO) * left)
    )
    rows = np.flatnonzero(good)
    windows = np.lib.stride_tricks.sliding_window_view(course, shape.rows)[rows]
    rows = rows[_bends_lose(windows, unexplained[rows], shape)]
    middle = shape.rows // 2
    return [
        _Candidate(
            float(t_s[at + middle - shape.core]),
            float(t_s[at + middle + shape.core]),
            shift_m=float(shift[at]),
            score=float(1.0 - unexplained[at] / left[at]),
        )
        for at in rows
    ]


def _bends_lose(windows: FloatArray, unexplained: FloatArray, shape: _Shape) -> IntArray:
    """Rows of the windows in which no road of up to three radii comes near, and the road turns slowly."""
    windows = windows - windows.mean(axis=1, keepdims=True)
    straight = windows @ shape.road
    energy = (windows**2).sum(axis=1) - (straight**2).sum(axis=1)
    best = np.zeros(energy.size)
    for pair in shape.bends:
        np.maximum(best, ((windows @ pair) ** 2).sum(axis=1), out=best)
    bent = np.maximum(energy - best, 1e-18)
    rate = np.abs(straight[:, 1] * (shape.road[1, 1] - shape.road[0, 1])) / _GRID_S
    return np.flatnonzero((unexplained < MAX_BEND_RATIO * bent) & (rate < MAX_RATE_RADPS))


def _distinct(candidates: Sequence[_Candidate]) -> list[FoundManoeuvre]:
    """Return the best of the candidates that overlap."""
    kept = list[_Candidate]()
    for one in sorted(candidates, key=lambda item: -item.score):
        if all(one.end_s <= other.start_s or one.start_s >= other.end_s for other in kept):
            kept.append(one)
    return [
        FoundManoeuvre(
            ManoeuvreKind.LANE_CHANGE,
            one.start_s,
            one.end_s,
            size=abs(one.shift_m),
            side="right" if one.shift_m > 0.0 else "left",
        )
        for one in kept
    ]
