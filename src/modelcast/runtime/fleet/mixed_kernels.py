"""Compiled tracks of a mixed fleet against the truth, each as its host reads it."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from modelcast.channel.cells_kernels import Cells, cell_row, cell_span, row_span
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, FloatCube, FloatVector, IntMatrix, IntVector
from modelcast.runtime.fleet.arrays import TRACK_MESSAGE
from modelcast.runtime.fleet.belief_words_kernels import (
    Tracking,
    bins_of,
    error_word,
    found_bins,
    gone_words,
    relative_bin,
    word_of,
)
from modelcast.runtime.fleet.mixed import MixedTally
from modelcast.runtime.fleet.tracking_kernels import Near, near_tracks, work_out
from modelcast.station.policy.neighbours_kernels import HostVector
from modelcast.station.receiver.reading_kernels import MODEL, MOST_PARAMETERS, FreeRule, displace_stated
from modelcast.station.sender.message_arrays import (
    BELIEF_COLUMNS,
    BELIEF_ERROR,
    BELIEF_NUMBER,
    CONTENT_FIT_S,
    CONTENT_SPEED_MPS,
    CONTENT_VEHICLE,
    MESSAGES_KEPT,
    SENDER_BITS,
    Contents,
)
from modelcast.station.sender.motion_kernels import MOTION

__all__ = ["COLUMNS", "MixedReaders", "count_mixed", "sample_mixed"]

COLUMNS = BELIEF_COLUMNS + 4
"""Columns of what a message makes its holders believe: those of model receivers, then the words of bins for
legacy and for free ones, then those of errors."""

_ERRORS = BELIEF_COLUMNS + 2

READINGS = 3
"""Of a sender's messages, a row of counts each."""


class MixedReaders(NamedTuple):
    """How Part I is coasted freely; group and reading of the vehicle of each slot, (V,)."""

    free: FreeRule
    group: IntVector
    reading: IntVector


@kernel(inlined=True)
def _read(
    x: Tracking, readers: MixedReaders, reading: int, message: int, contents: Contents, scratch: FloatVector
) -> int:
    """Word of what a message makes holders believe now that read it so; worked out once a step."""
    if reading == MODEL:
        return work_out(x, message, contents, scratch)
    sender = message & ((1 << SENDER_BITS) - 1)
    ring = (message >> SENDER_BITS) % MESSAGES_KEPT
    column = BELIEF_COLUMNS + reading
    known = contents.beliefs[sender, ring, column]
    if found_bins(x, known, contents.beliefs[sender, ring, _ERRORS + reading]):
        return known
    row = contents.rows[sender, ring]
    found, error = gone_words(x)
    if row[CONTENT_VEHICLE] == x.vehicle[sender]:
        stated = row[CONTENT_SPEED_MPS : CONTENT_SPEED_MPS + MOTION]
        age_s = x.t_s - row[CONTENT_FIT_S]
        displace_stated(readers.free, reading, stated, age_s, scratch[2:], scratch)
        found, error = word_of(x, sender, row, scratch), error_word(x, sender, row, scratch)
    contents.beliefs[sender, ring, _ERRORS + reading] = error
    contents.beliefs[sender, ring, column] = found
    return found


@kernel(inlined=True)
def _sample_each(
    x: Tracking,
    readers: MixedReaders,
    hosts: HostVector,
    contents: Contents,
    tracks: FloatCube,
    tally: MixedTally,
    span: tuple[int, int],
    near: Near,
    scratch: FloatVector,
) -> None:
    """Count the tracks of some hosts; the last two are overwritten."""
    mask, bins = (1 << SENDER_BITS) - 1, tally.held.shape[1]
    for host in range(span[0], span[1]):
        if x.vehicle[host] < 0 or not x.counted[host]:
            continue
        reading = readers.reading[host]
        errors = BELIEF_ERROR if reading == MODEL else _ERRORS + reading
        found = near_tracks(x, host, hosts[host].used, tracks, bins, near.slot, near.distance)
        for k in range(found):
            message, distance = int(tracks[host, near.slot[k], TRACK_MESSAGE]), near.distance[k]
            sender, number = message & mask, message >> SENDER_BITS
            if contents.beliefs[sender, number % MESSAGES_KEPT, BELIEF_NUMBER] != number:
                continue
            at, age = bins_of(_read(x, readers, reading, message, contents, scratch))
            if at < 0:
                continue
            which = READINGS * readers.group[sender] + reading
            tally.held[which, distance] += 1
            tally.error[which, distance, at] += 1
            tally.age[which, distance, age] += 1
            error = contents.beliefs[sender, number % MESSAGES_KEPT, errors]
            tally.relative[distance, relative_bin(error, x.own_error_m[host, 0], x.own_error_m[host, 1])] += 1
            if x.middle[0] <= distance < x.middle[1]:
                tally.recent[at] += 1


@kernel
def sample_mixed(
    x: Tracking,
    readers: MixedReaders,
    hosts: HostVector,
    contents: Contents,
    tracks: FloatCube,
    tally: MixedTally,
    first: int,
    end: int,
) -> None:
    """Count tracking error and information age of every live track of some hosts, by pairing and distance.

    Remotes that have left are passed over.
    """
    slots = tracks.shape[1] + 1
    near = Near(np.empty(slots, dtype=np.int64), np.empty(slots, dtype=np.int64))
    scratch = np.empty(2 + MOST_PARAMETERS)
    _sample_each(x, readers, hosts, contents, tracks, tally, (first, end), near, scratch)


@kernel
def count_mixed(
    cells: Cells,
    readers: MixedReaders,
    part: tuple[int, int],
    distance_bin_m: float,
    counted: BoolVector,
    pairs: IntMatrix,
) -> None:
    """Count one part of all pairs by pairing and distance, ``pairs`` (pairings, distances).

    ``part`` is its number and how many there are; ``counted`` (V,) whose pairs as hosts count. The cells are
    built for the distance that all bins reach.
    """
    present, bins = cells.order.size, pairs.shape[1]
    for k in range(present * part[0] // part[1], present * (part[0] + 1) // part[1]):
        east, north, one = cells.place[k, 0], cells.place[k, 1], cells.order[k]
        left, right, _, row_to = cell_span(cells, east, north, distance_bin_m * bins)
        for row in range(cell_row(cells, north), row_to + 1):
            low, high = row_span(cells, row, left, right)
            for n in range(max(low, k + 1), high):
                a, b, other = cells.place[n, 0] - east, cells.place[n, 1] - north, cells.order[n]
                distance = int(sqrt(a * a + b * b) / distance_bin_m)
                if distance < bins:
                    row_of = READINGS * readers.group[other] + readers.reading[one]
                    pairs[row_of, distance] += int(counted[one])
                    row_of = READINGS * readers.group[one] + readers.reading[other]
                    pairs[row_of, distance] += int(counted[other])
