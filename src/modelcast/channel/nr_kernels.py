"""Compiled NR-V2X mode 2: one interval of sensing, reserving and sending, slot by slot.

In every slot: vehicles whose turn it is send; everybody else adds up the power in each sub-channel, decodes
what it can and remembers what was reserved; then messages that became ready in the slot find their resources.
"""

from typing import NamedTuple

import numpy as np

from modelcast.channel.antennas import Antennas
from modelcast.channel.frame_kernels import Asked, Heard, heard_room, nothing_heard
from modelcast.channel.nr_air_kernels import (
    HALF_DUPLEX,
    RECEIVED,
    WEAK,
    Air,
    Around,
    Links,
    Turns,
    judge,
    links_room,
    no_links,
    receive_powers,
    silence,
    silent_air,
)
from modelcast.channel.nr_selection_kernels import NrConstants, select_resources
from modelcast.channel.propagation_kernels import PropagationTables
from modelcast.channel.random_kernels import next_word, uniform
from modelcast.channel.shadowing_kernels import Sweep
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    Float32Cube,
    FloatCube,
    FloatVector,
    Int16Matrix,
    IntMatrix,
    IntVector,
    UInt64Vector,
)

__all__ = ["COPIES", "GRANT_COLUMNS", "MESSAGE", "Sizes", "SlotMemory", "advance"]

# Columns of ``grant`` (V, GRANT_COLUMNS): integers.
MESSAGE, _BYTES, _SENT, COPIES, _LENGTH, _COUNTER, _UNUSED, _INTERVAL, _AGAIN = 0, 1, 2, 3, 4, 5, 6, 7, 8
GRANT_COLUMNS = 9
_PERIODIC, _ONE_SHOT = 1, 2
_NOT_YET = 0


class SlotMemory(NamedTuple):
    """What vehicles keep between slots: arrays of `NrState`."""

    grant: IntMatrix
    slots: IntMatrix
    bands: IntMatrix
    power_dbm: FloatVector
    reserved: Float32Cube
    fate: Int16Matrix
    busy: IntMatrix
    busy_ratio: FloatVector


class Sizes(NamedTuple):
    """Of messages of 0, 1, ... bytes: sub-channels, and the SINR ratio that the error model counts from."""

    length: IntVector
    needed_ratio: FloatVector


@kernel(inlined=True)
def _draw_counter(interval: int, random: UInt64Vector, constants: NrConstants) -> int:
    """Return how often a resource is used; TS 38.321, 5.22.1.1."""
    interval_ms = interval / constants.slots_a_ms
    times = int(np.ceil(100.0 / min(max(interval_ms, 20.0), 100.0)))
    return times * 5 + int(uniform(random) * (times * 10 + 1))


@kernel(inlined=True)
def _drop_resources(v: int, memory: SlotMemory) -> None:
    memory.grant[v, COPIES] = 0
    memory.slots[v, :] = -1


@kernel(inlined=True)
def _wanted_interval(n: int, asked: Asked, constants: NrConstants) -> int:
    """Return after how many slots the resource of a message is to come back; 0 for never."""
    if asked.grant[n] == _ONE_SHOT or (asked.grant[n] != _PERIODIC and constants.dynamic):
        return 0
    gap_ms = (asked.next_s[n] - asked.ready_s[n]) * 1e3
    if asked.grant[n] != _PERIODIC or not np.isfinite(gap_ms):
        return constants.interval
    # The shortest that the next message is sure to be ready for.
    gap_ms = max(np.ceil(gap_ms - 1e-6), 1.0)
    if gap_ms > 99.0:
        gap_ms = 100.0 * np.ceil(gap_ms / 100.0)
    return min(int(gap_ms) * constants.slots_a_ms, constants.longest)


@kernel
def _settle(v: int, memory: SlotMemory, outcomes: IntMatrix, constants: NrConstants) -> None:
    """Count what became of the copies of a message, once for each vehicle that was in reach."""
    for j in range(memory.fate.shape[1]):
        if memory.fate[v, j] != _NOT_YET:
            outcome, group = (memory.fate[v, j] - 1) % 5, (memory.fate[v, j] - 1) // 5
            if group < constants.bins:
                outcomes[group, outcome] += 1
            memory.fate[v, j] = _NOT_YET


@kernel
def _let_go(v: int, lapsed: int, memory: SlotMemory, heard: Heard, constants: NrConstants) -> int:
    """Give up the message that waits: expired, or settled where copies were sent; return how many lapsed."""
    grant = memory.grant
    if grant[v, MESSAGE] >= 0:
        if grant[v, _SENT] == 0:
            heard.expired[lapsed] = grant[v, MESSAGE]
            lapsed += 1
        else:
            _settle(v, memory, heard.outcomes, constants)
    grant[v, MESSAGE], grant[v, _SENT] = -1, 0
    return lapsed


