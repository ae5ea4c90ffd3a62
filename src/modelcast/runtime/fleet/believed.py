"""What hosts of a fleet believe of remotes, pair by pair: what applications on the map of a host take."""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.runtime.fleet.arrays import Tracks
from modelcast.runtime.fleet.believed_kernels import Pairs, Readers, believe_each
from modelcast.station.policy.neighbours_kernels import NeighbourTables
from modelcast.station.receiver.belief_kernels import BELIEF_COLUMNS
from modelcast.station.receiver.reading import Reading
from modelcast.station.sender.message_arrays import Contents

__all__ = ["Believed", "believe", "check_slots", "pairs_of"]


@dataclass(frozen=True, slots=True, eq=False)
class Believed:
    """Beliefs of N pairs of host and remote.

    Parameters
    ----------
    held
        Whether the host has a live track of the remote, (N,).
    motion
        East and north [m], their velocities [m/s], speed [m/s], heading, clockwise from north [rad],
        acceleration along the course [m/s²] and yaw rate, clockwise [rad/s], (N, 8), in the columns of
        `modelcast.station.receiver.belief_kernels`; not a number without a track.
    age_s
        Time since the fit that the host believes by, (N,) [s]; not a number without a track.
    """

    held: BoolArray
    _: KW_ONLY
    motion: FloatArray
    age_s: FloatArray


def pairs_of(
    hosts: IntArray, remotes: IntArray, reading: Reading | IntArray | None, own: IntArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Return slots of hosts and remotes, and how the hosts read, (N,) each, checked.

    Parameters
    ----------
    hosts, remotes
        Slots of each pair, (N,).
    reading
        One for all or (N,); None for each host's own.
    own
        How the vehicle of each slot reads, (V,).

    Raises
    ------
    ValueError
        Where the arrays differ in shape, a slot is none of the fleet's, or a reading is unknown.
    """
    given = np.broadcast_arrays(hosts, remotes, -1 if reading is None else reading)
    if given[0].ndim != 1:
        raise ValueError(f"hosts and remotes must be (N,), got {np.shape(hosts)} and {np.shape(remotes)}")
    host, remote, how = (np.array(one, dtype=np.int64) for one in given)
    check_slots("hosts", host, own.size)
    check_slots("remotes", remote, own.size)
    if reading is None:
        how = own[host]
    check_slots("reading", how, len(Reading))
    return host, remote, how


def believe(
    readers: Readers,
    tables: NeighbourTables,
    tracks: Tracks,
    contents: Contents,
    pairs: tuple[IntArray, IntArray, IntArray],
) -> Believed:
    """Return what hosts believe.

    Parameters
    ----------
    readers
        What they believe with.
    tables, tracks, contents
        Of all hosts and senders.
    pairs
        As `pairs_of` gives them.
    """
    count = pairs[0].size
    found = Pairs(
        *pairs,
        held=np.zeros(count, dtype=np.bool_),
        age_s=np.empty(count),
        motion=np.empty((count, BELIEF_COLUMNS)),
    )
    believe_each(readers, tables, tracks, contents.rows, found)
    return Believed(found.held, motion=found.motion, age_s=found.age_s)


def check_slots(name: str, numbers: IntArray, end: int) -> None:
    """Refuse numbers that are not of a range from 0.

    Parameters
    ----------
    name
        What they are called.
    numbers
        Slots, or other numbers, (N,).
    end
        The first that is too large.

    Raises
    ------
    ValueError
        Where one is out of the range.
    """
    if numbers.size and not 0 <= numbers.min() <= numbers.max() < end:
        raise ValueError(f"{name} must lie within 0..{end - 1}, got {numbers.min()} to {numbers.max()}")
