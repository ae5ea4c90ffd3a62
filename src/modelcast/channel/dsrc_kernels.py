"""Compiled IEEE 802.11p broadcast: one interval of EDCA, event by event.

Three kinds of event: a message becomes ready, a vehicle's countdown ends and its frame begins, a frame ends.
A frame touches the vehicles in range at its beginning and at its end, nobody else and at no other time.
Times are absolute seconds. There is no propagation delay (1 us is 300 m; a slot is 13 us).
"""

from typing import Any, NamedTuple

import numba
import numpy as np

from modelcast.channel.borrowing_kernels import borrowing
from modelcast.channel.error_models import HAZARD_MIN_DB, HAZARD_PER_DB, HAZARD_SIZE
from modelcast.channel.grid_kernels import build_grid, cell_span
from modelcast.channel.propagation_kernels import (
    fading_factor,
    grow_pairs,
    looked_up,
    median_ln,
    pair_row,
    pair_shadowing,
)
from modelcast.channel.random_kernels import next_word, uniform

__all__ = [
    "AIR",
    "BUSY_RATIO",
    "COLUMNS",
    "MESSAGE",
    "DsrcConstants",
    "advance",
    "silent_station",
]

# Columns of ``station`` (V, COLUMNS).
_SIGNAL, _SIGNALS, _LOCK, _LOCK_MW, _LOCK_S, _CHANGED_S, _EXPOSURE = 0, 1, 2, 3, 4, 5, 6
_HIDDEN, _CONCURRENT, _CAPTURED_S, _RECENT_S, _RECENT_MW = 7, 8, 9, 10, 11
_BUSY, _BUSY_S, _IDLE_S, _SENDING_S, _BACKOFF, _ACCESS_S = 12, 13, 14, 15, 16, 17
_LOADED_S, _LOAD, BUSY_RATIO = 18, 19, 20
_READY_S, _BYTES, _DBM = 21, 22, 23
_START_S, _END_S, _AIR_BYTES, _FIRST, _COUNT = 24, 25, 26, 27, 28
COLUMNS = 29

MESSAGE, AIR = 0, 1
"""Columns of ``message`` (V, 2): number of the message that waits, and of the one on the air; -1 for none."""

_LOCKED, _HALF_DUPLEX, _WEAK, _IS_HIDDEN, _IS_CONCURRENT = 0, 1, 2, 3, 4
_RECEIVED = 0
_ACCESS, _END = 0, 1
_NEVER = -1e9


class DsrcConstants(NamedTuple):
    """Parameters as numbers; made by `Dsrc`. Powers are in mW, times in s."""

    slot_s: float
    aifs_s: float
    window: int
    sensing_s: float
    immediate: bool
    preamble_s: float
    symbol_s: float
    bits_per_symbol: int
    capture_s: float
    capture_ratio: float
    preamble_ratio: float
    noise_mw: float
    sensitivity_mw: float
    decodable_mw: float
    energy_mw: float
    load_mw: float
    floor_mw: float
    gain_db: float
    range_m: float
    bin_m: float
    bins: int
    window_s: float
    by_stretch: bool
    units_fixed: float
    units_per_byte: float
    shadowed: bool


@numba.njit(cache=True, nogil=True)
def silent_station(vehicles: int) -> Any:
    """Return the station columns of a silent channel, (V, COLUMNS)."""
    station = np.zeros((vehicles, COLUMNS))
    for v in range(vehicles):
        station[v, _LOCK] = -1.0
        for column in (_CAPTURED_S, _RECENT_S, _BUSY_S, _IDLE_S, _SENDING_S, _START_S, _END_S):
            station[v, column] = _NEVER
        station[v, _ACCESS_S] = np.inf
        station[v, _LOADED_S] = -1.0
    return station


@borrowing
def _hazard(ratio: float, table: Any) -> float:
    at = (10.0 * np.log10(ratio) - HAZARD_MIN_DB) * HAZARD_PER_DB
    if at <= 0.0:
        return table[0]
    if at >= HAZARD_SIZE - 1:
        return table[HAZARD_SIZE - 1]
    k = int(at)
    return table[k] + (at - k) * (table[k + 1] - table[k])


