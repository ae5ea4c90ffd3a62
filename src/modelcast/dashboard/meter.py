"""Messages and bytes a second, over the last moments; time is an argument."""

import math
from collections import Counter

import numpy as np

from modelcast.dashboard.snapshot import Counters

__all__ = ["MessageMeter"]

_BIN_S = 0.1


class MessageMeter:
    """Counts what is sent, received and refused.

    Counts are kept in bins of 0.1 s, so a flood of messages takes no more room than a few.

    Parameters
    ----------
    window_s
        Time over which rates are taken [s].

    Raises
    ------
    ValueError
        Where it is shorter than a bin.

    Examples
    --------
    >>> meter = MessageMeter(window_s=1.0)
    >>> for step in range(40):
    ...     meter.received(0.05 * step, 200)
    >>> now = meter.counters(1.99)
    >>> now.received_per_s, now.received_bytes_per_s
    (20.0, 4000.0)
    """

    def __init__(self, window_s: float = 2.0) -> None:
        if not _BIN_S <= window_s <= 3600.0:
            raise ValueError(f"window_s must be from {_BIN_S} to 3600, got {window_s}")
        self._bins = round(window_s / _BIN_S)
        self._held: dict[int, list[int]] = {}
        self._rejected: Counter[str] = Counter()

    def sent(self, t_s: float, frame_bytes: int) -> None:
        """Count a frame that is sent.

        Parameters
        ----------
        t_s
            When [s].
        frame_bytes
            Its length [B].
        """
        self._count(t_s, 0, frame_bytes)

    def received(self, t_s: float, frame_bytes: int) -> None:
        """Count a frame that arrived.

        Parameters
        ----------
        t_s, frame_bytes
            As in `sent`.
        """
        self._count(t_s, 2, frame_bytes)

    def refused(self, reason: str, messages: int = 1) -> None:
        """Count messages that arrived and were refused.

        Parameters
        ----------
        reason
            Why, one of a few.
        messages
            How many.
        """
        self._rejected[reason] += messages

    def counters(
        self, t_s: float, *, loss_ratio: float = np.nan, channel_busy_ratio: float = np.nan
    ) -> Counters:
        """The rates of the window that ends now.

        Parameters
        ----------
        t_s
            Now [s].
        loss_ratio, channel_busy_ratio
            As in `Counters`.
        """
        newest = math.floor(t_s / _BIN_S + 1e-6)
        rows = [row for at, row in self._held.items() if newest - self._bins < at <= newest]
        sent, sent_bytes, received, received_bytes = (
            sum(row[column] for row in rows) / (self._bins * _BIN_S) for column in range(4)
        )
        return Counters(
            sent,
            received,
            sent_bytes_per_s=sent_bytes,
            received_bytes_per_s=received_bytes,
            loss_ratio=loss_ratio,
            channel_busy_ratio=channel_busy_ratio,
            rejected=dict(self._rejected),
        )

    def _count(self, t_s: float, column: int, frame_bytes: int) -> None:
        at = math.floor(t_s / _BIN_S + 1e-6)
        row = self._held.get(at)
        if row is None:
            row = self._held[at] = [0, 0, 0, 0]
            for old in [one for one in self._held if one <= at - self._bins]:
                del self._held[old]
        row[column] += 1
        row[column + 1] += frame_bytes
