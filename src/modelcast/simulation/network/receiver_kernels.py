"""Compiled receivers of the closed loop: every host takes in what it hears and tracks every remote."""

from math import hypot, sqrt

import numpy as np

from modelcast.channel.cells_kernels import build_cells, cell_span, row_span
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    BoolVector,
    FloatCube,
    FloatMatrix,
    FloatVector,
    Int16Matrix,
    Int32Cube,
    IntMatrix,
    IntVector,
)
from modelcast.models.member_kernels import parameter_count, predict_member
from modelcast.policy.neighbours_kernels import HostVector, NeighbourTables, SlotMatrix, hear
from modelcast.simulation.network.arrays import Contents, Tally
from modelcast.simulation.network.bins_kernels import bin_of
from modelcast.simulation.network.composing_kernels import LoopModels
from modelcast.simulation.network.layout_kernels import (
    BELIEF_AGE_BIN,
    BELIEF_ERROR_BIN,
    BELIEF_NUMBER,
    BELIEF_STEP,
    CONTENT_EAST_M,
    CONTENT_FIT_S,
    CONTENT_HEAD,
    CONTENT_MEMBER,
    CONTENT_NORTH_M,
    CONTENT_NUMBER,
    CONTENT_VEHICLE,
    FAR,
    MESSAGES_KEPT,
    REFUSED,
    SENDER_BITS,
    STALE,
    TAKEN,
    TRACK_MESSAGE,
    TRACK_RECEIVED_S,
    TRACK_VEHICLE,
)

__all__ = ["clear_hosts", "count_pairs", "hear_messages", "most_in_reach", "sample_tracks"]

_LINE = 64
"""Bytes of a cache line."""


@kernel(inlined=True)
def clear_hosts(started: BoolVector, tables: NeighbourTables, tracks: FloatCube) -> None:
    """Let new vehicles hold nothing: ``started`` (V,) says whose slot has one."""
    hosts, slots, index, _ = tables
    for host in range(started.size):
        if started[host]:
            for slot in range(hosts[host].used):
                slots[host, slot].remote = -1
                tracks[host, slot, TRACK_MESSAGE] = -1.0
            hosts[host].used = 0
            hosts[host].free = 0
            for at in range(index.shape[1]):
                index[host, at] = -1


@kernel
def _by_host(receiver: IntVector, hosts: int) -> IntVector:
    """Receptions host by host, each host's in the order given: a host's table then stays in the cache."""
    start = np.zeros(hosts + 1, dtype=np.int64)
    for host in receiver:
        start[host + 1] += 1
    for host in range(hosts):
        start[host + 1] += start[host]
    order = np.empty(receiver.size, dtype=np.int64)
    for k in range(receiver.size):
        host = receiver[k]
        order[start[host]] = k
        start[host] += 1
    return order


