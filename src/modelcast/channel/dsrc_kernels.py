"""Compiled IEEE 802.11p broadcast: one interval of EDCA, event by event.

Three kinds of event: a message becomes ready, a vehicle's countdown ends and its frame begins, a frame ends.
A frame touches the vehicles in range at its beginning and at its end, nobody else and at no other time.
Times are absolute seconds. There is no propagation delay (1 us is 300 m; a slot is 13 us).
"""

import numpy as np

from modelcast.channel.airtime_kernels import SERVICE_TAIL_BITS, frame_airtime
from modelcast.channel.cells_kernels import build_cells
from modelcast.channel.dsrc_link_kernels import (
    ACCESS_EVENT,
    END_EVENT,
    WORK,
    close_links,
    find_near,
    find_powers,
    heard_within_m,
    open_links,
)
from modelcast.channel.dsrc_station_kernels import (
    ACCESS_S,
    AIR,
    AIR_BYTES,
    BACKOFF,
    BUSY,
    BUSY_RATIO,
    BUSY_S,
    BYTES,
    COUNT,
    DBM,
    END_S,
    FIRST,
    IDLE_S,
    LOAD,
    LOADED_S,
    LOCK,
    LOCK_MW,
    MESSAGE,
    READY_S,
    SEED,
    SENDING_S,
    START_S,
    DsrcConstants,
    draw_backoff,
    sense_medium,
)
from modelcast.channel.event_heap_kernels import heap_room, pop_event, push_event
from modelcast.channel.pair_kernels import Pairs
from modelcast.channel.propagation_kernels import PropagationTables
from modelcast.channel.random_kernels import next_word
from modelcast.channel.shadowing_kernels import SILENT, shadow_rows
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    FloatMatrix,
    FloatVector,
    Int16Matrix,
    Int32Vector,
    IntMatrix,
    IntVector,
    UInt64Vector,
)

__all__ = ["advance"]


@kernel(inlined=True)
def _sent_ln(power_dbm: float, constants: DsrcConstants) -> float:
    """Return the logarithm of a transmit power [mW] and of the gains of both antennas."""
    return (constants.gain_db + power_dbm) * np.log(10.0) / 10.0


@kernel
def _find_reach(
    station: FloatMatrix,
    message: IntMatrix,
    sender: IntVector,
    power_dbm: FloatVector,
    position_m: FloatMatrix,
    tables: PropagationTables,
    constants: DsrcConstants,
) -> FloatVector:
    """Return the squared reach of what vehicles may send in this interval, as `shadow_rows` has it."""
    reach_m2 = np.full(station.shape[0], SILENT)
    if not constants.shadowed:
        return reach_m2
    for n in range(sender.size + station.shape[0]):
        v = sender[n] if n < sender.size else n - sender.size
        if n >= sender.size and message[v, MESSAGE] < 0:
            continue
        if np.isfinite(position_m[v, 0]) and np.isfinite(position_m[v, 1]):
            dbm = power_dbm[n] if n < sender.size else station[v, DBM]
            reach_m = heard_within_m(_sent_ln(dbm, constants), tables, constants.quiet_mw, constants.range_m)
            reach_m2[v] = max(reach_m2[v], reach_m * reach_m)
    return reach_m2


