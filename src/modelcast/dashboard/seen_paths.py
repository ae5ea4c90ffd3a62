"""The road drawn from the data: the ways on which the host and its remotes were seen to drive."""

import math
from collections.abc import Iterable

import numpy as np

from modelcast.core.arrays import FloatArray

__all__ = ["SeenPaths"]

_STEP_M = 4.0
_BREAK_M = 60.0
_CELL_M = 3.0
_SECTORS = 8


class SeenPaths:
    """Polylines that grow where somebody drives a way for the first time.

    A point is kept every 4 m. One that falls into a cell of 3 m through which a way of that direction (of
    eight) leads already adds nothing, so traffic that goes round and round leaves one line a lane. A line
    ends there, and where a vehicle jumps by more than 60 m.

    Parameters
    ----------
    most_points
        When so many are kept, no more are added.

    Examples
    --------
    >>> seen = SeenPaths()
    >>> for t in range(20):
    ...     seen.add([(7, 2.0 * t, 0.0)])
    >>> [line.shape for line in seen.lines_m()]
    [(10, 2)]
    """

    def __init__(self, most_points: int = 10_000) -> None:
        if most_points < 2:
            raise ValueError(f"most_points must be at least 2, got {most_points}")
        self._most_points = most_points
        self._lines: list[list[tuple[float, float]]] = []
        self._open: dict[int, list[tuple[float, float]] | None] = {}
        self._last: dict[int, tuple[float, float]] = {}
        self._taken: set[tuple[int, int, int]] = set()
        self.points = 0
        """Points kept; it grows with every change."""

    def add(self, places: Iterable[tuple[int, float, float]]) -> None:
        """Take in where vehicles are at one time; who is missing has left.

        Parameters
        ----------
        places
            Vehicle, east and north [m]; finite.
        """
        last: dict[int, tuple[float, float]] = {}
        for vehicle, east_m, north_m in places:
            last[vehicle] = self._moved(vehicle, (east_m, north_m))
        self._last = last
        self._open = {vehicle: line for vehicle, line in self._open.items() if vehicle in last}

    def lines_m(self) -> list[FloatArray]:
        """The ways of two points or more, (P, 2) each [m]."""
        return [np.array(line) for line in self._lines if len(line) > 1]

    def _moved(self, vehicle: int, here: tuple[float, float]) -> tuple[float, float]:
        """Take one place in, and return the place that the next is held against."""
        before = self._last.get(vehicle)
        if before is None:
            return here
        gone_m = math.dist(before, here)
        if gone_m < _STEP_M:
            return before
        if gone_m > _BREAK_M:
            self._open[vehicle] = None
            return here
        cells = _cells(before, here, gone_m)
        line = self._open.get(vehicle)
        if cells[-1] in self._taken or self.points + 2 > self._most_points:
            if line is not None and self.points < self._most_points:
                line.append(here)  # so that lines meet
                self.points += 1
            self._open[vehicle] = None
            return here
        self._taken.update(cells)
        if line is None:
            line = [before]
            self._lines.append(line)
            self._open[vehicle] = line
            self.points += 1
        line.append(here)
        self.points += 1
        return here


def _cells(
    before: tuple[float, float], here: tuple[float, float], gone_m: float
) -> list[tuple[int, int, int]]:
    """The cells from one place to another, with the direction; the last is that of the other."""
    east_m, north_m = here[0] - before[0], here[1] - before[1]
    sector = round(math.atan2(north_m, east_m) / (2.0 * math.pi) * _SECTORS) % _SECTORS
    pieces = math.ceil(gone_m / (0.4 * _CELL_M))
    shares = [piece / pieces for piece in range(pieces + 1)]
    return [
        (
            math.floor((before[0] + share * east_m) / _CELL_M),
            math.floor((before[1] + share * north_m) / _CELL_M),
            sector,
        )
        for share in shares
    ]
