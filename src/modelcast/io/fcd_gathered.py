"""What is gathered of a file of floating-car data while it is read once."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import Origin
from modelcast.core.kinds import Kind
from modelcast.io.base import Tally
from modelcast.io.fcd_columns import FcdRow
from modelcast.io.fcd_times import in_metres
from modelcast.world.scenario.motion import MotionCheck

__all__ = ["HEADING", "LENGTH", "SPEED", "Gathered"]

SPEED, HEADING, LENGTH = 2, 3, 6
"""Columns of a row's numbers."""


@dataclass(slots=True)
class Gathered:
    """What was gathered so far.

    Parameters
    ----------
    tally, rows
        Rows that are no vehicles by what they are, and all rows.
    times
        Of all time steps [s].
    names, most
        Vehicles, and how many there were at most at one time.
    visits, alone
        How often a vehicle came, and how often it was there at one time only.
    people
        Names of those that are no vehicles, by kind.
    unknown
        Rows without a speed, a heading, a length.
    low, high
        Least and largest x and y.
    inside, origin
        Whether all x and y could be longitude and latitude, and the first of them.
    metres, degrees
        How vehicles move if x and y are metres, and if they are longitude and latitude.
    """

    tally: Tally = field(default_factory=Tally)
    rows: int = 0
    times: list[float] = field(default_factory=list[float])
    names: set[str] = field(default_factory=set[str])
    most: int = 0
    visits: int = 0
    alone: int = 0
    people: dict[Kind, set[str]] = field(default_factory=dict[Kind, set[str]])
    unknown: tuple[int, int, int] = (0, 0, 0)
    low: FloatArray = field(default_factory=lambda: np.full(2, inf))
    high: FloatArray = field(default_factory=lambda: np.full(2, -inf))
    inside: bool = True
    origin: Origin | None = None
    metres: MotionCheck = field(default_factory=MotionCheck)
    degrees: MotionCheck = field(default_factory=MotionCheck)
    _present: dict[str, tuple[int, int]] = field(default_factory=dict[str, tuple[int, int]])

    @property
    def extent(self) -> float:
        """Width of the area of all positions, in their unit."""
        return float((self.high - self.low).max())

    def add(self, rows: Sequence[FcdRow]) -> None:
        """Take in the rows of one time.

        Parameters
        ----------
        rows
            At least one.
        """
        self.rows += len(rows)
        self.times.append(rows[0].t_s)
        for row in rows:
            if row.skipped:
                self.tally.skip(row.skipped, 1)
        here = [row for row in rows if not row.skipped]
        self.most = max(self.most, len(here))
        for row in here:
            if row.kind != Kind.VEHICLE:
                self.people.setdefault(row.kind, set()).add(row.vehicle)
        self._visit([row.vehicle for row in here])
        numbers = np.array([row.numbers for row in here]).reshape(-1, 7)
        speed, heading, length = (int(np.isnan(numbers[:, at]).sum()) for at in (SPEED, HEADING, LENGTH))
        self.unknown = (self.unknown[0] + speed, self.unknown[1] + heading, self.unknown[2] + length)
        self._move(rows[0].t_s, numbers)

    def _visit(self, vehicles: Sequence[str]) -> None:
        """Give who comes a number of its own, and count who leaves after one time."""
        before, self._present = self._present, {}
        for vehicle in vehicles:
            known = before.pop(vehicle, None)
            if known is None:
                known, self.visits = (self.visits, 0), self.visits + 1
            self._present[vehicle] = (known[0], known[1] + 1)
        self.alone += sum(times == 1 for _, times in before.values())
        self.names.update(self._present)

    def _move(self, t_s: float, numbers: FloatArray) -> None:
        """Follow the vehicles, by both meanings of x and y."""
        ids = np.array([number for number, _ in self._present.values()], dtype=np.int64)
        place, speed, heading = numbers[:, :2], numbers[:, SPEED], numbers[:, HEADING]
        self.metres.add(t_s, ids, place, speed, heading)
        if not len(numbers):
            self.degrees.add(t_s, ids, place, speed, heading)
            return
        self.low = np.minimum(self.low, place.min(axis=0))
        self.high = np.maximum(self.high, place.max(axis=0))
        self.inside = self.inside and bool((np.abs(place) <= (180.0, 90.0)).all())
        if self.inside:
            if self.origin is None:
                self.origin = Origin(float(place[0, 1]), float(place[0, 0]))
            self.degrees.add(t_s, ids, in_metres(numbers, self.origin), speed, heading)

    def finish(self) -> None:
        """Count what is still open at the end of the file."""
        self.metres.finish()
        self.degrees.finish()
