"""Compiled links of IEEE 802.11p frames: what a frame's beginning and end do to everybody in range."""

from typing import NamedTuple

import numpy as np

from modelcast.channel.antennas import Antennas
from modelcast.channel.cells_kernels import Cells, cell_span, row_span
from modelcast.channel.dsrc_station_kernels import (
    ACCESS_S,
    AIR,
    BACKOFF,
    COUNT,
    END_S,
    FIRST,
    HALF_DUPLEX,
    IDLE_S,
    LOCK,
    LOCKABLE,
    MESSAGE,
    RECEIVED,
    RECENT_MW,
    RECENT_S,
    SEED,
    SENDING_S,
    START_S,
    WEAK,
    DsrcConstants,
    begin_reception,
    disturb,
    finish_reception,
    sense_medium,
)
from modelcast.channel.event_heap_kernels import Events, push_event
from modelcast.channel.frame_kernels import Heard
from modelcast.channel.propagation_kernels import (
    PropagationTables,
    fading_factor,
    is_raised,
    looked_up,
    median_ln,
)
from modelcast.channel.random_kernels import word_of
from modelcast.channel.shadowing_kernels import ShadowRows
from modelcast.core.exponential_kernels import fast_exp
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    FloatMatrix,
    FloatVector,
    Int16Matrix,
    Int32Vector,
    IntMatrix,
    IntVector,
)

__all__ = [
    "ACCESS_EVENT",
    "END_EVENT",
    "Links",
    "Near",
    "close_links",
    "empty_near",
    "find_near",
    "find_powers",
    "heard_within_m",
    "open_links",
    "pack_links",
]

ACCESS_EVENT, END_EVENT = 0, 1
"""Low bit of an event: a countdown ends, a frame ends; the other bits are the vehicle."""

SQUARE_M2, DISTANCE_M, SHADOW, POWER_MW, FADING, GROUP, WORK = 0, 1, 2, 3, 4, 5, 6
"""Rows of ``work`` (WORK, N), what is found out about the vehicles near a frame, and their number; the last
is the bin of distance, a whole number, that of the constants for what is not counted."""

STRONG, DISTURBED, QUIET, KINDS = 0, 1, 2, 3
"""Rows of ``kind`` (KINDS, N), and their number."""


class Links(NamedTuple):
    """A frame at its receivers, frame after frame: who, power [mW], and flag and distance bin, (L, 2)."""

    receiver: Int32Vector
    mw: FloatVector
    flag: Int16Matrix


class Near(NamedTuple):
    """Who is near a frame: all that may notice it, and all within the bins of distance.

    ``who`` (N,) they are, a random ``word`` (N,) for each, and its ``place`` (N,) in the rows of shadowing;
    ``work`` (WORK, N). ``kind`` (KINDS, N + 1)
    lists who can lock on to it, who is disturbed at most, and who does not notice.
    """

    who: IntVector
    word: IntVector
    place: IntVector
    work: FloatMatrix
    kind: IntMatrix


@kernel
def empty_near(most: int) -> Near:
    """Return room for so many vehicles near a frame."""
    return Near(
        np.empty(most, dtype=np.int64),
        np.empty(most, dtype=np.int64),
        np.empty(most, dtype=np.int64),
        np.empty((WORK, most)),
        np.empty((KINDS, most + 1), dtype=np.int64),
    )


@kernel
def pack_links(
    station: FloatMatrix, message: IntMatrix, links: Links, sender: int, spare: int
) -> tuple[Links, int]:
    """Return the links of the frames on the air but that of ``sender``, with spare room, and their number."""
    live = 0
    for k in range(station.shape[0]):
        if message[k, AIR] >= 0 and k != sender:
            live += int(station[k, COUNT])
    size = live + spare
    packed = Links(np.empty(size, dtype=np.int32), np.empty(size), np.empty((size, 2), dtype=np.int16))
    used = 0
    for k in range(station.shape[0]):
        if message[k, AIR] >= 0 and k != sender:
            first, end = int(station[k, FIRST]), int(station[k, FIRST] + station[k, COUNT])
            to = used + end - first
            packed.receiver[used:to] = links.receiver[first:end]
            packed.mw[used:to] = links.mw[first:end]
            packed.flag[used:to] = links.flag[first:end]
            station[k, FIRST], used = used, to
    return packed, used


@kernel(inlined=True)
def heard_within_m(sent_ln: float, tables: PropagationTables, quiet_mw: float, range_m: float) -> float:
    """Return the distance at which a frame's median power falls below ``quiet_mw``, at most the range."""
    needed_ln = np.log(quiet_mw) - sent_ln
    low, high = 0, min(int(range_m * tables.per_m) + 1, tables.reach_ln.size - 1)
    if tables.reach_ln[high] >= needed_ln:
        return range_m
    while high - low > 1:
        middle = (low + high) // 2
        if tables.reach_ln[middle] >= needed_ln:
            low = middle
        else:
            high = middle
    return min(high / tables.per_m, range_m)


