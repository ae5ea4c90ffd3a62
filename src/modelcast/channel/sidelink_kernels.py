"""Compiled LTE-V2X mode 4: one interval of sensing-based semi-persistent scheduling, subframe by subframe.

In every subframe of 1 ms: vehicles whose turn it is send; everybody else adds up the power in each
sub-channel, decodes what it can, and remembers both; messages that became ready choose a resource if they
have none that fits.
"""

from typing import NamedTuple

import numpy as np

from modelcast.channel.antennas import Antennas
from modelcast.channel.cells_kernels import Cells, find_in_range
from modelcast.channel.copies_kernels import Copies, copies_room, kept_copies, seek_pairs, settle, tell
from modelcast.channel.error_kernels import hazard_at
from modelcast.channel.frame_kernels import Asked, Heard, heard_room, nothing_heard
from modelcast.channel.frame_link_kernels import Links, links_room, no_links
from modelcast.channel.propagation_kernels import PropagationTables, fading_factor, is_raised, median_ln
from modelcast.channel.random_kernels import LUCK, next_word, uniform, uniform_of, word_of
from modelcast.channel.shadowing_kernels import SILENT, ShadowRows, Sweep, shadow_of
from modelcast.channel.sidelink_grant_kernels import (
    AHEAD,
    BAND,
    BYTES,
    COUNTER,
    INTERVAL,
    LENGTH,
    MESSAGE,
    NEXT,
    RESERVED,
    SENT,
    SHOT,
    SHOT_LENGTH,
    SHOTS,
    SKIPS,
    TURNS,
    UNUSED,
    VIA,
    WISH,
    draw_counter,
    draw_shots,
    interval_for,
    is_foreseen,
    wants_one_shot,
)
from modelcast.channel.sidelink_parameters import MEMORY
from modelcast.channel.sidelink_selection_kernels import SidelinkConstants, select_resource
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

__all__ = ["Memory", "advance", "find_reach"]

_ANY = 0
_ALTERNATIVES_MS = 100
_RECEIVED, _HALF_DUPLEX, _WEAK, _HIDDEN, _CONCURRENT = 0, 1, 2, 3, 4


class Memory(NamedTuple):
    """What vehicles keep between subframes: arrays of `SidelinkState`."""

    grant: IntMatrix
    power_dbm: FloatVector
    sensed: Float32Cube
    reserved: Float32Cube
    busy_ratio: FloatVector
    copies: Copies


class Air(NamedTuple):
    """One subframe at V vehicles and in C sub-channels.

    ``power`` (V, C) [mW]; the two strongest senders, ``top_mw`` and ``top_turn`` (V, C, 2); who ``sends``
    and who ``reserves`` the resource again, (V,).
    """

    power: FloatMatrix
    top_mw: FloatCube
    top_turn: IntCube
    sends: BoolVector
    reserves: BoolVector


class Turns(NamedTuple):
    """Who sends in a subframe, in turn: ``vehicle``, ``place`` (V, 2), ``seed``, and their first links.

    ``which`` of the vehicle's turns it is, and its ``band``.
    """

    vehicle: IntVector
    which: IntVector
    band: IntVector
    place: FloatMatrix
    seed: IntVector
    first_link: IntVector


class Around(NamedTuple):
    """Where everybody is in this interval, and the antennas; ``near`` is scratch."""

    position_m: FloatMatrix
    gain_ln: FloatVector
    cells: Cells
    rows: ShadowRows
    near: IntMatrix


@kernel(inlined=True)
def _used(size_bytes: int, constants: SidelinkConstants) -> int:
    """Return the resource-block pairs that a message takes, control included."""
    return int(np.ceil(8.0 * size_bytes / constants.bits_per_block)) + constants.control_blocks


