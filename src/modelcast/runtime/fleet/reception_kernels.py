"""Compiled hosts of a fleet: every one takes in what it hears, by the rules of `track_kernels`."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, FloatCube, FloatMatrix, FloatVector, IntMatrix, IntVector
from modelcast.runtime.fleet.arrays import (
    FAR,
    REFUSED,
    STALE,
    TAKEN,
    TRACK_MESSAGE,
    TRACK_RECEIVED_S,
    UNKNOWN,
    Tally,
    Tracks,
)
from modelcast.runtime.fleet.bins_kernels import bin_of
from modelcast.station.policy.error_driven_kernels import IDENTIFICATION
from modelcast.station.policy.neighbours_kernels import NeighbourTables, find, hear
from modelcast.station.receiver.reading_kernels import MODEL
from modelcast.station.receiver.track_kernels import (
    ACCEPTED,
    HELD_CONTENT,
    HELD_FIT_S,
    HELD_MEMBER,
    HELD_NAMED_S,
    HELD_RECEIVED_S,
    OLDER,
    TRACK_COLUMNS,
    UNKNOWN_UPDATE,
    forget,
    take_identification,
    take_update,
)
from modelcast.station.sender.message_arrays import (
    CONTENT_EAST_M,
    CONTENT_FIT_S,
    CONTENT_KIND,
    CONTENT_MEMBER,
    CONTENT_NAMED_S,
    CONTENT_NORTH_M,
    CONTENT_NUMBER,
    CONTENT_UPDATE,
    CONTENT_VEHICLE,
    MESSAGES_KEPT,
    SENDER_BITS,
)

__all__ = ["Heard", "HearingLimits", "by_host", "clear_hosts", "hear_messages"]

_LINE = 64
"""Bytes of a cache line."""

_FEW = 8
"""A host that hears fewer than one in so many of its neighbours finds their tracks one by one."""

_TOUCHED = TRACK_COLUMNS
"""Where in the scratch row a number goes that means nothing."""


class Heard(NamedTuple):
    """Receptions of a step, (R,) each: message, receiver, time; and who and where vehicles are.

    ``order`` (R,) puts them host by host, those of host h from ``start[h]`` to ``start[h + 1]``. ``seen_m``
    is where hosts take themselves to be, ``truth_m`` where they are, (V, 2); ``reading`` (V,) how they read
    messages (`reading_kernels`), ``counted`` (V,) whose gaps count. ``is_copy`` (R,): sent by a relay.
    """

    message_id: IntVector
    received_s: FloatVector
    order: IntVector
    start: IntVector
    vehicle: IntVector
    seen_m: FloatMatrix
    truth_m: FloatMatrix
    reading: IntVector
    counted: BoolVector
    is_copy: BoolVector


class HearingLimits(NamedTuple):
    """What a host takes in.

    Farthest place of a remote that a host tracks [m]; how long a track lives unheard, and the sub-interval of
    the tables [s]; width of the bins of distance [m].
    """

    reach_m: float
    expiry_s: float
    sub_interval_s: float
    distance_bin_m: float


@kernel
def clear_hosts(started: BoolVector, tables: NeighbourTables, tracks: Tracks) -> None:
    """Let new vehicles hold nothing: ``started`` (V,) says whose slot has one."""
    hosts, slots, index, _ = tables
    for host in range(started.size):
        if started[host]:
            for slot in range(hosts[host].used):
                slots[host, slot].remote = -1
                tracks.held[host, slot, TRACK_MESSAGE] = -1.0
            hosts[host].used = 0
            hosts[host].free = 0
            for at in range(index.shape[1]):
                index[host, at] = -1


@kernel
def by_host(receiver: IntVector, start: IntVector, order: IntVector) -> None:
    """Receptions host by host, each host's in the order given: a host's table then stays in the cache.

    Writes ``start`` (V + 1,) and ``order`` (R,).
    """
    start[:] = 0
    hosts = start.size - 1
    for host in receiver:
        start[host + 1] += 1
    for host in range(hosts):
        start[host + 1] += start[host]
    for k in range(receiver.size):
        host = receiver[k]
        order[start[host]] = k
        start[host] += 1
    for host in range(hosts, 0, -1):
        start[host] = start[host - 1]
    start[0] = 0


@kernel(inlined=True)
def _touch_host(host: int, tables: NeighbourTables, tracks: Tracks) -> float:
    """Read through the tables of a host in the order of memory; return a number that means nothing.

    Its messages then find them in the cache: a processor fetches ahead of a walk, not of scattered look-ups.
    """
    total = 0.0
    for at in range(0, tables.lookup.shape[1], _LINE // 2):
        total += tables.lookup[host, at]
    for slot in range(tables.hosts[host].used):
        total += tables.slots[host, slot].heard_s + tracks.held[host, slot, TRACK_RECEIVED_S]
        total += tracks.vehicle[host, slot]
    return total


@kernel(inlined=True)
def _touch_messages(heard: Heard, host: int, rows: FloatCube, message: IntVector, at_s: FloatVector) -> float:
    """Write a host's messages and their times in order, and touch what they say and the ones before them say.

    All cache misses then overlap. Returns a number that means nothing.
    """
    total, first = 0.0, heard.start[host]
    count = heard.start[host + 1] - first
    for n in range(count):
        message[n], at_s[n] = (
            heard.message_id[heard.order[first + n]],
            heard.received_s[heard.order[first + n]],
        )
    for n in range(count):
        sender, number = message[n] & ((1 << SENDER_BITS) - 1), message[n] >> SENDER_BITS
        ring, before = number % MESSAGES_KEPT, (number - 1) % MESSAGES_KEPT
        total += rows[sender, ring, CONTENT_NUMBER] + rows[sender, ring, CONTENT_MEMBER]
        total += rows[sender, before, CONTENT_UPDATE] + rows[sender, before, CONTENT_MEMBER]
    return total


@kernel(inlined=True)
def _take(
    rows: FloatCube, message: int, track: FloatVector, at_s: float, expiry_s: float, held: FloatVector
) -> int:
    """Take a message into a track, whose update stands in its sender's ring; ``held`` is overwritten."""
    mask = (1 << SENDER_BITS) - 1
    sender, number = message & mask, message >> SENDER_BITS
    ring = number % MESSAGES_KEPT
    forget(held)
    if track[TRACK_MESSAGE] >= 0.0:
        before = int(track[TRACK_MESSAGE]) >> SENDER_BITS
        kept = before % MESSAGES_KEPT
        if number <= before:
            return OLDER
        held[HELD_CONTENT] = rows[sender, kept, CONTENT_UPDATE]
        held[HELD_MEMBER], held[HELD_FIT_S] = (
            rows[sender, kept, CONTENT_MEMBER],
            rows[sender, kept, CONTENT_FIT_S],
        )
        held[HELD_NAMED_S], held[HELD_RECEIVED_S] = (
            rows[sender, kept, CONTENT_NAMED_S],
            track[TRACK_RECEIVED_S],
        )
    update, member = int(rows[sender, ring, CONTENT_UPDATE]), int(rows[sender, ring, CONTENT_MEMBER])
    if rows[sender, ring, CONTENT_KIND] == IDENTIFICATION:
        status = take_identification(
            held, update, member, rows[sender, ring, CONTENT_NAMED_S], at_s, expiry_s
        )
    else:
        status = take_update(held, update, member, rows[sender, ring, CONTENT_FIT_S], at_s, expiry_s)
    if status == ACCEPTED:
        track[TRACK_MESSAGE] = float(message)
    elif held[HELD_CONTENT] < 0.0:
        track[TRACK_MESSAGE] = -1.0
    track[TRACK_RECEIVED_S] = held[HELD_RECEIVED_S]
    return status


