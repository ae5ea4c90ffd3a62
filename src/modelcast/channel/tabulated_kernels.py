"""Compiled radio from a table: chance of reception by distance and load."""

import numpy as np

from modelcast.channel.cells_kernels import build_cells, cell_span, row_span
from modelcast.channel.random_kernels import uniform
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntMatrix, IntVector, UInt64Vector

__all__ = ["advance"]


@kernel
def advance(
    random: UInt64Vector,
    sender: IntVector,
    ready_s: FloatVector,
    airtime_s: FloatVector,
    message_id: IntVector,
    position_m: FloatMatrix,
    interval_s: float,
    load_range_m: float,
    bin_m: float,
    loads: FloatVector,
    ratios: FloatMatrix,
) -> tuple[IntMatrix, FloatVector, IntMatrix, IntVector, FloatVector]:
    """Carry one interval; ``ratios`` (L, bins) is the table, ``loads`` (L,) its rising loads.

    Returns receptions ((R, 3) integers and their times (R,)), outcomes (bins, 5), expired messages, and the
    load of every vehicle.
    """
    bins = ratios.shape[1]
    range_m = bins * bin_m
    reach_m = max(range_m, load_range_m)
    cells = build_cells(position_m, reach_m)
    load = np.zeros(position_m.shape[0])
    outcomes = np.zeros((bins, 5), dtype=np.int64)
    expired, lapsed = np.empty(sender.size, dtype=np.int64), 0
    who, when, received = np.empty((1024, 3), dtype=np.int64), np.empty(1024), 0
    for turn in range(2):  # first the load of everybody, then who receives
        for n in range(sender.size):
            v = sender[n]
            east, north = position_m[v, 0], position_m[v, 1]
            if not (np.isfinite(east) and np.isfinite(north)):
                if turn == 0:
                    expired[lapsed] = message_id[n]
                    lapsed += 1
                continue
            if turn == 0:
                load[v] += airtime_s[n] / interval_s
            if received + cells.order.size > who.shape[0]:
                rows = 2 * (received + cells.order.size)
                more_who, more_when = np.empty((rows, 3), dtype=np.int64), np.empty(rows)
                more_who[:received], more_when[:received] = who[:received], when[:received]
                who, when = more_who, more_when
            left, right, row_from, row_to = cell_span(cells, east, north, reach_m)
            for row in range(row_from, row_to + 1):
                low, high = row_span(cells, row, left, right)
                for k in range(low, high):
                    j = cells.order[k]
                    away_east, away_north = cells.place[k, 0] - east, cells.place[k, 1] - north
                    distance_m = np.sqrt(away_east * away_east + away_north * away_north)
                    if j == v:
                        continue
                    if turn == 0:
                        if distance_m <= load_range_m:
                            load[j] += airtime_s[n] / interval_s
                        continue
                    group = int(distance_m / bin_m)
                    if group >= bins:
                        continue
                    luck = uniform(random)
                    if luck < np.interp(load[j], loads, ratios[:, group]):
                        outcomes[group, 0] += 1
                        who[received, 0], who[received, 1], who[received, 2] = message_id[n], v, j
                        when[received] = ready_s[n] + airtime_s[n]
                        received += 1
                    elif luck >= ratios[0, group]:
                        outcomes[group, 2] += 1
                    else:
                        outcomes[group, 3] += 1
    for v in range(load.size):
        load[v] = min(load[v], 1.0)
    return who[:received].copy(), when[:received].copy(), outcomes, expired[:lapsed].copy(), load