@kernel
def _take_in(
    n: int,
    slot: int,
    memory: SlotMemory,
    asked: Asked,
    sizes: Sizes,
    random: UInt64Vector,
    constants: NrConstants,
) -> None:
    """Let a message wait for the vehicle's resources; choose some where it has none that fit."""
    grant, v, size_bytes = memory.grant, asked.sender[n], asked.size_bytes[n]
    grant[v, MESSAGE], grant[v, _BYTES], grant[v, _SENT] = asked.message_id[n], size_bytes, 0
    memory.power_dbm[v] = asked.power_dbm[n]
    length, interval = sizes.length[size_bytes], _wanted_interval(n, asked, constants)
    fits = grant[v, COPIES] > 0 and grant[v, _LENGTH] >= length
    fits = fits and (grant[v, _INTERVAL] > 0) == (interval > 0)
    before = slot + constants.first - 1
    for k in range(grant[v, COPIES]):
        fits = fits and before < memory.slots[v, k] <= slot + constants.last
        before = memory.slots[v, k]
    if fits:
        return
    _drop_resources(v, memory)
    grant[v, COPIES] = select_resources(
        v, slot, length, memory.reserved, random, memory.slots[v], memory.bands[v], constants
    )
    grant[v, _LENGTH], grant[v, _INTERVAL], grant[v, _UNUSED] = length, interval, 0
    grant[v, _COUNTER] = _draw_counter(interval, random, constants) if interval > 0 else 1


@kernel(inlined=True)
def _announces(v: int, grant: IntMatrix, random: UInt64Vector, constants: NrConstants) -> bool:
    """Count a use of the resources; return whether they are reserved again."""
    if grant[v, _INTERVAL] == 0:
        return False
    if grant[v, _COUNTER] > 1:
        grant[v, _COUNTER] -= 1
        return True
    if uniform(random) < constants.keep_ratio:
        grant[v, _COUNTER] = _draw_counter(grant[v, _INTERVAL], random, constants)
        return True
    return False


@kernel
def _take_turns(
    slot: int,
    lapsed: int,
    memory: SlotMemory,
    around: Around,
    turns: Turns,
    air: Air,
    heard: Heard,
    random: UInt64Vector,
    constants: NrConstants,
) -> tuple[int, int]:
    """Write who sends in this slot; return how many, and how many messages lapsed."""
    grant, slots, position_m = memory.grant, memory.slots, around.position_m
    count = 0
    for v in range(grant.shape[0]):
        for k in range(constants.copies):
            if slots[v, k] != slot:
                continue
            interval = grant[v, _INTERVAL]
            slots[v, k] = slot + interval if interval > 0 else -1
            if grant[v, MESSAGE] < 0 or k != grant[v, _SENT]:
                if k == 0:
                    grant[v, _UNUSED] += 1
                    if 0 < constants.reselect_after <= grant[v, _UNUSED]:
                        _drop_resources(v, memory)
                continue
            if not (np.isfinite(position_m[v, 0]) and np.isfinite(position_m[v, 1])):
                lapsed = _let_go(v, lapsed, memory, heard, constants)
                _drop_resources(v, memory)
                continue
            if k == 0:
                grant[v, _UNUSED] = 0
                grant[v, _AGAIN] = int(_announces(v, grant, random, constants))
            grant[v, _SENT] += 1
            turns.who[count, 0], turns.who[count, 1] = v, memory.bands[v, k]
            turns.who[count, 2], turns.who[count, 3] = grant[v, _LENGTH], grant[v, _BYTES]
            turns.power_dbm[count] = memory.power_dbm[v]
            turns.place[count, 0], turns.place[count, 1] = position_m[v, 0], position_m[v, 1]
            turns.seed[count] = np.int64(next_word(random) >> np.uint64(1))
            air.sends[v] = True
            count += 1
    return count, lapsed


@kernel(inlined=True)
def _reserve(v: int, j: int, copy: int, rsrp_mw: float, memory: SlotMemory, constants: NrConstants) -> None:
    """Remember at ``j`` what the control information of a copy reserves: copies to come, and itself again."""
    grant, slots, bands, reserved = memory.grant, memory.slots, memory.bands, memory.reserved
    length = grant[v, _LENGTH]
    for k in range(copy, grant[v, COPIES]):
        if k == copy and grant[v, _AGAIN] == 0:
            continue
        row = slots[v, k] % constants.ahead
        for s in range(bands[v, k], bands[v, k] + length):
            reserved[row, j, s] = max(reserved[row, j, s], np.float32(rsrp_mw))


