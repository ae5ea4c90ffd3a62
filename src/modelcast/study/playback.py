"""A trip as it can be played: the truth, what each sender sends, and what its receiver believes.

Three senders drive the same trip at one threshold and meet the same channel: the evaluated one, one of plain
messages that the free receiver coasts, and the baseline. They keep the rules of the loss runs, keep-alive
included, and the losses are those of the evaluation's first seed.
"""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray

__all__ = ["Playback", "PlayedRun"]


@dataclass(frozen=True, slots=True)
class PlayedRun:
    """What one sender sent over a trip on one channel, and where its receiver believed it to be.

    Parameters
    ----------
    sender
        ``mbc`` for the evaluated one, ``free`` or ``baseline``.
    members
        Names of the sub-models of its bank.
    packet_error_ratio
        Mean share of messages that the channel loses, 0..1.
    believed_m
        Positions after the instant's message, (T, 2) [m]; NaN where the receiver held nothing.
    sent
        Samples with a message, (N,).
    kind
        `MessageKind` of each, (N,).
    in_use
        Sub-model in use after each, (N,).
    lost
        Whether each was lost, (N,).
    """

    sender: str
    members: tuple[str, ...]
    _: KW_ONLY
    packet_error_ratio: float
    believed_m: FloatArray
    sent: IntArray
    kind: IntArray
    in_use: IntArray
    lost: BoolArray


@dataclass(frozen=True, slots=True)
class Playback:
    """One trip of T samples, and the runs over it.

    Parameters
    ----------
    trip, threshold_m
        Which trip, and the threshold that all senders keep [m].
    at_s
        Time of the manoeuvre [s].
    t_s
        Sample times, (T,) [s].
    truth_m
        True positions, (T, 2) [m].
    parts
        Samples at which a part begins behind a gap, without the first.
    runs
        A run a channel and sender: without loss first, senders in the same order on each channel.
    """

    trip: str
    threshold_m: float
    _: KW_ONLY
    at_s: float
    t_s: FloatArray
    truth_m: FloatArray
    parts: IntArray
    runs: tuple[PlayedRun, ...]

    def error_m(self, run: PlayedRun) -> FloatArray:
        """Tracking error of a run after the instant's message, (T,) [m]; NaN where nothing was held.

        Parameters
        ----------
        run
            One of the runs.
        """
        return np.hypot(*(run.believed_m - self.truth_m).T)