@borrowing
def _push(times: Any, what: Any, count: int, t_s: float, event: int) -> int:
    """Put an event into the heap, whose arrays have room; return the new count."""
    at = count
    while at > 0:
        parent = (at - 1) >> 1
        if times[parent] <= t_s:
            break
        times[at], what[at] = times[parent], what[parent]
        at = parent
    times[at], what[at] = t_s, event
    return count + 1


@borrowing
def _pop(times: Any, what: Any, count: int) -> int:
    """Take the first event out of the heap; return the new count."""
    count -= 1
    t_s, event = times[count], what[count]
    at = 0
    while True:
        child = 2 * at + 1
        if child >= count:
            break
        if child + 1 < count and times[child + 1] < times[child]:
            child += 1
        if times[child] >= t_s:
            break
        times[at], what[at] = times[child], what[child]
        at = child
    times[at], what[at] = t_s, event
    return count


@numba.njit(cache=True, nogil=True)
def _room(times: Any, what: Any, count: int) -> Any:
    """Return a heap with room for ``count`` events and two more."""
    if count + 2 <= times.size:
        return times, what
    held = times.size
    new_times, new_what = np.empty(2 * count + 2), np.empty(2 * count + 2, dtype=np.int64)
    new_times[:held], new_what[:held] = times, what
    return new_times, new_what


@borrowing
def _settle(station: Any, j: int, t_s: float, hazard: Any, constants: Any) -> None:
    """Count what a locked receiver suffered since its surroundings last changed."""
    holder = int(station[j, _LOCK])
    airtime_s = station[holder, _END_S] - station[holder, _START_S]
    payload_from = station[j, _LOCK_S] + constants.preamble_s
    since = max(station[j, _CHANGED_S], payload_from)
    station[j, _CHANGED_S] = t_s
    if t_s <= since:
        return
    other_mw = max(station[j, _SIGNAL] - station[j, _LOCK_MW], 0.0)
    if station[j, _SIGNALS] < 1.5:
        other_mw = 0.0
    if constants.by_stretch:
        share = (t_s - since) / (airtime_s - constants.preamble_s)
        ratio = station[j, _LOCK_MW] / (constants.noise_mw + other_mw)
        units = constants.units_fixed + constants.units_per_byte * station[holder, _AIR_BYTES]
        station[j, _EXPOSURE] += units * share * _hazard(ratio, hazard)
    else:
        station[j, _EXPOSURE] += other_mw * (t_s - since)


@borrowing
def _medium(station: Any, j: int, t_s: float, constants: Any) -> int:
    """Bring carrier sense and load up to date; return 1 where it turned busy, -1 where it turned idle."""
    sending = station[j, _SENDING_S] > t_s
    busy = (
        sending
        or (station[j, _LOCK] >= 0.0 and station[j, _LOCK_MW] >= constants.decodable_mw)
        or station[j, _SIGNAL] >= constants.energy_mw
    )
    loaded = sending or station[j, _SIGNAL] >= constants.load_mw
    if loaded:
        if station[j, _LOADED_S] < 0.0:
            station[j, _LOADED_S] = t_s
    elif station[j, _LOADED_S] >= 0.0:
        station[j, _LOAD] += t_s - station[j, _LOADED_S]
        station[j, _LOADED_S] = -1.0
    if busy:
        if station[j, _BUSY] == 0.0:
            station[j, _BUSY], station[j, _BUSY_S] = 1.0, t_s
            if station[j, _BACKOFF] > 0.0 and not (station[j, _ACCESS_S] < t_s + constants.sensing_s):
                passed = np.floor((t_s - station[j, _IDLE_S] - constants.aifs_s) / constants.slot_s + 1e-6)
                station[j, _BACKOFF] = max(station[j, _BACKOFF] - max(passed, 0.0), 0.0)
            return 1
        return 0
    if station[j, _BUSY] == 1.0:
        station[j, _BUSY], station[j, _IDLE_S] = 0.0, t_s
        return -1
    return 0


@borrowing
def _draw_backoff(random: Any, window: int) -> float:
    return np.floor(uniform(random) * (window + 1))


@borrowing
def _is_concurrent(first_s: float, second_s: float, slot_s: float) -> bool:
    return abs(first_s - second_s) < slot_s