@kernel
def advance(
    now_s: float,
    until_s: float,
    random: UInt64Vector,
    station: FloatMatrix,
    message: IntMatrix,
    air_receiver: Int32Vector,
    air_mw: FloatVector,
    air_flag: Int16Matrix,
    pairs: Pairs,
    sender: IntVector,
    ready_s: FloatVector,
    size_bytes: IntVector,
    power_dbm: FloatVector,
    message_id: IntVector,
    position_m: FloatMatrix,
    hazard: FloatVector,
    tables: PropagationTables,
    constants: DsrcConstants,
) -> tuple[
    IntMatrix,
    FloatMatrix,
    IntMatrix,
    IntVector,
    Int32Vector,
    FloatVector,
    Int16Matrix,
    Pairs,
]:
    """Carry one interval; the arrays of the state are written into.

    Returns receptions (message, sender and receiver as (R, 3) integers, time and power as (R, 2)), outcomes
    (bins, 5), expired messages, and the arrays of the state that may have been replaced: receivers, powers
    and flags of the frames still on the air, and the store of pairs.
    """
    vehicles = station.shape[0]
    cells = build_cells(position_m, constants.range_m)
    present = cells.order.size

    reach_m2 = _find_reach(station, message, sender, power_dbm, position_m, tables, constants)
    rows, pairs = shadow_rows(reach_m2, position_m, cells, random[1], tables, constants.range_m, pairs)
    near, work = np.empty((present, 2), dtype=np.int64), np.empty((WORK, present))
    who = np.empty((1024, 3), dtype=np.int64)
    when = np.empty((1024, 2))
    received = 0
    outcomes = np.zeros((constants.bins, 5), dtype=np.int64)
    expired = np.empty(sender.size + vehicles, dtype=np.int64)
    lapsed = 0

    # Links of the frames on the air: a pool that is filled in order and packed when it is full.
    pool = max(air_receiver.size + 16 * vehicles, 4096)
    link_receiver = np.empty(pool, dtype=np.int32)
    link_mw = np.empty(pool)
    link_flag = np.empty((pool, 2), dtype=np.int16)
    used = air_receiver.size
    link_receiver[:used], link_mw[:used], link_flag[:used] = air_receiver, air_mw, air_flag

    times, what, count = np.empty(4 * vehicles + 64), np.empty(4 * vehicles + 64, dtype=np.int64), 0
    for v in range(vehicles):
        if message[v, AIR] >= 0:
            count = push_event(times, what, count, station[v, END_S], 2 * v + END_EVENT)
        if np.isfinite(station[v, ACCESS_S]):
            count = push_event(times, what, count, station[v, ACCESS_S], 2 * v + ACCESS_EVENT)
    arrival = 0
    boundary_s = (np.floor(now_s / constants.window_s + 1e-9) + 1.0) * constants.window_s

    while True:
        next_s, kind, v = np.inf, -1, -1
        if count > 0:
            next_s, kind, v = times[0], what[0] & 1, what[0] >> 1
        if arrival < sender.size and ready_s[arrival] < next_s:
            next_s, kind, v = ready_s[arrival], 2, sender[arrival]
        ends = next_s >= until_s
        while boundary_s <= (until_s + 1e-9 if ends else next_s):
            for k in range(vehicles):
                if station[k, LOADED_S] >= 0.0:
                    station[k, LOAD] += boundary_s - station[k, LOADED_S]
                    station[k, LOADED_S] = boundary_s
                station[k, BUSY_RATIO] = min(station[k, LOAD] / constants.window_s, 1.0)
                station[k, LOAD] = 0.0
            boundary_s += constants.window_s
        if ends:
            break
        t_s = next_s

        if kind == END_EVENT:
            count = pop_event(times, what, count)
            links = int(station[v, COUNT])
            while received + links > who.shape[0]:
                new_who = np.empty((2 * who.shape[0], 3), dtype=np.int64)
                new_when = np.empty((2 * who.shape[0], 2))
                new_who[:received], new_when[:received] = who[:received], when[:received]
                who, when = new_who, new_when
            times, what = heap_room(times, what, count + links)
            received, count = close_links(
                v,
                t_s,
                station,
                message,
                link_receiver,
                link_mw,
                link_flag,
                hazard,
                constants,
                who,
                when,
                received,
                outcomes,
                times,
                what,
                count,
            )
            message[v, AIR] = -1
            station[v, COUNT] = 0.0
            station[v, SENDING_S] = t_s
            station[v, BACKOFF] = draw_backoff(random, constants.window)
            if sense_medium(station, v, t_s, constants) < 0 and message[v, MESSAGE] >= 0:
                station[v, ACCESS_S] = t_s + constants.aifs_s + station[v, BACKOFF] * constants.slot_s
                times, what = heap_room(times, what, count)
                count = push_event(times, what, count, station[v, ACCESS_S], 2 * v + ACCESS_EVENT)
            continue

        if kind == 2:
            n = arrival
            arrival += 1
            if not (np.isfinite(position_m[v, 0]) and np.isfinite(position_m[v, 1])):
                expired[lapsed] = message_id[n]
                lapsed += 1
                continue
            if message[v, MESSAGE] >= 0:
                expired[lapsed] = message[v, MESSAGE]
                lapsed += 1
            waited = message[v, MESSAGE] >= 0
            message[v, MESSAGE] = message_id[n]
            station[v, READY_S], station[v, BYTES], station[v, DBM] = t_s, size_bytes[n], power_dbm[n]
            if waited or station[v, SENDING_S] > t_s:
                continue
            unaware = station[v, BUSY] == 1.0 and t_s < station[v, BUSY_S] + constants.sensing_s
            idle = station[v, BUSY] == 0.0 or unaware
            counted_s = station[v, IDLE_S] + constants.aifs_s + station[v, BACKOFF] * constants.slot_s
            if idle and constants.immediate and counted_s <= t_s:
                station[v, BACKOFF] = 0.0
                station[v, ACCESS_S] = t_s
            else:
                over = station[v, BACKOFF] <= 0.0 or (idle and counted_s <= t_s)
                if over or not constants.immediate:
                    station[v, BACKOFF] = draw_backoff(random, constants.window)
                    if station[v, BUSY] == 0.0:
                        station[v, IDLE_S] = max(station[v, IDLE_S], t_s - constants.aifs_s)
                if station[v, BUSY] == 1.0:
                    continue
                station[v, ACCESS_S] = (
                    station[v, IDLE_S] + constants.aifs_s + station[v, BACKOFF] * constants.slot_s
                )
            if station[v, ACCESS_S] > t_s:
                times, what = heap_room(times, what, count)
                count = push_event(times, what, count, station[v, ACCESS_S], 2 * v + ACCESS_EVENT)
                continue
        else:
            count = pop_event(times, what, count)
            if station[v, ACCESS_S] != t_s or message[v, MESSAGE] < 0:
                continue
            if station[v, BUSY] == 1.0 and t_s >= station[v, BUSY_S] + constants.sensing_s:
                station[v, ACCESS_S] = np.inf  # the medium turned busy in time: counted down on its next idle
                continue

        # A frame begins.
        station[v, ACCESS_S] = np.inf
        station[v, BACKOFF] = 0.0
        message[v, AIR], message[v, MESSAGE] = message[v, MESSAGE], -1
        message[v, SEED] = np.int64(next_word(random) >> np.uint64(1))
        end_s = t_s + frame_airtime(
            int(station[v, BYTES]),
            constants.preamble_s,
            constants.symbol_s,
            SERVICE_TAIL_BITS,
            constants.bits_per_symbol,
        )
        station[v, START_S], station[v, END_S], station[v, AIR_BYTES] = t_s, end_s, station[v, BYTES]
        station[v, SENDING_S] = end_s
        station[v, LOCK], station[v, LOCK_MW] = -1.0, 0.0
        sense_medium(station, v, t_s, constants)
        times, what = heap_room(times, what, count)
        count = push_event(times, what, count, end_s, 2 * v + END_EVENT)

        if used + present > link_receiver.size:
            live = 0
            for k in range(vehicles):
                if message[k, AIR] >= 0 and k != v:
                    live += int(station[k, COUNT])
            pool = max(pool, 2 * (live + present))
            new_receiver, new_mw = np.empty(pool, dtype=np.int32), np.empty(pool)
            new_flag = np.empty((pool, 2), dtype=np.int16)
            used = 0
            for k in range(vehicles):
                if message[k, AIR] >= 0 and k != v:
                    first, links = int(station[k, FIRST]), int(station[k, COUNT])
                    new_receiver[used : used + links] = link_receiver[first : first + links]
                    new_mw[used : used + links] = link_mw[first : first + links]
                    new_flag[used : used + links] = link_flag[first : first + links]
                    station[k, FIRST] = used
                    used += links
            link_receiver, link_mw, link_flag = new_receiver, new_mw, new_flag

        station[v, FIRST] = used
        sent_ln = _sent_ln(station[v, DBM], constants)
        reached = find_near(
            v, t_s, sent_ln, station, position_m, cells, tables, constants, outcomes, near, work
        )
        seed = message[v, SEED]
        find_powers(v, sent_ln, seed, rows, position_m, cells, tables, constants, near, work, reached)
        used = open_links(
            v,
            t_s,
            end_s,
            station,
            link_receiver,
            link_mw,
            link_flag,
            used,
            cells,
            hazard,
            constants,
            outcomes,
            near,
            work,
            reached,
        )
        station[v, COUNT] = used - int(station[v, FIRST])

    live = 0
    for k in range(vehicles):
        if message[k, AIR] >= 0:
            live += int(station[k, COUNT])
    left_receiver, left_mw = np.empty(live, dtype=np.int32), np.empty(live)
    left_flag = np.empty((live, 2), dtype=np.int16)
    at = 0
    for k in range(vehicles):
        if message[k, AIR] >= 0:
            first, links = int(station[k, FIRST]), int(station[k, COUNT])
            left_receiver[at : at + links] = link_receiver[first : first + links]
            left_mw[at : at + links] = link_mw[first : first + links]
            left_flag[at : at + links] = link_flag[first : first + links]
            station[k, FIRST] = at
            at += links
    return (
        who[:received].copy(),
        when[:received].copy(),
        outcomes,
        expired[:lapsed].copy(),
        left_receiver,
        left_mw,
        left_flag,
        pairs,
    )
