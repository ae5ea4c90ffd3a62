"""What a policy put on the air over a trip: when, how many bytes, and for how long."""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.models.bank import Bank
from modelcast.runtime.trip.runtime import TripMessages
from modelcast.station.policy.base import MessageKind
from modelcast.study.settings import EvaluationSettings

__all__ = ["SentLoad", "sent_load"]


@dataclass(frozen=True, slots=True)
class SentLoad:
    """The N messages of one policy over a trip.

    Parameters
    ----------
    at
        Samples at which they were sent, (N,).
    size_bytes
        Application bytes of each: the message in its frame, without security header or lower layers, (N,).
    airtime_s
        How long each occupies the channel, all layers and the security header counted, (N,) [s].
    """

    at: IntArray
    size_bytes: IntArray
    airtime_s: FloatArray


def sent_load(walk: TripMessages, bank: Bank, t_s: FloatArray, settings: EvaluationSettings) -> SentLoad:
    """Messages of a policy by the sizes and the stack of the settings.

    Parameters
    ----------
    walk
        What was sent.
    bank
        By which sub-models.
    t_s
        Sample times, (T,) [s].
    settings
        Sizes and stack.
    """
    at = np.flatnonzero(walk.transmits)
    updates = settings.sizes.each_update_bytes(bank, walk.policy.identify)
    named = walk.kind[at] == MessageKind.IDENTIFICATION
    size_bytes = np.where(named, settings.sizes.identification_bytes, updates[walk.in_use[at]])
    return SentLoad(at, size_bytes, settings.stack.sent_airtime_s(t_s[at], size_bytes))
