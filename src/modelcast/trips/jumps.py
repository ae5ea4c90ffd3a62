"""Positions that no vehicle can reach: where a recording jumps, and which of its rows are glitches.

The bounds are physical. A step is impossible where it is longer than the fastest vehicle goes, or where no
acceleration explains it, neither from the step before nor to the step after. What a receiver's errors add is
allowed for, from the recording's own noise.
"""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray

__all__ = [
    "EARTH_M",
    "JUMP_TOLERANCE_M",
    "MAX_ACCELERATION_MPS2",
    "MAX_GLITCH_S",
    "MAX_IMPOSSIBLE_RATIO",
    "MAX_SPEED_MPS",
    "Settled",
    "jump_tolerance_m",
    "jumps_between",
    "settle",
]

MAX_SPEED_MPS = 163.8
"""The fastest speed that a basic safety message can state (SAE J2735, 8190 steps of 0.02 m/s)."""

MAX_ACCELERATION_MPS2 = 20.0
"""Two g: tyres on a dry road hold about one, racing cars with downforce somewhat more."""

JUMP_TOLERANCE_M = 10.0
"""What the errors of two positions may add: twice the largest step of an honest development trip."""

MAX_GLITCH_S = 10.0
"""A stretch that leaves and comes back within this time is a glitch; a longer one may be the truth [s]."""

MAX_EDGE_GLITCH_S = 1.0
"""At an end of the recording there is nothing to come back to: only so short a stretch is a glitch [s]."""

MAX_IMPOSSIBLE_RATIO = 0.1
"""Where more steps than this are faster than any vehicle, a unit is wrong, not a row."""

EARTH_M = 20_040_000.0
"""Half the length of the equator: no two places on Earth are farther apart [m]."""

_NOISE_STEPS = 6.0  # white noise of 1e6 samples stays under 4.5 medians of its second differences
_MIN_STEPS = 20
_USUAL_PERIODS = 1.5  # steps that take longer than this many usual ones were made by a car that stood


@dataclass(frozen=True, slots=True)
class Settled:
    """Which rows of a recording are kept, and where it is to be split.

    Parameters
    ----------
    kept
        Rows that are no glitch, (T,).
    off_earth
        Rows that are no place on Earth, (T,); none of them is kept.
    split
        Rows of the recording at which a new part begins, because the position jumped and stayed, (S,).
    """

    kept: BoolArray
    off_earth: BoolArray
    split: IntArray


def settle(t_s: FloatArray, position_m: FloatArray) -> Settled:
    """Find glitches and jumps.

    Parameters
    ----------
    t_s
        Times, strictly increasing, (T,) [s].
    position_m
        East and north, (T, 2) [m].

    Returns
    -------
    Settled
        A stretch between two impossible steps is a glitch where the trip goes on behind it, within
        `MAX_GLITCH_S`, at less than half its distance; so is a stretch of `MAX_EDGE_GLITCH_S` at an end. Any
        other impossible step splits the trip. In a recording of fewer than 20 steps nothing tells what is
        usual, and none is judged.

    Raises
    ------
    ValueError
        Where more than `MAX_IMPOSSIBLE_RATIO` of the steps are faster than `MAX_SPEED_MPS`.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(0.0, 10.0, 0.1)
    >>> path = np.stack([10.0 * t, 0.0 * t], axis=1)
    >>> path[40:43] += 500.0
    >>> path[70:] += 50.0
    >>> found = settle(t, path)
    >>> np.flatnonzero(~found.kept).tolist(), found.split.tolist()
    ([40, 41, 42], [70])
    """
    off_earth = np.zeros(len(t_s), dtype=np.bool_)
    if np.hypot(*np.ptp(position_m, axis=0)) > EARTH_M:
        off_earth = np.hypot(*(position_m - np.median(position_m, axis=0)).T) > EARTH_M
    rows = np.flatnonzero(~off_earth)
    kept = ~off_earth
    t, at = t_s[rows], position_m[rows]
    steps = _Steps.of(t, at)
    impossible = steps.impossible()
    if not impossible.any():
        return Settled(kept, off_earth, np.empty(0, dtype=np.int64))
    steps.require_speeds()
    glitch, split = _chained(_Path(t, at, steps.tolerance_m), steps.row[impossible])
    kept[rows[glitch]] = False
    return Settled(kept, off_earth, rows[split])


