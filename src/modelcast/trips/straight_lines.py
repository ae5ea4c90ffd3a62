"""Slow fixes joined by straight lines: a log that looks fast and smooth, and holds a fix now and then.

Two traits tell, and each is enough. Both compare accelerations of a moving vehicle.

*Corners.* Where nothing was added to the lines, most samples have no acceleration at all, and the velocity
changes in single corners between straight stretches. This asks nothing of when the fixes were made.

*Curvature.* The trip is cut into pieces of one period, at every phase. In an honest log the acceleration
within the pieces (of a quadratic through each) is about that between them (of the slopes of the pieces before
and behind), at any period and phase. Where the cut falls on the fixes, the pieces of a joined log are
straight. Noise that was added later averages out over a piece.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.trips.trajectory import Trajectory

__all__ = [
    "MAX_JOINED_CURVATURE_RATIO",
    "MAX_PERIOD_S",
    "MIN_CORNER_RATIO",
    "MIN_STRAIGHT_RATIO",
    "STRAIGHT_MPS2",
    "StraightLines",
    "straight_lines",
]

STRAIGHT_MPS2 = 0.02
"""An acceleration under this is none: 0.1 mm of position between samples of 10 Hz."""

MIN_STRAIGHT_RATIO = 0.25
"""Share of straight samples from which corners are looked for; honest logs have up to 0.22."""

MIN_CORNER_RATIO = 0.25
"""Share of the velocity's change in single corners; honest logs stay under 0.02, joined ones over 0.4."""

MAX_JOINED_CURVATURE_RATIO = 0.45
"""Curvature within pieces over that between; honest logs stay over 0.7."""

MAX_PERIOD_S = 5.0
"""Slower fixes are not looked for: such a log is useless in other ways."""

_MOVING_MPS = 1.0
_MIN_PIECES = 8
_MIN_SAMPLES = 30
_MIN_TURNING_MPS2 = 0.02  # steady driving on a straight road is straight however it was recorded
_MOST_SAMPLES_A_PIECE = 60
_ROUNDING_ERROR_M = 1e-5  # of kilometres in single precision, less than any grid
_LEAST_ROWS = 3  # two are always on a line
_ON_A_SAMPLE = 1e-3  # of a step
_USUAL_PERIODS_S = (0.2, 0.25, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0)
_PHASES = 12
_AS_GOOD = 0.1  # a fraction of the period cuts into straight pieces too: the longest as good is it


@dataclass(frozen=True, slots=True)
class StraightLines:
    """What was found of straight lines in one trip; NaN where the drive cannot tell.

    Parameters
    ----------
    straight_ratio
        Share of moving samples with an acceleration under `STRAIGHT_MPS2`.
    corner_ratio
        Share of the velocity's change that is made in corners of at most two samples between straight ones.
    curvature_ratio
        Mean acceleration within pieces over that between, for the cut at which it is least.
    period_s
        Time between the fixes that were joined [s]; NaN where none were.
    """

    straight_ratio: float
    corner_ratio: float
    curvature_ratio: float
    period_s: float


def straight_lines(trip: Trajectory) -> StraightLines:
    """Look for slow fixes joined by straight lines.

    Parameters
    ----------
    trip
        As the reader returned it.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.trips.trajectory import build_trajectory
    >>> t = np.arange(0.0, 60.0, 0.1)
    >>> path = np.stack([30.0 * np.sin(0.3 * t), 30.0 * np.cos(0.3 * t)], axis=1)
    >>> fixes = np.stack([np.interp(t, t[::10], path[::10, axis]) for axis in (0, 1)], axis=1)
    >>> [round(straight_lines(build_trajectory("made/1", t, one)).period_s, 6) for one in (path, fixes)]
    [nan, 1.0]
    """
    straight, corner, between_s = _corners(trip)
    curvature, period_s = _least_curvature(trip)
    joined = float("nan")
    if straight >= MIN_STRAIGHT_RATIO and corner >= MIN_CORNER_RATIO:
        joined = between_s
    elif curvature <= MAX_JOINED_CURVATURE_RATIO:
        joined = period_s
    return StraightLines(straight, corner, curvature, joined)


