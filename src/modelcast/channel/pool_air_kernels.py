"""Compiled air of a pool in one subframe or slot: who sends, what everybody gets, what is decoded.

Modes 4 and 2 share it. The power of a frame is spread evenly over the part of its sub-channels that it fills;
the rest gets what leaks.
"""

from typing import NamedTuple

import numpy as np

from modelcast.channel.antennas import Antennas
from modelcast.channel.cells_kernels import Cells, cell_span, row_span
from modelcast.channel.dsrc_link_kernels import heard_within_m
from modelcast.channel.error_kernels import survives
from modelcast.channel.frame_errors import FrameErrors
from modelcast.channel.frame_link_kernels import Links, links_room
from modelcast.channel.pool_constants import PoolConstants
from modelcast.channel.propagation_kernels import (
    PropagationTables,
    fading_factor,
    is_raised,
    looked_up,
    median_ln,
)
from modelcast.channel.random_kernels import LUCK, next_word, uniform_of, word_of
from modelcast.channel.shadowing_kernels import SILENT, ShadowRows, Sweep
from modelcast.core.exponential_kernels import fast_exp
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    BoolVector,
    FloatCube,
    FloatMatrix,
    FloatVector,
    IntMatrix,
    IntVector,
    UInt64Vector,
)

__all__ = [
    "Air",
    "Around",
    "Turns",
    "add_turn",
    "air_room",
    "find_reach",
    "is_there",
    "judge_frame",
    "measure_busy",
    "receive_frames",
    "sensed_mw",
    "silence",
    "silent_air",
    "surroundings",
]

RECEIVED, HALF_DUPLEX, WEAK, HIDDEN, CONCURRENT = 0, 1, 2, 3, 4
"""As `OUTCOMES` has them."""

_LN_PER_DB = np.log(10.0) / 10.0
_VEHICLE, _BAND, _LENGTH, _BYTES = 0, 1, 2, 3
_POWER_MW, _DISTANCE_M = 0, 1


class Air(NamedTuple):
    """One subframe or slot at V vehicles and in C sub-channels.

    ``power`` (V, C) [mW] in all, ``each`` (turns, V) [mW] from each sender, 0 where too weak to matter; who
    ``sends`` and who ``hears`` anything, (V,).
    """

    power: FloatMatrix
    each: FloatMatrix
    sends: BoolVector
    hears: BoolVector


class Turns(NamedTuple):
    """Who sends, in turn.

    ``who`` (V, 4): vehicle, first sub-channel, length, bytes; ``filled`` (V,): sub-channels that its power is
    on; ``spread`` (V, C): what each sub-channel gets of the power on a filled one; ``power_dbm``; ``place``
    (V, 2); ``seed``; and the first link of each.
    """

    who: IntMatrix
    filled: FloatVector
    spread: FloatMatrix
    power_dbm: FloatVector
    place: FloatMatrix
    seed: IntVector
    first_link: IntVector


class Around(NamedTuple):
    """Where everybody is in this interval, and the antennas; the rest is scratch."""

    position_m: FloatMatrix
    antennas: Antennas
    cells: Cells
    rows: ShadowRows
    who: IntVector
    place: IntVector
    work: FloatMatrix


@kernel
def surroundings(sweep: Sweep, antennas: Antennas) -> Around:
    """Return where everybody is in an interval."""
    room = sweep.cells.order.size + 1
    who, place = np.empty(room, dtype=np.int64), np.empty(room, dtype=np.int64)
    return Around(sweep.position_m, antennas, sweep.cells, sweep.rows, who, place, np.empty((2, room)))


@kernel
def silent_air(vehicles: int, channels: int) -> tuple[Air, Turns]:
    """Return air without power, and room for everybody's turn."""
    air = Air(
        np.zeros((vehicles, channels)),
        np.zeros((8, vehicles)),
        np.zeros(vehicles, dtype=np.bool_),
        np.zeros(vehicles, dtype=np.bool_),
    )
    turns = Turns(
        np.empty((vehicles, 4), dtype=np.int64),
        np.empty(vehicles),
        np.empty((vehicles, channels)),
        np.empty(vehicles),
        np.empty((vehicles, 2)),
        np.empty(vehicles, dtype=np.int64),
        np.empty(vehicles + 1, dtype=np.int64),
    )
    return air, turns


@kernel
def air_room(air: Air, count: int) -> Air:
    """Return the same silent air with room for so many senders."""
    if count <= air.each.shape[0]:
        return air
    return Air(air.power, np.zeros((2 * count, air.each.shape[1])), air.sends, air.hears)


