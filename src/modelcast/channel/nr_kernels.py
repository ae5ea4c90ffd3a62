"""Compiled NR-V2X mode 2: one interval of sensing, reserving and sending, slot by slot.

In every slot: vehicles whose turn it is send; everybody else adds up the power in each sub-channel, decodes
what it can and remembers what was reserved; then messages that became ready in the slot find their resources.
"""

from typing import NamedTuple

import numpy as np

from modelcast.channel.antennas import Antennas
from modelcast.channel.copies_kernels import (
    Copies,
    copies_room,
    forget_pairs,
    kept_copies,
    move_last,
    seek_pairs,
    settle,
    tell,
)
from modelcast.channel.frame_kernels import Asked, Heard, heard_room, nothing_heard
from modelcast.channel.frame_link_kernels import Links, links_room, no_links
from modelcast.channel.nr_air_kernels import (
    HALF_DUPLEX,
    RECEIVED,
    WEAK,
    Air,
    Around,
    Errors,
    Turns,
    air_room,
    judge,
    other_power,
    reach_m,
    receive_powers,
    silence,
    silent_air,
)
from modelcast.channel.nr_selection_kernels import NrConstants, select_resources
from modelcast.channel.propagation_kernels import PropagationTables
from modelcast.channel.random_kernels import next_word, uniform
from modelcast.channel.shadowing_kernels import SILENT, Sweep
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    Float32Cube,
    FloatCube,
    FloatMatrix,
    FloatVector,
    IntMatrix,
    IntVector,
    UInt64Vector,
)

__all__ = ["COPIES", "GRANT_COLUMNS", "MESSAGE", "SlotMemory", "advance", "find_reach"]

# Columns of ``grant`` (V, GRANT_COLUMNS): integers.
MESSAGE, _BYTES, _SENT, COPIES, _LENGTH, _COUNTER, _UNUSED, _INTERVAL, _AGAIN = 0, 1, 2, 3, 4, 5, 6, 7, 8
_WISH = 9  # the interval that the message that waits wants
GRANT_COLUMNS = 10
_PERIODIC, _ONE_SHOT = 1, 2


class SlotMemory(NamedTuple):
    """What vehicles keep between slots: arrays of `NrState`."""

    grant: IntMatrix
    slots: IntMatrix
    bands: IntMatrix
    power_dbm: FloatVector
    reserved: Float32Cube
    copies: Copies
    busy: IntMatrix
    busy_ratio: FloatVector


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
def find_reach(
    memory: SlotMemory,
    asked: Asked,
    lengths: IntVector,
    position_m: FloatMatrix,
    antennas: Antennas,
    tables: PropagationTables,
    constants: NrConstants,
) -> FloatMatrix:
    """Return the squared reach of what vehicles may send in this interval, as `lay_out` has it."""
    vehicles, number = memory.grant.shape[0], asked.sender.size
    reach_m2 = np.full((vehicles, 2), SILENT)
    if not constants.shadowed:
        return reach_m2
    for n in range(number + vehicles):
        v = int(asked.sender[n]) if n < number else n - number
        if n >= number and memory.grant[v, MESSAGE] < 0:
            continue
        if np.isfinite(position_m[v, 0]) and np.isfinite(position_m[v, 1]):
            dbm = asked.power_dbm[n] if n < number else memory.power_dbm[v]
            length = int(lengths[asked.size_bytes[n]]) if n < number else int(memory.grant[v, _LENGTH])
            heard_m = reach_m(dbm, antennas.gain_ln[v], length, tables, constants)
            reach_m2[v] = max(reach_m2[v, 0], heard_m * heard_m)
    return reach_m2


@kernel
def _let_go(v: int, lapsed: int, memory: SlotMemory, heard: Heard) -> int:
    """Give up the message that waits: expired, or settled where copies were sent; return how many lapsed."""
    grant = memory.grant
    if grant[v, MESSAGE] >= 0:
        if grant[v, _SENT] == 0:
            heard.expired[lapsed] = grant[v, MESSAGE]
            lapsed += 1
        else:
            settle(memory.copies, v, heard.outcomes)
    grant[v, MESSAGE], grant[v, _SENT] = -1, 0
    return lapsed


