"""What a fleet on the air holds, as plain arrays that the compiled loop owns and writes.

Vehicles are slots of the scenario. Every message has a number that counts those of its slot from 0; its
content stands at that number modulo `MESSAGES_KEPT` in its sender's ring, as decoded from its bytes. Since
every host that holds a message holds the same numbers, tracks only say which message they hold.
"""

from typing import Any, NamedTuple

import numpy as np

from modelcast.core.kernel_types import (
    BoolVector,
    FloatCube,
    FloatMatrix,
    FloatVector,
    Int32Cube,
    IntMatrix,
    IntVector,
)
from modelcast.models.point_kernels import SAMPLE_COLUMNS
from modelcast.runtime.fleet.bins_kernels import BINS
from modelcast.runtime.fleet.layout_kernels import (
    BELIEF_COLUMNS,
    CAUSES,
    CONTENT_HEAD,
    MESSAGES_KEPT,
    SUMS,
)
from modelcast.station.policy.dcc_kernels import STATE_COLUMNS as DCC_COLUMNS
from modelcast.station.policy.j2945_kernels import STATE_COLUMNS as RULE_COLUMNS

__all__ = [
    "Contents",
    "Outbox",
    "SenderArrays",
    "Tally",
    "contents",
    "outbox",
    "sender_arrays",
    "tally",
]


class SenderArrays(NamedTuple):
    """What V senders hold.

    ``vehicle`` (V,) who is in the slot, -1 for nobody; ``history`` (V,) samples since it came; ``samples``
    (V, 2n, 7) and ``times`` (2n,) the last n samples, each written twice so that every window lies in one
    piece; ``noise`` (V, 2) running mean of squares and how many; ``phase`` (V,) where in a step each decides;
    ``rows`` (V, 15) and ``control`` (V, 5) state of the rule; ``begins_s``
    and ``begun`` (V,) when each begins to decide, and whether it has; ``due_s`` (V,) of the periodic one;
    ``number`` (V,) of the next message; ``believed`` (V,) of that which the remotes are believed to hold, -1
    for none; ``sent_s`` and ``certified_s`` (V,) when the last message, and the last with a certificate,
    went out; ``pending`` (V, 4) a message of the next step: time, power, whether believed, cause.
    """

    vehicle: IntVector
    history: IntVector
    samples: FloatCube
    times: FloatVector
    noise: FloatMatrix
    phase: FloatVector
    rows: FloatMatrix
    control: FloatMatrix
    begins_s: FloatVector
    begun: BoolVector
    due_s: FloatVector
    number: IntVector
    believed: IntVector
    sent_s: FloatVector
    certified_s: FloatVector
    pending: FloatMatrix
    trials: FloatCube
    origin: FloatMatrix
    scores: FloatMatrix


class Contents(NamedTuple):
    """Messages as decoded, ``rows`` (V, MESSAGES_KEPT, W), and what they make their holders believe.

    ``beliefs`` (V, MESSAGES_KEPT, 4) is worked out once a step for each message, since it is the same for all
    hosts that hold it.
    """

    rows: FloatCube
    beliefs: Int32Cube


class Outbox(NamedTuple):
    """Messages of one step, (2V,): sender, ready [s], bytes, power [dBm], id; and the count, (1,)."""

    sender: IntVector
    ready_s: FloatVector
    size_bytes: IntVector
    power_dbm: FloatVector
    message_id: IntVector
    filled: IntVector


class Tally(NamedTuple):
    """Streamed counts, in bins of distance between host and remote.

    ``error``, ``age``, ``gap`` (distances, BINS) of tracking errors, information ages and inter-packet gaps;
    ``held``, ``pairs`` (distances,) samples with a live track, and all; ``recent`` (BINS,) tracking errors
    near the middle distances since it was last cleared; ``causes`` (CAUSES,) messages by cause; ``sums``
    (SUMS,) as `layout_kernels` names them.
    """

    error: IntMatrix
    age: IntMatrix
    gap: IntMatrix
    held: IntVector
    pairs: IntVector
    recent: IntVector
    causes: IntVector
    sums: FloatVector


def sender_arrays(vehicles: int, window: int, phase: Any, *, members: int, parameters: int) -> SenderArrays:
    """Return the arrays of senders that have seen nothing.

    Parameters
    ----------
    vehicles
        V.
    window
        Longest window of a sub-model, n.
    phase
        Where in a step each decides, (V,) in [0, 1).
    members, parameters
        Sub-models, and most parameters of one.
    """
    return SenderArrays(
        vehicle=np.full(vehicles, -1, dtype=np.int64),
        history=np.zeros(vehicles, dtype=np.int64),
        samples=np.zeros((vehicles, 2 * window, SAMPLE_COLUMNS)),
        times=np.zeros(2 * window),
        noise=np.zeros((vehicles, 2)),
        phase=np.ascontiguousarray(phase, dtype=np.float64),
        rows=np.zeros((vehicles, RULE_COLUMNS)),
        control=np.zeros((vehicles, DCC_COLUMNS)),
        begins_s=np.zeros(vehicles),
        begun=np.zeros(vehicles, dtype=np.bool_),
        due_s=np.full(vehicles, -np.inf),
        number=np.zeros(vehicles, dtype=np.int64),
        believed=np.full(vehicles, -1, dtype=np.int64),
        sent_s=np.full(vehicles, -np.inf),
        certified_s=np.full(vehicles, -np.inf),
        pending=np.full((vehicles, 4), np.inf),
        trials=np.zeros((vehicles, members, parameters + 1)),
        origin=np.zeros((vehicles, 3)),
        scores=np.full((vehicles, members), -1.0),
    )


def contents(vehicles: int, parameters: int) -> Contents:
    """Return empty rings for messages of so many parameters at most."""
    shape = (vehicles, MESSAGES_KEPT)
    return Contents(
        rows=np.full((*shape, CONTENT_HEAD + parameters), -1.0),
        beliefs=np.full((*shape, BELIEF_COLUMNS), -1, dtype=np.int32),
    )


def outbox(vehicles: int) -> Outbox:
    """Return an empty outbox."""
    most = 2 * vehicles
    return Outbox(
        sender=np.zeros(most, dtype=np.int64),
        ready_s=np.zeros(most),
        size_bytes=np.zeros(most, dtype=np.int64),
        power_dbm=np.zeros(most),
        message_id=np.zeros(most, dtype=np.int64),
        filled=np.zeros(1, dtype=np.int64),
    )


def tally(distances: int) -> Tally:
    """Return counts of zero for so many bins of distance."""
    return Tally(
        error=np.zeros((distances, BINS), dtype=np.int64),
        age=np.zeros((distances, BINS), dtype=np.int64),
        gap=np.zeros((distances, BINS), dtype=np.int64),
        held=np.zeros(distances, dtype=np.int64),
        pairs=np.zeros(distances, dtype=np.int64),
        recent=np.zeros(BINS, dtype=np.int64),
        causes=np.zeros(CAUSES, dtype=np.int64),
        sums=np.zeros(SUMS),
    )
