"""Compiled tracks of a fleet against the truth: what hosts believe, by distance, and how many pairs are."""

from math import hypot, sqrt
from typing import NamedTuple

import numpy as np

from modelcast.channel.cells_kernels import Cells, build_cells, cell_row, cell_span, row_span
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatCube, FloatMatrix, FloatVector, IntCube, IntVector
from modelcast.models.member_kernels import Members, predict_member
from modelcast.runtime.fleet.arrays import (
    TRACK_MESSAGE,
    TRACK_RECEIVED_S,
    Tally,
)
from modelcast.runtime.fleet.bins_kernels import bin_of
from modelcast.station.policy.neighbours_kernels import HostVector
from modelcast.station.sender.message_arrays import (
    BELIEF,
    BELIEF_NUMBER,
    CONTENT_EAST_M,
    CONTENT_FIT_S,
    CONTENT_HEAD,
    CONTENT_MEMBER,
    CONTENT_NORTH_M,
    CONTENT_VEHICLE,
    MESSAGES_KEPT,
    SENDER_BITS,
    Contents,
)

__all__ = ["Tracking", "count_pairs", "most_in_reach", "sample_tracks"]

_BIN_BITS = 10
_BIN_MASK = (1 << _BIN_BITS) - 1


class Tracking(NamedTuple):
    """What tracks are sampled with.

    Members of the bank, and whether content holds the parameters of all; time, number of the step; silence
    after which a track is lost [s]; width of the bins of distance [m]; first and end bin of the middle
    distances; who is where, (V,) and (V, 2).
    """

    members: Members
    carries_all: bool
    t_s: float
    step: int
    expiry_s: float
    distance_bin_m: float
    middle: tuple[int, int]
    vehicle: IntVector
    truth_m: FloatMatrix


@kernel(inlined=True)
def _work_out(x: Tracking, message: int, contents: Contents, scratch: FloatVector) -> int:
    """What a message makes its holders believe now: bins of error and age, and the step, in one word.

    The word is written in one go, so that whoever reads it finds all of it. An error bin of 0 says that the
    sender has left.
    """
    sender = message & ((1 << SENDER_BITS) - 1)
    ring = (message >> SENDER_BITS) % MESSAGES_KEPT
    known = contents.beliefs[sender, ring, BELIEF]
    if known >> (2 * _BIN_BITS) == x.step:
        return known
    error_bin, age_bin = 0, 0
    row = contents.rows[sender, ring]
    if row[CONTENT_VEHICLE] == x.vehicle[sender]:
        member, offsets = int(row[CONTENT_MEMBER]), x.members.offsets
        first = CONTENT_HEAD + (offsets[member] if x.carries_all else 0)
        own = row[first : first + offsets[member + 1] - offsets[member]]
        predict_member(x.members, member, own, x.t_s - row[CONTENT_FIT_S], scratch)
        east, north = scratch[0] + row[CONTENT_EAST_M], scratch[1] + row[CONTENT_NORTH_M]
        error_bin = bin_of(hypot(east - x.truth_m[sender, 0], north - x.truth_m[sender, 1])) + 1
        age_bin = bin_of(x.t_s - row[CONTENT_FIT_S])
    found = (x.step << (2 * _BIN_BITS)) | (error_bin << _BIN_BITS) | age_bin
    contents.beliefs[sender, ring, BELIEF] = found
    return found


@kernel(inlined=True)
def _count(belief: int, distance: int, middle: tuple[int, int], tally: Tally) -> None:
    """Count one track at a distance; that of a remote that has left is passed over."""
    at = ((belief >> _BIN_BITS) & _BIN_MASK) - 1
    if at < 0:
        return
    tally.held[distance] += 1
    tally.error[distance, at] += 1
    tally.age[distance, belief & _BIN_MASK] += 1
    if middle[0] <= distance < middle[1]:
        tally.recent[at] += 1