@kernel(inlined=True)
def _touch_host(host: int, used: int, slots: SlotMatrix, index: Int16Matrix, tracks: FloatCube) -> float:
    """Read through the tables of a host in the order of memory; return a number that means nothing.

    Its messages then find them in the cache: a processor fetches ahead of a walk, not of scattered look-ups.
    """
    total = 0.0
    for at in range(0, index.shape[1], _LINE // 2):
        total += index[host, at]
    for slot in range(used):
        total += slots[host, slot].heard_s + tracks[host, slot, TRACK_RECEIVED_S]
    return total


@kernel(inlined=True)
def _hear_each(
    order: IntVector,
    message_id: IntVector,
    receiver: IntVector,
    received_s: FloatVector,
    vehicle: IntVector,
    seen_m: FloatMatrix,
    truth_m: FloatMatrix,
    reach_m: float,
    sub_interval_s: float,
    distance_bin_m: float,
    hosts: HostVector,
    slots: SlotMatrix,
    index: Int16Matrix,
    free: Int16Matrix,
    rows: FloatCube,
    tracks: FloatCube,
    gap: IntMatrix,
    sums: FloatVector,
    touched: FloatVector,
) -> None:
    """Take in receptions in an order, host by host; ``touched`` (1,) is overwritten."""
    mask = (1 << SENDER_BITS) - 1
    taken = far = refused = stale = 0
    last = -1
    for at in range(order.size):
        k = int(order[at])
        host = int(receiver[k])
        if host != last:
            touched[0] = _touch_host(host, hosts[host].used, slots, index, tracks)
            last = host
        message = int(message_id[k])
        sender, number = message & mask, message >> SENDER_BITS
        ring = number % MESSAGES_KEPT
        if vehicle[host] < 0 or rows[sender, ring, CONTENT_NUMBER] != number:
            stale += 1
            continue
        stated_east_m, stated_north_m = (
            rows[sender, ring, CONTENT_EAST_M],
            rows[sender, ring, CONTENT_NORTH_M],
        )
        east, north = stated_east_m - seen_m[host, 0], stated_north_m - seen_m[host, 1]
        if east * east + north * north > reach_m * reach_m:
            far += 1
            continue
        remote, held_id = int(rows[sender, ring, CONTENT_VEHICLE]), float(message_id[k])
        at_s = float(received_s[k])
        slot = hear(
            hosts, slots, index, free, host, remote, ring, at_s, stated_east_m, stated_north_m, sub_interval_s
        )
        if slot < 0:
            refused += 1
            continue
        if tracks[host, slot, TRACK_MESSAGE] >= 0.0 and tracks[host, slot, TRACK_VEHICLE] == remote:
            held = int(tracks[host, slot, TRACK_MESSAGE]) >> SENDER_BITS
            if number <= held:
                stale += 1
                continue
            # Two messages of one sample: the first stays, as in `modelcast.agents.host.Host`.
            if rows[sender, held % MESSAGES_KEPT, CONTENT_FIT_S] >= rows[sender, ring, CONTENT_FIT_S]:
                held_id = tracks[host, slot, TRACK_MESSAGE]
            east, north = truth_m[sender, 0] - truth_m[host, 0], truth_m[sender, 1] - truth_m[host, 1]
            if vehicle[sender] == remote:
                distance = int(sqrt(east * east + north * north) / distance_bin_m)
                if distance < gap.shape[0]:
                    gap[distance, bin_of(at_s - tracks[host, slot, TRACK_RECEIVED_S])] += 1
        taken += 1
        tracks[host, slot, TRACK_MESSAGE] = held_id
        tracks[host, slot, TRACK_RECEIVED_S] = at_s
        tracks[host, slot, TRACK_VEHICLE] = remote
    sums[TAKEN] += taken
    sums[FAR] += far
    sums[REFUSED] += refused
    sums[STALE] += stale


@kernel
def hear_messages(
    message_id: IntVector,
    receiver: IntVector,
    received_s: FloatVector,
    vehicle: IntVector,
    seen_m: FloatMatrix,
    truth_m: FloatMatrix,
    reach_m: float,
    sub_interval_s: float,
    distance_bin_m: float,
    tables: NeighbourTables,
    contents: Contents,
    tracks: FloatCube,
    tally: Tally,
) -> None:
    """Take in receptions, (R,) each, in the order of time.

    A host passes over remotes that state a place farther than ``reach_m``, and messages no newer than what
    it holds. Inter-packet gaps are counted by the true distance.
    """
    hosts, slots, index, free = tables
    _hear_each(
        _by_host(receiver, vehicle.size), message_id, receiver, received_s, vehicle, seen_m, truth_m,
        reach_m, sub_interval_s, distance_bin_m, hosts, slots, index, free, contents.rows, tracks, tally.gap,
        tally.sums, np.empty(1),
    )  # fmt: skip


@kernel(inlined=True)
def _predicted(models: LoopModels, content: FloatVector, t_s: float, out: FloatVector) -> None:
    """Where a message puts its sender at a time, into ``out`` (2,)."""
    members, member = models.members, int(content[CONTENT_MEMBER])
    parameters = content[CONTENT_HEAD : CONTENT_HEAD + parameter_count(members, member)]
    predict_member(members, member, parameters, t_s - content[CONTENT_FIT_S], out)
    out[0] += content[CONTENT_EAST_M]
    out[1] += content[CONTENT_NORTH_M]


@kernel(inlined=True)
def _count(
    beliefs: Int32Cube,
    sender: int,
    ring: int,
    distance: int,
    middle: tuple[int, int],
    held: IntVector,
    error: IntMatrix,
    age: IntMatrix,
    recent: IntVector,
) -> None:
    """Count one track at a distance; that of a remote that has left is passed over."""
    at = beliefs[sender, ring, BELIEF_ERROR_BIN]
    if at < 0:
        return
    held[distance] += 1
    error[distance, at] += 1
    age[distance, beliefs[sender, ring, BELIEF_AGE_BIN]] += 1
    if middle[0] <= distance < middle[1]:
        recent[at] += 1


@kernel(inlined=True)
def _sample_host(
    host: int,
    used: int,
    t_s: float,
    step: int,
    expiry_s: float,
    distance_bin_m: float,
    middle: tuple[int, int],
    truth_m: FloatMatrix,
    beliefs: Int32Cube,
    tracks: FloatCube,
    held: IntVector,
    error: IntMatrix,
    age: IntMatrix,
    recent: IntVector,
    out_waiting: IntVector,
) -> int:
    """Count the tracks of one host; those whose belief is not worked out yet are listed instead."""
    most_m = distance_bin_m * held.size
    mask = (1 << SENDER_BITS) - 1
    waiting = 0
    east_m, north_m = truth_m[host, 0], truth_m[host, 1]
    for slot in range(used):
        if tracks[host, slot, TRACK_MESSAGE] < 0.0 or t_s - tracks[host, slot, TRACK_RECEIVED_S] > expiry_s:
            continue
        message = int(tracks[host, slot, TRACK_MESSAGE])
        sender, number = message & mask, message >> SENDER_BITS
        east, north = truth_m[sender, 0] - east_m, truth_m[sender, 1] - north_m
        square = east * east + north * north
        if not square < most_m * most_m:
            continue
        ring = number % MESSAGES_KEPT
        if beliefs[sender, ring, BELIEF_NUMBER] != number:
            continue
        if beliefs[sender, ring, BELIEF_STEP] != step:
            out_waiting[waiting] = slot
            waiting += 1
            continue
        _count(beliefs, sender, ring, int(sqrt(square) / distance_bin_m), middle, held, error, age, recent)
    return waiting


@kernel(inlined=True)
def _touch_contents(
    host: int, count: int, waiting: IntVector, tracks: FloatCube, rows: FloatCube, out: FloatVector
) -> None:
    """Touch the contents of all messages that wait to be worked out, so that their cache misses overlap."""
    for k in range(count):
        message = int(tracks[host, waiting[k], TRACK_MESSAGE])
        sender, ring = message & ((1 << SENDER_BITS) - 1), (message >> SENDER_BITS) % MESSAGES_KEPT
        out[k] = rows[sender, ring, CONTENT_FIT_S] + rows[sender, ring, CONTENT_HEAD]


@kernel(inlined=True)
def _work_out(
    models: LoopModels,
    message: int,
    t_s: float,
    step: int,
    vehicle: IntVector,
    truth_m: FloatMatrix,
    contents: Contents,
    scratch: FloatVector,
) -> None:
    """Work out what a message makes its holders believe now, where that has not been done."""
    sender = message & ((1 << SENDER_BITS) - 1)
    ring = (message >> SENDER_BITS) % MESSAGES_KEPT
    belief = contents.beliefs[sender, ring]
    if belief[BELIEF_STEP] == step:
        return
    content = contents.rows[sender, ring]
    belief[BELIEF_STEP], belief[BELIEF_ERROR_BIN] = step, -1
    if content[CONTENT_VEHICLE] == vehicle[sender]:
        _predicted(models, content, t_s, scratch)
        error_m = hypot(scratch[0] - truth_m[sender, 0], scratch[1] - truth_m[sender, 1])
        belief[BELIEF_ERROR_BIN] = bin_of(error_m)
        belief[BELIEF_AGE_BIN] = bin_of(t_s - content[CONTENT_FIT_S])


@kernel
def sample_tracks(
    models: LoopModels,
    t_s: float,
    step: int,
    expiry_s: float,
    distance_bin_m: float,
    middle: tuple[int, int],
    vehicle: IntVector,
    truth_m: FloatMatrix,
    tables: NeighbourTables,
    contents: Contents,
    tracks: FloatCube,
    tally: Tally,
    scratch: FloatVector,
) -> None:
    """Count the tracking error and information age of every live track now, by true distance.

    What a message predicts is worked out once, whoever holds it. ``middle`` are the first and the end bin of
    distance that also count in ``tally.recent``. Remotes that have left are passed over.
    """
    hosts = tables[0]
    mask = (1 << SENDER_BITS) - 1
    waiting, touched = np.empty(tracks.shape[1], dtype=np.int64), np.empty(tracks.shape[1])
    for host in range(vehicle.size):
        if vehicle[host] < 0:
            continue
        used = hosts[host].used
        count = _sample_host(
            host, used, t_s, step, expiry_s, distance_bin_m, middle, truth_m, contents.beliefs, tracks,
            tally.held, tally.error, tally.age, tally.recent, waiting,
        )  # fmt: skip
        _touch_contents(host, count, waiting, tracks, contents.rows, touched)
        for k in range(count):
            slot = waiting[k]
            message = int(tracks[host, slot, TRACK_MESSAGE])
            _work_out(models, message, t_s, step, vehicle, truth_m, contents, scratch)
            sender, ring = message & mask, (message >> SENDER_BITS) % MESSAGES_KEPT
            way_m = hypot(truth_m[sender, 0] - truth_m[host, 0], truth_m[sender, 1] - truth_m[host, 1])
            _count(
                contents.beliefs, sender, ring, min(int(way_m / distance_bin_m), tally.held.size - 1), middle,
                tally.held, tally.error, tally.age, tally.recent,
            )  # fmt: skip


@kernel
def count_pairs(position_m: FloatMatrix, distance_bin_m: float, pairs: IntVector) -> None:
    """Count all pairs of host and remote by distance, ``pairs`` (distances,); NaN is nobody."""
    most_m = distance_bin_m * pairs.size
    cells = build_cells(position_m, most_m)
    for v in range(position_m.shape[0]):
        east, north = position_m[v, 0], position_m[v, 1]
        if np.isnan(east):
            continue
        first, last, row_from, row_to = cell_span(cells, east, north, most_m)
        for row in range(row_from, row_to + 1):
            low, high = row_span(cells, row, first, last)
            for k in range(low, high):
                a, b = cells.place[k, 0] - east, cells.place[k, 1] - north
                square = a * a + b * b
                if square < most_m * most_m and cells.order[k] != v:
                    pairs[int(sqrt(square) / distance_bin_m)] += 1


@kernel
def most_in_reach(position_m: FloatMatrix, reach_m: float) -> int:
    """Most vehicles within reach of one, itself among them."""
    cells = build_cells(position_m, reach_m)
    most = 0
    for v in range(position_m.shape[0]):
        east, north = position_m[v, 0], position_m[v, 1]
        if np.isnan(east):
            continue
        first, last, row_from, row_to = cell_span(cells, east, north, reach_m)
        near = 0
        for row in range(row_from, row_to + 1):
            low, high = row_span(cells, row, first, last)
            for k in range(low, high):
                a, b = cells.place[k, 0] - east, cells.place[k, 1] - north
                if a * a + b * b <= reach_m * reach_m:
                    near += 1
        most = max(most, near)
    return most
