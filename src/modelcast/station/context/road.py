"""The road as driven before: a memory of bounded size that cells go into while driving, and what it tells.

Everything is causal: at each sample a car knows what was driven before, by itself at least
`drive_kernels.HELD_S` ago or by others whose drives it was given.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray, owned
from modelcast.models.context_columns import CONTEXT_COLUMNS
from modelcast.models.point_kernels import SAMPLE_COLUMNS
from modelcast.station.context import drive_kernels, road_kernels
from modelcast.station.context.drive_kernels import Drives
from modelcast.station.context.road_kernels import CELL_M, CELL_NUMBERS, NOWHERE, Roads

__all__ = [
    "MOST_CELLS",
    "NO_ROADS",
    "RoadCells",
    "drives",
    "joined",
    "road_cells",
    "road_columns",
    "roads",
    "roads_of",
    "stored",
]

MOST_CELLS = 20_000
"""Cells of a car's memory of its own drives: 100 km."""


@dataclass(frozen=True, slots=True, eq=False)
class RoadCells:
    """Cells of roads driven, K of them, in the order in which they were passed.

    Parameters
    ----------
    numbers
        East, north [m], and the heading, clockwise from north and unwrapped along each pass [rad], (K, 3).
    passes
        The pass that each belongs to, (K,): cells of one follow each other, `road_kernels.CELL_M` apart.

    Raises
    ------
    ValueError
        Where shapes do not agree, a number is not finite, or a pass is left and taken up again.
    """

    numbers: FloatArray
    passes: IntArray

    def __post_init__(self) -> None:
        count = self.passes.size
        if self.passes.ndim != 1 or self.numbers.shape != (count, CELL_NUMBERS):
            raise ValueError(
                f"numbers must be ({count}, {CELL_NUMBERS}) for {count} passes, got {self.numbers.shape}"
            )
        if not np.isfinite(self.numbers).all():
            raise ValueError("cells must be finite")
        changes = np.count_nonzero(np.diff(self.passes))
        if count and np.unique(self.passes).size != changes + 1:
            raise ValueError("cells of one pass must follow each other")

    def __len__(self) -> int:
        return int(self.passes.size)

    @property
    def length_m(self) -> float:
        """Length of road that the cells stand for, a pass over the same road counted again [m]."""
        return len(self) * CELL_M


def roads(memories: int, cells: int) -> Roads:
    """Return memories that hold nothing.

    Parameters
    ----------
    memories, cells
        R and N, both at least 1.

    Notes
    -----
    A cell takes 24 to 28 bytes: three single-precision numbers, its pass, its link and its share of the grid.
    """
    buckets = 1 << max(cells - 1, 1).bit_length()
    return Roads(
        np.zeros((memories, cells, CELL_NUMBERS), dtype=np.float32),
        np.full((memories, cells), -1, dtype=np.int32),
        np.full((memories, cells), NOWHERE, dtype=np.int32),
        np.full((memories, buckets), NOWHERE, dtype=np.int32),
        np.zeros(memories, dtype=np.int64),
    )


def joined(parts: Sequence[RoadCells]) -> RoadCells:
    """Cells of several drives one after another, their passes kept apart.

    Parameters
    ----------
    parts
        In order, at least one.
    """
    numbered: list[IntArray] = []
    first = 0
    for one in parts:
        numbered.append(one.passes - one.passes.min(initial=0) + first)
        first = int(numbered[-1].max(initial=first)) + 1
    return RoadCells(np.concatenate([one.numbers for one in parts]), np.concatenate(numbered))


NO_ROADS = roads(1, 1)
"""A memory of nothing, for where none is shared. Nobody writes into it."""


def roads_of(cells: RoadCells, most: int | None = None) -> Roads:
    """Return one memory that holds these cells.

    Parameters
    ----------
    cells
        What to hold.
    most
        Cells that there is room for; the first give way. None for all.
    """
    found = roads(1, max(len(cells), 1) if most is None else most)
    road_kernels.store_cells(found, 0, owned(cells.numbers), owned(cells.passes, np.int64))
    return found


def drives(vehicles: int) -> Drives:
    """Return vehicles that have not moved.

    Parameters
    ----------
    vehicles
        V.
    """
    numbers = np.zeros((vehicles, drive_kernels.NUMBERS), dtype=np.int64)
    numbers[:, drive_kernels.MATCHED :] = NOWHERE
    return Drives(
        np.zeros((vehicles, drive_kernels.MARKS, 3)),
        numbers,
        np.full((vehicles, drive_kernels.PLACES), np.nan),
    )


def road_columns(
    t_s: FloatArray, samples: FloatArray, *, shared: Roads = NO_ROADS, most: int = MOST_CELLS
) -> FloatArray:
    """Road's columns of the context at every sample of one drive, (T, 13); the others are zero.

    Parameters
    ----------
    t_s
        Times, (T,) [s].
    samples
        What was sensed, (T, 9) as `modelcast.models.base.Windows` has them.
    shared
        Memory of other drives, all before this one.
    most
        Cells of the own drive that there is room for.

    Examples
    --------
    Two laps of a circle of 100 m: on the second, the road turns by v t / R.

    >>> t = np.arange(0.0, 130.0, 0.1)
    >>> angle = 0.1 * t
    >>> position = 100.0 * np.stack([np.sin(angle), np.cos(angle)], axis=1)
    >>> velocity = 10.0 * np.stack([np.cos(angle), -np.sin(angle)], axis=1)
    >>> samples = np.column_stack([position, velocity, np.zeros((t.size, 3))])
    >>> context = road_columns(t, samples)
    >>> context[300, 12], context[1200, 12], context[1200, 5:8].round(2).tolist()
    (np.float64(0.0), np.float64(1.0), [0.1, 0.2, 0.3])
    """
    out = np.zeros((t_s.size, CONTEXT_COLUMNS))
    drive_kernels.drive_through(
        drives(1), roads(1, most), shared, owned(t_s), owned(samples[:, :SAMPLE_COLUMNS]), out
    )
    return out


def road_cells(t_s: FloatArray, samples: FloatArray, *, first_pass: int = 0) -> RoadCells:
    """All cells of one drive.

    Parameters
    ----------
    t_s, samples
        As for `road_columns`.
    first_pass
        Number of its first pass.
    """
    way_m = float(np.hypot(*np.diff(samples[:, :2], axis=0).T).sum()) if t_s.size > 1 else 0.0
    held = roads(1, int(min(way_m, 1e7) / CELL_M) + 2)
    driven = drives(1)
    driven.numbers[0, drive_kernels.PASS] = first_pass - 1
    nothing = np.empty((t_s.size, CONTEXT_COLUMNS))
    drive_kernels.drive_through(
        driven, held, NO_ROADS, owned(t_s), owned(samples[:, :SAMPLE_COLUMNS]), nothing
    )
    drive_kernels.end_drive(driven, 0, held, 0)
    return stored(held)


def stored(memory: Roads) -> RoadCells:
    """What the first memory holds, the oldest first.

    Parameters
    ----------
    memory
        Any.
    """
    count, length = int(memory.filled[0]), memory.passes.shape[1]
    number: IntArray = np.arange(count, dtype=np.int64)[-length:]
    order = number % length
    return RoadCells(memory.cells[0, order].astype(np.float64), memory.passes[0, order].astype(np.int64))