def jump_tolerance_m(t_s: FloatArray, position_m: FloatArray) -> float:
    """What errors of the positions may add to a step: `JUMP_TOLERANCE_M`, or more where the noise is [m].

    Parameters
    ----------
    t_s, position_m
        As in `settle`.
    """
    return _Steps.of(t_s, position_m).tolerance_m


def jumps_between(t_s: FloatArray, position_m: FloatArray, segments: IntArray) -> tuple[IntArray, FloatArray]:
    """First rows of parts that no vehicle could have reached from the part before, and how far off they are.

    Parameters
    ----------
    t_s, position_m
        As in `settle`.
    segments
        Bounds of the parts, (S + 1,).

    Returns
    -------
    tuple[IntArray, FloatArray]
        Rows, (J,), and their distance from where the vehicle would have gone on to, (J,) [m].
    """
    path = _Path(t_s, position_m, jump_tolerance_m(t_s, position_m))
    found: list[int] = []
    sizes: list[float] = []
    for k, start in enumerate(segments[1:-1].tolist()):
        off_m, possible_m = path.off(int(segments[k]), start - 1, start)
        if off_m > possible_m:
            found.append(start)
            sizes.append(off_m)
    return np.array(found, dtype=np.int64), np.array(sizes)


@dataclass(frozen=True, slots=True)
class _Steps:
    """Steps from one new position to the next.

    A position that is repeated tells nothing new. So a receiver slower than the log makes steps of its own
    period; a car that stood for long makes no longer ones for that.

    Parameters
    ----------
    row
        Rows that the steps lead to, (N,).
    moved
        Displacements, (N, 2) [m].
    elapsed
        Times they took, (N,) [s].
    """

    row: IntArray
    moved: FloatArray
    elapsed: FloatArray

    @classmethod
    def of(cls, t_s: FloatArray, position_m: FloatArray) -> "_Steps":
        """The steps of a recording."""
        row = np.flatnonzero((np.diff(position_m, axis=0) != 0.0).any(axis=1)) + 1
        new = np.append(0, row)
        since = np.diff(t_s[new])
        usual_s = _USUAL_PERIODS * float(np.median(since)) if since.size else 0.0
        moved = np.diff(position_m[new], axis=0)
        return cls(row, moved, np.maximum(t_s[row] - t_s[row - 1], np.minimum(since, usual_s)))

    def deviations_m(self) -> tuple[FloatArray, FloatArray]:
        """Distance of each step from what the one before and the one behind would have made it, (N,) [m].

        The first and the last have one neighbour only; the next but one stands for the other.
        """
        return self._deviation_m(1), self._deviation_m(-1)

    def _deviation_m(self, shift: int) -> FloatArray:
        """Distance from what a neighbour would have made it: 1 for the one before, -1 for that behind."""
        velocity = self.moved / self.elapsed[:, None]
        other = np.roll(velocity, shift, axis=0)
        if len(velocity) > 2:
            edge = 0 if shift > 0 else -1
            other[edge] = velocity[2 if shift > 0 else -3]
        return np.hypot(*(self.moved - other * self.elapsed[:, None]).T)

    @property
    def tolerance_m(self) -> float:
        """What errors may add [m]."""
        if len(self.moved) < _MIN_STEPS:
            return JUMP_TOLERANCE_M
        before = self._deviation_m(1)
        return max(JUMP_TOLERANCE_M, _NOISE_STEPS * float(np.median(before)))

    def too_fast(self) -> BoolArray:
        """Steps faster than any vehicle, (N,)."""
        return np.hypot(*self.moved.T) > MAX_SPEED_MPS * self.elapsed + self.tolerance_m

    def impossible(self) -> BoolArray:
        """Steps that no vehicle makes, (N,)."""
        if len(self.moved) < _MIN_STEPS:
            return np.zeros(len(self.moved), dtype=np.bool_)
        # What noise adds is at least `JUMP_TOLERANCE_M`, and hardly any recording needs more.
        slack_m = MAX_ACCELERATION_MPS2 * self.elapsed**2 + JUMP_TOLERANCE_M
        fast_m = MAX_SPEED_MPS * self.elapsed + JUMP_TOLERANCE_M
        if (self._deviation_m(1) <= slack_m).all() and (np.hypot(*self.moved.T) <= fast_m).all():
            return np.zeros(len(self.moved), dtype=np.bool_)
        reach = MAX_ACCELERATION_MPS2 * self.elapsed**2 + self.tolerance_m
        return (np.minimum(*self.deviations_m()) > reach) | self.too_fast()

    def require_speeds(self) -> None:
        """Refuse a recording that is faster than any vehicle most of the time."""
        fast = self.too_fast()
        if fast.size >= _MIN_STEPS and fast.mean() > MAX_IMPOSSIBLE_RATIO:
            speed = np.hypot(*self.moved.T) / self.elapsed
            raise ValueError(
                f"{int(fast.sum())} of {fast.size} steps are faster than any vehicle "
                f"({MAX_SPEED_MPS:g} m/s), median speed {np.median(speed):.4g} m/s: "
                "check the units of time and position"
            )