def _corners(trip: Trajectory) -> tuple[float, float, float]:
    """Share of straight samples, share of the change in corners, and median time between corners [s]."""
    elapsed = np.diff(trip.t_s)
    velocity = np.diff(trip.position_m, axis=0) / elapsed[:, None]
    inside = np.ones(len(velocity), dtype=np.bool_)
    inside[trip.segments[1:-1] - 1] = False
    moves = (np.hypot(velocity[:, 0], velocity[:, 1]) > _MOVING_MPS) & inside
    used = (moves[1:] | moves[:-1]) & inside[1:] & inside[:-1]
    if used.sum() < _MIN_SAMPLES:
        return float("nan"), float("nan"), float("nan")
    change = np.diff(velocity, axis=0)
    size = np.hypot(change[:, 0], change[:, 1])
    straight = size < STRAIGHT_MPS2 * 0.5 * (elapsed[1:] + elapsed[:-1])
    at, sizes = _single(change, used & ~straight, used & straight)
    total = float(size[used].sum())
    if (
        at.size < _MIN_PIECES
        or total == 0.0
        or _is_rounded(np.diff(np.diff(trip.position_m, axis=0), axis=0)[used])
    ):
        return float(straight[used].mean()), 0.0, float("nan")
    between_s = float(np.median(np.diff(trip.t_s[1:-1][at])))
    return float(straight[used].mean()), float(sizes.sum()) / total, between_s


def _is_rounded(bends_m: FloatArray) -> bool:
    """Whether second differences are multiples of one step: rounding of a smooth path makes corners too."""
    rounded = True
    for axis in range(2):
        sizes: FloatArray = np.abs(bends_m[:, axis])
        sizes = sizes[sizes > _ROUNDING_ERROR_M]
        if sizes.size:
            multiples = sizes / float(np.percentile(sizes, 2.0))
            rounded &= bool((np.abs(multiples - np.rint(multiples)) < 0.1).mean() > 0.8)
    return rounded


