"""Losses as they were recorded: what receivers heard of senders on the road, replayed.

Use `RecordedLosses` where somebody has logs: real losses come in bursts of all lengths, more of them at the
edge of reach, which neither `IndependentErasure` nor `GilbertElliott` has.
"""

from dataclasses import dataclass

import numpy as np

from modelcast.channel.base import AbstractChannel
from modelcast.channel.link_record import LinkRecord
from modelcast.core.arrays import BoolArray, FloatArray, IntArray

__all__ = ["RecordedLosses"]


@dataclass(frozen=True, slots=True, eq=False)
class RecordedLosses(AbstractChannel):
    """The losses of recorded links; each run draws a link of them and where in its record the trip begins.

    Parameters
    ----------
    links
        The records; each holds messages.

    Raises
    ------
    ValueError
        Where there is no link, or one without messages.

    Notes
    -----
    Every message of every link is as likely to be the first: a link is drawn as often as it has messages, and
    the place within it is uniform. So the loss at any instant is, over the runs, the mean of the record. At
    an instant between two recorded messages it is that of the one before. A record is a circle: behind its
    last message comes its first, as often as a trip needs; both were heard, so no run of losses is
    longer than one recorded. One random number is drawn, whatever the record.

    Examples
    --------
    >>> import numpy as np
    >>> link = LinkRecord("a hears b", np.array([False, True, True, False]), period_s=0.1)
    >>> channel = RecordedLosses((link,))
    >>> channel.packet_error_ratio
    0.5
    >>> channel.losses(np.arange(8) * 0.1, np.random.default_rng(1)).tolist()
    [True, False, False, True, True, False, False, True]
    """

    links: tuple[LinkRecord, ...]

    def __post_init__(self) -> None:
        if not self.links:
            raise ValueError("links must hold one link at least")
        for link in self.links:
            if not link.lost.size:
                raise ValueError(f"{link.name}: no message of the link is known to be heard or lost")

    @property
    def messages(self) -> int:
        """Messages heard and lost."""
        return sum(link.lost.size for link in self.links)

    @property
    def packet_error_ratio(self) -> float:
        """Share of the recorded messages that were lost."""
        return sum(int(link.lost.sum()) for link in self.links) / self.messages

    @property
    def bursts_s(self) -> FloatArray:
        """How long each run of lost messages lasts, (R,) [s]."""
        return np.concatenate([link.bursts.astype(np.float64) * link.period_s for link in self.links])

    @property
    def mean_burst_s(self) -> float | None:
        """How long a run of lost messages lasts on average; None where none was lost [s]."""
        bursts_s = self.bursts_s
        return float(bursts_s.mean()) if bursts_s.size else None

    def losses(self, t_s: FloatArray, rng: np.random.Generator) -> BoolArray:
        """What a drawn link lost from a drawn place on, (T,)."""
        return self.losses_from(float(rng.random()) * self.messages, t_s)

    def losses_from(self, start: float, t_s: FloatArray) -> BoolArray:
        """What was lost from a place of the record on, (T,).

        Parameters
        ----------
        start
            Messages before that place, those of all links one behind the other: 0 to `messages`. Time 0 is
            there.
        t_s
            Instants, (T,) [s].

        Raises
        ------
        ValueError
            Where the place is out of the record.
        """
        if not 0.0 <= start < self.messages:
            raise ValueError(f"start must lie in 0..{self.messages}, got {start}")
        ends: IntArray = np.cumsum([link.lost.size for link in self.links])
        at = int(np.searchsorted(ends, start, side="right"))
        link = self.links[at]
        place = start - float(ends[at] - link.lost.size)
        return link.lost[np.floor(place + t_s / link.period_s).astype(np.int64) % link.lost.size]
