"""Compiled air of one slot: who sends, what power everybody gets in each sub-channel, and what is decoded.

A frame's power is spread evenly over the sub-channels of its resource; the rest gets what leaks.
"""

from typing import NamedTuple

import numpy as np

from modelcast.channel.cells_kernels import Cells, find_in_range
from modelcast.channel.error_kernels import hazard_at
from modelcast.channel.nr_selection_kernels import NrConstants
from modelcast.channel.propagation_kernels import PropagationTables, fading_factor, is_raised, median_ln
from modelcast.channel.random_kernels import LUCK, uniform_of, word_of
from modelcast.channel.shadowing_kernels import ShadowRows, shadow_of
from modelcast.core.exponential_kernels import fast_exp
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    BoolVector,
    FloatCube,
    FloatMatrix,
    FloatVector,
    IntCube,
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
    "Links",
    "Turns",
    "judge",
    "links_room",
    "no_links",
    "receive_powers",
    "silence",
    "silent_air",
]

RECEIVED, HALF_DUPLEX, WEAK, HIDDEN, CONCURRENT = 0, 1, 2, 3, 4
"""As `OUTCOMES` has them."""

_LN_PER_DB = np.log(10.0) / 10.0


class Air(NamedTuple):
    """One slot at V vehicles and in C sub-channels.

    ``power`` (V, C) [mW]; the two strongest senders, ``top_mw`` and ``top_turn`` (V, C, 2); who ``sends``
    and who hears anything, (V,).
    """

    power: FloatMatrix
    top_mw: FloatCube
    top_turn: IntCube
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


class Links(NamedTuple):
    """Frames at their receivers, frame after frame: who, power [mW], distance bin."""

    receiver: IntVector
    mw: FloatVector
    bin: IntVector


class Around(NamedTuple):
    """Where everybody is in this interval, and the antennas; ``near`` is scratch."""

    position_m: FloatMatrix
    gain_ln: FloatVector
    cells: Cells
    rows: ShadowRows
    near: IntMatrix