@kernel(inlined=True)
def find_near(
    v: int,
    sent_ln: float,
    rows: ShadowRows,
    position_m: FloatMatrix,
    cells: Cells,
    antennas: Antennas,
    tables: PropagationTables,
    constants: DsrcConstants,
    near: Near,
) -> int:
    """Write who is near a frame of ``v``, and their median powers in logarithms; return how many they are.

    Loops that touch few arrays run several at a time, so there are many of them. Who neither notices the
    frame nor counts among its outcomes is passed over; every place is written and the next overwrites it
    unless it is near: a branch would be guessed wrongly too often.
    """
    east, north = position_m[v, 0], position_m[v, 1]
    counted_m = 0.0 if antennas.weak[v] else min(constants.bins * constants.bin_m, constants.range_m)
    quiet_mw = constants.weak_quiet_mw if antennas.weak[v] else constants.quiet_mw
    most_m = max(heard_within_m(sent_ln, tables, quiet_mw, constants.range_m), counted_m)
    weak_m = heard_within_m(sent_ln + antennas.weak_ln, tables, constants.weak_quiet_mw, constants.range_m)
    most_m2, weak_m2 = most_m * most_m, weak_m * weak_m
    left, right, row_from, row_to = cell_span(cells, east, north, most_m)
    open_ground, work, count = tables.nlos_kind == 0 and tables.raised == 0, near.work, 0
    for row in range(row_from, row_to + 1):
        low, high = row_span(cells, row, left, right)
        # Without a sign, so that nothing asks whether it counts from the end.
        begin, end, place = np.uint64(low), np.uint64(high), near.place
        start = np.uint64(rows.start[rows.first[v] + row]) if constants.shadowed else np.uint64(0)
        for k in range(begin, end):
            away_east, away_north = cells.place[k, 0] - east, cells.place[k, 1] - north
            square = away_east * away_east + away_north * away_north
            who = cells.order[k]
            near.who[count], work[SQUARE_M2, count], place[count] = who, square, np.int64(start + k)
            count += int(square <= (weak_m2 if antennas.weak[who] else most_m2))
    if constants.shadowed:
        for n in range(count):
            work[SHADOW, n] = rows.value[near.place[n]]
    for n in range(count):
        work[DISTANCE_M, n] = np.sqrt(work[SQUARE_M2, n])
    if open_ground:
        for n in range(count):
            work[POWER_MW, n] = looked_up(tables.los_ln, work[DISTANCE_M, n] * tables.per_m)
        if constants.shadowed:
            for n in range(count):
                work[POWER_MW, n] += tables.shadowing_los_ln * work[SHADOW, n]
    else:
        for n in range(count):
            j, distance_m = near.who[n], work[DISTANCE_M, n]
            raised = is_raised(v, j, position_m.shape[0], tables.raised)
            ln, los = median_ln(east, north, position_m[j, 0], position_m[j, 1], distance_m, raised, tables)
            if constants.shadowed:
                ln += (tables.shadowing_los_ln if los else tables.shadowing_nlos_ln) * work[SHADOW, n]
            work[POWER_MW, n] = ln
    for n in range(count):
        work[POWER_MW, n] = sent_ln + min(work[POWER_MW, n], 0.0) + antennas.gain_ln[near.who[n]]
    return count


@kernel(inlined=True)
def find_powers(
    v: int,
    sent_ln: float,
    seed: int,
    tables: PropagationTables,
    constants: DsrcConstants,
    near: Near,
    count: int,
) -> None:
    """Turn logarithms of median powers into powers with fading; 0 for ``v``, and beyond its reach."""
    work, range_m = near.work, constants.range_m
    reach_m = heard_within_m(sent_ln, tables, constants.quiet_mw, range_m)
    for n in range(count):
        near.word[n] = np.int64(word_of(seed, near.who[n]))
    for n in range(count):
        work[FADING, n] = fading_factor(
            work[DISTANCE_M, n],
            np.uint64(near.word[n]),
            tables.fading,
            tables.fading_near_m,
            tables.fading_far_m,
        )
    for n in range(count):
        power_mw = fast_exp(work[POWER_MW, n]) * work[FADING, n]
        work[POWER_MW, n] = power_mw if work[SQUARE_M2, n] <= reach_m * reach_m else 0.0
    for n in range(count):
        group = min(np.floor(work[DISTANCE_M, n] / constants.bin_m), float(constants.bins))
        work[GROUP, n] = group if work[SQUARE_M2, n] <= range_m * range_m else float(constants.bins)
    for n in range(count):
        if near.who[n] == v:
            work[POWER_MW, n], work[GROUP, n] = 0.0, float(constants.bins)