@kernel(inlined=True)
def is_there(v: int, position_m: FloatMatrix) -> bool:
    """Return whether a vehicle is anywhere."""
    return bool(np.isfinite(position_m[v, 0]) and np.isfinite(position_m[v, 1]))


@kernel(inlined=True)
def add_turn(
    turn: int,
    v: int,
    band: int,
    length: int,
    filled: float,
    size_bytes: int,
    power_dbm: float,
    position_m: FloatMatrix,
    leak: FloatCube,
    turns: Turns,
    air: Air,
    random: UInt64Vector,
) -> None:
    """Let a vehicle send, in turn; ``filled`` of the ``length`` sub-channels from ``band`` on bear power."""
    turns.who[turn, _VEHICLE], turns.who[turn, _BAND] = v, band
    turns.who[turn, _LENGTH], turns.who[turn, _BYTES] = length, size_bytes
    turns.filled[turn], turns.power_dbm[turn] = filled, power_dbm
    turns.place[turn, 0], turns.place[turn, 1] = position_m[v, 0], position_m[v, 1]
    turns.seed[turn] = np.int64(next_word(random) >> np.uint64(1))
    for s in range(turns.spread.shape[1]):
        turns.spread[turn, s] = leak[length - 1, band, s]
    for k in range(length):
        turns.spread[turn, band + k] *= min(max(filled - k, 0.0), 1.0)
    air.sends[v] = True


@kernel(inlined=True)
def sensed_mw(power_mw: float, pool: PoolConstants) -> float:
    """Return what a vehicle senses in a sub-channel where it gets this power [mW]."""
    if pool.noise_counts:
        return power_mw + pool.noise_mw
    return power_mw if power_mw >= pool.noise_mw else 0.0


@kernel(inlined=True)
def _reach_m(
    power_dbm: float, gain_ln: float, filled: float, tables: PropagationTables, pool: PoolConstants
) -> float:
    """Return how far a frame over so many sub-channels matters to anybody: by its median power [m]."""
    sent_ln = (pool.gain_db + power_dbm) * _LN_PER_DB + gain_ln
    return heard_within_m(sent_ln, tables, pool.quiet_mw * filled, pool.range_m)


@kernel
def find_reach(
    sender: IntVector,
    filled: FloatVector,
    power_dbm: FloatVector,
    waiting_filled: FloatVector,
    waiting_dbm: FloatVector,
    position_m: FloatMatrix,
    antennas: Antennas,
    tables: PropagationTables,
    pool: PoolConstants,
) -> FloatMatrix:
    """Return the squared reach of what vehicles may send in this interval, as `lay_out` has it.

    Of messages to come, sub-channels filled and power, (N,), and of those that wait at vehicles, (V,), -1
    where none does.
    """
    vehicles, number = waiting_filled.size, sender.size
    reach_m2 = np.full((vehicles, 2), SILENT)
    if not pool.shadowed:
        return reach_m2
    for n in range(number + vehicles):
        v = int(sender[n]) if n < number else n - number
        fills = filled[n] if n < number else waiting_filled[v]
        if fills >= 0.0 and is_there(v, position_m):
            dbm = power_dbm[n] if n < number else waiting_dbm[v]
            heard_m = _reach_m(dbm, antennas.gain_ln[v], fills, tables, pool)
            reach_m2[v] = max(reach_m2[v, 0], heard_m * heard_m)
    return reach_m2


