"""Compiled radio from a table: chance of reception by distance and load."""

from typing import NamedTuple

import numpy as np

from modelcast.channel.cells_kernels import build_cells, cell_span, row_span
from modelcast.channel.propagation_kernels import PropagationTables, is_raised, looked_up, median_ln
from modelcast.channel.random_kernels import uniform
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    FloatCube,
    FloatMatrix,
    FloatVector,
    IntMatrix,
    IntVector,
    UInt64Vector,
)

__all__ = ["Sensed", "advance"]

_DB_PER_LN = 10.0 / np.log(10.0)


class Sensed(NamedTuple):
    """Who senses which frame.

    ``over_db`` (N,) is how far each frame's transmit power is above the bound, ``reach_m`` how far the
    loudest is sensed; ``shares`` (2, 3, K) are those of `modelcast.channel.sensed_share.sensed_shares`, from
    ``-margin_db`` to ``margin_db``.
    """

    over_db: FloatVector
    reach_m: float
    margin_db: float
    shares: FloatCube
    tables: PropagationTables


@kernel(inlined=True)
def _share(
    v: int,
    j: int,
    position_m: FloatMatrix,
    distance_m: float,
    over_db: float,
    sensed: Sensed,
) -> float:
    """Return the chance that vehicle ``j`` senses a frame of vehicle ``v``."""
    tables = sensed.tables
    ln, los = median_ln(
        position_m[v, 0],
        position_m[v, 1],
        position_m[j, 0],
        position_m[j, 1],
        distance_m,
        is_raised(v, j, position_m.shape[0], tables.raised),
        tables,
    )
    margin_db = over_db + _DB_PER_LN * ln
    near = 0 if distance_m < tables.fading_near_m else (1 if distance_m < tables.fading_far_m else 2)
    shares = sensed.shares[0 if los else 1, near]
    if margin_db <= -sensed.margin_db:
        return 0.0
    last = shares.size - 1
    return looked_up(shares, min(0.5 * last * (margin_db / sensed.margin_db + 1.0), np.float64(last)))


@kernel
def advance(
    random: UInt64Vector,
    sender: IntVector,
    ready_s: FloatVector,
    airtime_s: FloatVector,
    message_id: IntVector,
    position_m: FloatMatrix,
    interval_s: float,
    sensed: Sensed,
    bin_m: float,
    loads: FloatVector,
    ratios: FloatMatrix,
) -> tuple[IntMatrix, FloatVector, IntMatrix, IntVector, FloatVector]:
    """Carry one interval; ``ratios`` (L, bins) is the table, ``loads`` (L,) its rising loads; see `Sensed`.

    Returns receptions ((R, 3) integers and their times (R,)), outcomes (bins, 5), expired messages, and the
    load of every vehicle.
    """
    bins = ratios.shape[1]
    range_m = bins * bin_m
    reach_m = max(range_m, sensed.reach_m)
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
                        if distance_m <= sensed.reach_m:
                            share = _share(v, j, position_m, distance_m, sensed.over_db[n], sensed)
                            load[j] += share * airtime_s[n] / interval_s
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
    return who[:received].copy(), when[:received].copy(), outcomes, expired[:lapsed].copy(), load
