"""Plausibility of what remotes say, by the laws of motion and by what they said before.

A signature tells who spoke, not whether it is true: a broken sensor's numbers are signed like any other. The
checks here need the messages alone, and no model: two instants, two positions, the velocities stated at both.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from types import MappingProxyType

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.station.receiver import plausibility_kernels
from modelcast.station.receiver.plausibility_limits import DEFAULT_LIMITS, PlausibilityLimits
from modelcast.station.receiver.statements import Statements, statements_of
from modelcast.trips.trajectory import Trajectory

__all__ = ["Finding", "Plausibility", "PlausibilityState", "trip_findings"]


class Finding(IntEnum):
    """What a check found; the tests are made in this order, the first that fails counts."""

    PLAUSIBLE = 0
    IN_FUTURE = 1
    STALE = 2
    REPEATED = 3
    OVERTAKEN = 4
    POSITION_JUMP = 5
    SPEED_MISMATCH = 6
    STUCK_SPEED = 7

    @property
    def reason(self) -> str:
        """In words."""
        return _REASONS[self]


_REASONS = {
    Finding.PLAUSIBLE: "plausible",
    Finding.IN_FUTURE: "dated in the future",
    Finding.STALE: "too old on arrival, as if replayed",
    Finding.REPEATED: "repeated instant",
    Finding.OVERTAKEN: "older than one already judged",
    Finding.POSITION_JUMP: "position jump",
    Finding.SPEED_MISMATCH: "speed against displacement",
    Finding.STUCK_SPEED: "stuck speed",
}


def _no_vehicles() -> IntArray:
    return np.empty(0, dtype=np.int64)


def _no_rows() -> FloatArray:
    return np.empty((0, plausibility_kernels.COLUMNS))


def _no_counts() -> IntArray:
    return np.zeros(len(Finding), dtype=np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class PlausibilityState:
    """What was said before by V remotes, and what was found so far.

    Parameters
    ----------
    vehicle
        Temporary ids, rising, (V,).
    rows
        Numbers of each remote, (V, `plausibility_kernels.COLUMNS`).
    counts
        Messages of each `Finding`, (F,).
    """

    vehicle: IntArray = field(default_factory=_no_vehicles)
    rows: FloatArray = field(default_factory=_no_rows)
    counts: IntArray = field(default_factory=_no_counts)

    @property
    def by_reason(self) -> Mapping[Finding, int]:
        """Messages of each finding that occurred."""
        return MappingProxyType({one: int(self.counts[one]) for one in Finding if self.counts[one]})


@dataclass(frozen=True, slots=True)
class Plausibility:
    """Judges messages by the laws of motion.

    Parameters
    ----------
    limits
        What is let through.
    memory_s
        A remote of which nothing entered for so long is forgotten [s]; its next message is a first one.

    Raises
    ------
    ValueError
        Where ``memory_s`` is not positive and finite.

    Notes
    -----
    *Position jump*: farther from the last position than ``max_speed_mps`` times the time between, plus
    ``position_tolerance_m``. A message that jumped does not count as last: one bad fix is one bad message,
    and a move that lasts is believed as soon as a vehicle could have made it.

    *Speed against displacement*: for any motion with accelerations up to A, the displacement over a step dt
    differs from the mean of the velocities at both ends times dt by at most A dt²/4, since it does by the
    integral of a(s)(dt/2 - s). These bounds are added up over a window, with the tolerances of position
    and speed, and compared with the difference of two lengths, of the displacement and of the stated one. So
    a constant error of the heading does not count. A message also fails where the last whole window did, or
    where it states a speed over ``max_speed_mps``.

    *Stuck speed*: the same, where the stated speed has not changed for ``stuck_after_s``. The window is then
    longer, up to ``stuck_window_s``. A constant speed that agrees with the displacement is plausible.

    Examples
    --------
    >>> from modelcast.station.receiver.statements import Statements
    >>> moving = Statements(
    ...     np.full(60, 7),
    ...     np.arange(60) * 0.1,
    ...     position_m=np.stack([np.arange(60) * 2.2, np.zeros(60)], axis=1),
    ...     velocity_mps=np.tile([5.0, 0.0], (60, 1)),
    ...     received_s=np.arange(60) * 0.1,
    ... )
    >>> findings, state = Plausibility().check(PlausibilityState(), moving)
    >>> {finding.name: count for finding, count in state.by_reason.items()}
    {'PLAUSIBLE': 2, 'SPEED_MISMATCH': 18, 'STUCK_SPEED': 40}
    """

    limits: PlausibilityLimits = DEFAULT_LIMITS
    memory_s: float = 60.0

    def __post_init__(self) -> None:
        if not 0 < self.memory_s < np.inf:
            raise ValueError(f"memory_s must be positive and finite, got {self.memory_s}")

    def check(self, state: PlausibilityState, reports: Statements) -> tuple[IntArray, PlausibilityState]:
        """Findings of messages in order, (B,), and the new state.

        Parameters
        ----------
        state
            What was said before.
        reports
            What the messages say.
        """
        if reports.vehicle.size == 0:
            return np.empty(0, dtype=np.int64), state
        fresh = state.rows[:, 0] >= reports.received_s.min() - self.memory_s
        vehicle, rows = state.vehicle[fresh], state.rows[fresh]
        of = np.searchsorted(vehicle, reports.vehicle)
        if (of == vehicle.size).any() or (vehicle[of] != reports.vehicle).any():
            vehicle, rows = _with_new(vehicle, rows, reports.vehicle)
            of = np.searchsorted(vehicle, reports.vehicle)
        findings = np.empty(reports.vehicle.size, dtype=np.int64)
        plausibility_kernels.judge(
            rows,
            of,
            reports.t_s,
            reports.position_m,
            reports.velocity_mps,
            reports.received_s,
            self.limits.numbers,
            findings,
        )
        entered = ~np.isnan(rows[:, 0])
        if not entered.all():
            vehicle, rows = vehicle[entered], rows[entered]
        more = np.bincount(findings, minlength=len(Finding))
        return findings, PlausibilityState(vehicle, rows, state.counts + more)


def _with_new(known: IntArray, held: FloatArray, reported: IntArray) -> tuple[IntArray, FloatArray]:
    """Remotes known and reported, by rising id, and their rows, empty for the new ones."""
    vehicle = np.union1d(known, reported)
    rows = np.full((vehicle.size, plausibility_kernels.COLUMNS), np.nan)
    rows[np.searchsorted(vehicle, known)] = held
    return vehicle, rows


def trip_findings(trip: Trajectory, checks: Plausibility | None = None) -> Mapping[Finding, int] | None:
    """Samples of a trip by finding, as if each were a message; None without columns of speed and heading.

    Parameters
    ----------
    trip
        A recorded trip.
    checks
        What judges; the default limits where None.
    """
    reports = statements_of(trip)
    if reports is None:
        return None
    _, state = (checks or Plausibility()).check(PlausibilityState(), reports)
    return state.by_reason
