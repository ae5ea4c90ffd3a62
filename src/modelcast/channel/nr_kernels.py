"""Compiled NR-V2X mode 2: one interval of sensing, reserving and sending, slot by slot.

In every slot: vehicles whose turn it is send; everybody else adds up the power in each sub-channel, decodes
what it can and remembers what was reserved; then messages that became ready in the slot find their resources.
"""

from typing import NamedTuple

import numpy as np

from modelcast.channel.antennas import Antennas
from modelcast.channel.copies_kernels import Copies, copies_room, kept_copies, settle
from modelcast.channel.frame_errors import FrameErrors
from modelcast.channel.frame_kernels import Asked, Heard, heard_room, nothing_heard
from modelcast.channel.frame_link_kernels import Links, no_links
from modelcast.channel.frame_outcome_kernels import tell_frame
from modelcast.channel.nr_selection_kernels import NrConstants, select_resources
from modelcast.channel.pool_air_kernels import (
    Air,
    Turns,
    add_turn,
    air_room,
    is_there,
    judge_frame,
    measure_busy,
    receive_frames,
    silence,
    silent_air,
    surroundings,
)
from modelcast.channel.propagation_kernels import PropagationTables
from modelcast.channel.random_kernels import uniform
from modelcast.channel.shadowing_kernels import Sweep
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

__all__ = ["COPIES", "GRANT_COLUMNS", "LENGTH", "MESSAGE", "SlotMemory", "advance"]

# Columns of ``grant`` (V, GRANT_COLUMNS): integers.
MESSAGE, _BYTES, _SENT, COPIES, LENGTH, _COUNTER, _UNUSED, _INTERVAL, _AGAIN = 0, 1, 2, 3, 4, 5, 6, 7, 8
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
    fits = grant[v, COPIES] > 0 and grant[v, LENGTH] >= length
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
    grant[v, LENGTH], grant[v, _INTERVAL], grant[v, _UNUSED] = length, interval, 0
    grant[v, _COUNTER] = _draw_counter(interval, random, constants) if interval > 0 else 1


@kernel(inlined=True)
def _are_reserved(v: int, slot: int, interval: int, memory: SlotMemory, constants: NrConstants) -> bool:
    """Return whether others are known to be where a vehicle's resources come back."""
    loudest_mw = np.float32(0.0)
    for k in range(memory.grant[v, COPIES]):
        at, band = memory.slots[v, k] + interval, memory.bands[v, k]
        if at - slot < constants.ahead:
            for s in range(band, band + memory.grant[v, LENGTH]):
                loudest_mw = max(loudest_mw, memory.reserved[at % constants.ahead, v, s])
    return bool(loudest_mw > constants.pool.reserved_mw)


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
    position_m: FloatMatrix,
    leak: FloatCube,
    turns: Turns,
    air: Air,
    heard: Heard,
    random: UInt64Vector,
    constants: NrConstants,
) -> tuple[int, int]:
    """Write who sends in this slot; return how many, and how many messages lapsed."""
    count, grant, slots = 0, memory.grant, memory.slots
    for v in range(grant.shape[0]):
        for k in range(constants.copies):
            if slots[v, k] != slot:
                continue
            waits = grant[v, MESSAGE] >= 0
            if waits and not is_there(v, position_m):
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
            length, dbm = int(grant[v, LENGTH]), float(memory.power_dbm[v])
            add_turn(
                count,
                v,
                int(memory.bands[v, k]),
                length,
                float(length),
                int(grant[v, _BYTES]),
                dbm,
                position_m,
                leak,
                turns,
                air,
                random,
            )
            count += 1
    return count, lapsed


@kernel(inlined=True)
def _reserve(v: int, j: int, copy: int, rsrp_mw: float, memory: SlotMemory, constants: NrConstants) -> None:
    """Remember at ``j`` what the control information of a copy reserves: copies to come, and itself again.

    Itself for every interval that begins within T2: Q times in TS 38.214, 8.1.4.
    """
    grant, slots, bands, reserved = memory.grant, memory.slots, memory.bands, memory.reserved
    length, interval = grant[v, LENGTH], grant[v, _INTERVAL]
    for k in range(copy, grant[v, COPIES]):
        uses = 1
        if k == copy:
            uses = (constants.last + interval - 1) // interval if grant[v, _AGAIN] == 1 else 0
        for use in range(uses):
            row = (slots[v, k] + use * interval) % constants.ahead
            for s in range(bands[v, k], bands[v, k] + length):
                reserved[row, j, s] = max(reserved[row, j, s], np.float32(rsrp_mw))