@borrowing
def _begin(
    station: Any, j: int, sender: int, power_mw: float, t_s: float, end_s: float, hazard: Any, constants: Any
) -> int:
    """A frame begins at one receiver: add its power, lock or not; return the flag of this pair."""
    slot_s = constants.slot_s
    before_mw = station[j, _SIGNAL] if station[j, _SIGNALS] > 0.5 else 0.0
    locked = station[j, _LOCK] >= 0.0
    airtime_s = end_s - t_s
    concurrent_before = _is_concurrent(station[j, _RECENT_S], t_s, slot_s)
    if locked:
        _settle(station, j, t_s, hazard, constants)
    flag = _LOCKED
    if station[j, _SENDING_S] > t_s:
        flag = _HALF_DUPLEX
    elif power_mw < constants.sensitivity_mw or power_mw < constants.preamble_ratio * constants.noise_mw:
        flag = _WEAK
    else:
        heard = power_mw >= constants.preamble_ratio * (constants.noise_mw + before_mw)
        if locked:
            heard = t_s - station[
                j, _LOCK_S
            ] <= constants.capture_s and power_mw >= constants.capture_ratio * (
                constants.noise_mw + before_mw
            )
        if not heard:
            at_fault_s = station[j, _LOCK_S] if locked else station[j, _RECENT_S]
            flag = _IS_CONCURRENT if _is_concurrent(at_fault_s, t_s, slot_s) else _IS_HIDDEN
    if flag == _LOCKED:
        if locked:
            station[j, _CAPTURED_S] = t_s
        station[j, _LOCK], station[j, _LOCK_MW], station[j, _LOCK_S] = sender, power_mw, t_s
        station[j, _CHANGED_S], station[j, _EXPOSURE] = t_s, 0.0
        recent_mw = min(station[j, _RECENT_MW], before_mw) if concurrent_before else 0.0
        station[j, _CONCURRENT] = recent_mw * airtime_s
        station[j, _HIDDEN] = (before_mw - recent_mw) * airtime_s
    elif locked:
        overlap_s = min(end_s, station[int(station[j, _LOCK]), _END_S]) - t_s
        if _is_concurrent(station[j, _LOCK_S], t_s, slot_s):
            station[j, _CONCURRENT] += power_mw * overlap_s
        else:
            station[j, _HIDDEN] += power_mw * overlap_s
    station[j, _SIGNAL] = before_mw + power_mw
    station[j, _SIGNALS] += 1.0
    station[j, _RECENT_S], station[j, _RECENT_MW] = t_s, power_mw
    return flag


@borrowing
def _finish(
    station: Any,
    j: int,
    sender: int,
    power_mw: float,
    flag: int,
    t_s: float,
    hazard: Any,
    constants: Any,
    random: Any,
) -> int:
    """A frame ends at one receiver: take its power away; return what became of it."""
    start_s = station[sender, _START_S]
    outcome = flag
    mine = station[j, _LOCK] == sender
    if station[j, _LOCK] >= 0.0:
        _settle(station, j, t_s, hazard, constants)
    if station[j, _SENDING_S] > start_s:
        outcome = _HALF_DUPLEX
    elif mine:
        units = constants.units_fixed + constants.units_per_byte * station[sender, _AIR_BYTES]
        alone = units * _hazard(power_mw / constants.noise_mw, hazard)
        if constants.by_stretch:
            suffered = station[j, _EXPOSURE]
        else:
            mean_mw = station[j, _EXPOSURE] / (t_s - start_s - constants.preamble_s)
            suffered = units * _hazard(power_mw / (constants.noise_mw + mean_mw), hazard)
        luck = -np.log(1.0 - uniform(random))
        if suffered <= luck:
            outcome = _RECEIVED
        elif alone > luck:
            outcome = _WEAK
        else:
            outcome = _IS_CONCURRENT if station[j, _CONCURRENT] > station[j, _HIDDEN] else _IS_HIDDEN
    elif flag == _LOCKED:  # a stronger frame took the receiver away
        outcome = (
            _IS_CONCURRENT
            if _is_concurrent(station[j, _CAPTURED_S], start_s, constants.slot_s)
            else _IS_HIDDEN
        )
    if mine:
        station[j, _LOCK], station[j, _LOCK_MW] = -1.0, 0.0
    station[j, _SIGNALS] -= 1.0
    station[j, _SIGNAL] = max(station[j, _SIGNAL] - power_mw, 0.0) if station[j, _SIGNALS] > 0.5 else 0.0
    return outcome


