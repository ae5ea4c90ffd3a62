"""Compiled LTE-V2X mode 4: one interval of sensing-based semi-persistent scheduling, subframe by subframe.

In every subframe of 1 ms: messages become ready and choose a resource if they have none; vehicles whose turn
it is send; everybody else adds up the power in each sub-channel, decodes what it can, and remembers both.
"""

import numpy as np

from modelcast.channel.cells_kernels import Cells, build_cells, find_in_range
from modelcast.channel.error_kernels import hazard_at
from modelcast.channel.frame_kernels import Asked, Heard, heard_room, nothing_heard
from modelcast.channel.pair_kernels import Pairs
from modelcast.channel.propagation_kernels import PropagationTables, fading_factor, median_ln
from modelcast.channel.random_kernels import LUCK, next_word, uniform, uniform_of, word_of
from modelcast.channel.shadowing_kernels import SILENT, ShadowRows, shadow_of, shadow_rows
from modelcast.channel.sidelink_selection_kernels import MEMORY, SidelinkConstants, select_resource
from modelcast.core.exponential_kernels import fast_exp
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    BoolVector,
    Float32Cube,
    FloatCube,
    FloatMatrix,
    FloatVector,
    IntCube,
    IntMatrix,
    IntVector,
    UInt64Vector,
)

__all__ = [
    "BAND",
    "GRANT_COLUMNS",
    "MESSAGE",
    "NEXT",
    "advance",
]

# Columns of ``grant`` (V, GRANT_COLUMNS): integers.
BAND, NEXT, _COUNTER, _UNUSED, _LENGTH, MESSAGE, _READY, _BYTES = 0, 1, 2, 3, 4, 5, 6, 7
GRANT_COLUMNS = 8
_RECEIVED, _HALF_DUPLEX, _WEAK, _HIDDEN, _CONCURRENT = 0, 1, 2, 3, 4


@kernel(inlined=True)
def _used(size_bytes: int, constants: SidelinkConstants) -> int:
    """Return the resource-block pairs that a message takes, control included."""
    return int(np.ceil(8.0 * size_bytes / constants.bits_per_block)) + constants.control_blocks


@kernel(inlined=True)
def _draw_counter(random: UInt64Vector, constants: SidelinkConstants) -> int:
    span = constants.counter_high - constants.counter_low + 1
    return constants.counter_low + int(uniform(random) * span)


@kernel(inlined=True)
def _receive_powers(
    v: int,
    sent_ln: float,
    band: int,
    used_blocks: int,
    turn: int,
    position_m: FloatMatrix,
    cells: Cells,
    tables: PropagationTables,
    rows: ShadowRows,
    seed: int,
    leak: FloatCube,
    power: FloatMatrix,
    top_mw: FloatCube,
    top_turn: IntCube,
    link_receiver: IntVector,
    link_mw: FloatVector,
    link_bin: IntVector,
    used: int,
    constants: SidelinkConstants,
    sends: BoolVector,
    outcomes: IntMatrix,
    near: IntMatrix,
    count: int,
) -> int:
    """Add the power of one sender to the ``count`` vehicles in ``near``; return how many links there are."""
    length = (used_blocks + constants.blocks - 1) // constants.blocks
    east, north = position_m[v, 0], position_m[v, 1]
    for n in range(count):
        k = near[n, 0]
        away_east, away_north = cells.place[k, 0] - east, cells.place[k, 1] - north
        j = int(cells.order[k])
        distance_m = np.sqrt(away_east * away_east + away_north * away_north)
        ln, los = median_ln(east, north, cells.place[k, 0], cells.place[k, 1], distance_m, tables)
        word = word_of(seed, j)
        if constants.shadowed:
            sigma = tables.shadowing_los_ln if los else tables.shadowing_nlos_ln
            ln += sigma * shadow_of(v, near[n, 1], k, rows)
        power_mw = fast_exp(sent_ln + min(ln, 0.0)) * fading_factor(
            distance_m, word, tables.fading, tables.fading_near_m, tables.fading_far_m
        )
        group = min(int(distance_m / constants.bin_m), constants.bins)
        if power_mw < constants.quiet_mw:
            if group < constants.bins:
                outcomes[group, _HALF_DUPLEX if sends[j] else _WEAK] += 1
            continue
        density_mw = power_mw * constants.blocks / used_blocks
        for s in range(constants.sub_channels):
            share_mw = density_mw * leak[length - 1, band, s]
            if band <= s < band + length:
                share_mw *= (
                    min(used_blocks - (s - band) * constants.blocks, constants.blocks) / constants.blocks
                )
            power[j, s] += share_mw
            if share_mw > top_mw[j, s, 0]:
                top_mw[j, s, 1], top_turn[j, s, 1] = top_mw[j, s, 0], top_turn[j, s, 0]
                top_mw[j, s, 0], top_turn[j, s, 0] = share_mw, turn
            elif share_mw > top_mw[j, s, 1]:
                top_mw[j, s, 1], top_turn[j, s, 1] = share_mw, turn
        link_receiver[used], link_mw[used] = j, power_mw
        link_bin[used] = group
        used += 1
    return used