@kernel(inlined=True)
def _sample_host(
    x: Tracking, host: int, used: int, beliefs: IntCube, tracks: FloatCube, tally: Tally, waiting: IntVector
) -> int:
    """Count the tracks of one host; those whose belief is not worked out yet are listed instead."""
    most_m = x.distance_bin_m * tally.held.size
    mask = (1 << SENDER_BITS) - 1
    count = 0
    east_m, north_m = x.truth_m[host, 0], x.truth_m[host, 1]
    for slot in range(used):
        if (
            tracks[host, slot, TRACK_MESSAGE] < 0.0
            or x.t_s - tracks[host, slot, TRACK_RECEIVED_S] > x.expiry_s
        ):
            continue
        message = int(tracks[host, slot, TRACK_MESSAGE])
        sender, number = message & mask, message >> SENDER_BITS
        east, north = x.truth_m[sender, 0] - east_m, x.truth_m[sender, 1] - north_m
        square = east * east + north * north
        if not square < most_m * most_m:
            continue
        ring = number % MESSAGES_KEPT
        if beliefs[sender, ring, BELIEF_NUMBER] != number:
            continue
        belief = beliefs[sender, ring, BELIEF]
        if belief >> (2 * _BIN_BITS) != x.step:
            waiting[count] = slot
            count += 1
            continue
        _count(belief, int(sqrt(square) / x.distance_bin_m), x.middle, tally)
    return count


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
def _sample_each(
    x: Tracking,
    hosts: HostVector,
    contents: Contents,
    tracks: FloatCube,
    tally: Tally,
    first: int,
    end: int,
    waiting: IntVector,
    touched: FloatVector,
    scratch: FloatVector,
) -> None:
    """Count the tracks of some hosts; the last three are overwritten."""
    mask = (1 << SENDER_BITS) - 1
    for host in range(first, end):
        if x.vehicle[host] < 0:
            continue
        count = _sample_host(x, host, hosts[host].used, contents.beliefs, tracks, tally, waiting)
        _touch_contents(host, count, waiting, tracks, contents.rows, touched)
        for k in range(count):
            message = int(tracks[host, waiting[k], TRACK_MESSAGE])
            sender = message & mask
            way_m = hypot(
                x.truth_m[sender, 0] - x.truth_m[host, 0], x.truth_m[sender, 1] - x.truth_m[host, 1]
            )
            distance = min(int(way_m / x.distance_bin_m), tally.held.size - 1)
            _count(_work_out(x, message, contents, scratch), distance, x.middle, tally)


@kernel
def sample_tracks(
    x: Tracking, hosts: HostVector, contents: Contents, tracks: FloatCube, tally: Tally, first: int, end: int
) -> None:
    """Count the tracking error and information age of every live track of some hosts, by true distance.

    What a message predicts is worked out once, whoever holds it. Remotes that have left are passed over.
    """
    waiting, touched = np.empty(tracks.shape[1], dtype=np.int64), np.empty(tracks.shape[1])
    _sample_each(x, hosts, contents, tracks, tally, first, end, waiting, touched, np.empty(2))


@kernel(inlined=True)
def _count_ahead(cells: Cells, k: int, distance_bin_m: float, pairs: IntVector) -> None:
    """Count the pairs of one vehicle with those behind it in the cells' order, in both directions."""
    most_m = distance_bin_m * pairs.size
    east, north = cells.place[k, 0], cells.place[k, 1]
    left, right, _, row_to = cell_span(cells, east, north, most_m)
    for row in range(cell_row(cells, north), row_to + 1):
        low, high = row_span(cells, row, left, right)
        for other in range(max(low, k + 1), high):
            a, b = cells.place[other, 0] - east, cells.place[other, 1] - north
            square = a * a + b * b
            if square < most_m * most_m:
                pairs[int(sqrt(square) / distance_bin_m)] += 2


@kernel
def count_pairs(cells: Cells, part: int, parts: int, distance_bin_m: float, pairs: IntVector) -> None:
    """Count one part of all pairs of host and remote by distance, ``pairs`` (distances,).

    The cells are built for the distance that all bins reach.
    """
    present = cells.order.size
    for k in range(present * part // parts, present * (part + 1) // parts):
        _count_ahead(cells, k, distance_bin_m, pairs)


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