@borrowing
def _open_links(
    v: int,
    t_s: float,
    end_s: float,
    sent_ln: float,
    random: Any,
    station: Any,
    link_receiver: Any,
    link_mw: Any,
    link_flag: Any,
    used: int,
    pairs: Any,
    pair_count: Any,
    position_m: Any,
    grid: Any,
    hazard: Any,
    tables: Any,
    constants: Any,
    outcomes: Any,
    near: Any,
) -> int:
    """A frame of ``v`` begins at all vehicles in range; return how much of the pool is used."""
    vehicles = station.shape[0]
    range_m = constants.range_m
    open_ground = tables.nlos_kind == 0
    east, north = position_m[v, 0], position_m[v, 1]
    column_from, column_to = cell_span(east, grid.corner_east_m, grid.cell_m, grid.columns, range_m)
    row_from, row_to = cell_span(north, grid.corner_north_m, grid.cell_m, grid.rows, range_m)
    # First who is near, and where the pair's shadowing is kept: a short loop lets cache misses overlap.
    count = 0
    for row in range(row_from, row_to + 1):
        low = grid.start[row * grid.columns + column_from]
        high = grid.start[row * grid.columns + column_to + 1]
        for k in range(low, high):
            away_east, away_north = grid.place[k, 0] - east, grid.place[k, 1] - north
            square = away_east * away_east + away_north * away_north
            j = grid.order[k]
            if square <= range_m * range_m and j != v:
                near[count, 0] = k
                if constants.shadowed:
                    near[count, 1] = pair_row(min(v, j) * vehicles + max(v, j), pairs)
                count += 1
    for n in range(count):
        k = near[n, 0]
        j = grid.order[k]
        away_east, away_north = grid.place[k, 0] - east, grid.place[k, 1] - north
        distance_m = np.sqrt(away_east * away_east + away_north * away_north)
        if open_ground:
            ln, los = looked_up(tables.los_ln, distance_m * tables.per_m), True
        else:
            ln, los = median_ln(east, north, grid.place[k, 0], grid.place[k, 1], distance_m, tables)
        word = next_word(random)
        if constants.shadowed:
            key = min(v, j) * vehicles + max(v, j)
            row = near[n, 1]
            if pairs[row, 0] != key:  # a new pair of this very frame may have taken the free row
                row = pair_row(key, pairs)
            sigma = tables.shadowing_los_ln if los else tables.shadowing_nlos_ln
            sign = 1.0 if v < j else -1.0
            shadow = pair_shadowing(
                row,
                key,
                sign * away_east,
                sign * away_north,
                word,
                tables.normal,
                tables.decorrelation_m,
                pairs,
                pair_count,
            )
            ln += sigma * shadow
        power_mw = np.exp(sent_ln + min(ln, 0.0)) * fading_factor(
            distance_m, word, tables.fading, tables.fading_near_m, tables.fading_far_m
        )
        group = int(distance_m / constants.bin_m)
        if power_mw < constants.floor_mw:
            if group < constants.bins:
                outcomes[group, _HALF_DUPLEX if station[j, _SENDING_S] > t_s else _WEAK] += 1
            continue
        flag = _begin(station, j, v, power_mw, t_s, end_s, hazard, constants)
        link_receiver[used], link_mw[used] = j, power_mw
        link_flag[used, 0], link_flag[used, 1] = flag, min(group, constants.bins)
        used += 1
        turned = _medium(station, j, t_s, constants)
        if turned > 0 and station[j, _ACCESS_S] >= t_s + constants.sensing_s:
            station[j, _ACCESS_S] = np.inf
    return used


