"""Compiled air of one slot: who sends, what power everybody gets in each sub-channel, and what is decoded.

A frame's power is spread evenly over the sub-channels of its resource; the rest gets what leaks.
"""

from typing import NamedTuple

import numpy as np

from modelcast.channel.antennas import Antennas
from modelcast.channel.cells_kernels import Cells, cell_span, row_span
from modelcast.channel.dsrc_link_kernels import heard_within_m
from modelcast.channel.error_kernels import hazard_at
from modelcast.channel.frame_link_kernels import Links
from modelcast.channel.nr_selection_kernels import NrConstants
from modelcast.channel.propagation_kernels import (
    PropagationTables,
    fading_factor,
    is_raised,
    looked_up,
    median_ln,
)
from modelcast.channel.random_kernels import LUCK, uniform_of, word_of
from modelcast.channel.shadowing_kernels import ShadowRows
from modelcast.core.exponential_kernels import fast_exp
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    BoolVector,
    FloatCube,
    FloatMatrix,
    FloatVector,
    IntMatrix,
    IntVector,
)

__all__ = [
    "CONCURRENT",
    "HALF_DUPLEX",
    "HIDDEN",
    "RECEIVED",
    "WEAK",
    "Air",
    "Around",
    "Errors",
    "Turns",
    "air_room",
    "judge",
    "other_power",
    "reach_m",
    "receive_powers",
    "silence",
    "silent_air",
]

RECEIVED, HALF_DUPLEX, WEAK, HIDDEN, CONCURRENT = 0, 1, 2, 3, 4
"""As `OUTCOMES` has them."""

HOPELESS = 40.0
"""Units of hazard beyond any luck: chance has 53 bits."""

_LN_PER_DB = np.log(10.0) / 10.0
_VEHICLE, _BAND, _LENGTH, _BYTES = 0, 1, 2, 3
_POWER_MW, _DISTANCE_M = 0, 1


class Errors(NamedTuple):
    """The error model, and what it says of messages of 0, 1, 2, ... bytes.

    ``hazard`` (HAZARD_SIZE,) is that of the SINR over ``needed_ratio``; ``units`` of hazard a message has.
    Such a ratio below ``hopeless_ratio`` is lost, one from ``safe_ratio`` on received, whatever the luck.
    """

    hazard: FloatVector
    units: FloatVector
    needed_ratio: FloatVector
    hopeless_ratio: FloatVector
    safe_ratio: float


class Air(NamedTuple):
    """One slot at V vehicles and in C sub-channels.

    ``power`` (V, C) [mW] in all, ``each`` (turns, V) [mW] from each sender, 0 where too weak to matter; who
    ``sends`` and who ``hears`` anything, (V,).
    """

    power: FloatMatrix
    each: FloatMatrix
    sends: BoolVector
    hears: BoolVector


