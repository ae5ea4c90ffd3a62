"""Compiled tracks of a fleet against the truth: what hosts believe, by distance, and how many pairs are."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from modelcast.channel.cells_kernels import Cells, build_cells, cell_row, cell_span, row_span
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, FloatCube, FloatMatrix, FloatVector, IntCube, IntVector
from modelcast.models.member_kernels import predict_member
from modelcast.runtime.fleet.arrays import (
    TRACK_MESSAGE,
    TRACK_RECEIVED_S,
    Tally,
)
from modelcast.runtime.fleet.belief_words_kernels import (
    Tracking,
    bins_of,
    error_units,
    error_word,
    found_bins,
    gone_words,
    units_bin,
    word_of,
)
from modelcast.runtime.fleet.believed_kernels import own_span
from modelcast.station.policy.neighbours_kernels import HostVector
from modelcast.station.sender.message_arrays import (
    BELIEF,
    BELIEF_ERROR,
    BELIEF_NUMBER,
    CONTENT_FIT_S,
    CONTENT_HEAD,
    CONTENT_MEMBER,
    CONTENT_VEHICLE,
    MESSAGES_KEPT,
    SENDER_BITS,
    Contents,
)

__all__ = ["Near", "count_pairs", "most_in_reach", "near_tracks", "sample_tracks", "work_out"]


class Near(NamedTuple):
    """Tracks of one host: slots and bins of distance; (C + 1,) each, and overwritten."""

    slot: IntVector
    distance: IntVector


class _Found(NamedTuple):
    """What is found out about the tracks near a host, one loop after another; (C + 1,) each, and overwritten.

    The ``message`` that each holds and the two words of it, ``belief`` and ``error``; the tracks whose words
    wait to be worked out, ``due``; the remote's error in units of a word, ``east`` and ``north``, and then
    the bin of it ``relative`` to the host's own. Loops that touch few arrays run several at a time, and none
    has a branch that is guessed wrongly for every other track.
    """

    message: IntVector
    belief: IntVector
    error: IntVector
    due: IntVector
    east: FloatVector
    north: FloatVector
    relative: IntVector


@kernel(inlined=True)
def work_out(x: Tracking, message: int, contents: Contents, scratch: FloatVector) -> int:
    """What a message makes its holders believe now: bins of error and age, and the step, in one word.

    Each word is written in one go, so that whoever reads it finds all of it. An error bin of 0 says that the
    sender has left. The error itself is in the word beside it.
    """
    sender = message & ((1 << SENDER_BITS) - 1)
    ring = (message >> SENDER_BITS) % MESSAGES_KEPT
    known = contents.beliefs[sender, ring, BELIEF]
    if found_bins(x, known, contents.beliefs[sender, ring, BELIEF_ERROR]):
        return known
    found, error = gone_words(x)
    row = contents.rows[sender, ring]
    if row[CONTENT_VEHICLE] == x.vehicle[sender]:
        own, end = own_span(x.members, row)
        predict_member(x.members, int(row[CONTENT_MEMBER]), row[own:end], x.t_s - row[CONTENT_FIT_S], scratch)
        found, error = word_of(x, sender, row, scratch), error_word(x, sender, row, scratch)
    contents.beliefs[sender, ring, BELIEF_ERROR] = error
    contents.beliefs[sender, ring, BELIEF] = found
    return found


@kernel(inlined=True)
def near_tracks(
    x: Tracking, host: int, used: int, tracks: FloatCube, bins: int, near: IntVector, distance: IntVector
) -> int:
    """List the live tracks of one host within the bins, and their bins of distance; returns how many.

    Every slot is written and the next overwrites it unless it counts: a branch would be guessed wrongly for
    every other track.
    """
    most_m = x.distance_bin_m * bins
    most_m2, a_bin = most_m * most_m, 1.0 / x.distance_bin_m
    people_m2, own = min(most_m2, x.people_m2), x.person[host]
    east_m, north_m = x.truth_m[host, 0], x.truth_m[host, 1]
    count = 0
    for slot in range(used):
        message, silent_s = tracks[host, slot, TRACK_MESSAGE], x.t_s - tracks[host, slot, TRACK_RECEIVED_S]
        sender = int(max(message, 0.0)) & ((1 << SENDER_BITS) - 1)
        east, north = x.truth_m[sender, 0] - east_m, x.truth_m[sender, 1] - north_m
        square = east * east + north * north
        is_near = square < (people_m2 if own or x.person[sender] else most_m2)
        near[count], distance[count] = slot, int(sqrt(square if is_near else 0.0) * a_bin)
        count += int(is_near & (message >= 0.0) & (silent_s <= x.expiry_s))
    return count


@kernel(inlined=True)
def _read_words(
    x: Tracking, host: int, beliefs: IntCube, tracks: FloatCube, near: Near, found: _Found, count: int
) -> int:
    """Write the words of the tracks near a host; returns how many are not worked out yet, which are listed.

    Those whose message its sender's ring holds no more are read as of one who has left.
    """
    mask = (1 << SENDER_BITS) - 1
    gone, _ = gone_words(x)
    due = 0
    for k in range(count):
        found.message[k] = int(tracks[host, near.slot[k], TRACK_MESSAGE])
    for k in range(count):
        sender, number = found.message[k] & mask, found.message[k] >> SENDER_BITS
        ring = number % MESSAGES_KEPT
        belief, error = beliefs[sender, ring, BELIEF], beliefs[sender, ring, BELIEF_ERROR]
        is_held = beliefs[sender, ring, BELIEF_NUMBER] == number
        found.belief[k], found.error[k] = belief if is_held else gone, error
        found.due[due] = k
        due += int(is_held & (not found_bins(x, belief, error)))
    return due


@kernel(inlined=True)
def _work_out_due(x: Tracking, contents: Contents, found: _Found, due: int, scratch: FloatVector) -> None:
    """Work out the words of the tracks listed; ``scratch`` (2,) is overwritten."""
    mask, touched = (1 << SENDER_BITS) - 1, 0.0
    # First touch the contents of all, so that their cache misses overlap.
    for n in range(due):
        message = found.message[found.due[n]]
        sender, ring = message & mask, (message >> SENDER_BITS) % MESSAGES_KEPT
        touched += contents.rows[sender, ring, CONTENT_FIT_S] + contents.rows[sender, ring, CONTENT_HEAD]
    found.east[0] = touched
    for n in range(due):
        k = found.due[n]
        message = int(found.message[k])
        sender, ring = message & mask, (message >> SENDER_BITS) % MESSAGES_KEPT
        found.belief[k] = work_out(x, message, contents, scratch)
        found.error[k] = contents.beliefs[sender, ring, BELIEF_ERROR]


@kernel(inlined=True)
def _count_words(
    x: Tracking, host: int, tally: Tally, distance: IntVector, found: _Found, count: int
) -> None:
    """Count the tracks near a host from their words; those of remotes that have left are passed over."""
    left = 0
    for k in range(count):
        at, _ = bins_of(found.belief[k])
        found.belief[left], found.error[left], distance[left] = found.belief[k], found.error[k], distance[k]
        left += int(at >= 0)
    for k in range(left):
        found.east[k], found.north[k] = error_units(found.error[k])
    own_east_m, own_north_m = x.own_error_m[host, 0], x.own_error_m[host, 1]
    for k in range(left):
        found.relative[k] = units_bin(found.east[k], found.north[k], own_east_m, own_north_m)
    for k in range(left):
        far = distance[k]
        at, age = bins_of(found.belief[k])
        tally.held[far] += 1
        tally.error[far, at] += 1
        tally.relative[far, found.relative[k]] += 1
        tally.age[far, age] += 1
        tally.recent[at] += int((x.middle[0] <= far) & (far < x.middle[1]))


@kernel(inlined=True)
def _sample_each(
    x: Tracking,
    hosts: HostVector,
    contents: Contents,
    tracks: FloatCube,
    tally: Tally,
    first: int,
    end: int,
    near: Near,
    words: _Found,
    scratch: FloatVector,
) -> None:
    """Count the tracks of some hosts; the last three are overwritten."""
    bins = tally.held.size
    for host in range(first, end):
        if x.vehicle[host] < 0 or not x.counted[host]:
            continue
        count = near_tracks(x, host, hosts[host].used, tracks, bins, near.slot, near.distance)
        due = _read_words(x, host, contents.beliefs, tracks, near, words, count)
        _work_out_due(x, contents, words, due, scratch)
        _count_words(x, host, tally, near.distance, words, count)


@kernel
def sample_tracks(
    x: Tracking, hosts: HostVector, contents: Contents, tracks: FloatCube, tally: Tally, first: int, end: int
) -> None:
    """Count the tracking error and information age of every live track of some hosts, by true distance.

    Hosts that do not count are passed over. What a message predicts is worked out once, whoever holds it.
    Remotes that have left are passed over.
    """
    slots = tracks.shape[1] + 1
    near = Near(np.empty(slots, dtype=np.int64), np.empty(slots, dtype=np.int64))
    words = _Found(
        np.empty(slots, dtype=np.int64), np.empty(slots, dtype=np.int64), np.empty(slots, dtype=np.int64),
        np.empty(slots, dtype=np.int64), np.empty(slots), np.empty(slots), np.empty(slots, dtype=np.int64),
    )  # fmt: skip
    _sample_each(x, hosts, contents, tracks, tally, first, end, near, words, np.empty(2))


@kernel(inlined=True)
def _count_ahead(
    cells: Cells, k: int, distance_bin_m: float, counts: IntVector, way: FloatVector, pairs: IntVector
) -> None:
    """Count the pairs of one vehicle with those behind it in the cells' order, in both directions.

    ``counts`` (N,) is 1 for hosts that count. The last of ``pairs`` takes all that are farther than the bins.
    ``way`` (N,) is overwritten: distances are found in a loop of their own, several at a time.
    """
    bins, a_bin = pairs.size - 1, 1.0 / distance_bin_m
    east, north = cells.place[k, 0], cells.place[k, 1]
    left, right, _, row_to = cell_span(cells, east, north, distance_bin_m * bins)
    for row in range(cell_row(cells, north), row_to + 1):
        low, high = row_span(cells, row, left, right)
        low = max(low, k + 1)
        for n in range(high - low):
            a, b = cells.place[low + n, 0] - east, cells.place[low + n, 1] - north
            way[n] = sqrt(a * a + b * b) * a_bin
        for n in range(high - low):
            pairs[int(min(way[n], float(bins)))] += counts[k] + counts[low + n]


@kernel
def count_pairs(
    cells: Cells, part: tuple[int, int], distance_bin_m: float, counted: BoolVector, pairs: IntVector
) -> None:
    """Count one part of all pairs of host and remote by distance, ``pairs`` (distances,).

    ``part`` is its number and how many there are; ``counted`` (V,) whose pairs as hosts count. The cells are
    built for the distance that all bins reach.
    """
    present = cells.order.size
    way, found = np.empty(present), np.zeros(pairs.size + 1, dtype=np.int64)
    counts = np.zeros(present, dtype=np.int64)
    for k in range(present):
        counts[k] = int(counted[cells.order[k]])
    for k in range(present * part[0] // part[1], present * (part[0] + 1) // part[1]):
        _count_ahead(cells, k, distance_bin_m, counts, way, found)
    for at in range(pairs.size):
        pairs[at] += found[at]


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