@kernel
def _take_in(
    n: int,
    slot: int,
    memory: SlotMemory,
    asked: Asked,
    lengths: IntVector,
    random: UInt64Vector,
    constants: NrConstants,
) -> None:
    """Let a message wait for the vehicle's resources; choose some where it has none that fit."""
    grant, v, size_bytes = memory.grant, asked.sender[n], asked.size_bytes[n]
    grant[v, MESSAGE], grant[v, _BYTES], grant[v, _SENT] = asked.message_id[n], size_bytes, 0
    memory.power_dbm[v] = asked.power_dbm[n]
    length, interval = int(lengths[size_bytes]), _wanted_interval(n, asked, constants)
    fits = grant[v, COPIES] > 0 and grant[v, _LENGTH] >= length
    fits = fits and (grant[v, _INTERVAL] > 0) == (interval > 0)
    grant[v, _WISH] = interval
    # All copies before the first comes back.
    if fits and interval > 0:
        fits = memory.slots[v, grant[v, COPIES] - 1] - memory.slots[v, 0] < interval
    before = slot + constants.first - 1
    for k in range(grant[v, COPIES]):
        fits = fits and before < memory.slots[v, k] <= slot + constants.last
        before = memory.slots[v, k]
    if fits:
        return
    _drop_resources(v, memory)
    span = min(constants.span, interval) if interval > 0 else constants.span
    grant[v, COPIES] = select_resources(
        v, slot, length, span, memory.reserved, random, memory.slots[v], memory.bands[v], constants
    )
    grant[v, _LENGTH], grant[v, _INTERVAL], grant[v, _UNUSED] = length, interval, 0
    grant[v, _COUNTER] = _draw_counter(interval, random, constants) if interval > 0 else 1


@kernel(inlined=True)
def _are_reserved(v: int, slot: int, interval: int, memory: SlotMemory, constants: NrConstants) -> bool:
    """Return whether others are known to be where a vehicle's resources come back."""
    loudest_mw = np.float32(0.0)
    for k in range(memory.grant[v, COPIES]):
        at, band = memory.slots[v, k] + interval, memory.bands[v, k]
        if at - slot < constants.ahead:
            for s in range(band, band + memory.grant[v, _LENGTH]):
                loudest_mw = max(loudest_mw, memory.reserved[at % constants.ahead, v, s])
    return bool(loudest_mw > constants.reserved_mw)


@kernel(inlined=True)
def _announces(v: int, slot: int, memory: SlotMemory, random: UInt64Vector, constants: NrConstants) -> bool:
    """Count a use of the resources; return whether they are reserved again, after the interval wished for.

    It is the new one from this use on; the counter goes on. Where others reserved then, they are not.
    """
    grant = memory.grant
    wish, held = grant[v, _WISH], grant[v, _INTERVAL]
    grant[v, _INTERVAL] = wish
    if wish == 0:
        return False
    if grant[v, _COUNTER] > 1:
        grant[v, _COUNTER] -= 1
    elif uniform(random) < constants.keep_ratio:
        grant[v, _COUNTER] = _draw_counter(wish, random, constants)
    else:
        return False
    return wish == held or not _are_reserved(v, slot, wish, memory, constants)


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
            waits = grant[v, MESSAGE] >= 0
            if waits and not (np.isfinite(position_m[v, 0]) and np.isfinite(position_m[v, 1])):
                lapsed = _let_go(v, lapsed, memory, heard)
                _drop_resources(v, memory)
                continue
            if waits and k == 0:
                grant[v, _UNUSED] = 0
                grant[v, _AGAIN] = int(_announces(v, slot, memory, random, constants))
            interval = grant[v, _INTERVAL]
            slots[v, k] = slot + interval if interval > 0 else -1
            if not waits:
                if k == 0:
                    grant[v, _UNUSED] += 1
                    if 0 < constants.reselect_after <= grant[v, _UNUSED]:
                        _drop_resources(v, memory)
                continue
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
    """Remember at ``j`` what the control information of a copy reserves: copies to come, and itself again.

    Itself for every interval that begins within T2: Q times in TS 38.214, 8.1.4.
    """
    grant, slots, bands, reserved = memory.grant, memory.slots, memory.bands, memory.reserved
    length, interval = grant[v, _LENGTH], grant[v, _INTERVAL]
    for k in range(copy, grant[v, COPIES]):
        uses = 1
        if k == copy:
            uses = (constants.last + interval - 1) // interval if grant[v, _AGAIN] == 1 else 0
        for use in range(uses):
            row = (slots[v, k] + use * interval) % constants.ahead
            for s in range(bands[v, k], bands[v, k] + length):
                reserved[row, j, s] = max(reserved[row, j, s], np.float32(rsrp_mw))


