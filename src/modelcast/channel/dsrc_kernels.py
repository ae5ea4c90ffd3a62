"""Compiled IEEE 802.11p broadcast: one interval of EDCA, event by event.

Three kinds of event: a message becomes ready, a vehicle's countdown ends and its frame begins, a frame ends.
A frame touches the vehicles in range at its beginning and at its end, nobody else and at no other time.
Times are absolute seconds. There is no propagation delay (1 us is 300 m; a slot is 13 us).
"""

from typing import NamedTuple

import numpy as np

from modelcast.channel.airtime_kernels import SERVICE_TAIL_BITS, frame_airtime
from modelcast.channel.antennas import Antennas
from modelcast.channel.dsrc_link_kernels import (
    ACCESS_EVENT,
    END_EVENT,
    Links,
    close_links,
    empty_near,
    find_near,
    find_powers,
    heard_within_m,
    open_links,
    pack_links,
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
    IDLE_S,
    LOAD,
    LOADED_S,
    LOCK,
    LOCK_MW,
    MESSAGE,
    SEED,
    SENDING_S,
    START_S,
    DsrcConstants,
    draw_backoff,
    sense_medium,
)
from modelcast.channel.event_heap_kernels import Events, heap_room, pop_event, push_event
from modelcast.channel.frame_kernels import Asked, Heard, heard_room, nothing_heard
from modelcast.channel.propagation_kernels import PropagationTables
from modelcast.channel.random_kernels import next_word
from modelcast.channel.shadowing_kernels import SILENT, Sweep
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    FloatMatrix,
    FloatVector,
    IntMatrix,
    UInt64Vector,
)

__all__ = ["advance", "begin_interval", "end_interval", "find_reach"]

READY_EVENT = 2
"""Beside those of the heap: a message becomes ready."""


class Course(NamedTuple):
    """An interval under way: what is ahead, who has which frame on the air, what was heard.

    ``events`` is a heap, of ``ahead``. ``links`` are a pool that is filled in order, up to ``used``, and
    packed when it is full. ``heard`` holds ``received`` receptions, and ``lapsed`` messages never sent. The
    next message to become ready is ``arrival``; the next measuring window ends at ``boundary_s``.
    """

    events: Events
    ahead: int
    links: Links
    used: int
    heard: Heard
    received: int
    lapsed: int
    arrival: int
    boundary_s: float


@kernel(inlined=True)
def _sent_ln(power_dbm: float, constants: DsrcConstants) -> float:
    """Return the logarithm of a transmit power [mW] and of the gains of both antennas."""
    return (constants.gain_db + power_dbm) * np.log(10.0) / 10.0


@kernel
def find_reach(
    station: FloatMatrix,
    message: IntMatrix,
    asked: Asked,
    position_m: FloatMatrix,
    antennas: Antennas,
    tables: PropagationTables,
    constants: DsrcConstants,
) -> FloatMatrix:
    """Return the squared reach of what vehicles may send in this interval, as `lay_out` has it."""
    reach_m2, number = np.full((station.shape[0], 2), SILENT), asked.sender.size
    if not constants.shadowed:
        return reach_m2
    for n in range(number + station.shape[0]):
        v = int(asked.sender[n]) if n < number else n - number
        if n >= number and message[v, MESSAGE] < 0:
            continue
        if np.isfinite(position_m[v, 0]) and np.isfinite(position_m[v, 1]):
            dbm = asked.power_dbm[n] if n < number else station[v, DBM]
            sent_ln = _sent_ln(dbm, constants) + antennas.gain_ln[v]
            for to_weak in range(2):
                heard_ln = sent_ln + antennas.weak_ln * to_weak
                is_weak = to_weak == 1 or antennas.weak[v]
                quiet_mw = constants.weak_quiet_mw if is_weak else constants.quiet_mw
                reach_m = heard_within_m(heard_ln, tables, quiet_mw, constants.range_m)
                reach_m2[v, to_weak] = max(reach_m2[v, to_weak], reach_m * reach_m)
    return reach_m2