@kernel(inlined=True)
def _judge(
    j: int,
    power_mw: float,
    band: int,
    turn: int,
    size_bytes: int,
    place: FloatMatrix,
    power: FloatMatrix,
    top_mw: FloatCube,
    top_turn: IntCube,
    hazard: FloatVector,
    seed: int,
    constants: SidelinkConstants,
) -> tuple[int, float]:
    """Return what became of a frame at a listening receiver, and its SINR."""
    used_blocks = _used(size_bytes, constants)
    length = (used_blocks + constants.blocks - 1) // constants.blocks
    noise_mw = constants.noise_mw * used_blocks / constants.blocks
    density_mw = power_mw * constants.blocks / used_blocks
    other_mw = 0.0
    worst_mw, worst = 0.0, -1
    for s in range(band, band + length):
        share = min(used_blocks - (s - band) * constants.blocks, constants.blocks) / constants.blocks
        other_mw += max(power[j, s] - density_mw * share, 0.0)
        rank = 1 if top_turn[j, s, 0] == turn else 0
        if top_mw[j, s, rank] > worst_mw:
            worst_mw, worst = top_mw[j, s, rank], top_turn[j, s, rank]
    if worst < 0:
        other_mw = 0.0
    ratio = power_mw / (noise_mw + other_mw)
    if power_mw < constants.sensitivity_mw:
        return _WEAK, ratio
    units = constants.units_fixed + constants.units_per_byte * size_bytes
    luck = -np.log(1.0 - uniform_of(seed, j + LUCK))
    if units * hazard_at(ratio, hazard) <= luck:
        return _RECEIVED, ratio
    if units * hazard_at(power_mw / noise_mw, hazard) > luck or worst < 0:
        return _WEAK, ratio
    east, north = place[turn, 0] - place[worst, 0], place[turn, 1] - place[worst, 1]
    reach_m = constants.sensing_range_m
    return (_CONCURRENT if east * east + north * north <= reach_m * reach_m else _HIDDEN), ratio


