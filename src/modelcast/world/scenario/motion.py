"""Whether vehicles move as their columns say: the check that every source of traffic passes.

A file may hold degrees where metres are meant, km/h where m/s are, or headings counted from east. None of it
shows in a single frame. So each vehicle's way is laid out in stretches of about `STRETCH_M`, and how far it
came is set against its speeds; and how it moved from frame to frame against its headings. Long stretches make
the noise of positions small, short ones keep bends from mattering.
"""

from collections.abc import Iterable, Iterator

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.world.scenario.base import FleetFrame

__all__ = ["MotionCheck", "checked", "is_jump"]

STRETCH_M = 20.0
"""Length of a stretch [m]."""

_LONGEST_S = 10.0
_RATIO = (0.7, 1.4)
"""Way over speed by time, of all stretches together: mph for km/h is 1.6, knots for m/s 1.9, feet 0.3."""

_AGREEMENT = 0.7  # at 45° the cosine is 0.71


_LONG_M = 3.0
"""Shorter stretches are noise of positions, or too little to tell [m]."""

_EVIDENCE_M = 3.0
_MOST_JUMPS = 0.05
_JUMP_M = 5.0
_JUMP_MPS2 = 5.0
_FASTEST_MPS = 100.0


def is_jump(moved_m: FloatArray, fastest_mps: FloatArray, elapsed_s: float) -> BoolArray:
    """Return which steps no vehicle makes: over 5 m more than at its higher speed and 5 m/s² on top.

    Parameters
    ----------
    moved_m
        Distances moved, (V,) [m].
    fastest_mps
        The higher speed of both ends, (V,) [m/s]; NaN where not known: 100 m/s is then allowed.
    elapsed_s
        Time of the step [s].

    Examples
    --------
    >>> import numpy as np
    >>> is_jump(np.array([1.5, 3.3, 60.0]), np.array([15.0, 15.0, 15.0]), 0.1)
    array([False, False,  True])
    """
    known = np.where(np.isnan(fastest_mps), _FASTEST_MPS, fastest_mps)
    return moved_m > (known + _JUMP_MPS2 * elapsed_s) * elapsed_s + _JUMP_M


