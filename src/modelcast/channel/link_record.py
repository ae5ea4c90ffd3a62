"""What one receiver lost of one sender's messages, told from the counts of those that it heard.

A message counts (SAE J2735 ``msgCnt``: 0 to 127, then 0 again), so a gap in the counts that lasts as long as
the messages in it would have taken is a gap of lost messages. `counted_link` makes a `LinkRecord` of that;
`modelcast.channel.recorded.RecordedLosses` replays it.
"""

import hashlib
from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray

__all__ = ["COUNTS", "SHORTEST_PART", "LinkRecord", "counted_link"]

COUNTS = 128
"""Counts there are (SAE J2735, DE_MsgCount): no gap of as many messages can be told from a shorter one."""

SHORTEST_PART = 100
"""Messages, 10 s of them: a part begins and ends with one heard, so a short one makes losses look rare."""

_SLACK = 1
"""Messages by which counts and times may disagree: times are rounded and jitter."""


@dataclass(frozen=True, slots=True, eq=False)
class LinkRecord:
    """Which of a sender's messages one receiver lost, in order: the link's parts one behind the other.

    Parameters
    ----------
    name
        Who heard whom.
    lost
        Whether each message sent was lost, (N,). A part begins and ends with a message heard, so no run of
        losses grows together with another where two parts meet, or the end and the begin.
    period_s
        Time from message to message [s].
    heard
        Messages heard, those of parts left out too; repeated ones count once.
    unknown
        Spans between two messages heard of which it is not known what was lost.
    unknown_s
        Their length together [s].
    short
        Parts left out since they have fewer than `SHORTEST_PART` messages.

    Raises
    ------
    ValueError
        Where a record does not begin and end with a message heard, or the period is not positive.
    """

    name: str
    lost: BoolArray
    _: KW_ONLY
    period_s: float
    heard: int = 0
    unknown: int = 0
    unknown_s: float = 0.0
    short: int = 0

    def __post_init__(self) -> None:
        if self.lost.ndim != 1 or (self.lost.size and (self.lost[0] or self.lost[-1])):
            raise ValueError(f"{self.name}: lost must have one axis and begin and end with a message heard")
        if not (np.isfinite(self.period_s) and self.period_s > 0.0):
            raise ValueError(f"{self.name}: period_s must be positive and finite, got {self.period_s}")

    @property
    def fingerprint(self) -> str:
        """A hash of what is replayed, 16 hexadecimal digits."""
        told = f"{self.lost.size} {self.period_s!r} ".encode() + np.packbits(self.lost).tobytes()
        return hashlib.sha256(told).hexdigest()[:16]

    @property
    def bursts(self) -> IntArray:
        """Lengths of the runs of lost messages, in order, (R,)."""
        edges = np.flatnonzero(np.diff(self.lost.astype(np.int8)))
        return edges[1::2] - edges[::2]


def counted_link(name: str, t_s: FloatArray, count: IntArray, *, epoch: IntArray | None = None) -> LinkRecord:
    """The record of a link from the messages heard.

    Parameters
    ----------
    name
        Who heard whom.
    t_s
        When each message was generated, in any order, (M,) [s].
    count
        Its count, 0 to 127, (M,).
    epoch
        What changes where the sender's counts jump, (M,), as the random number of Safety Pilot messages does;
        None where nothing tells.

    Returns
    -------
    LinkRecord
        With no message in ``lost`` where no part is long enough.

    Raises
    ------
    ValueError
        Where shapes differ, a time is not finite, or a count is out of its range.

    Notes
    -----
    Messages are put in order of time. From one to the next, time makes a step of ``k`` messages, and of the
    steps that the counts allow (``d`` modulo 128) the nearest to ``k`` is taken. Where ``d`` and ``k`` differ
    by more than one, or ``k`` is over 127, or the epoch changed in more than one step, it is not known what
    was lost between the two: the record ends there and begins anew. Within a part every message has a number;
    numbers that were not heard were lost. So repeated messages and those that came out of order lose nothing.
    The period is the median of time over counts of all steps.

    Examples
    --------
    >>> import numpy as np
    >>> sent = np.arange(200)
    >>> heard = np.delete(sent, [50, 51, 120])
    >>> link = counted_link("a hears b", heard * 0.1, (heard + 100) % 128)
    >>> link.lost.size, np.flatnonzero(link.lost).tolist(), link.bursts.tolist()
    (200, [50, 51, 120], [2, 1])
    """
    epoch = np.zeros(t_s.size, dtype=np.int64) if epoch is None else epoch
    if t_s.ndim != 1 or not t_s.shape == count.shape == epoch.shape:
        raise ValueError(f"t_s, count and epoch must be (M,), got {t_s.shape}, {count.shape}, {epoch.shape}")
    if not np.isfinite(t_s).all():
        raise ValueError("t_s must be finite")
    if count.size and not 0 <= count.min() <= count.max() < COUNTS:
        raise ValueError(f"count must lie in 0..{COUNTS - 1}, got {count.min()} to {count.max()}")
    order = np.argsort(t_s, kind="stable")
    t_s, count, same = t_s[order], count[order], np.diff(epoch[order]) == 0
    step_s, gone = np.diff(t_s), np.diff(count) % COUNTS
    telling = same & (gone > 0) & (step_s > 0.0)
    if not telling.any():
        return LinkRecord(name, np.zeros(0, dtype=np.bool_), period_s=1.0, heard=t_s.size, short=1)
    period_s = float(np.median(step_s[telling] / gone[telling]))
    # A pause of days would overflow nothing else, but has no place in whole numbers.
    k = np.rint(np.minimum(step_s / period_s, 2.0 * COUNTS)).astype(np.int64)
    d = np.where(same, k + (gone - k + COUNTS // 2) % COUNTS - COUNTS // 2, 1)
    joined = np.where(same, (np.abs(d - k) <= _SLACK) & (k < COUNTS), k == 1)
    ends = np.concatenate([np.flatnonzero(~joined) + 1, [t_s.size]])
    parts: list[BoolArray] = []
    heard = short = 0
    for first, end in zip(np.concatenate([[0], ends[:-1]]).tolist(), ends.tolist(), strict=True):
        number = np.concatenate([[0], np.cumsum(d[first : end - 1])])
        number -= number.min()
        lost = np.ones(int(number.max()) + 1, dtype=np.bool_)
        lost[number] = False
        heard += int(lost.size - lost.sum())
        if lost.size < SHORTEST_PART:
            short += 1
        else:
            parts.append(lost)
    return LinkRecord(
        name,
        np.concatenate(parts) if parts else np.zeros(0, dtype=np.bool_),
        period_s=period_s,
        heard=heard,
        unknown=int((~joined).sum()),
        unknown_s=float(step_s[~joined].sum()),
        short=short,
    )
