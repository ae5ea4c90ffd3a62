"""What a mixed fleet counts: tracking errors by who speaks and who reads how."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from modelcast.core.arrays import IntArray
from modelcast.core.kernel_types import IntCube, IntMatrix, IntVector
from modelcast.runtime.fleet.arrays import Tally
from modelcast.runtime.fleet.bins_kernels import BINS
from modelcast.runtime.fleet.mix import Mix
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.receiver.reading import Reading
from modelcast.station.sender.message_arrays import SentTally

__all__ = ["GroupRun", "MixedTally", "mixed_tally", "pairing", "pooled_mixed", "within"]


class MixedTally(NamedTuple):
    """Streamed counts of pairings, a row each: sender 0 as legacy, free and model receivers read it, then 1.

    ``error`` and ``age`` (pairings, distances, BINS) of tracking errors and information ages; ``relative``
    (distances, BINS) of relative errors, of all pairings together; ``held`` and ``pairs`` (pairings,
    distances) samples with a live track, and all; ``recent`` (BINS,) tracking errors near the middle
    distances since it was last cleared. No rows where all speak alike and read models.
    """

    error: IntCube
    relative: IntMatrix
    age: IntCube
    held: IntMatrix
    pairs: IntMatrix
    recent: IntVector


@dataclass(frozen=True, slots=True)
class GroupRun:
    """What the vehicles of one sender did in a run, the warm-up left out.

    Parameters
    ----------
    name
        Of the sender.
    sent
        Its counts.
    vehicle_s
        Time observed, over its vehicles [s].
    """

    name: str
    sent: SentTally
    vehicle_s: float


def pairing(group: int, reading: Reading) -> int:
    """Row of a pairing.

    Parameters
    ----------
    group
        Number of the sender.
    reading
        How its hosts read it.
    """
    return len(Reading) * group + reading


def mixed_tally(mix: Mix, settings: NetworkSettings) -> MixedTally:
    """Return counts of zero.

    Parameters
    ----------
    mix
        Who speaks and reads.
    settings
        How many bins of distance there are.
    """
    pairings = 0 if mix.is_one else len(mix.senders) * len(Reading)
    shape = (pairings, settings.distances)

    def nothing(*shape: int) -> IntArray:
        return np.zeros(shape, dtype=np.int64)

    return MixedTally(
        error=nothing(*shape, BINS),
        relative=nothing(settings.distances, BINS),
        age=nothing(*shape, BINS),
        held=nothing(*shape),
        pairs=nothing(*shape),
        recent=nothing(BINS),
    )


def pooled_mixed(tallies: list[MixedTally]) -> MixedTally:
    """Return the counts of several parts of a fleet together.

    Parameters
    ----------
    tallies
        At least one.
    """
    return MixedTally(*(np.sum(columns, axis=0) for columns in zip(*tallies, strict=True)))


def within(mixed: MixedTally, counts: Tally) -> Tally:
    """Return counts of a whole fleet with those of all its pairings in place of its own.

    Parameters
    ----------
    mixed
        Of the pairings.
    counts
        What hosts counted whoever speaks: gaps and receptions.
    """
    return counts._replace(
        error=mixed.error.sum(axis=0),
        relative=mixed.relative,
        age=mixed.age.sum(axis=0),
        held=mixed.held.sum(axis=0),
        pairs=mixed.pairs.sum(axis=0),
        recent=mixed.recent,
    )
