"""Cells of a neighbour search: who is near a place, at a cost that grows with the neighbours only."""

from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, IntVector

__all__ = ["CELLS_A_RANGE", "Cells", "build_cells", "cell_row", "cell_span", "row_span"]

CELLS_A_RANGE = 4
"""Cells a range: small cells waste less of what is looked at."""

_MOST_CELLS_AXIS = 512


class Cells(NamedTuple):
    """Vehicles sorted by cell.

    ``order`` (N,) lists the vehicles present, ``start`` (cells + 1,) where each cell begins in it, row after
    row; ``place`` (N, 2) are their positions in that order.
    """

    order: IntVector
    start: IntVector
    place: FloatMatrix
    corner_east_m: float
    corner_north_m: float
    cell_m: float
    columns: int
    rows: int


@kernel
def build_cells(position_m: FloatMatrix, range_m: float) -> Cells:
    """Return the `Cells` of all vehicles whose position (V, 2) is not NaN."""
    vehicles = position_m.shape[0]
    low_e, low_n, high_e, high_n = np.inf, np.inf, -np.inf, -np.inf
    present = 0
    for v in range(vehicles):
        east, north = position_m[v, 0], position_m[v, 1]
        if np.isfinite(east) and np.isfinite(north):
            present += 1
            low_e, high_e = min(low_e, east), max(high_e, east)
            low_n, high_n = min(low_n, north), max(high_n, north)
    if present == 0:
        low_e, low_n, high_e, high_n = 0.0, 0.0, 0.0, 0.0
    span = max(high_e - low_e, high_n - low_n)
    cell_m = max(range_m / CELLS_A_RANGE, span / _MOST_CELLS_AXIS)
    columns, rows = int((high_e - low_e) / cell_m) + 1, int((high_n - low_n) / cell_m) + 1
    start = np.zeros(columns * rows + 1, dtype=np.int64)
    cell = np.full(vehicles, -1, dtype=np.int64)
    for v in range(vehicles):
        east, north = position_m[v, 0], position_m[v, 1]
        if np.isfinite(east) and np.isfinite(north):
            cell[v] = int((north - low_n) / cell_m) * columns + int((east - low_e) / cell_m)
            start[cell[v] + 1] += 1
    for c in range(columns * rows):
        start[c + 1] += start[c]
    order = np.empty(present, dtype=np.int64)
    place = np.empty((present, 2))
    filled = start.copy()
    for v in range(vehicles):
        if cell[v] >= 0:
            at = filled[cell[v]]
            filled[cell[v]] += 1
            order[at] = v
            place[at, 0], place[at, 1] = position_m[v, 0], position_m[v, 1]
    return Cells(order, start, place, low_e, low_n, cell_m, columns, rows)


@kernel(inlined=True)
def _axis_span(at_m: float, corner_m: float, cell_m: float, cells: int, range_m: float) -> tuple[int, int]:
    """Return the first and last cell of one axis that a circle touches; one after the other for none."""
    first = min(max(int((at_m - range_m - corner_m) / cell_m), 0), cells)
    last = max(min(int((at_m + range_m - corner_m) / cell_m), cells - 1), -1)
    return first, last


@kernel(inlined=True)
def cell_span(cells: Cells, east_m: float, north_m: float, range_m: float) -> tuple[int, int, int, int]:
    """Return first and last column and first and last row that a circle touches."""
    left, right = _axis_span(east_m, cells.corner_east_m, cells.cell_m, cells.columns, range_m)
    low, high = _axis_span(north_m, cells.corner_north_m, cells.cell_m, cells.rows, range_m)
    return left, right, low, high


@kernel(inlined=True)
def row_span(cells: Cells, row: int, left: int, right: int) -> tuple[int, int]:
    """Return where in the order the cells of a row begin and end, the end excluded."""
    return cells.start[row * cells.columns + left], cells.start[row * cells.columns + right + 1]


@kernel(inlined=True)
def cell_row(cells: Cells, north_m: float) -> int:
    """Return the row of cells that a place lies in."""
    return int((north_m - cells.corner_north_m) / cells.cell_m)
