"""Who speaks and who reads how in a fleet: vehicles of several senders and readings on one channel.

A vehicle belongs to a group of senders and reads in one way as long as it lives, also where it leaves and
comes back. Both are drawn in the order in which vehicles appear, from numbers that no share is part of: the
vehicles that speak a language at 25 % speak it at 50 % too.
"""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.core.chance import child_generator
from modelcast.models.bank import Bank
from modelcast.station.receiver.reading import Reading
from modelcast.station.sender.sender import Sender

__all__ = ["MODEL_READERS", "Draw", "Mix"]

MODEL_READERS = (0.0, 0.0, 1.0)
"""Everybody reads models."""

_SLACK = 1e-9


@dataclass(frozen=True, slots=True)
class Mix:
    """Senders and readings of a fleet, each with its share of the vehicles.

    Parameters
    ----------
    senders
        What vehicles send, and when; one a group.
    shares
        Of the vehicles, one a group, 0..1.
    readings
        Shares of those that read as legacy, free and model receivers do (`Reading`), 0..1.
    free
        The bank by whose free sub-model Part I is coasted; None for `modelcast.station.banks.free_bank`.

    Raises
    ------
    ValueError
        Where there is no sender, shares are not one each, or do not sum to 1.

    Examples
    --------
    >>> from modelcast.station.sender.sender import named_sender
    >>> Mix((named_sender("bsm-10hz"),)).is_one
    True
    """

    senders: tuple[Sender, ...]
    shares: tuple[float, ...] = (1.0,)
    _: KW_ONLY
    readings: tuple[float, float, float] = MODEL_READERS
    free: Bank | None = None

    def __post_init__(self) -> None:
        if not self.senders or len(self.senders) != len(self.shares):
            raise ValueError(f"shares must be one a sender, got {len(self.shares)} of {len(self.senders)}")
        if len(self.readings) != len(Reading):
            raise ValueError(f"readings must be legacy, free and model, got {self.readings}")
        for name, shares in (("shares", self.shares), ("readings", self.readings)):
            if min(shares) < 0.0 or not abs(sum(shares) - 1.0) <= _SLACK:
                raise ValueError(f"{name} must be shares that sum to 1, got {shares}")

    @property
    def is_one(self) -> bool:
        """Whether all speak alike, and read models."""
        return len(self.senders) == 1 and self.readings == MODEL_READERS


class Draw:
    """Draws of vehicles: which group each belongs to, and how it reads.

    Parameters
    ----------
    mix
        The shares.
    seed
        Of the draws.
    """

    def __init__(self, mix: Mix, seed: int) -> None:
        self._edges = [np.cumsum(shares)[:-1] for shares in (mix.shares, mix.readings)]
        self._rng = child_generator(seed, "mix")
        self._known: dict[int, tuple[int, int]] = {}

    def place(self, vehicle: IntArray, new: BoolArray, group: IntArray, reading: IntArray) -> None:
        """Write group and reading of the vehicles of new slots into their columns.

        Those that appear together share each range of the draw evenly, so that shares are met from the first
        frame on.

        Parameters
        ----------
        vehicle
            Ids by slot, (V,).
        new
            Slots that have a new vehicle, (V,).
        group, reading
            Of each slot, (V,); written.
        """
        ids: list[int] = vehicle[new].tolist()
        fresh = [one for one in dict.fromkeys(ids) if one not in self._known]
        if fresh:
            found = [np.searchsorted(edges, self._even(len(fresh)), side="right") for edges in self._edges]
            pairs = zip(*(one.tolist() for one in found), strict=True)
            self._known |= dict(zip(fresh, pairs, strict=True))
        for slot, one in zip(np.flatnonzero(new).tolist(), ids, strict=True):
            group[slot], reading[slot] = self._known[one]

    def _even(self, count: int) -> FloatArray:
        """So many numbers in [0, 1), one in each of as many equal parts, in random order."""
        return (self._rng.permutation(count) + self._rng.random(count)) / count
