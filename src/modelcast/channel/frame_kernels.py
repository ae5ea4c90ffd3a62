"""Compiled parts that all radios of frames share: what goes into a step and what comes out of it."""

from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntMatrix, IntVector

__all__ = ["Asked", "Heard", "are_in_order", "heard_room", "nothing_heard"]


class Asked(NamedTuple):
    """The columns of `Transmissions`, (N,) each."""

    sender: IntVector
    ready_s: FloatVector
    size_bytes: IntVector
    power_dbm: FloatVector
    message_id: IntVector
    priority: IntVector
    next_s: FloatVector
    grant: IntVector


class Heard(NamedTuple):
    """What becomes of them.

    ``who`` (R, 3): message, sender, receiver; ``when`` (R, 2): time [s] and power [mW]; ``outcomes`` (bins,
    5) and ``expired`` (E,) as `Receptions` has them.
    """

    who: IntMatrix
    when: FloatMatrix
    outcomes: IntMatrix
    expired: IntVector


@kernel
def nothing_heard(bins: int, messages: int) -> Heard:
    """Return room for receptions and for so many expired messages."""
    return Heard(
        np.empty((1024, 3), dtype=np.int64),
        np.empty((1024, 2)),
        np.zeros((bins, 5), dtype=np.int64),
        np.empty(messages, dtype=np.int64),
    )


@kernel
def heard_room(heard: Heard, received: int, more: int) -> Heard:
    """Return the same with room for more receptions."""
    held = heard.who.shape[0]
    if received + more <= held:
        return heard
    size = max(2 * held, received + more)
    who, when = np.empty((size, 3), dtype=np.int64), np.empty((size, 2))
    who[:received], when[:received] = heard.who[:received], heard.when[:received]
    return Heard(who, when, heard.outcomes, heard.expired)


@kernel
def are_in_order(
    message_id: IntVector,
    sender: IntVector,
    receiver: IntVector,
    t_s: FloatVector,
    vehicles: int,
    since_s: float,
) -> bool:
    """Return whether receptions, (R,) each, are as a fleet of so many can take them (`Receptions.check`)."""
    good, before_s = True, since_s
    for k in range(t_s.size):
        good &= (sender[k] >= 0) & (sender[k] < vehicles) & (receiver[k] >= 0) & (receiver[k] < vehicles)
        good &= (message_id[k] >= 0) & (sender[k] != receiver[k]) & (t_s[k] >= before_s)
        before_s = t_s[k]
    return good