@kernel
def advance(
    now: int,
    until: int,
    random: UInt64Vector,
    grant: IntMatrix,
    power_dbm: FloatVector,
    sensed: Float32Cube,
    reserved: Float32Cube,
    busy_ratio: FloatVector,
    pairs: Pairs,
    asked: Asked,
    position_m: FloatMatrix,
    hazard: FloatVector,
    leak: FloatCube,
    tables: PropagationTables,
    constants: SidelinkConstants,
) -> tuple[Heard, Pairs]:
    """Carry the subframes ``now`` to ``until``, the end excluded; the arrays of the state are written into.

    Returns what was heard, and the store of pairs.
    """
    vehicles, sender = grant.shape[0], asked.sender
    ready_subframe = np.floor(asked.ready_s * 1e3 + 1e-6).astype(np.int64)
    channels = constants.sub_channels
    cells = build_cells(position_m, constants.range_m)
    present = cells.order.size
    reach_m2 = np.full(vehicles, SILENT)
    if constants.shadowed:
        for n in range(sender.size + vehicles):
            v = sender[n] if n < sender.size else n - sender.size
            if (n < sender.size or grant[v, MESSAGE] >= 0) and np.isfinite(position_m[v].sum()):
                reach_m2[v] = constants.range_m * constants.range_m
    rows, pairs = shadow_rows(reach_m2, position_m, cells, random[1], tables, constants.range_m, pairs)
    gain_ln = constants.gain_db * np.log(10.0) / 10.0
    heard, received, lapsed = nothing_heard(constants.bins, sender.size + vehicles), 0, 0
    outcomes, expired = heard.outcomes, heard.expired
    power = np.zeros((vehicles, channels))
    top_mw, top_turn = (
        np.zeros((vehicles, channels, 2)),
        np.full((vehicles, channels, 2), -1, dtype=np.int64),
    )
    sends = np.zeros(vehicles, dtype=np.bool_)
    arrival = 0
    links_room = 4 * max(present, 1)
    link_receiver, link_mw = np.empty(links_room, dtype=np.int64), np.empty(links_room)
    link_bin = np.empty(links_room, dtype=np.int64)
    turns = np.empty(vehicles, dtype=np.int64)
    place = np.empty((vehicles, 2))
    seeds = np.empty(vehicles, dtype=np.int64)
    first_link = np.empty(vehicles + 1, dtype=np.int64)
    reserves = np.zeros(vehicles, dtype=np.bool_)
    near = np.empty((present, 2), dtype=np.int64)

    for subframe in range(now, until):
        # Messages that became ready before this subframe choose their resource.
        while arrival < sender.size and ready_subframe[arrival] <= subframe:
            v, n = sender[arrival], arrival
            arrival += 1
            if not (np.isfinite(position_m[v, 0]) and np.isfinite(position_m[v, 1])):
                expired[lapsed] = asked.message_id[n]
                lapsed += 1
                continue
            waited = grant[v, MESSAGE] >= 0
            if waited:
                expired[lapsed] = grant[v, MESSAGE]
                lapsed += 1
            length = (_used(asked.size_bytes[n], constants) + constants.blocks - 1) // constants.blocks
            grant[v, MESSAGE], grant[v, _READY], grant[v, _BYTES] = (
                asked.message_id[n],
                subframe,
                asked.size_bytes[n],
            )
            power_dbm[v] = asked.power_dbm[n]
            ahead = grant[v, NEXT] - subframe
            if (
                grant[v, BAND] < 0
                or grant[v, _LENGTH] < length
                or ahead < constants.first
                or ahead > constants.last
            ):
                when_next, band = select_resource(v, subframe, length, sensed, reserved, random, constants)
                grant[v, BAND], grant[v, NEXT], grant[v, _LENGTH] = band, when_next, length
                grant[v, _COUNTER] = 1 if constants.one_shot else _draw_counter(random, constants)
                grant[v, _UNUSED] = 0

        # Who sends.
        count = 0
        for v in range(vehicles):
            if grant[v, BAND] < 0 or grant[v, NEXT] != subframe:
                continue
            grant[v, NEXT] += constants.interval
            if grant[v, MESSAGE] < 0 or not np.isfinite(position_m[v, 0]):
                grant[v, _UNUSED] += 1
                if grant[v, _UNUSED] >= constants.reselect_after:
                    grant[v, BAND] = -1
                continue
            grant[v, _UNUSED] = 0
            turns[count] = v
            place[count, 0], place[count, 1] = position_m[v, 0], position_m[v, 1]
            seeds[count] = np.int64(next_word(random) >> np.uint64(1))
            count += 1
            sends[v] = True
            reserves[v] = True
            if grant[v, _COUNTER] > 1:
                grant[v, _COUNTER] -= 1
            elif not constants.one_shot and uniform(random) < constants.keep_ratio:
                grant[v, _COUNTER] = _draw_counter(random, constants)
            else:
                reserves[v] = False

        # Power in every sub-channel of every receiver.
        used = 0
        for turn in range(count):
            v = turns[turn]
            if used + present > link_receiver.size:
                links_room = 2 * (used + present)
                more_receiver, more_mw = np.empty(links_room, dtype=np.int64), np.empty(links_room)
                more_bin = np.empty(links_room, dtype=np.int64)
                more_receiver[:used], more_mw[:used] = link_receiver[:used], link_mw[:used]
                more_bin[:used] = link_bin[:used]
                link_receiver, link_mw, link_bin = more_receiver, more_mw, more_bin
            in_range = find_in_range(v, position_m, cells, constants.range_m, near)
            first_link[turn] = used
            used = _receive_powers(
                v,
                gain_ln + power_dbm[v] * np.log(10.0) / 10.0,
                grant[v, BAND],
                _used(grant[v, _BYTES], constants),
                turn,
                position_m,
                cells,
                tables,
                rows,
                seeds[turn],
                leak,
                power,
                top_mw,
                top_turn,
                link_receiver,
                link_mw,
                link_bin,
                used,
                constants,
                sends,
                outcomes,
                near,
                in_range,
            )
        first_link[count] = used

        # What everybody remembers of this subframe.
        slot, phase = subframe % MEMORY, subframe % constants.interval
        for v in range(vehicles):
            for s in range(channels):
                sensed[v, slot, s] = np.inf if sends[v] else power[v, s] + constants.noise_mw
                reserved[v, phase, s] = 0.0

        # What becomes of every frame at every receiver.
        heard = heard_room(heard, received, used)
        who, when = heard.who, heard.when
        for turn in range(count):
            v = turns[turn]
            band, size = grant[v, BAND], grant[v, _BYTES]
            used_blocks = _used(size, constants)
            length = (used_blocks + constants.blocks - 1) // constants.blocks
            for k in range(first_link[turn], first_link[turn + 1]):
                j = link_receiver[k]
                if sends[j]:
                    outcome = _HALF_DUPLEX
                else:
                    outcome, ratio = _judge(
                        j,
                        link_mw[k],
                        band,
                        turn,
                        size,
                        place,
                        power,
                        top_mw,
                        top_turn,
                        hazard,
                        seeds[turn],
                        constants,
                    )
                    if reserves[v] and ratio >= constants.control_ratio:
                        rsrp_mw = link_mw[k] / (used_blocks * constants.elements)
                        for s in range(band, band + length):
                            reserved[j, phase, s] = max(reserved[j, phase, s], rsrp_mw)
                if link_bin[k] < constants.bins:
                    outcomes[link_bin[k], outcome] += 1
                if outcome == _RECEIVED:
                    who[received, 0], who[received, 1], who[received, 2] = grant[v, MESSAGE], v, j
                    when[received, 0], when[received, 1] = (subframe + 1) * 1e-3, link_mw[k]
                    received += 1
        for k in range(used):
            j = link_receiver[k]
            for s in range(channels):
                power[j, s] = 0.0
                top_mw[j, s, 0], top_mw[j, s, 1] = 0.0, 0.0
                top_turn[j, s, 0], top_turn[j, s, 1] = -1, -1
        for turn in range(count):
            v = turns[turn]
            sends[v] = False
            grant[v, MESSAGE] = -1
            if not reserves[v]:
                grant[v, BAND] = -1

        if (subframe + 1) % constants.window == 0:
            for v in range(vehicles):
                listened, busy = 0, 0
                for back in range(constants.window):
                    at = (subframe - back) % MEMORY
                    if np.isfinite(sensed[v, at, 0]):
                        for s in range(channels):
                            listened += 1
                            busy += sensed[v, at, s] > constants.load_mw
                busy_ratio[v] = busy / max(listened, 1)

    who, when = heard.who[:received].copy(), heard.when[:received].copy()
    return Heard(who, when, outcomes, expired[:lapsed].copy()), pairs