@kernel
def silent_air(vehicles: int, channels: int) -> tuple[Air, Turns]:
    """Return a slot without power, and room for everybody's turn."""
    air = Air(
        np.zeros((vehicles, channels)),
        np.zeros((vehicles, channels, 2)),
        np.full((vehicles, channels, 2), -1, dtype=np.int64),
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
def no_links() -> Links:
    """Return links without room."""
    return Links(np.empty(0, dtype=np.int64), np.empty(0), np.empty(0, dtype=np.int64))


@kernel
def links_room(links: Links, used: int, more: int) -> Links:
    """Return the same with room for more links."""
    if used + more <= links.receiver.size:
        return links
    size = 2 * (used + more)
    roomier = Links(np.empty(size, dtype=np.int64), np.empty(size), np.empty(size, dtype=np.int64))
    roomier.receiver[:used], roomier.mw[:used] = links.receiver[:used], links.mw[:used]
    roomier.bin[:used] = links.bin[:used]
    return roomier


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
    """Add the power of one sender to the vehicles in range; return how many links there are.

    A link too weak to matter to anybody else has no power, its own included.
    """
    v, band, length = int(turns.who[turn, 0]), int(turns.who[turn, 1]), int(turns.who[turn, 2])
    seed = int(turns.seed[turn])
    sent_ln = (constants.gain_db + turns.power_dbm[turn]) * _LN_PER_DB + around.gain_ln[v]
    position_m, cells, near = around.position_m, around.cells, around.near
    power, top_mw, top_turn = air.power, air.top_mw, air.top_turn
    east, north = position_m[v, 0], position_m[v, 1]
    for n in range(find_in_range(v, position_m, cells, constants.range_m, near)):
        k = near[n, 0]
        away_east, away_north = cells.place[k, 0] - east, cells.place[k, 1] - north
        j = int(cells.order[k])
        distance_m = np.sqrt(away_east * away_east + away_north * away_north)
        raised = is_raised(v, j, position_m.shape[0], tables.raised)
        ln, los = median_ln(east, north, cells.place[k, 0], cells.place[k, 1], distance_m, raised, tables)
        if constants.shadowed:
            sigma = tables.shadowing_los_ln if los else tables.shadowing_nlos_ln
            ln += sigma * shadow_of(v, near[n, 1], k, around.rows)
        power_mw = fast_exp(sent_ln + min(ln, 0.0) + around.gain_ln[j]) * fading_factor(
            distance_m, word_of(seed, j), tables.fading, tables.fading_near_m, tables.fading_far_m
        )
        links.receiver[used], links.bin[used] = j, min(int(distance_m / constants.bin_m), constants.bins)
        links.mw[used] = power_mw if power_mw >= constants.quiet_mw else 0.0
        used += 1
        if power_mw < constants.quiet_mw:
            continue
        air.hears[j] = True
        for s in range(constants.sub_channels):
            share_mw = power_mw / length * leak[length - 1, band, s]
            power[j, s] += share_mw
            if share_mw > top_mw[j, s, 0]:
                top_mw[j, s, 1], top_turn[j, s, 1] = top_mw[j, s, 0], top_turn[j, s, 0]
                top_mw[j, s, 0], top_turn[j, s, 0] = share_mw, turn
            elif share_mw > top_mw[j, s, 1]:
                top_mw[j, s, 1], top_turn[j, s, 1] = share_mw, turn
    return used


@kernel(inlined=True)
def judge(
    j: int,
    power_mw: float,
    turn: int,
    turns: Turns,
    air: Air,
    hazard: FloatVector,
    needed_ratio: float,
    constants: NrConstants,
) -> tuple[int, float]:
    """Return what became of a frame at a listening receiver, and its SINR.

    The hazard is that of the SINR over ``needed_ratio``.
    """
    power, top_mw, top_turn = air.power, air.top_mw, air.top_turn
    band, length = int(turns.who[turn, 1]), int(turns.who[turn, 2])
    noise_mw = constants.noise_mw * length
    other_mw = 0.0
    worst_mw, worst = 0.0, -1
    for s in range(band, band + length):
        other_mw += max(power[j, s] - power_mw / length, 0.0)
        rank = 1 if top_turn[j, s, 0] == turn else 0
        if top_mw[j, s, rank] > worst_mw:
            worst_mw, worst = top_mw[j, s, rank], top_turn[j, s, rank]
    if worst < 0:
        other_mw = 0.0
    ratio = power_mw / (noise_mw + other_mw)
    if power_mw < constants.sensitivity_mw:
        return WEAK, ratio
    units = constants.units_fixed + constants.units_per_byte * turns.who[turn, 3]
    luck = -np.log(1.0 - uniform_of(int(turns.seed[turn]), j + LUCK))
    if units * hazard_at(ratio / needed_ratio, hazard) <= luck:
        return RECEIVED, ratio
    if worst < 0 or units * hazard_at(power_mw / noise_mw / needed_ratio, hazard) > luck:
        return WEAK, ratio
    east = turns.place[turn, 0] - turns.place[worst, 0]
    north = turns.place[turn, 1] - turns.place[worst, 1]
    reach_m = constants.sensing_range_m
    return (CONCURRENT if east * east + north * north <= reach_m * reach_m else HIDDEN), ratio


@kernel(inlined=True)
def silence(
    count: int,
    used: int,
    turns: Turns,
    links: Links,
    air: Air,
    busy: IntMatrix,
    constants: NrConstants,
) -> None:
    """Count the busy sub-channels at everybody who listens, (V, 2), and make the air silent again."""
    for k in range(used):
        j = links.receiver[k]
        if air.hears[j]:
            air.hears[j] = False
            for s in range(constants.sub_channels):
                loud = air.power[j, s] + constants.noise_mw > constants.load_mw
                busy[j, 0] += int(loud and not air.sends[j])
                air.power[j, s] = 0.0
                air.top_mw[j, s, 0], air.top_mw[j, s, 1] = 0.0, 0.0
                air.top_turn[j, s, 0], air.top_turn[j, s, 1] = -1, -1
    for turn in range(count):
        busy[turns.who[turn, 0], 1] += 1
        air.sends[turns.who[turn, 0]] = False
