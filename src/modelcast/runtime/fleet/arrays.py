"""What a fleet on the air holds beside its stations, as plain arrays that the compiled loop owns and writes.

Vehicles are slots of the scenario. Every message has a number that counts those of its slot from 0; its
content stands at that number modulo `MESSAGES_KEPT` in its sender's ring, as decoded from its codes. Since
every host that holds a message holds the same numbers, tracks only say which message they hold.
"""

from typing import NamedTuple

import numpy as np

from modelcast.core.kernel_types import FloatCube, Int32Matrix, IntMatrix, IntVector
from modelcast.runtime.fleet.bins_kernels import BINS

__all__ = [
    "FAR",
    "REFUSED",
    "STALE",
    "TAKEN",
    "TRACK_COLUMNS",
    "TRACK_MESSAGE",
    "TRACK_RECEIVED_S",
    "UNKNOWN",
    "Tally",
    "Tracks",
    "pooled",
    "tally",
    "tracks",
]

TRACK_MESSAGE, TRACK_RECEIVED_S, TRACK_COLUMNS = range(3)
"""Columns of a track: id of the message held, -1 for none, and when the last one arrived; their number."""

TAKEN, FAR, REFUSED, STALE, UNKNOWN = range(5)
"""Sums of receptions: taken in, of remotes out of reach, without a free slot, older than what is held, naming
an
update that is not held."""


class Tracks(NamedTuple):
    """What V hosts hold: ``held`` (V, C, TRACK_COLUMNS) as named above, and whose it is, ``vehicle`` (V, C).

    They stand apart since the first is read through in every step, and what is read takes the time.
    """

    held: FloatCube
    vehicle: Int32Matrix


def tracks(vehicles: int, capacity: int) -> Tracks:
    """Return tracks of nothing."""
    return Tracks(
        np.full((vehicles, capacity, TRACK_COLUMNS), -1.0),
        np.full((vehicles, capacity), -1, dtype=np.int32),
    )


class Tally(NamedTuple):
    """Streamed counts, in bins of distance between host and remote.

    ``error``, ``relative``, ``age``, ``gap`` (distances, BINS) of tracking errors, of those relative to where
    hosts take themselves to be, of information ages and inter-packet gaps;
    ``held``, ``pairs`` (distances,) samples with a live track, and all; ``recent`` (BINS,) tracking errors
    near the middle distances since it was last cleared; ``causes`` (CAUSES,) messages by cause; ``sums``
    (SUMS,).
    """

    error: IntMatrix
    relative: IntMatrix
    age: IntMatrix
    gap: IntMatrix
    held: IntVector
    pairs: IntVector
    recent: IntVector
    heard: IntVector


def tally(distances: int) -> Tally:
    """Return counts of zero for so many bins of distance."""
    return Tally(
        error=np.zeros((distances, BINS), dtype=np.int64),
        relative=np.zeros((distances, BINS), dtype=np.int64),
        age=np.zeros((distances, BINS), dtype=np.int64),
        gap=np.zeros((distances, BINS), dtype=np.int64),
        held=np.zeros(distances, dtype=np.int64),
        pairs=np.zeros(distances, dtype=np.int64),
        recent=np.zeros(BINS, dtype=np.int64),
        heard=np.zeros(5, dtype=np.int64),
    )


def pooled(tallies: list[Tally]) -> Tally:
    """Return the counts of several parts of a fleet together, always added in their order."""
    return Tally(*(np.sum(columns, axis=0) for columns in zip(*tallies, strict=True)))