@borrowing
def _close_links(
    v: int,
    t_s: float,
    random: Any,
    station: Any,
    message: Any,
    link_receiver: Any,
    link_mw: Any,
    link_flag: Any,
    hazard: Any,
    constants: Any,
    who: Any,
    when: Any,
    received: int,
    outcomes: Any,
    times: Any,
    what: Any,
    count: int,
) -> Any:
    """A frame of ``v`` ends at all its receivers; return the numbers of receptions and of events."""
    first, links = int(station[v, _FIRST]), int(station[v, _COUNT])
    for k in range(first, first + links):
        j = link_receiver[k]
        outcome = _finish(station, j, v, link_mw[k], link_flag[k, 0], t_s, hazard, constants, random)
        if link_flag[k, 1] < constants.bins:
            outcomes[link_flag[k, 1], outcome] += 1
        if outcome == _RECEIVED:
            who[received, 0], who[received, 1], who[received, 2] = message[v, AIR], v, j
            when[received, 0], when[received, 1] = t_s, link_mw[k]
            received += 1
        if _medium(station, j, t_s, constants) < 0 and message[j, MESSAGE] >= 0:
            station[j, _ACCESS_S] = t_s + constants.aifs_s + station[j, _BACKOFF] * constants.slot_s
            count = _push(times, what, count, station[j, _ACCESS_S], 2 * j + _ACCESS)
    return received, count