class Turns(NamedTuple):
    """Who sends in a slot, in turn.

    ``who`` (V, 4): vehicle, first sub-channel, length, bytes; ``power_dbm``; ``place`` (V, 2); ``seed``; and
    the first link of each.
    """

    who: IntMatrix
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
def silent_air(vehicles: int, channels: int) -> tuple[Air, Turns]:
    """Return a slot without power, and room for everybody's turn."""
    air = Air(
        np.zeros((vehicles, channels)),
        np.zeros((8, vehicles)),
        np.zeros(vehicles, dtype=np.bool_),
        np.zeros(vehicles, dtype=np.bool_),
    )
    turns = Turns(
        np.empty((vehicles, 4), dtype=np.int64),
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
def reach_m(
    power_dbm: float, gain_ln: float, length: int, tables: PropagationTables, constants: NrConstants
) -> float:
    """Return how far a frame over so many sub-channels matters to anybody: by its median power [m]."""
    sent_ln = (constants.gain_db + power_dbm) * _LN_PER_DB + gain_ln
    return heard_within_m(sent_ln, tables, constants.quiet_mw * length, constants.range_m)


@kernel(inlined=True)
def _find_near(
    v: int, reached_m: float, around: Around, tables: PropagationTables, constants: NrConstants
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
        start = np.uint64(rows.start[rows.first[v] + row]) if constants.shadowed else np.uint64(0)
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
        if constants.shadowed:
            for n in range(count):
                work[_POWER_MW, n] += tables.shadowing_los_ln * np.float64(rows.value[around.place[n]])
        return count
    for n in range(count):
        j, distance_m = around.who[n], work[_DISTANCE_M, n]
        raised = is_raised(v, j, position_m.shape[0], tables.raised)
        ln, los = median_ln(east, north, position_m[j, 0], position_m[j, 1], distance_m, raised, tables)
        if constants.shadowed:
            sigma = tables.shadowing_los_ln if los else tables.shadowing_nlos_ln
            ln += sigma * np.float64(rows.value[around.place[n]])
        work[_POWER_MW, n] = ln
    return count


@kernel(inlined=True)
def receive_powers(
    turn: int,
    turns: Turns,
    air: Air,
    links: Links,
    used: int,
    around: Around,
    leak: FloatCube,
    tables: PropagationTables,
    constants: NrConstants,
) -> int:
    """Add the power of one sender to the vehicles in reach; return how many links there are.

    Who is beyond its reach has a link if it counts among the outcomes.
    """
    v, band, length = (
        int(turns.who[turn, _VEHICLE]),
        int(turns.who[turn, _BAND]),
        int(turns.who[turn, _LENGTH]),
    )
    seed, gain_ln, who, work = int(turns.seed[turn]), around.antennas.gain_ln, around.who, around.work
    sent_ln = (constants.gain_db + turns.power_dbm[turn]) * _LN_PER_DB + gain_ln[v]
    heard_m = reach_m(turns.power_dbm[turn], gain_ln[v], length, tables, constants)
    counted_m = min(constants.bins * constants.bin_m, constants.range_m)
    count = _find_near(v, max(heard_m, counted_m), around, tables, constants)
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
    quiet_mw, each, power = constants.quiet_mw * length, air.each, air.power
    for n in range(count):
        j, power_mw = who[n], work[_POWER_MW, n]
        group = min(int(work[_DISTANCE_M, n] / constants.bin_m), constants.bins)
        if power_mw < quiet_mw or work[_DISTANCE_M, n] > heard_m:
            if group < constants.bins:
                links.receiver[used], links.mw[used], links.bin[used] = j, 0.0, group
                used += 1
            continue
        links.receiver[used], links.mw[used], links.bin[used] = j, power_mw, group
        used += 1
        air.hears[j] = True
        each[turn, j] = power_mw
        share_mw = power_mw / length
        for s in range(constants.sub_channels):
            power[j, s] += share_mw * leak[length - 1, band, s]
    return used


@kernel(inlined=True)
def other_power(j: int, power_mw: float, turn: int, turns: Turns, air: Air) -> float:
    """Return the power of others over the sub-channels of a frame [mW]; 0 where there is none."""
    band, length = turns.who[turn, _BAND], turns.who[turn, _LENGTH]
    share_mw, other_mw = power_mw / length, 0.0
    for s in range(band, band + length):
        other_mw += max(air.power[j, s] - share_mw, 0.0)
    return other_mw


@kernel(inlined=True)
def _strongest_other(j: int, turn: int, count: int, turns: Turns, air: Air, leak: FloatCube) -> int:
    """Return whose turn disturbs a frame most at a receiver."""
    band, length = turns.who[turn, _BAND], turns.who[turn, _LENGTH]
    worst_mw, worst = 0.0, turn
    for other in range(count):
        power_mw = air.each[other, j]
        if other == turn or power_mw == 0.0:
            continue
        theirs = turns.who[other, _LENGTH]
        total = 0.0
        for s in range(band, band + length):
            total += leak[theirs - 1, turns.who[other, _BAND], s]
        if power_mw / theirs * total > worst_mw:
            worst_mw, worst = power_mw / theirs * total, other
    return worst


@kernel(inlined=True)
def judge(
    j: int,
    power_mw: float,
    other_mw: float,
    turn: int,
    count: int,
    turns: Turns,
    air: Air,
    leak: FloatCube,
    errors: Errors,
    constants: NrConstants,
) -> int:
    """Return what became of a frame at a listening receiver."""
    size_bytes, noise_mw = turns.who[turn, _BYTES], constants.noise_mw * turns.who[turn, _LENGTH]
    hopeless_ratio = errors.hopeless_ratio[size_bytes]
    counted_mw = power_mw / errors.needed_ratio[size_bytes]
    clear_ratio, ratio = counted_mw / noise_mw, counted_mw / (noise_mw + other_mw)
    if power_mw < constants.sensitivity_mw or clear_ratio < hopeless_ratio:
        return WEAK
    if ratio >= errors.safe_ratio:
        return RECEIVED
    units = errors.units[size_bytes]
    luck = -np.log(1.0 - uniform_of(int(turns.seed[turn]), j + LUCK))
    if ratio >= hopeless_ratio and units * hazard_at(ratio, errors.hazard) <= luck:
        return RECEIVED
    if other_mw == 0.0 or units * hazard_at(clear_ratio, errors.hazard) > luck:
        return WEAK
    worst = _strongest_other(j, turn, count, turns, air, leak)
    east = turns.place[turn, 0] - turns.place[worst, 0]
    north = turns.place[turn, 1] - turns.place[worst, 1]
    sensed_m = constants.sensing_range_m
    return CONCURRENT if east * east + north * north <= sensed_m * sensed_m else HIDDEN


@kernel(inlined=True)
def silence(
    count: int,
    turns: Turns,
    links: Links,
    air: Air,
    busy: IntMatrix,
    constants: NrConstants,
) -> None:
    """Count the busy sub-channels at everybody who listens, (V, 2), and make the air silent again."""
    for turn in range(count):
        for k in range(turns.first_link[turn], turns.first_link[turn + 1]):
            j = links.receiver[k]
            air.each[turn, j] = 0.0
            if air.hears[j]:
                air.hears[j] = False
                loud = 0
                for s in range(constants.sub_channels):
                    loud += int(air.power[j, s] + constants.noise_mw > constants.load_mw)
                    air.power[j, s] = 0.0
                busy[j, 0] += 0 if air.sends[j] else loud
    for turn in range(count):
        busy[turns.who[turn, _VEHICLE], 1] += 1
        air.sends[turns.who[turn, _VEHICLE]] = False