@kernel(inlined=True)
def _finish_frame(
    turn: int,
    slot: int,
    count: int,
    turns: Turns,
    memory: SlotMemory,
    air: Air,
    links: Links,
    heard: Heard,
    received: int,
    waiting: int,
    leak: FloatCube,
    errors: Errors,
    constants: NrConstants,
) -> tuple[int, int]:
    """Say what becomes of a frame at every receiver; return how many receptions and waiting pairs."""
    v, grant, copies = int(turns.who[turn, 0]), memory.grant, memory.copies
    length, copy = int(turns.who[turn, 2]), int(grant[v, _SENT]) - 1
    more = copy + 1 < int(grant[v, COPIES])
    lone = copy == 0 and not more
    if not lone:
        if copy == 0:
            copies.span[v, 0], copies.span[v, 1] = waiting, 0
        elif more:
            waiting = move_last(copies, v, waiting)
        seek_pairs(copies, v)
    tells = more or int(grant[v, _AGAIN]) == 1
    end_s = (slot + 1) * 1e-3 / constants.slots_a_ms
    for k in range(turns.first_link[turn], turns.first_link[turn + 1]):
        j, power_mw, group, outcome = int(links.receiver[k]), float(links.mw[k]), int(links.bin[k]), WEAK
        if air.sends[j]:
            outcome = HALF_DUPLEX
        elif power_mw > 0.0:
            other_mw = other_power(j, power_mw, turn, turns, air)
            outcome = judge(j, power_mw, other_mw, turn, count, turns, air, leak, errors, constants)
            counted_mw = power_mw + other_mw if constants.reserved_by_total else power_mw
            rsrp_mw = counted_mw / (length * constants.elements)
            # What is weaker excludes nothing.
            if tells and rsrp_mw > constants.reserved_mw:
                ratio = power_mw / (constants.noise_mw * length + other_mw)
                if ratio >= constants.control_ratio:
                    _reserve(v, j, copy, rsrp_mw, memory, constants)
        new = outcome == RECEIVED
        if not lone:
            new, waiting = tell(copies, v, j, outcome, group, waiting, more, heard.outcomes)
        elif group < constants.bins:
            heard.outcomes[group, outcome] += 1
        if new:
            who, when = heard.who, heard.when
            who[received, 0], who[received, 1], who[received, 2] = grant[v, MESSAGE], v, j
            when[received, 0], when[received, 1] = end_s, power_mw
            received += 1
    if more:
        forget_pairs(copies, v)
    elif not lone:
        settle(copies, v, heard.outcomes)
    return received, waiting


@kernel
def _end_turns(count: int, slot: int, turns: Turns, memory: SlotMemory, constants: NrConstants) -> None:
    """Who sent heard nothing of what is reserved; messages sent in full are gone, and resources not kept."""
    grant = memory.grant
    row = (slot + constants.interval) % constants.ahead
    for turn in range(count):
        v = turns.who[turn, 0]
        memory.reserved[row, v, :] = np.inf
        if grant[v, _SENT] == grant[v, COPIES]:
            grant[v, MESSAGE], grant[v, _SENT] = -1, 0
            if grant[v, _AGAIN] == 0:
                _drop_resources(v, memory)