@numba.njit(cache=True, nogil=True)
def advance(
    now_s: float,
    until_s: float,
    random: Any,
    station: Any,
    message: Any,
    air_receiver: Any,
    air_mw: Any,
    air_flag: Any,
    pairs: Any,
    pair_count: Any,
    sender: Any,
    ready_s: Any,
    size_bytes: Any,
    power_dbm: Any,
    message_id: Any,
    position_m: Any,
    hazard: Any,
    tables: Any,
    constants: Any,
) -> Any:
    """Carry one interval; the arrays of the state are written into.

    Returns receptions (message, sender and receiver as (R, 3) integers, time and power as (R, 2)), outcomes
    (bins, 5), expired messages, and the arrays of the state that may have been replaced: receivers, powers
    and flags of the frames still on the air, and the store of pairs.
    """
    vehicles = station.shape[0]
    grid = build_grid(position_m, constants.range_m)
    present = grid.order.size
    gain_ln = constants.gain_db * np.log(10.0) / 10.0

    near = np.empty((present, 2), dtype=np.int64)
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
            count = _push(times, what, count, station[v, _END_S], 2 * v + _END)
        if np.isfinite(station[v, _ACCESS_S]):
            count = _push(times, what, count, station[v, _ACCESS_S], 2 * v + _ACCESS)
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
                if station[k, _LOADED_S] >= 0.0:
                    station[k, _LOAD] += boundary_s - station[k, _LOADED_S]
                    station[k, _LOADED_S] = boundary_s
                station[k, BUSY_RATIO] = min(station[k, _LOAD] / constants.window_s, 1.0)
                station[k, _LOAD] = 0.0
            boundary_s += constants.window_s
        if ends:
            break
        t_s = next_s

        if kind == _END:
            count = _pop(times, what, count)
            links = int(station[v, _COUNT])
            while received + links > who.shape[0]:
                new_who = np.empty((2 * who.shape[0], 3), dtype=np.int64)
                new_when = np.empty((2 * who.shape[0], 2))
                new_who[:received], new_when[:received] = who[:received], when[:received]
                who, when = new_who, new_when
            times, what = _room(times, what, count + links)
            received, count = _close_links(
                v,
                t_s,
                random,
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
            station[v, _COUNT] = 0.0
            station[v, _SENDING_S] = t_s
            station[v, _BACKOFF] = _draw_backoff(random, constants.window)
            if _medium(station, v, t_s, constants) < 0 and message[v, MESSAGE] >= 0:
                station[v, _ACCESS_S] = t_s + constants.aifs_s + station[v, _BACKOFF] * constants.slot_s
                times, what = _room(times, what, count)
                count = _push(times, what, count, station[v, _ACCESS_S], 2 * v + _ACCESS)
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
            station[v, _READY_S], station[v, _BYTES], station[v, _DBM] = t_s, size_bytes[n], power_dbm[n]
            if waited or station[v, _SENDING_S] > t_s:
                continue
            unaware = station[v, _BUSY] == 1.0 and t_s < station[v, _BUSY_S] + constants.sensing_s
            idle = station[v, _BUSY] == 0.0 or unaware
            counted_s = station[v, _IDLE_S] + constants.aifs_s + station[v, _BACKOFF] * constants.slot_s
            if idle and constants.immediate and counted_s <= t_s:
                station[v, _BACKOFF] = 0.0
                station[v, _ACCESS_S] = t_s
            else:
                over = station[v, _BACKOFF] <= 0.0 or (idle and counted_s <= t_s)
                if over or not constants.immediate:
                    station[v, _BACKOFF] = _draw_backoff(random, constants.window)
                    if station[v, _BUSY] == 0.0:
                        station[v, _IDLE_S] = max(station[v, _IDLE_S], t_s - constants.aifs_s)
                if station[v, _BUSY] == 1.0:
                    continue
                station[v, _ACCESS_S] = (
                    station[v, _IDLE_S] + constants.aifs_s + station[v, _BACKOFF] * constants.slot_s
                )
            if station[v, _ACCESS_S] > t_s:
                times, what = _room(times, what, count)
                count = _push(times, what, count, station[v, _ACCESS_S], 2 * v + _ACCESS)
                continue
        else:
            count = _pop(times, what, count)
            if station[v, _ACCESS_S] != t_s or message[v, MESSAGE] < 0:
                continue
            if station[v, _BUSY] == 1.0 and t_s >= station[v, _BUSY_S] + constants.sensing_s:
                station[v, _ACCESS_S] = (
                    np.inf
                )  # the medium turned busy in time: counted down on its next idle
                continue

        # A frame begins.
        station[v, _ACCESS_S] = np.inf
        station[v, _BACKOFF] = 0.0
        message[v, AIR], message[v, MESSAGE] = message[v, MESSAGE], -1
        bits = 22 + 8 * int(station[v, _BYTES])
        symbols = (bits + constants.bits_per_symbol - 1) // constants.bits_per_symbol
        end_s = t_s + constants.preamble_s + constants.symbol_s * symbols
        station[v, _START_S], station[v, _END_S], station[v, _AIR_BYTES] = t_s, end_s, station[v, _BYTES]
        station[v, _SENDING_S] = end_s
        station[v, _LOCK], station[v, _LOCK_MW] = -1.0, 0.0
        _medium(station, v, t_s, constants)
        times, what = _room(times, what, count)
        count = _push(times, what, count, end_s, 2 * v + _END)

        if used + present > link_receiver.size:
            live = 0
            for k in range(vehicles):
                if message[k, AIR] >= 0 and k != v:
                    live += int(station[k, _COUNT])
            pool = max(pool, 2 * (live + present))
            new_receiver, new_mw = np.empty(pool, dtype=np.int32), np.empty(pool)
            new_flag = np.empty((pool, 2), dtype=np.int16)
            used = 0
            for k in range(vehicles):
                if message[k, AIR] >= 0 and k != v:
                    first, links = int(station[k, _FIRST]), int(station[k, _COUNT])
                    new_receiver[used : used + links] = link_receiver[first : first + links]
                    new_mw[used : used + links] = link_mw[first : first + links]
                    new_flag[used : used + links] = link_flag[first : first + links]
                    station[k, _FIRST] = used
                    used += links
            link_receiver, link_mw, link_flag = new_receiver, new_mw, new_flag
        if constants.shadowed and 2 * (pair_count[0] + present) > pairs.shape[0]:
            pairs, pair_count = grow_pairs(pairs, position_m, 1.2 * constants.range_m, present)

        station[v, _FIRST] = used
        sent_ln = gain_ln + station[v, _DBM] * np.log(10.0) / 10.0
        used = _open_links(
            v,
            t_s,
            end_s,
            sent_ln,
            random,
            station,
            link_receiver,
            link_mw,
            link_flag,
            used,
            pairs,
            pair_count,
            position_m,
            grid,
            hazard,
            tables,
            constants,
            outcomes,
            near,
        )
        station[v, _COUNT] = used - int(station[v, _FIRST])

    live = 0
    for k in range(vehicles):
        if message[k, AIR] >= 0:
            live += int(station[k, _COUNT])
    left_receiver, left_mw = np.empty(live, dtype=np.int32), np.empty(live)
    left_flag = np.empty((live, 2), dtype=np.int16)
    at = 0
    for k in range(vehicles):
        if message[k, AIR] >= 0:
            first, links = int(station[k, _FIRST]), int(station[k, _COUNT])
            left_receiver[at : at + links] = link_receiver[first : first + links]
            left_mw[at : at + links] = link_mw[first : first + links]
            left_flag[at : at + links] = link_flag[first : first + links]
            station[k, _FIRST] = at
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
        pair_count,
    )