@dataclass(frozen=True, slots=True)
class _Path:
    """Times, positions and what their errors may add to a step."""

    t_s: FloatArray
    position_m: FloatArray
    tolerance_m: float

    def off(self, first: int, last: int, row: int) -> tuple[float, float]:
        """How far a row is from where rows ``first`` to ``last`` lead, and the most that is possible [m]."""
        elapsed = float(self.t_s[row] - self.t_s[last])
        led, reach = self.position_m[last], MAX_SPEED_MPS * elapsed
        if last > first:
            velocity = (led - self.position_m[last - 1]) / (self.t_s[last] - self.t_s[last - 1])
            led = led + velocity * elapsed
            reach = min(reach, MAX_ACCELERATION_MPS2 * elapsed**2)
        return float(np.hypot(*(self.position_m[row] - led))), reach + self.tolerance_m


def _chained(path: _Path, breaks: IntArray) -> tuple[IntArray, IntArray]:
    """Rows of glitches, and rows at which the trip is split, from the rows behind impossible steps."""
    bounds = [0, *breaks.tolist(), path.t_s.size]
    last = len(bounds) - 1
    glitch: list[int] = []
    split: list[int] = []
    own, other = 0, 1  # the piece that goes on, and the one behind it
    while other < last:
        back = _comes_back(path, bounds, own, other)
        if back is None:
            split.append(bounds[other])
            back = other
        glitch += range(bounds[other], bounds[back])
        own, other = back, back + 1
    return _without_edges(path.t_s, glitch, split)


def _comes_back(path: _Path, bounds: list[int], own: int, other: int) -> int | None:
    """The piece at which the trip goes on after a glitch that begins with piece ``other``, or None."""
    first, end = bounds[own], bounds[own + 1] - 1
    away_m, _ = path.off(first, end, bounds[other])
    for piece in range(other + 1, len(bounds) - 1):
        row = bounds[piece]
        if path.t_s[row] - path.t_s[end] > MAX_GLITCH_S:
            return None
        off_m, possible_m = path.off(first, end, row)
        longer = bounds[own + 1] - bounds[own] + bounds[piece + 1] - row >= row - bounds[other]
        if longer and off_m <= possible_m and off_m < 0.5 * away_m:
            return piece
    return None


def _without_edges(t_s: FloatArray, glitch: list[int], split: list[int]) -> tuple[IntArray, IntArray]:
    """Take a very short first or last part for a glitch too."""
    count = len(t_s)
    if split and t_s[split[0] - 1] - t_s[0] <= MAX_EDGE_GLITCH_S and 2 * split[0] < count:
        glitch = [*range(split[0]), *glitch]
        split = split[1:]
    if split and t_s[-1] - t_s[split[-1]] <= MAX_EDGE_GLITCH_S and 2 * (count - split[-1]) < count:
        glitch = [*glitch, *range(split[-1], count)]
        split = split[:-1]
    return np.unique(np.array(glitch, dtype=np.int64)), np.array(split, dtype=np.int64)