@kernel(inlined=True)
def _close_windows(
    station: FloatMatrix, boundary_s: float, until_s: float, constants: DsrcConstants
) -> float:
    """Work out the busy ratio of all measuring windows that end by then; return when the next one ends."""
    while boundary_s <= until_s:
        for k in range(station.shape[0]):
            if station[k, LOADED_S] >= 0.0:
                station[k, LOAD] += boundary_s - station[k, LOADED_S]
                station[k, LOADED_S] = boundary_s
            station[k, BUSY_RATIO] = min(station[k, LOAD] / constants.window_s, 1.0)
            station[k, LOAD] = 0.0
        boundary_s += constants.window_s
    return boundary_s


@kernel(inlined=True)
def _access_s(station: FloatMatrix, v: int, constants: DsrcConstants) -> float:
    """Return when the countdown of a vehicle ends if the medium stays idle."""
    return station[v, IDLE_S] + constants.aifs_s + station[v, BACKOFF] * constants.slot_s


@kernel(inlined=True)
def _contend(
    station: FloatMatrix, v: int, t_s: float, random: UInt64Vector, constants: DsrcConstants
) -> bool:
    """Let a message that became ready count down; return whether it does, the medium being idle."""
    unaware = station[v, BUSY] == 1.0 and t_s < station[v, BUSY_S] + constants.sensing_s
    idle = station[v, BUSY] == 0.0 or unaware
    counted_s = _access_s(station, v, constants)
    if idle and constants.immediate and counted_s <= t_s:
        station[v, BACKOFF] = 0.0
        station[v, ACCESS_S] = t_s
        return True
    over = station[v, BACKOFF] <= 0.0 or (idle and counted_s <= t_s)
    if over or not constants.immediate:
        station[v, BACKOFF] = draw_backoff(random, constants.window)
        if station[v, BUSY] == 0.0:
            station[v, IDLE_S] = max(station[v, IDLE_S], t_s + constants.arrival_aifs_s - constants.aifs_s)
    if station[v, BUSY] == 1.0:
        return False
    station[v, ACCESS_S] = _access_s(station, v, constants)
    return True


@kernel(inlined=True)
def _begin_frame(
    station: FloatMatrix, message: IntMatrix, v: int, t_s: float, word: np.uint64, constants: DsrcConstants
) -> None:
    """Put the message that waits on the air."""
    station[v, ACCESS_S] = np.inf
    station[v, BACKOFF] = 0.0
    message[v, AIR], message[v, MESSAGE] = message[v, MESSAGE], -1
    message[v, SEED] = np.int64(word >> np.uint64(1))
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


@kernel
def _events_ahead(station: FloatMatrix, message: IntMatrix) -> tuple[Events, int]:
    """Return the ends of frames on the air and of countdowns, and how many there are."""
    vehicles = station.shape[0]
    room = 4 * vehicles + 64
    events, count = Events(np.empty(room), np.empty(room, dtype=np.int64)), 0
    for v in range(vehicles):
        if message[v, AIR] >= 0:
            count = push_event(events, count, station[v, END_S], 2 * v + END_EVENT)
        if np.isfinite(station[v, ACCESS_S]):
            count = push_event(events, count, station[v, ACCESS_S], 2 * v + ACCESS_EVENT)
    return events, count


@kernel
def begin_interval(
    now_s: float,
    station: FloatMatrix,
    message: IntMatrix,
    air: Links,
    asked: Asked,
    constants: DsrcConstants,
) -> Course:
    """Return the course of an interval that begins now, with the links of the frames on the air."""
    vehicles = station.shape[0]
    links, used = pack_links(station, message, air, -1, max(16 * vehicles, 4096))
    events, count = _events_ahead(station, message)
    boundary_s = (np.floor(now_s / constants.window_s + 1e-9) + 1.0) * constants.window_s
    heard = nothing_heard(constants.bins, asked.sender.size + vehicles)
    return Course(events, count, links, used, heard, 0, 0, 0, boundary_s)


@kernel
def end_interval(station: FloatMatrix, message: IntMatrix, course: Course) -> tuple[Heard, Links]:
    """Return what was heard, and the links of the frames still on the air."""
    left, _ = pack_links(station, message, course.links, -1, 0)
    heard, received = course.heard, course.received
    expired = heard.expired[: course.lapsed].copy()
    return Heard(heard.who[:received], heard.when[:received], heard.outcomes, expired), left