@kernel(inlined=True)
def _find_near(
    v: int, reached_m: float, around: Around, tables: PropagationTables, pool: PoolConstants
) -> int:
    """Write who is within a distance of ``v``, how far away, and logarithms of the gains; return how many.

    Loops that touch few arrays run several at a time, so there are many of them. Every place is written, and
    the next overwrites it unless it is near: a branch would be guessed wrongly too often.
    """
    position_m, cells, rows, work = around.position_m, around.cells, around.rows, around.work
    east, north = position_m[v, 0], position_m[v, 1]
    left, right, row_from, row_to = cell_span(cells, east, north, reached_m)
    most_m2, count = reached_m * reached_m, 0
    for row in range(row_from, row_to + 1):
        low, high = row_span(cells, row, left, right)
        begin, end = np.uint64(low), np.uint64(high)
        start = np.uint64(rows.start[rows.first[v] + row]) if pool.shadowed else np.uint64(0)
        for k in range(begin, end):
            away_east, away_north = cells.place[k, 0] - east, cells.place[k, 1] - north
            square, j = away_east * away_east + away_north * away_north, cells.order[k]
            around.who[count], around.place[count] = j, np.int64(start + k)
            work[_DISTANCE_M, count] = square
            count += int((square <= most_m2) & (j != v))
    for n in range(count):
        work[_DISTANCE_M, n] = np.sqrt(work[_DISTANCE_M, n])
    if tables.nlos_kind == 0 and tables.raised == 0:
        for n in range(count):
            work[_POWER_MW, n] = looked_up(tables.los_ln, work[_DISTANCE_M, n] * tables.per_m)
        if pool.shadowed:
            for n in range(count):
                work[_POWER_MW, n] += tables.shadowing_los_ln * np.float64(rows.value[around.place[n]])
        return count
    for n in range(count):
        j, distance_m = around.who[n], work[_DISTANCE_M, n]
        raised = is_raised(v, j, position_m.shape[0], tables.raised)
        ln, los = median_ln(east, north, position_m[j, 0], position_m[j, 1], distance_m, raised, tables)
        if pool.shadowed:
            sigma = tables.shadowing_los_ln if los else tables.shadowing_nlos_ln
            ln += sigma * np.float64(rows.value[around.place[n]])
        work[_POWER_MW, n] = ln
    return count


@kernel(inlined=True)
def _receive_powers(
    turn: int,
    turns: Turns,
    air: Air,
    links: Links,
    used: int,
    around: Around,
    tables: PropagationTables,
    pool: PoolConstants,
) -> int:
    """Add the power of one sender to the vehicles in reach; return how many links there are.

    Who is beyond its reach has a link if it counts among the outcomes.
    """
    v, filled = int(turns.who[turn, _VEHICLE]), float(turns.filled[turn])
    seed, gain_ln, who, work = int(turns.seed[turn]), around.antennas.gain_ln, around.who, around.work
    sent_ln = (pool.gain_db + turns.power_dbm[turn]) * _LN_PER_DB + gain_ln[v]
    heard_m = _reach_m(turns.power_dbm[turn], gain_ln[v], filled, tables, pool)
    counted_m = min(pool.bins * pool.bin_m, pool.range_m)
    count = _find_near(v, max(heard_m, counted_m), around, tables, pool)
    for n in range(count):
        work[_POWER_MW, n] = fast_exp(sent_ln + min(work[_POWER_MW, n], 0.0) + gain_ln[who[n]])
    if tables.fading.shape[1] > 1:
        for n in range(count):
            work[_POWER_MW, n] *= fading_factor(
                work[_DISTANCE_M, n],
                word_of(seed, who[n]),
                tables.fading,
                tables.fading_near_m,
                tables.fading_far_m,
            )
    quiet_mw, each, power, spread = pool.quiet_mw * filled, air.each, air.power, turns.spread
    for n in range(count):
        j, power_mw = who[n], work[_POWER_MW, n]
        group = min(int(work[_DISTANCE_M, n] / pool.bin_m), pool.bins)
        if power_mw < quiet_mw or work[_DISTANCE_M, n] > heard_m:
            if group < pool.bins:
                links.receiver[used], links.mw[used], links.bin[used] = j, 0.0, group
                used += 1
            continue
        links.receiver[used], links.mw[used], links.bin[used] = j, power_mw, group
        used += 1
        air.hears[j] = True
        each[turn, j] = power_mw
        share_mw = power_mw / filled
        for s in range(pool.sub_channels):
            power[j, s] += share_mw * spread[turn, s]
    return used


@kernel
def receive_frames(
    count: int,
    turns: Turns,
    air: Air,
    links: Links,
    around: Around,
    tables: PropagationTables,
    pool: PoolConstants,
) -> tuple[Links, int]:
    """Let everybody in reach get the power of all frames; return the links, and how many there are."""
    used, present = 0, around.cells.order.size
    for turn in range(count):
        links = links_room(links, used, present)
        turns.first_link[turn] = used
        used = _receive_powers(turn, turns, air, links, used, around, tables, pool)
    turns.first_link[count] = used
    return links, used


@kernel(inlined=True)
def _other_power(j: int, power_mw: float, turn: int, turns: Turns, air: Air) -> float:
    """Return the power of others over the sub-channels of a frame [mW]; 0 where there is none."""
    band, length = turns.who[turn, _BAND], turns.who[turn, _LENGTH]
    share_mw, other_mw = power_mw / turns.filled[turn], 0.0
    for s in range(band, band + length):
        other_mw += max(air.power[j, s] - share_mw * turns.spread[turn, s], 0.0)
    return other_mw