@kernel(inlined=True)
def _finish_frame(
    turn: int,
    slot: int,
    turns: Turns,
    memory: SlotMemory,
    air: Air,
    links: Links,
    heard: Heard,
    received: int,
    hazard: FloatVector,
    sizes: Sizes,
    constants: NrConstants,
) -> int:
    """Say what becomes of a frame at every receiver; return the number of receptions."""
    v, grant, fate = int(turns.who[turn, 0]), memory.grant, memory.fate
    length, copy = int(turns.who[turn, 2]), int(grant[v, _SENT]) - 1
    needed_ratio = sizes.needed_ratio[turns.who[turn, 3]]
    for k in range(turns.first_link[turn], turns.first_link[turn + 1]):
        j = int(links.receiver[k])
        outcome, ratio = WEAK, 0.0
        if air.sends[j]:
            outcome = HALF_DUPLEX
        elif links.mw[k] > 0.0:
            outcome, ratio = judge(j, links.mw[k], turn, turns, air, hazard, needed_ratio, constants)
            if ratio >= constants.control_ratio:
                _reserve(v, j, copy, links.mw[k] / (length * constants.elements), memory, constants)
        group = links.bin[k]
        if constants.copies == 1:
            if group < constants.bins:
                heard.outcomes[group, outcome] += 1
        else:
            if fate[v, j] != _NOT_YET:
                group = (fate[v, j] - 1) // 5
                if (fate[v, j] - 1) % 5 == RECEIVED:
                    continue
            fate[v, j] = 1 + outcome + 5 * group
        if outcome == RECEIVED:
            who, when = heard.who, heard.when
            who[received, 0], who[received, 1], who[received, 2] = grant[v, MESSAGE], v, j
            when[received, 0] = (slot + 1) * 1e-3 / constants.slots_a_ms
            when[received, 1] = links.mw[k]
            received += 1
    return received


@kernel
def _end_turns(
    count: int, slot: int, turns: Turns, memory: SlotMemory, outcomes: IntMatrix, constants: NrConstants
) -> None:
    """Who sent heard nothing of what is reserved; messages sent in full are gone, and resources not kept."""
    grant = memory.grant
    row = (slot + constants.interval) % constants.ahead
    for turn in range(count):
        v = turns.who[turn, 0]
        memory.reserved[row, v, :] = np.inf
        if grant[v, _SENT] == grant[v, COPIES]:
            if constants.copies > 1:
                _settle(v, memory, outcomes, constants)
            grant[v, MESSAGE], grant[v, _SENT] = -1, 0
            if grant[v, _AGAIN] == 0:
                _drop_resources(v, memory)


@kernel(inlined=True)
def _measure_busy(memory: SlotMemory, constants: NrConstants) -> None:
    """Work out the busy ratios of the window that ends."""
    for v in range(memory.grant.shape[0]):
        listened = (constants.window - memory.busy[v, 1]) * constants.sub_channels
        memory.busy_ratio[v] = memory.busy[v, 0] / max(listened, 1)
        memory.busy[v, 0], memory.busy[v, 1] = 0, 0


@kernel
def advance(
    now: int,
    until: int,
    random: UInt64Vector,
    memory: SlotMemory,
    asked: Asked,
    sizes: Sizes,
    sweep: Sweep,
    antennas: Antennas,
    hazard: FloatVector,
    leak: FloatCube,
    tables: PropagationTables,
    constants: NrConstants,
) -> Heard:
    """Carry the slots ``now`` to ``until``, the end excluded; the state's arrays are written into."""
    sender, position_m = asked.sender, sweep.position_m
    vehicles, channels = memory.grant.shape[0], constants.sub_channels
    ready_slot = np.floor(asked.ready_s * 1e3 * constants.slots_a_ms + 1e-6).astype(np.int64)
    present = sweep.cells.order.size
    around = Around(
        position_m, antennas.gain_ln, sweep.cells, sweep.rows, np.empty((present, 2), dtype=np.int64)
    )
    heard, received, lapsed = nothing_heard(constants.bins, sender.size + vehicles), 0, 0
    air, turns = silent_air(vehicles, channels)
    links = no_links()
    arrival = 0
    for slot in range(now, until):
        count, lapsed = _take_turns(slot, lapsed, memory, around, turns, air, heard, random, constants)
        used = 0
        for turn in range(count):
            links = links_room(links, used, present)
            turns.first_link[turn] = used
            used = receive_powers(turn, turns, air, links, used, around, leak, tables, constants)
        turns.first_link[count] = used
        memory.reserved[slot % constants.ahead] = 0.0  # what was reserved for this slot has come
        heard = heard_room(heard, received, used)
        for turn in range(count):
            received = _finish_frame(
                turn, slot, turns, memory, air, links, heard, received, hazard, sizes, constants
            )
        _end_turns(count, slot, turns, memory, heard.outcomes, constants)
        silence(count, used, turns, links, air, memory.busy, constants)
        if (slot + 1) % constants.window == 0:
            _measure_busy(memory, constants)
        # Messages that became ready in this slot find their resources in later ones.
        while arrival < sender.size and ready_slot[arrival] <= slot:
            v, n = sender[arrival], arrival
            arrival += 1
            lapsed = _let_go(v, lapsed, memory, heard, constants)
            if np.isfinite(position_m[v, 0]) and np.isfinite(position_m[v, 1]):
                _take_in(n, slot, memory, asked, sizes, random, constants)
            else:
                heard.expired[lapsed] = asked.message_id[n]
                lapsed += 1

    who, when = heard.who[:received].copy(), heard.when[:received].copy()
    return Heard(who, when, heard.outcomes, heard.expired[:lapsed].copy())