@kernel
def advance(
    course: Course,
    stop_s: float,
    is_end: bool,
    random: UInt64Vector,
    station: FloatMatrix,
    message: IntMatrix,
    asked: Asked,
    sweep: Sweep,
    antennas: Antennas,
    hazard: FloatVector,
    tables: PropagationTables,
    constants: DsrcConstants,
) -> Course:
    """Carry an interval on up to a time, its end or one before; the arrays of the state are written into.

    Returns the course from there, whose arrays may be those of the one given. Where an interval was halted
    changes nothing.
    """
    number = asked.sender.size
    cells, rows, position_m = sweep.cells, sweep.rows, sweep.position_m
    present = cells.order.size
    near = empty_near(present)
    events, count, links, used, heard, received, lapsed, arrival, boundary_s = course

    while True:
        t_s, kind, v = np.inf, -1, -1
        if count > 0:
            t_s, kind, v = events.times[0], int(events.what[0] & 1), int(events.what[0] >> 1)
        if arrival < number and asked.ready_s[arrival] < t_s:
            t_s, kind, v = asked.ready_s[arrival], READY_EVENT, int(asked.sender[arrival])
        if t_s >= stop_s:
            if is_end:
                boundary_s = _close_windows(station, boundary_s, stop_s + 1e-9, constants)
            return Course(events, count, links, used, heard, received, lapsed, arrival, boundary_s)
        boundary_s = _close_windows(station, boundary_s, t_s, constants)

        if kind == END_EVENT:
            count = pop_event(events, count)
            receivers = int(station[v, COUNT])
            heard = heard_room(heard, received, receivers)
            events = heap_room(events, count + receivers)
            received, count = close_links(
                v, t_s, station, message, links, hazard, constants, heard, received, events, count
            )
            message[v, AIR] = -1
            station[v, COUNT] = 0.0
            station[v, SENDING_S] = t_s
            station[v, BACKOFF] = draw_backoff(random, constants.window)
            if sense_medium(station, v, t_s, constants) < 0 and message[v, MESSAGE] >= 0:
                station[v, ACCESS_S] = t_s + constants.aifs_s + station[v, BACKOFF] * constants.slot_s
                events = heap_room(events, count)
                count = push_event(events, count, station[v, ACCESS_S], 2 * v + ACCESS_EVENT)
            continue

        if kind == READY_EVENT:
            n = arrival
            arrival += 1
            waited = message[v, MESSAGE] >= 0
            absent = not (np.isfinite(position_m[v, 0]) and np.isfinite(position_m[v, 1]))
            if absent or waited:
                heard.expired[lapsed] = asked.message_id[n] if absent else message[v, MESSAGE]
                lapsed += 1
            if absent:
                continue
            message[v, MESSAGE] = asked.message_id[n]
            station[v, BYTES] = asked.size_bytes[n]
            station[v, DBM] = asked.power_dbm[n]
            if waited or station[v, SENDING_S] > t_s or not _contend(station, v, t_s, random, constants):
                continue
            if station[v, ACCESS_S] > t_s:
                events = heap_room(events, count)
                count = push_event(events, count, station[v, ACCESS_S], 2 * v + ACCESS_EVENT)
                continue
        else:
            count = pop_event(events, count)
            if station[v, ACCESS_S] != t_s or message[v, MESSAGE] < 0:
                continue
            if station[v, BUSY] == 1.0 and t_s >= station[v, BUSY_S] + constants.sensing_s:
                station[v, ACCESS_S] = np.inf  # the medium turned busy in time: counted down on its next idle
                continue

        _begin_frame(station, message, v, t_s, next_word(random), constants)
        events = heap_room(events, count)
        count = push_event(events, count, station[v, END_S], 2 * v + END_EVENT)
        if used + present > links.receiver.size:
            links, used = pack_links(station, message, links, v, links.receiver.size)
        sent_ln, seed = _sent_ln(station[v, DBM], constants) + antennas.gain_ln[v], message[v, SEED]
        reached = find_near(v, sent_ln, rows, position_m, cells, antennas, tables, constants, near)
        find_powers(v, sent_ln, seed, tables, constants, near, reached)
        used = open_links(v, t_s, station, links, used, hazard, constants, heard.outcomes, near, reached)