@kernel
def _with_room(memory: SlotMemory, v: int, waiting: int, present: int) -> SlotMemory:
    """Return the same with room for the pairs of a frame that wait: those there are once more, and new ones.

    There may be more than vehicles ``present``: some heard an earlier copy and left.
    """
    more = int(memory.copies.span[v, 1]) + present
    return SlotMemory(
        memory.grant,
        memory.slots,
        memory.bands,
        memory.power_dbm,
        memory.reserved,
        copies_room(memory.copies, waiting, more),
        memory.busy,
        memory.busy_ratio,
    )


@kernel(inlined=True)
def _measure_busy(memory: SlotMemory, constants: NrConstants) -> None:
    """Work out the busy ratios of the window that ends."""
    for v in range(memory.grant.shape[0]):
        listened = (constants.window - memory.busy[v, 1]) * constants.sub_channels
        # Silent slots are not visited: there, noise alone decides.
        busy = listened if constants.noise_mw > constants.load_mw else memory.busy[v, 0]
        memory.busy_ratio[v] = busy / max(listened, 1)
        memory.busy[v, 0], memory.busy[v, 1] = 0, 0


@kernel
def advance(
    now: int,
    until: int,
    random: UInt64Vector,
    memory: SlotMemory,
    asked: Asked,
    lengths: IntVector,
    sweep: Sweep,
    antennas: Antennas,
    errors: Errors,
    leak: FloatCube,
    tables: PropagationTables,
    constants: NrConstants,
) -> tuple[Heard, IntMatrix, IntMatrix]:
    """Carry the slots ``now`` to ``until``, the end excluded; the state's arrays are written into.

    ``lengths`` are sub-channels of messages of 0, 1, ... bytes. Returns the pairs that wait for another copy,
    and their spans, too.
    """
    sender, position_m, cells = asked.sender, sweep.position_m, sweep.cells
    vehicles, channels, present = memory.grant.shape[0], constants.sub_channels, sweep.cells.order.size
    ready_slot = np.floor(asked.ready_s * 1e3 * constants.slots_a_ms + 1e-6).astype(np.int64)
    who, place = np.empty(present + 1, dtype=np.int64), np.empty(present + 1, dtype=np.int64)
    around = Around(position_m, antennas, cells, sweep.rows, who, place, np.empty((2, present + 1)))
    heard, received, lapsed = nothing_heard(constants.bins, sender.size + vehicles), 0, 0
    waiting = memory.copies.span[:, 1].sum()
    air, turns = silent_air(vehicles, channels)
    links = no_links()
    arrival = 0
    for slot in range(now, until):
        count, lapsed = _take_turns(slot, lapsed, memory, around, turns, air, heard, random, constants)
        air = air_room(air, count)
        used = 0
        for turn in range(count):
            links = links_room(links, used, present)
            turns.first_link[turn] = used
            used = receive_powers(turn, turns, air, links, used, around, leak, tables, constants)
        turns.first_link[count] = used
        memory.reserved[slot % constants.ahead] = 0.0  # what was reserved for this slot has come
        heard = heard_room(heard, received, used)
        for turn in range(count):
            if constants.copies > 1:
                memory = _with_room(memory, int(turns.who[turn, 0]), waiting, present)
            received, waiting = _finish_frame(
                turn,
                slot,
                count,
                turns,
                memory,
                air,
                links,
                heard,
                received,
                waiting,
                leak,
                errors,
                constants,
            )
        _end_turns(count, slot, turns, memory, constants)
        silence(count, turns, links, air, memory.busy, constants)
        if (slot + 1) % constants.window == 0:
            _measure_busy(memory, constants)
        # Messages that became ready in this slot find their resources in later ones.
        while arrival < sender.size and ready_slot[arrival] <= slot:
            v, n = sender[arrival], arrival
            arrival += 1
            lapsed = _let_go(v, lapsed, memory, heard)
            if np.isfinite(position_m[v, 0]) and np.isfinite(position_m[v, 1]):
                _take_in(n, slot, memory, asked, lengths, random, constants)
            else:
                heard.expired[lapsed] = asked.message_id[n]
                lapsed += 1

    pair, span = kept_copies(memory.copies)
    found, when = heard.who[:received].copy(), heard.when[:received].copy()
    return Heard(found, when, heard.outcomes, heard.expired[:lapsed].copy()), pair, span