def _single(change: FloatArray, bent: BoolArray, straight: BoolArray) -> tuple[IntArray, FloatArray]:
    """First sample and size of every change of one or two samples that stands between straight ones."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], bent, [False]]).astype(np.int8))).reshape(-1, 2)
    edges = edges[(edges[:, 0] > 0) & (edges[:, 1] < bent.size) & (np.diff(edges, axis=1)[:, 0] <= 2)]
    edges = edges[straight[edges[:, 0] - 1] & straight[np.minimum(edges[:, 1], bent.size - 1)]]
    first, end = edges[:, 0], edges[:, 1]
    net = change[first] + np.where((end - first == 2)[:, None], change[end - 1], 0.0)
    return first, np.hypot(net[:, 0], net[:, 1])


def _least_curvature(trip: Trajectory) -> tuple[float, float]:
    """The least ratio of curvature within pieces to that between, and the period it belongs to [s]."""
    rows = _Rows.of(trip)
    told = [(ratio, cut.period_s) for cut in _cuts(trip) for ratio in _ratios(rows, cut)]
    if not told:
        return float("nan"), float("nan")
    least = min(ratio for ratio, _ in told)
    return least, max(period_s for ratio, period_s in told if ratio <= least + _AS_GOOD)


def _cuts(trip: Trajectory) -> "Iterator[_Cut]":
    """Yield the trip cut at every period, one after another: all at once are 2 kB a sample."""
    longest_s = min(1.02 * MAX_PERIOD_S, trip.duration_s / _MIN_PIECES)
    counts = [n for n in range(2, _MOST_SAMPLES_A_PIECE + 1) if n * trip.dt_s <= longest_s]
    for n in counts:
        yield _counted(trip, n)
    for period_s in _USUAL_PERIODS_S:
        steps = period_s / trip.dt_s
        counted = round(steps) in counts and abs(steps - round(steps)) < _ON_A_SAMPLE
        if steps >= _LEAST_ROWS and period_s <= longest_s and not counted:
            yield _timed(trip, period_s)


@dataclass(frozen=True, slots=True)
class _Cut:
    """A trip cut into pieces of one period: rows at which pieces start, grouped by the cut's phase.

    Parameters
    ----------
    period_s
        The period [s].
    length
        Rows of a piece that are looked at.
    start, before, behind
        First rows of a piece, of the one before it and of the one behind it, (K,).
    phase
        Which cut each belongs to, (K,).
    """

    period_s: float
    length: int
    start: IntArray
    before: IntArray
    behind: IntArray
    phase: IntArray


def _counted(trip: Trajectory, rows: int) -> _Cut:
    """Pieces of a whole number of rows, at every phase."""
    at = np.arange(rows, len(trip) - rows)
    length = max(rows, _LEAST_ROWS)
    first = trip.segment_start[at]
    place = at + np.round(trip.t_s[first] / trip.dt_s).astype(np.int64) - first
    return _Cut(rows * trip.dt_s, length, at, at - rows, at + rows, place % rows)


def _timed(trip: Trajectory, period_s: float) -> _Cut:
    """Pieces of a period that is no whole number of rows, at some phases."""
    length = int(period_s / trip.dt_s + _ON_A_SAMPLE)
    starts: list[IntArray] = []
    phases: list[IntArray] = []
    for phase in range(_PHASES):
        edges = np.arange(phase * period_s / _PHASES, trip.t_s[-1], period_s)
        starts.append(np.searchsorted(trip.t_s, edges - _ON_A_SAMPLE * trip.dt_s))
        phases.append(np.full(edges.size, phase))
    inner = [slice(1, -1)] * _PHASES
    return _Cut(
        period_s,
        length,
        np.concatenate([one[cut] for one, cut in zip(starts, inner, strict=True)]),
        np.concatenate([one[:-2] for one in starts]),
        np.concatenate([one[2:] for one in starts]),
        np.concatenate([one[cut] for one, cut in zip(phases, inner, strict=True)]),
    )


@dataclass(frozen=True, slots=True)
class _Rows:
    """What all cuts read of a trip, an array for each axis: positions from the first on, and parts.

    Parameters
    ----------
    position_m
        East and north, (T,) each [m].
    first, end
        First row of each row's gapless part, and the one behind its last, (T,).
    dt_s
        Step [s].
    """

    position_m: tuple[FloatArray, FloatArray]
    first: IntArray
    end: IntArray
    dt_s: float

    @classmethod
    def of(cls, trip: Trajectory) -> "_Rows":
        """Those of a trip."""
        east_m, north_m = np.ascontiguousarray((trip.position_m - trip.position_m[0]).T)
        end = np.repeat(trip.segments[1:], np.diff(trip.segments))
        return cls((east_m, north_m), trip.segment_start, end, trip.dt_s)


def _ratios(rows: _Rows, cut: _Cut) -> list[float]:
    """Mean acceleration within the pieces over that between them, of every phase that can tell."""
    last = np.minimum(cut.behind, rows.end.size - 1)
    whole = (cut.behind + cut.length <= rows.end[last]) & (rows.first[last] <= cut.before)
    start, before, behind, phase = (one[whole] for one in (cut.start, cut.before, cut.behind, cut.phase))
    if start.size < _MIN_PIECES:
        return []
    slopes, bends = _fits(rows, cut.length)
    within = np.hypot(*(bend[start] for bend in bends))
    between = np.hypot(*(slope[behind] - slope[before] for slope in slopes)) / (2.0 * cut.period_s)
    gone = np.hypot(*(axis_m[behind] - axis_m[start] for axis_m in rows.position_m))
    moving = (gone > _MOVING_MPS * cut.period_s).astype(np.float64)
    pieces = np.bincount(phase, weights=moving)
    inner, outer = np.bincount(phase, weights=moving * within), np.bincount(phase, weights=moving * between)
    tells = (pieces >= _MIN_PIECES) & (outer > _MIN_TURNING_MPS2 * pieces)
    return (inner[tells] / outer[tells]).tolist()


def _fits(rows: _Rows, length: int) -> tuple[list[FloatArray], list[FloatArray]]:
    """Velocity and acceleration of a quadratic through the rows from each row on, an axis each."""
    place = np.arange(length) - 0.5 * (length - 1)
    square = place**2 - (place**2).mean()
    kernels = (place / (place @ place) / rows.dt_s, 2.0 * square / (square @ square) / rows.dt_s**2)
    slopes, bends = (
        [np.correlate(axis_m, kernel, "valid") for axis_m in rows.position_m] for kernel in kernels
    )
    return slopes, bends