@kernel(inlined=True)
def _hear_each(
    heard: Heard,
    limits: HearingLimits,
    tables: NeighbourTables,
    rows: FloatCube,
    tracks: Tracks,
    gap: IntMatrix,
    first: int,
    end: int,
    scratch: FloatVector,
    own: tuple[IntVector, FloatVector],
    counts: IntVector,
) -> None:
    """Take in the receptions of some hosts; what became of them is added to ``counts`` (5,).

    ``scratch`` and ``own``, room for messages of a host and their times, are overwritten.
    """
    mask = (1 << SENDER_BITS) - 1
    messages, times_s = own
    for host in range(first, end):
        if heard.start[host] == heard.start[host + 1]:
            continue
        if _FEW * (heard.start[host + 1] - heard.start[host]) >= tables.hosts[host].used:
            scratch[_TOUCHED] = _touch_host(host, tables, tracks)
        scratch[_TOUCHED] += _touch_messages(heard, host, rows, messages, times_s)
        for at in range(heard.start[host], heard.start[host + 1]):
            k = heard.order[at]
            n = at - heard.start[host]
            message, at_s = int(messages[n]), float(times_s[n])
            sender, number = message & mask, message >> SENDER_BITS
            ring = number % MESSAGES_KEPT
            if sender == host:
                counts[STALE] += 1  # its own, repeated by a relay
                continue
            if heard.vehicle[host] < 0 or rows[sender, ring, CONTENT_NUMBER] != number:
                counts[STALE] += 1
                continue
            stated_east_m, stated_north_m = (
                rows[sender, ring, CONTENT_EAST_M],
                rows[sender, ring, CONTENT_NORTH_M],
            )
            east, north = stated_east_m - heard.seen_m[host, 0], stated_north_m - heard.seen_m[host, 1]
            if east * east + north * north > limits.reach_m * limits.reach_m:
                counts[FAR] += 1
                continue
            remote = int(rows[sender, ring, CONTENT_VEHICLE])
            # A relay's copy tells nothing of the link to the remote: it is counted for no packet error ratio.
            slot = find(tables.slots, tables.lookup, host, remote) if heard.is_copy[k] else -1
            if slot < 0:
                slot = hear(
                    tables.hosts, tables.slots, tables.lookup, tables.free, host, remote, ring, at_s,
                    stated_east_m, stated_north_m, limits.sub_interval_s,
                )  # fmt: skip
            if slot < 0:
                counts[REFUSED] += 1
                continue
            track = tracks.held[host, slot]
            if tracks.vehicle[host, slot] != remote:
                tracks.vehicle[host, slot] = remote
                track[TRACK_MESSAGE], track[TRACK_RECEIVED_S] = -1.0, -np.inf
            if rows[sender, ring, CONTENT_KIND] == IDENTIFICATION and heard.reading[host] != MODEL:
                counts[UNKNOWN] += 1  # it names nothing to who knows no model
                continue
            before_s = track[TRACK_RECEIVED_S]
            status = _take(rows, message, track, at_s, limits.expiry_s, scratch)
            if status == OLDER:
                counts[STALE] += 1
                continue
            if status == UNKNOWN_UPDATE:
                counts[UNKNOWN] += 1
                continue
            counts[TAKEN] += 1
            if before_s > -np.inf and heard.vehicle[sender] == remote and heard.counted[host]:
                away_east = heard.truth_m[sender, 0] - heard.truth_m[host, 0]
                away_north = heard.truth_m[sender, 1] - heard.truth_m[host, 1]
                distance = int(sqrt(away_east * away_east + away_north * away_north) / limits.distance_bin_m)
                if distance < gap.shape[0]:
                    gap[distance, bin_of(at_s - before_s)] += 1


@kernel
def hear_messages(
    heard: Heard,
    limits: HearingLimits,
    tables: NeighbourTables,
    rows: FloatCube,
    tracks: Tracks,
    tally: Tally,
    first: int,
    end: int,
) -> None:
    """Take in the receptions of hosts ``first`` to ``end``, each host's in the order of time.

    A host passes over remotes that state a place farther than its reach, and messages no newer than what it
    holds. Inter-packet gaps are counted by the true distance.
    """
    counts = np.zeros(5, dtype=np.int64)
    scratch = np.empty(TRACK_COLUMNS + 1)
    most = 0
    for host in range(first, end):
        most = max(most, heard.start[host + 1] - heard.start[host])
    own = np.empty(most, dtype=np.int64), np.empty(most)
    _hear_each(heard, limits, tables, rows, tracks, tally.gap, first, end, scratch, own, counts)
    for column in range(counts.size):
        tally.heard[column] += counts[column]