@kernel(inlined=True)
def _sort_near(
    t_s: float,
    station: FloatMatrix,
    constants: DsrcConstants,
    outcomes: IntMatrix,
    near: Near,
    count: int,
) -> tuple[int, int]:
    """Write which vehicles near can lock on to a frame, and which it only disturbs, into ``near.kind``.

    The two kinds then have loops of their own: a branch for each neighbour would be guessed wrongly too
    often. Returns how many there are of both; all others are counted right away.
    """
    weak_mw = max(constants.sensitivity_mw, constants.preamble_ratio * constants.noise_mw)
    strong, weak, quiet = 0, 0, 0
    for n in range(count):
        power_mw = near.work[POWER_MW, n]
        locks, disturbs = power_mw >= weak_mw, power_mw >= constants.quiet_mw
        near.kind[STRONG, strong] = near.kind[DISTURBED, weak] = near.kind[QUIET, quiet] = n
        strong += int(locks & disturbs)
        weak += int(disturbs & (not locks))
        quiet += int(not disturbs)
    for k in range(quiet):
        n = near.kind[QUIET, k]
        group = int(near.work[GROUP, n])
        if group < constants.bins:
            sending = station[near.who[n], SENDING_S] > t_s
            outcomes[group, HALF_DUPLEX if sending else WEAK] += 1
    return strong, weak


@kernel(inlined=True)
def open_links(
    v: int,
    t_s: float,
    station: FloatMatrix,
    links: Links,
    used: int,
    hazard: FloatVector,
    constants: DsrcConstants,
    outcomes: IntMatrix,
    near: Near,
    count: int,
) -> int:
    """A frame of ``v`` begins at the ``count`` vehicles in ``near``; return how much of the pool is used."""
    strong, weak = _sort_near(t_s, station, constants, outcomes, near, count)
    for k in range(strong + weak):
        n = near.kind[STRONG, k] if k < strong else near.kind[DISTURBED, k - strong]
        links.receiver[used + k], links.mw[used + k] = near.who[n], near.work[POWER_MW, n]
        links.flag[used + k, 0], links.flag[used + k, 1] = WEAK, near.work[GROUP, n]
    for at in range(used, used + strong + weak):
        j, power_mw, locks = int(links.receiver[at]), links.mw[at], at < used + strong
        if not locks and disturb(station, j, power_mw, 1.0):
            station[j, RECENT_S], station[j, RECENT_MW] = t_s, power_mw
            continue
        flag = begin_reception(station, j, v, power_mw, locks, t_s, station[v, END_S], hazard, constants)
        links.flag[at, 0] = flag
        turned = sense_medium(station, j, t_s, constants)
        if turned > 0 and station[j, ACCESS_S] >= t_s + constants.sensing_s:
            station[j, ACCESS_S] = np.inf
    station[v, FIRST], station[v, LOCKABLE], station[v, COUNT] = used, strong, strong + weak
    return used + strong + weak


@kernel(inlined=True)
def close_links(
    v: int,
    t_s: float,
    station: FloatMatrix,
    message: IntMatrix,
    links: Links,
    hazard: FloatVector,
    constants: DsrcConstants,
    heard: Heard,
    received: int,
    events: Events,
    count: int,
) -> tuple[int, int]:
    """A frame of ``v`` ends at all its receivers; return the numbers of receptions and of events."""
    first, seed = int(station[v, FIRST]), message[v, SEED]
    weak, end = first + int(station[v, LOCKABLE]), first + int(station[v, COUNT])
    for k in range(first, end):
        j, group, locks = int(links.receiver[k]), int(links.flag[k, 1]), k < weak
        if not locks and disturb(station, j, -links.mw[k], -1.0):
            if group < constants.bins:
                sending = station[j, SENDING_S] > station[v, START_S]
                heard.outcomes[group, HALF_DUPLEX if sending else WEAK] += 1
            continue
        held = locks and station[j, LOCK] == v
        outcome = finish_reception(
            station, j, v, links.mw[k], locks, links.flag[k, 0], t_s, hazard, constants, seed
        )
        if group < constants.bins:
            heard.outcomes[group, outcome] += 1
        if outcome == RECEIVED:
            who, when = heard.who, heard.when
            who[received, 0], who[received, 1], who[received, 2] = message[v, AIR], v, j
            when[received, 0], when[received, 1] = t_s, links.mw[k]
            received += 1
        if sense_medium(station, j, t_s, constants) >= 0:
            continue
        if held and outcome != RECEIVED:
            station[j, IDLE_S] = t_s + constants.extended_s
        if message[j, MESSAGE] >= 0:
            station[j, ACCESS_S] = (
                station[j, IDLE_S] + constants.aifs_s + station[j, BACKOFF] * constants.slot_s
            )
            count = push_event(events, count, station[j, ACCESS_S], 2 * j + ACCESS_EVENT)
    return received, count