@kernel(inlined=True)
def _hear_reservations(
    turn: int, turns: Turns, links: Links, memory: SlotMemory, constants: NrConstants
) -> None:
    """Let who understands a frame's control information remember what it reserves."""
    v, pool = int(turns.who[turn, 0]), constants.pool
    copy, filled = int(memory.grant[v, _SENT]) - 1, turns.filled[turn]
    if copy + 1 >= memory.grant[v, COPIES] and memory.grant[v, _AGAIN] == 0:
        return
    for k in range(turns.first_link[turn], turns.first_link[turn + 1]):
        power_mw, other_mw = links.mw[k], links.other_mw[k]
        counted_mw = power_mw + other_mw if constants.reserved_by_total else power_mw
        rsrp_mw = counted_mw / (filled * pool.elements)
        # What is weaker excludes nothing.
        if rsrp_mw > pool.reserved_mw and power_mw >= pool.control_ratio * (
            pool.noise_mw * filled + other_mw
        ):
            _reserve(v, int(links.receiver[k]), copy, rsrp_mw, memory, constants)


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
    errors: FrameErrors,
    leak: FloatCube,
    tables: PropagationTables,
    constants: NrConstants,
) -> tuple[Heard, IntMatrix, IntMatrix]:
    """Carry the slots ``now`` to ``until``, the end excluded; the state's arrays are written into.

    ``lengths`` are sub-channels of messages of 0, 1, ... bytes. Returns the pairs that wait for another copy,
    and their spans, too.
    """
    sender, position_m, pool, present = asked.sender, sweep.position_m, constants.pool, sweep.cells.order.size
    vehicles = memory.grant.shape[0]
    ready_slot = np.floor(asked.ready_s * 1e3 * constants.slots_a_ms + 1e-6).astype(np.int64)
    around = surroundings(sweep, antennas)
    heard, received, lapsed = nothing_heard(pool.bins, sender.size + vehicles), 0, 0
    waiting = memory.copies.span[:, 1].sum()
    air, turns = silent_air(vehicles, pool.sub_channels)
    links = no_links()
    arrival = 0
    for slot in range(now, until):
        count, lapsed = _take_turns(
            slot, lapsed, memory, position_m, leak, turns, air, heard, random, constants
        )
        air = air_room(air, count)
        links, used = receive_frames(count, turns, air, links, around, tables, pool)
        memory.reserved[slot % constants.ahead] = 0.0  # what was reserved for this slot has come
        heard = heard_room(heard, received, used)
        end_s = (slot + 1) * 1e-3 / constants.slots_a_ms
        for turn in range(count):
            v = int(turns.who[turn, 0])
            first, last = turns.first_link[turn], turns.first_link[turn + 1]
            if constants.copies > 1:
                memory = _with_room(memory, v, waiting, present)
            judge_frame(turn, count, turns, air, links, errors, pool)
            _hear_reservations(turn, turns, links, memory, constants)
            message_id, copy = memory.grant[v, MESSAGE], memory.grant[v, _SENT] - 1
            more = bool(copy + 1 < memory.grant[v, COPIES])
            received, waiting = tell_frame(
                v,
                message_id,
                copy,
                more,
                first,
                last,
                end_s,
                links,
                memory.copies,
                heard,
                received,
                waiting,
            )
        _end_turns(count, slot, turns, memory, constants)
        silence(count, turns, links, air, memory.busy, pool)
        if (slot + 1) % pool.window == 0:
            measure_busy(memory.busy, memory.busy_ratio, pool)
        # Messages that became ready in this slot find their resources in later ones.
        while arrival < sender.size and ready_slot[arrival] <= slot:
            v, n = sender[arrival], arrival
            arrival += 1
            lapsed = _let_go(v, lapsed, memory, heard)
            if is_there(v, position_m):
                _take_in(n, slot, memory, asked, lengths, random, constants)
            else:
                heard.expired[lapsed] = asked.message_id[n]
                lapsed += 1

    pair, span = kept_copies(memory.copies)
    found, when = heard.who[:received].copy(), heard.when[:received].copy()
    return Heard(found, when, heard.outcomes, heard.expired[:lapsed].copy()), pair, span