class MotionCheck:
    """Gathers how far vehicles came, and how far their speeds say.

    Examples
    --------
    >>> import numpy as np
    >>> check = MotionCheck()
    >>> for k in range(30):
    ...     at = np.array([[1.5 * k, 0.0]])
    ...     check.add(0.1 * k, np.array([7]), at, np.array([15.0]), np.array([np.pi / 2]))
    >>> round(check.ratio, 3), check.fault()
    (1.0, '')
    """

    def __init__(self) -> None:
        self._t_s = -np.inf
        self._ids: IntArray = np.zeros(0, dtype=np.int64)
        self._columns: FloatArray = np.zeros((0, 9))
        self._moved = self._due = 0.0
        self._course = self._across = self._weight = 0.0
        self.pairs = self.jumps = self.stretches = self.off = 0
        self.way_m = self.time_s = 0.0

    def add(
        self,
        t_s: float,
        ids: IntArray,
        position_m: FloatArray,
        speed_mps: FloatArray,
        heading_rad: FloatArray,
    ) -> None:
        """Take in the vehicles of one instant.

        Parameters
        ----------
        t_s
            Time, later than the last [s].
        ids
            Who they are, (V,), each once.
        position_m, speed_mps, heading_rad
            (V, 2) [m], (V,) [m/s], (V,) [rad clockwise from north]; NaN where a speed or heading is unknown.
        """
        # columns: position, speed, heading; of the stretch: its start, way by the speeds, time; jumped
        now = np.column_stack(
            (position_m, speed_mps, heading_rad, position_m, np.zeros((len(ids), 2)), np.zeros(len(ids)))
        )
        _, before, here = np.intersect1d(self._ids, ids, assume_unique=True, return_indices=True)
        old, new = self._columns[before], now[here]
        elapsed_s = t_s - self._t_s
        step = new[:, :2] - old[:, :2]
        moved = np.hypot(step[:, 0], step[:, 1])
        jumped = is_jump(moved, np.maximum(old[:, 2], new[:, 2]), elapsed_s)
        self.pairs += int(before.size)
        self.jumps += int(jumped.sum())
        self._turn(step[~jumped], moved[~jumped], old[~jumped, 3], new[~jumped, 3])
        new[:, 4:6] = old[:, 4:6]
        new[:, 6] = old[:, 6] + 0.5 * (old[:, 2] + new[:, 2]) * elapsed_s
        new[:, 7] = old[:, 7] + elapsed_s
        came = np.hypot(*(new[:, :2] - new[:, 4:6]).T)
        ended = (came >= STRETCH_M) | (new[:, 6] >= STRETCH_M) | (new[:, 7] >= _LONGEST_S)
        self._close(new[ended & ~jumped])
        new[ended | jumped, 4:] = np.column_stack(
            (new[ended | jumped, :2], np.zeros((int((ended | jumped).sum()), 3)))
        )
        now[here] = new
        gone = np.ones(self._ids.size, dtype=np.bool_)
        gone[before[~jumped]] = False
        self._close(self._columns[gone])
        self._t_s, self._ids, self._columns = t_s, ids, now

    def _turn(self, step: FloatArray, moved: FloatArray, old: FloatArray, new: FloatArray) -> None:
        """Set motion against headings."""
        used = (moved >= 0.5) & ~np.isnan(old + new)
        course = np.arctan2(step[used, 0], step[used, 1])
        heading = np.arctan2(np.sin(old) + np.sin(new), np.cos(old) + np.cos(new))[used]
        self._course += float((moved[used] * np.cos(course - heading)).sum())
        self._across += float((moved[used] * np.sin(course - heading)).sum())
        self._weight += float(moved[used].sum())

    def _close(self, rows: FloatArray) -> None:
        """Count the stretches that end with these rows."""
        came = np.hypot(*(rows[:, :2] - rows[:, 4:6]).T)
        self.way_m += float(came.sum())
        self.time_s += float(rows[:, 7].sum())
        due = rows[:, 6]
        long = ~np.isnan(due) & (np.maximum(came, due) >= _LONG_M)
        self._moved += float(came[long].sum())
        self._due += float(due[long].sum())
        self.stretches += int(long.sum())
        self.off += int((long & ((came < 0.5 * due) | (came > 2.0 * due))).sum())

    def finish(self) -> None:
        """Count the stretches that are still open; all vehicles are gone after this."""
        self._close(self._columns)
        self._ids, self._columns = self._ids[:0], self._columns[:0]

    @property
    def has_evidence(self) -> bool:
        """Whether speeds or positions moved far enough to judge."""
        return max(self._moved, self._due) >= _EVIDENCE_M

    @property
    def ratio(self) -> float:
        """Way over what the speeds say; NaN where they say nothing."""
        if self._due > 0.0:
            return self._moved / self._due
        return np.inf if self.has_evidence else np.nan

    @property
    def turn_rad(self) -> float:
        """Mean of course minus heading, NaN where too little moved [rad]."""
        return float(np.arctan2(self._across, self._course)) if self._weight >= _EVIDENCE_M else np.nan

    @property
    def agreement(self) -> float:
        """Mean cosine between headings and motion; NaN where too little moved."""
        return self._course / self._weight if self._weight >= _EVIDENCE_M else np.nan

    def speed_fault(self) -> str:
        """Return in words how positions and speeds disagree, empty where they do not."""
        if self.pairs and self.jumps > _MOST_JUMPS * self.pairs:
            return f"positions do not move as the speeds say: {self.jumps} of {self.pairs} steps are jumps"
        if self.has_evidence and not _RATIO[0] <= self.ratio <= _RATIO[1]:
            return (
                f"positions do not move as the speeds say: they come {self._moved:.3g} m "
                f"where the speeds say {self._due:.3g} m"
            )
        return ""

    def fault(self) -> str:
        """Return in words what disagrees, speeds or headings; empty where all agrees."""
        found = self.speed_fault()
        if not found and self.agreement < _AGREEMENT:
            return (
                "vehicles do not move where their headings point: the mean cosine between both is "
                f"{self.agreement:.2f}"
            )
        return found


def checked(frames: Iterable[FleetFrame]) -> Iterator[FleetFrame]:
    """Yield frames, and refuse them at their end where vehicles did not move as their columns say.

    Parameters
    ----------
    frames
        Complete frames of one run.

    Raises
    ------
    ValueError
        At the end, so that no figure is made of such traffic.
    """
    check = MotionCheck()
    for frame in frames:
        here = frame.active
        check.add(
            frame.t_s,
            frame.vehicle_id[here],
            frame.position_m[here],
            frame.speed_mps[here],
            frame.heading_rad[here],
        )
        yield frame
    check.finish()
    found = check.fault()
    if found:
        raise ValueError(found)