@kernel(inlined=True)
def _length_of(used_blocks: int, constants: SidelinkConstants) -> int:
    """Return the sub-channels that a message of so many resource-block pairs takes."""
    return max((used_blocks + constants.blocks - 1) // constants.blocks, constants.least_sub_channels)


@kernel(inlined=True)
def _filled(used_blocks: int, place: int, constants: SidelinkConstants) -> float:
    """Return how much a message fills the ``place``-th sub-channel that it takes, 0..1."""
    return min(max(used_blocks - place * constants.blocks, 0), constants.blocks) / constants.blocks


@kernel(inlined=True)
def _receive_powers(
    turn: int,
    turns: Turns,
    memory: Memory,
    air: Air,
    links: Links,
    used: int,
    around: Around,
    leak: FloatCube,
    tables: PropagationTables,
    outcomes: IntMatrix,
    constants: SidelinkConstants,
) -> int:
    """Add the power of one sender to the vehicles in range; return how many links there are."""
    v, seed = int(turns.vehicle[turn]), int(turns.seed[turn])
    sent_ln = (constants.gain_db + memory.power_dbm[v]) * np.log(10.0) / 10.0 + around.gain_ln[v]
    band, used_blocks = int(turns.band[turn]), _used(int(memory.grant[v, BYTES]), constants)
    position_m, cells, near = around.position_m, around.cells, around.near
    power, top_mw, top_turn = air.power, air.top_mw, air.top_turn
    length = _length_of(used_blocks, constants)
    east, north = position_m[v, 0], position_m[v, 1]
    for n in range(find_in_range(v, position_m, cells, constants.range_m, near)):
        k = near[n, 0]
        away_east, away_north = cells.place[k, 0] - east, cells.place[k, 1] - north
        j = int(cells.order[k])
        distance_m = np.sqrt(away_east * away_east + away_north * away_north)
        raised = is_raised(v, j, position_m.shape[0], tables.raised)
        ln, los = median_ln(east, north, cells.place[k, 0], cells.place[k, 1], distance_m, raised, tables)
        word = word_of(seed, j)
        if constants.shadowed:
            sigma = tables.shadowing_los_ln if los else tables.shadowing_nlos_ln
            ln += sigma * shadow_of(v, near[n, 1], k, around.rows)
        power_mw = fast_exp(sent_ln + min(ln, 0.0) + around.gain_ln[j]) * fading_factor(
            distance_m, word, tables.fading, tables.fading_near_m, tables.fading_far_m
        )
        group = min(int(distance_m / constants.bin_m), constants.bins)
        if power_mw < constants.quiet_mw:
            if constants.copies > 1:
                # Whether it counts is seen once all copies have gone out.
                links.receiver[used], links.mw[used], links.bin[used] = j, 0.0, group
                used += 1
            elif group < constants.bins:
                outcomes[group, _HALF_DUPLEX if air.sends[j] else _WEAK] += 1
            continue
        density_mw = power_mw * constants.blocks / used_blocks
        for s in range(constants.sub_channels):
            share_mw = density_mw * leak[length - 1, band, s]
            if band <= s < band + length:
                share_mw *= _filled(used_blocks, s - band, constants)
            power[j, s] += share_mw
            if share_mw > top_mw[j, s, 0]:
                top_mw[j, s, 1], top_turn[j, s, 1] = top_mw[j, s, 0], top_turn[j, s, 0]
                top_mw[j, s, 0], top_turn[j, s, 0] = share_mw, turn
            elif share_mw > top_mw[j, s, 1]:
                top_mw[j, s, 1], top_turn[j, s, 1] = share_mw, turn
        links.receiver[used], links.mw[used], links.bin[used] = j, power_mw, group
        used += 1
    return used


@kernel(inlined=True)
def _judge(
    j: int,
    power_mw: float,
    band: int,
    turn: int,
    size_bytes: int,
    turns: Turns,
    air: Air,
    hazard: FloatVector,
    constants: SidelinkConstants,
) -> tuple[int, float]:
    """Return what became of a frame at a listening receiver, and its SINR."""
    place, power, top_mw, top_turn = turns.place, air.power, air.top_mw, air.top_turn
    used_blocks = _used(size_bytes, constants)
    length = _length_of(used_blocks, constants)
    noise_mw = constants.noise_mw * used_blocks / constants.blocks
    density_mw = power_mw * constants.blocks / used_blocks
    other_mw = 0.0
    worst_mw, worst = 0.0, -1
    for s in range(band, band + length):
        other_mw += max(power[j, s] - density_mw * _filled(used_blocks, s - band, constants), 0.0)
        rank = 1 if top_turn[j, s, 0] == turn else 0
        if top_mw[j, s, rank] > worst_mw:
            worst_mw, worst = top_mw[j, s, rank], top_turn[j, s, rank]
    if worst < 0:
        other_mw = 0.0
    ratio = power_mw / (noise_mw + other_mw)
    if power_mw < constants.sensitivity_mw:
        return _WEAK, ratio
    units = constants.units_fixed + constants.units_per_byte * size_bytes
    luck = -np.log(1.0 - uniform_of(int(turns.seed[turn]), j + LUCK))
    if units * hazard_at(ratio, hazard) <= luck:
        return _RECEIVED, ratio
    if units * hazard_at(power_mw / noise_mw, hazard) > luck or worst < 0:
        return _WEAK, ratio
    east, north = place[turn, 0] - place[worst, 0], place[turn, 1] - place[worst, 1]
    reach_m = constants.sensing_range_m
    return (_CONCURRENT if east * east + north * north <= reach_m * reach_m else _HIDDEN), ratio


@kernel(inlined=True)
def _is_there(v: int, position_m: FloatMatrix) -> bool:
    """Whether a vehicle is anywhere."""
    return bool(np.isfinite(position_m[v, 0]) and np.isfinite(position_m[v, 1]))


@kernel
def find_reach(
    grant: IntMatrix, sender: IntVector, position_m: FloatMatrix, constants: SidelinkConstants
) -> FloatMatrix:
    """Return the squared reach of what vehicles may send in this interval, as `lay_out` has it."""
    reach_m2 = np.full((grant.shape[0], 2), SILENT)
    if constants.shadowed:
        for n in range(sender.size + grant.shape[0]):
            v = int(sender[n]) if n < sender.size else n - sender.size
            if _is_there(v, position_m) and (n < sender.size or grant[v, MESSAGE] >= 0):
                reach_m2[v] = constants.range_m * constants.range_m
    return reach_m2


@kernel(inlined=True)
def _fits(
    v: int, kind: int, subframe: int, length: int, grant: IntMatrix, constants: SidelinkConstants
) -> bool:
    """Whether a turn of a kind is there for a message that is ready, in time and long enough."""
    long_enough = grant[v, LENGTH if kind == RESERVED else SHOT_LENGTH] >= length
    ahead = grant[v, NEXT + kind] - subframe
    return bool(grant[v, BAND + kind] >= 0 and long_enough and constants.first <= ahead <= constants.last)


@kernel
def _choose(
    v: int,
    kind: int,
    subframe: int,
    length: int,
    interval: int,
    memory: Memory,
    random: UInt64Vector,
    constants: SidelinkConstants,
) -> None:
    """Choose the turns of a kind by sensing, or by chance where it is the first and the parameters say so."""
    grant = memory.grant
    blind = constants.first_by_chance and grant[v, LENGTH] == 0 and grant[v, SHOT_LENGTH] == 0
    when, band, when_again, band_again = select_resource(
        v, subframe, length, interval, blind, memory.sensed, memory.reserved, random, constants
    )
    grant[v, BAND + kind], grant[v, NEXT + kind] = band, when
    grant[v, BAND + kind + 1], grant[v, NEXT + kind + 1] = band_again, when_again


@kernel
def _take_in(
    n: int, subframe: int, memory: Memory, asked: Asked, random: UInt64Vector, constants: SidelinkConstants
) -> None:
    """Let a message wait for the vehicle's resource; choose one where it has none that fits."""
    grant, v, size_bytes, wish = memory.grant, asked.sender[n], asked.size_bytes[n], asked.grant[n]
    length = _length_of(_used(size_bytes, constants), constants)
    grant[v, MESSAGE], grant[v, BYTES], grant[v, WISH] = asked.message_id[n], size_bytes, wish
    grant[v, AHEAD] = int(np.floor(asked.next_s[n] * 1e3 + 1e-6)) if asked.next_s[n] < 1e12 else -1
    grant[v, VIA], grant[v, SENT], grant[v, SKIPS] = RESERVED, 0, 0
    memory.power_dbm[v] = asked.power_dbm[n]
    fits = _fits(v, RESERVED, subframe, length, grant, constants)
    shot = wants_one_shot(wish, constants)
    if constants.interleaved and fits and not shot:
        grant[v, SHOTS] -= 1
        if grant[v, SHOTS] <= 0:
            grant[v, SHOTS], grant[v, SKIPS], shot = draw_shots(random, constants), 1, True
    if fits and not shot:
        return
    if wish == _ANY and constants.grant_by_next and not shot:
        shot = not is_foreseen(grant, v, subframe + constants.first, constants)
        if shot:
            grant[v, BAND] = grant[v, BAND + 1] = -1
    if shot:
        grant[v, VIA] = SHOT
        if not _fits(v, SHOT, subframe, length, grant, constants):
            _choose(v, SHOT, subframe, length, 0, memory, random, constants)
            grant[v, SHOT_LENGTH] = length
        return
    interval = interval_for(grant, v, subframe + constants.first, constants)
    _choose(v, RESERVED, subframe, length, interval, memory, random, constants)
    grant[v, LENGTH], grant[v, COUNTER], grant[v, UNUSED] = length, draw_counter(random, constants), 0
    grant[v, INTERVAL] = interval
    if constants.interleaved and grant[v, SHOTS] <= 0:
        grant[v, SHOTS] = draw_shots(random, constants)


@kernel(inlined=True)
def _pass_by(v: int, which: int, grant: IntMatrix, constants: SidelinkConstants) -> None:
    """Let a reserved turn pass without a message."""
    grant[v, NEXT + which] += grant[v, INTERVAL]
    if which != RESERVED:
        return
    if grant[v, SKIPS] > 0:
        grant[v, SKIPS] = 0
        grant[v, COUNTER] = max(grant[v, COUNTER] - 1, 1)
        return
    grant[v, UNUSED] += 1
    if grant[v, UNUSED] >= constants.reselect_after:
        grant[v, BAND] = grant[v, BAND + 1] = -1


@kernel(inlined=True)
def _goes_on(
    v: int, subframe: int, memory: Memory, random: UInt64Vector, constants: SidelinkConstants
) -> bool:
    """Whether a resource that is used now comes back; its interval is written."""
    grant = memory.grant
    grant[v, UNUSED] = 0
    if grant[v, COUNTER] > 1:
        grant[v, COUNTER] -= 1
    elif uniform(random) < constants.keep_ratio:
        grant[v, COUNTER] = draw_counter(random, constants)
    else:
        return False
    if not constants.interval_by_next and not constants.grant_by_next:
        return True
    if grant[v, WISH] == _ANY and constants.grant_by_next and not is_foreseen(grant, v, subframe, constants):
        return False
    grant[v, INTERVAL] = interval_for(grant, v, subframe, constants)
    if grant[v, INTERVAL] == constants.horizon:
        return True  # nobody can have announced anything so far ahead; its phase is still that of now
    for s in range(grant[v, BAND], grant[v, BAND] + grant[v, LENGTH]):
        if memory.reserved[v, (subframe + grant[v, INTERVAL]) % constants.horizon, s] > constants.reserved_mw:
            return False  # another will be there
    return True


@kernel(inlined=True)
def _let_go(v: int, lapsed: int, memory: Memory, heard: Heard) -> int:
    """Give up the message that waits: expired, or settled where a copy was sent; return how many lapsed."""
    grant = memory.grant
    if grant[v, MESSAGE] >= 0:
        if grant[v, SENT] == 0:
            heard.expired[lapsed] = grant[v, MESSAGE]
            lapsed += 1
        else:
            settle(memory.copies, v, heard.outcomes)  # no other copy is to come
    grant[v, MESSAGE] = -1
    return lapsed


@kernel(inlined=True)
def _take_turns(
    subframe: int,
    lapsed: int,
    memory: Memory,
    position_m: FloatMatrix,
    turns: Turns,
    air: Air,
    heard: Heard,
    random: UInt64Vector,
    constants: SidelinkConstants,
) -> tuple[int, int]:
    """Write who sends in this subframe; return how many, and how many messages have lapsed.

    Who is not there lets its message go.
    """
    count, grant = 0, memory.grant
    for v in range(grant.shape[0]):
        for which in range(TURNS if constants.copies > 1 else TURNS - 1):
            if grant[v, NEXT + which] != subframe or grant[v, BAND + which] < 0:
                continue
            kind = which & SHOT
            due = grant[v, MESSAGE] >= 0 and grant[v, VIA] == kind and grant[v, SENT] == which - kind
            if due and not _is_there(v, position_m):
                lapsed, due = _let_go(v, lapsed, memory, heard), False
            if not due:
                if kind == RESERVED:
                    _pass_by(v, which, grant, constants)
                continue
            turns.vehicle[count], turns.which[count], turns.band[count] = v, which, grant[v, BAND + which]
            turns.place[count, 0], turns.place[count, 1] = position_m[v, 0], position_m[v, 1]
            turns.seed[count] = np.int64(next_word(random) >> np.uint64(1))
            count += 1
            air.sends[v] = True
            if which == RESERVED:
                air.reserves[v] = _goes_on(v, subframe, memory, random, constants)
            else:
                air.reserves[v] = kind == RESERVED and grant[v, BAND] >= 0
            if kind == RESERVED:
                grant[v, NEXT + which] += grant[v, INTERVAL]
    return count, lapsed


@kernel(inlined=True)
def _remember(subframe: int, memory: Memory, air: Air, constants: SidelinkConstants) -> None:
    """Keep what everybody sensed; what was reserved in this phase has come."""
    slot, phase = subframe % MEMORY, subframe % constants.horizon
    for v in range(memory.grant.shape[0]):
        for s in range(constants.sub_channels):
            sensed_mw = air.power[v, s] + constants.noise_mw
            if not constants.noise_counts:
                sensed_mw = air.power[v, s] if air.power[v, s] >= constants.noise_mw else 0.0
            sensed_mw = np.inf if air.sends[v] else sensed_mw
            memory.sensed[v, slot, s] = sensed_mw
            memory.reserved[v, phase, s] = 0.0


@kernel(inlined=True)
def _mark(j: int, subframe: int, band: int, length: int, rsrp_mw: float, reserved: Float32Cube) -> None:
    """Let a vehicle know that a resource is taken in one subframe to come."""
    phase = subframe % reserved.shape[1]
    for s in range(band, band + length):
        reserved[j, phase, s] = max(reserved[j, phase, s], rsrp_mw)


@kernel(inlined=True)
def _announce(
    j: int, subframe: int, interval: int, band: int, length: int, rsrp_mw: float, reserved: Float32Cube
) -> None:
    """Let a vehicle know that a resource comes back, short intervals as often as 100 ms hold."""
    for later in range(subframe + interval, subframe + max(interval, _ALTERNATIVES_MS) + 1, interval):
        _mark(j, later, band, length, rsrp_mw, reserved)


@kernel(inlined=True)
def _finish_frame(
    turn: int,
    subframe: int,
    turns: Turns,
    memory: Memory,
    air: Air,
    links: Links,
    heard: Heard,
    received: int,
    waiting: int,
    hazard: FloatVector,
    constants: SidelinkConstants,
) -> tuple[int, int]:
    """Say what becomes of a frame at every receiver; return how many receptions and waiting pairs."""
    v, which, band = int(turns.vehicle[turn]), int(turns.which[turn]), int(turns.band[turn])
    grant, size = memory.grant, int(memory.grant[v, BYTES])
    used_blocks = _used(size, constants)
    length = _length_of(used_blocks, constants)
    more = bool(constants.copies > 1 and which & 1 == 0 and grant[v, BAND + which + 1] >= 0)
    gap = int(grant[v, NEXT + which + 1]) - subframe if more else 0
    alone = not more and memory.copies.span[v, 1] == 0
    if more:
        memory.copies.span[v, 0] = waiting
    else:
        seek_pairs(memory.copies, v)
    for k in range(turns.first_link[turn], turns.first_link[turn + 1]):
        j = int(links.receiver[k])
        if air.sends[j]:
            outcome = _HALF_DUPLEX
        elif links.mw[k] == 0.0:
            outcome = _WEAK
        else:
            outcome, ratio = _judge(j, links.mw[k], band, turn, size, turns, air, hazard, constants)
            if ratio >= constants.control_ratio and (air.reserves[v] or more):
                rsrp_mw = links.mw[k] / (used_blocks * constants.elements)
                if air.reserves[v]:
                    _announce(j, subframe, int(grant[v, INTERVAL]), band, length, rsrp_mw, memory.reserved)
                if more:
                    again = int(grant[v, BAND + which + 1])
                    _mark(j, subframe + gap, again, length, rsrp_mw, memory.reserved)
        new = outcome == _RECEIVED
        if not alone:
            new, waiting = tell(
                memory.copies, v, j, outcome, int(links.bin[k]), waiting, more, heard.outcomes
            )
        elif links.bin[k] < constants.bins:
            heard.outcomes[links.bin[k], outcome] += 1
        if new:
            who, when = heard.who, heard.when
            who[received, 0], who[received, 1], who[received, 2] = grant[v, MESSAGE], v, j
            when[received, 0], when[received, 1] = (subframe + 1) * 1e-3, links.mw[k]
            received += 1
    if not more:
        settle(memory.copies, v, heard.outcomes)
    return received, waiting


@kernel(inlined=True)
def _clear(
    count: int, used: int, turns: Turns, links: Links, memory: Memory, air: Air, channels: int
) -> None:
    """Make the air silent again; messages sent are gone, and resources that were not reserved."""
    grant = memory.grant
    for k in range(used):
        j = links.receiver[k]
        for s in range(channels):
            air.power[j, s] = 0.0
            air.top_mw[j, s, 0], air.top_mw[j, s, 1] = 0.0, 0.0
            air.top_turn[j, s, 0], air.top_turn[j, s, 1] = -1, -1
    for turn in range(count):
        v, which = turns.vehicle[turn], turns.which[turn]
        air.sends[v] = False
        grant[v, SENT] += 1
        if which & 1 == 1 or grant[v, BAND + which + 1] < 0:
            grant[v, MESSAGE] = -1
        if not air.reserves[v]:
            grant[v, BAND + which] = -1


@kernel(inlined=True)
def _measure_busy(subframe: int, memory: Memory, constants: SidelinkConstants) -> None:
    """Work out the busy ratios of the window that ends with this subframe."""
    for v in range(memory.grant.shape[0]):
        listened, busy = 0, 0
        for back in range(constants.window):
            at = (subframe - back) % MEMORY
            if np.isfinite(memory.sensed[v, at, 0]):
                for s in range(constants.sub_channels):
                    listened += 1
                    busy += memory.sensed[v, at, s] > constants.load_mw
        memory.busy_ratio[v] = busy / max(listened, 1)


@kernel
def _silent_air(vehicles: int, channels: int) -> tuple[Air, Turns]:
    """Return a subframe without power, and room for everybody's turn."""
    air = Air(
        np.zeros((vehicles, channels)),
        np.zeros((vehicles, channels, 2)),
        np.full((vehicles, channels, 2), -1, dtype=np.int64),
        np.zeros(vehicles, dtype=np.bool_),
        np.zeros(vehicles, dtype=np.bool_),
    )
    turns = Turns(
        np.empty(vehicles, dtype=np.int64),
        np.empty(vehicles, dtype=np.int64),
        np.empty(vehicles, dtype=np.int64),
        np.empty((vehicles, 2)),
        np.empty(vehicles, dtype=np.int64),
        np.empty(vehicles + 1, dtype=np.int64),
    )
    return air, turns


@kernel
def advance(
    now: int,
    until: int,
    random: UInt64Vector,
    memory: Memory,
    asked: Asked,
    sweep: Sweep,
    antennas: Antennas,
    hazard: FloatVector,
    leak: FloatCube,
    tables: PropagationTables,
    constants: SidelinkConstants,
) -> tuple[Heard, IntMatrix, IntMatrix]:
    """Carry the subframes ``now`` to ``until``, the end excluded; the state's arrays are written into.

    What waits for a copy, and whose it is, comes beside what is heard.
    """
    grant, sender = memory.grant, asked.sender
    vehicles, channels = grant.shape[0], constants.sub_channels
    ready_subframe = np.floor(asked.ready_s * 1e3 + 1e-6).astype(np.int64)
    position_m, present = sweep.position_m, sweep.cells.order.size
    around = Around(
        position_m, antennas.gain_ln, sweep.cells, sweep.rows, np.empty((present, 2), dtype=np.int64)
    )
    heard, received, lapsed = nothing_heard(constants.bins, sender.size + vehicles), 0, 0
    air, turns = _silent_air(vehicles, channels)
    links = no_links()
    arrival, waiting = 0, memory.copies.pair.shape[0]

    for subframe in range(now, until):
        count, lapsed = _take_turns(
            subframe, lapsed, memory, position_m, turns, air, heard, random, constants
        )
        used = 0
        for turn in range(count):
            links = links_room(links, used, present)
            turns.first_link[turn] = used
            used = _receive_powers(
                turn, turns, memory, air, links, used, around, leak, tables, heard.outcomes, constants
            )
        turns.first_link[count] = used
        _remember(subframe, memory, air, constants)
        heard = heard_room(heard, received, used)
        if constants.copies > 1:
            copies = copies_room(memory.copies, waiting, used)
            memory = Memory(
                grant, memory.power_dbm, memory.sensed, memory.reserved, memory.busy_ratio, copies
            )
        for turn in range(count):
            received, waiting = _finish_frame(
                turn, subframe, turns, memory, air, links, heard, received, waiting, hazard, constants
            )
        _clear(count, used, turns, links, memory, air, channels)
        # Messages that became ready in this subframe choose their resource once it is over: whose turn it
        # was has sent, and what it brought is known.
        while arrival < sender.size and ready_subframe[arrival] <= subframe:
            v, n = sender[arrival], arrival
            arrival += 1
            lapsed = _let_go(v, lapsed, memory, heard)
            if _is_there(v, position_m):
                _take_in(n, subframe, memory, asked, random, constants)
            else:
                heard.expired[lapsed] = asked.message_id[n]
                lapsed += 1
        if (subframe + 1) % constants.window == 0:
            _measure_busy(subframe, memory, constants)

    who, when = heard.who[:received].copy(), heard.when[:received].copy()
    pair, span = kept_copies(memory.copies)
    return Heard(who, when, heard.outcomes, heard.expired[:lapsed].copy()), pair, span