@kernel(inlined=True)
def _strongest_other(j: int, turn: int, count: int, turns: Turns, air: Air) -> int:
    """Return whose turn disturbs a frame most at a receiver."""
    band, length = turns.who[turn, _BAND], turns.who[turn, _LENGTH]
    worst_mw, worst = 0.0, turn
    for other in range(count):
        power_mw = air.each[other, j]
        if other == turn or power_mw == 0.0:
            continue
        total = 0.0
        for s in range(band, band + length):
            total += turns.spread[other, s]
        share_mw = power_mw / turns.filled[other]
        if share_mw * total > worst_mw:
            worst_mw, worst = share_mw * total, other
    return worst


@kernel(inlined=True)
def _judge(
    j: int,
    power_mw: float,
    other_mw: float,
    turn: int,
    count: int,
    turns: Turns,
    air: Air,
    errors: FrameErrors,
    pool: PoolConstants,
) -> int:
    """Return what became of a frame at a listening receiver."""
    size_bytes, noise_mw = turns.who[turn, _BYTES], pool.noise_mw * turns.filled[turn]
    hopeless_ratio = errors.hopeless_ratio[size_bytes]
    counted_mw = power_mw / errors.needed_ratio[size_bytes]
    clear_ratio, ratio = counted_mw / noise_mw, counted_mw / (noise_mw + other_mw)
    if power_mw < pool.sensitivity_mw or clear_ratio < hopeless_ratio:
        return WEAK
    if ratio >= errors.safe_ratio:
        return RECEIVED
    chance = uniform_of(int(turns.seed[turn]), j + LUCK)
    if ratio >= hopeless_ratio and survives(ratio, chance, size_bytes, errors):
        return RECEIVED
    if other_mw == 0.0 or not survives(clear_ratio, chance, size_bytes, errors):
        return WEAK
    worst = _strongest_other(j, turn, count, turns, air)
    east = turns.place[turn, 0] - turns.place[worst, 0]
    north = turns.place[turn, 1] - turns.place[worst, 1]
    sensed_m = pool.sensing_range_m
    return CONCURRENT if east * east + north * north <= sensed_m * sensed_m else HIDDEN


@kernel(inlined=True)
def judge_frame(
    turn: int,
    count: int,
    turns: Turns,
    air: Air,
    links: Links,
    errors: FrameErrors,
    pool: PoolConstants,
) -> None:
    """Write what became of a frame at each of its links, and the power of others there."""
    for k in range(turns.first_link[turn], turns.first_link[turn + 1]):
        j, power_mw = int(links.receiver[k]), float(links.mw[k])
        links.outcome[k], links.other_mw[k] = WEAK, 0.0
        if air.sends[j]:
            links.outcome[k], links.other_mw[k] = HALF_DUPLEX, np.inf
        elif power_mw > 0.0:
            other_mw = _other_power(j, power_mw, turn, turns, air)
            links.other_mw[k] = other_mw
            links.outcome[k] = _judge(j, power_mw, other_mw, turn, count, turns, air, errors, pool)


@kernel(inlined=True)
def silence(
    count: int,
    turns: Turns,
    links: Links,
    air: Air,
    busy: IntMatrix,
    pool: PoolConstants,
) -> None:
    """Count the busy sub-channels at everybody who listens, (V, 2), and make the air silent again."""
    for turn in range(count):
        for k in range(turns.first_link[turn], turns.first_link[turn + 1]):
            j = links.receiver[k]
            air.each[turn, j] = 0.0
            if air.hears[j]:
                air.hears[j] = False
                loud = 0
                for s in range(pool.sub_channels):
                    loud += int(sensed_mw(air.power[j, s], pool) > pool.load_mw)
                    air.power[j, s] = 0.0
                busy[j, 0] += 0 if air.sends[j] else loud
    for turn in range(count):
        busy[turns.who[turn, _VEHICLE], 1] += 1
        air.sends[turns.who[turn, _VEHICLE]] = False


@kernel(inlined=True)
def measure_busy(busy: IntMatrix, busy_ratio: FloatVector, pool: PoolConstants) -> None:
    """Work out the busy ratios of the window that ends, from what `silence` counted."""
    for v in range(busy.shape[0]):
        listened = (pool.window - busy[v, 1]) * pool.sub_channels
        # Where nobody sends, nothing is counted: there, noise alone decides.
        loud = listened if sensed_mw(0.0, pool) > pool.load_mw else busy[v, 0]
        busy_ratio[v] = loud / max(listened, 1)
        busy[v, 0], busy[v, 1] = 0, 0
