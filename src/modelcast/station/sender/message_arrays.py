"""What stations hold of their messages, as plain arrays that compiled steps own and write.

Every message has a number that counts those of its station from 0; its content stands at that number modulo
`MESSAGES_KEPT` in a ring, as decoded from its codes.
"""

from typing import NamedTuple

import numpy as np

from modelcast.core.kernel_types import (
    BoolVector,
    FloatCube,
    FloatMatrix,
    FloatVector,
    IntCube,
    IntVector,
)
from modelcast.messages.cam_sizes import FrameSizeNumbers
from modelcast.messages.stack_kernels import StackNumbers
from modelcast.station.sender.motion_kernels import MOTION

__all__ = [
    "AIRTIME_S",
    "BELIEF",
    "BELIEF_COLUMNS",
    "BELIEF_ERROR",
    "BELIEF_NUMBER",
    "CAUSES",
    "CERTIFICATES",
    "CONTENT_ACCELERATION_MPS2",
    "CONTENT_BYTES",
    "CONTENT_EAST_M",
    "CONTENT_FIRST",
    "CONTENT_FIT_S",
    "CONTENT_HEAD",
    "CONTENT_HEADING_RAD",
    "CONTENT_KIND",
    "CONTENT_MEMBER",
    "CONTENT_NAMED_S",
    "CONTENT_NORTH_M",
    "CONTENT_NUMBER",
    "CONTENT_SENT_S",
    "CONTENT_SPEED_MPS",
    "CONTENT_UPDATE",
    "CONTENT_VEHICLE",
    "CONTENT_YAW_RATE_RADPS",
    "FRAME_BYTES",
    "IDENTIFICATIONS",
    "MESSAGES",
    "MESSAGES_KEPT",
    "MODELS",
    "PAYLOAD_BYTES",
    "POWER_DBM",
    "SENDER_BITS",
    "SENT",
    "Contents",
    "FleetNumbers",
    "Outbox",
    "Senders",
    "SentTally",
    "contents",
    "outbox",
    "senders",
    "sent_tally",
]

MESSAGES_KEPT = 128
"""Messages of a sender that its ring holds; the message count on the air (DE_MsgCount) runs modulo it too."""

SENDER_BITS = 20
"""Bits of a message's id on the radio that say whose it is; its number stands above them."""

(
    CONTENT_VEHICLE,
    CONTENT_NUMBER,
    CONTENT_KIND,
    CONTENT_UPDATE,
    CONTENT_FIT_S,
    CONTENT_NAMED_S,
    CONTENT_SENT_S,
    CONTENT_EAST_M,
    CONTENT_NORTH_M,
    CONTENT_MEMBER,
    CONTENT_BYTES,
    CONTENT_SPEED_MPS,
    CONTENT_HEADING_RAD,
    CONTENT_ACCELERATION_MPS2,
    CONTENT_YAW_RATE_RADPS,
    CONTENT_FIRST,
) = range(16)
"""Columns of a message's content: who sent it and its number; its kind, and the number of the update that it
is
or names; instant of that update's fit, of the decision, and when it was handed to the radio; the position
stated; the sub-model; payload bytes; what Part I states of motion, as receivers decode it; the column where
the sub-model's parameters begin. Parameters follow. Of an identification, Part I and parameters are those of
the update it names."""

CONTENT_HEAD = 16

BELIEF_NUMBER, BELIEF, BELIEF_ERROR, BELIEF_COLUMNS = range(4)
"""Columns of what a message makes its holders believe: its number; step, bins of tracking error and
information age at that step, in one word; step and error as a vector, in another (`belief_words_kernels`);
their number."""

CAUSES = 4
"""Causes of a message as `j2945_kernels` numbers them; the others count under time (1)."""

(
    MESSAGES,
    MODELS,
    IDENTIFICATIONS,
    CERTIFICATES,
    PAYLOAD_BYTES,
    FRAME_BYTES,
    AIRTIME_S,
    POWER_DBM,
) = range(8)
"""Sums of what was sent: messages handed to the radio, those with a model, identifications, those with a
certificate; bytes, bytes of frames, airtime, power."""

SENT = 8


class SentTally(NamedTuple):
    """Counts of messages: ``causes`` (CAUSES,) by cause; ``sums`` (G, SENT), a row a group of slots.

    Slots fall into G groups one after another. Each adds to the row of its group, so that sums are the same
    to the last digit however the groups are worked on.
    """

    causes: IntVector
    sums: FloatMatrix

    @property
    def total(self) -> FloatVector:
        """Sums of all groups, (SENT,)."""
        return self.sums.sum(axis=0)


class Senders(NamedTuple):
    """What V stations on the air hold of their messages.

    ``vehicle`` (V,) who is in the slot, -1 for nobody; ``number`` (V,) of the next message; ``update`` (V,)
    of the update that the remotes are believed to hold, and ``stated`` (V, MOTION) what its Part I states;
    ``sent_s`` and ``certified_s`` (V,) when the last message, and the last with a certificate, went out;
    ``size_state`` (V,) of the last frame where sizes follow a chain, -1 before the first, and ``word`` (V,)
    what its numbers are drawn by.
    """

    vehicle: IntVector
    number: IntVector
    update: IntVector
    stated: FloatMatrix
    sent_s: FloatVector
    certified_s: FloatVector
    size_state: IntVector
    word: IntVector


class FleetNumbers(NamedTuple):
    """What all messages of a fleet have in common.

    ``stack`` what goes round a payload; ``identification_bytes``; ``carries_all`` whether updates hold the
    parameters of all members; ``first_member`` where the bank begins among the members of all senders;
    ``plain`` (M,) with which the message is a plain one; ``power_dbm`` where the policy leaves it open;
    ``jitter_s`` by which messages that leave at once are spread; ``grant`` that each asks for; ``frames``
    sizes of frames that follow a chain.
    """

    stack: StackNumbers
    identification_bytes: int
    carries_all: bool
    first_member: int
    plain: BoolVector
    power_dbm: float
    jitter_s: float
    grant: int
    frames: FrameSizeNumbers


class Contents(NamedTuple):
    """Messages as decoded, ``rows`` (V, MESSAGES_KEPT, W), and what they make their holders believe.

    ``beliefs`` (V, MESSAGES_KEPT, BELIEF_COLUMNS) is worked out once a step for each message, since it is the
    same for all hosts that hold it.
    """

    rows: FloatCube
    beliefs: IntCube


class Outbox(NamedTuple):
    """Messages of one step: sender, ready [s], bytes, power [dBm], id, next one [s], grant; count, (1,)."""

    sender: IntVector
    ready_s: FloatVector
    size_bytes: IntVector
    power_dbm: FloatVector
    message_id: IntVector
    next_s: FloatVector
    grant: IntVector
    filled: IntVector


def senders(phase: FloatVector) -> Senders:
    """Return V stations that have sent nothing, one a phase (V,), by whose bits sizes are drawn."""
    vehicles = phase.size
    return Senders(
        vehicle=np.full(vehicles, -1, dtype=np.int64),
        number=np.zeros(vehicles, dtype=np.int64),
        update=np.full(vehicles, -1, dtype=np.int64),
        stated=np.zeros((vehicles, MOTION)),
        sent_s=np.full(vehicles, -np.inf),
        certified_s=np.full(vehicles, -np.inf),
        size_state=np.full(vehicles, -1, dtype=np.int64),
        word=np.array(phase, dtype=np.float64).view(np.int64) ^ np.arange(vehicles) << SENDER_BITS,
    )


def contents(vehicles: int, parameters: int, *, beliefs: int = BELIEF_COLUMNS) -> Contents:
    """Return empty rings for messages of so many parameters at most, and columns of beliefs."""
    shape = (vehicles, MESSAGES_KEPT)
    return Contents(
        rows=np.full((*shape, CONTENT_HEAD + parameters), -1.0),
        beliefs=np.full((*shape, beliefs), -1, dtype=np.int64),
    )


def outbox(vehicles: int) -> Outbox:
    """Return an empty outbox for so many vehicles."""
    most = 2 * vehicles
    return Outbox(
        sender=np.zeros(most, dtype=np.int64),
        ready_s=np.zeros(most),
        size_bytes=np.zeros(most, dtype=np.int64),
        power_dbm=np.zeros(most),
        message_id=np.zeros(most, dtype=np.int64),
        next_s=np.full(most, np.inf),
        grant=np.zeros(most, dtype=np.int64),
        filled=np.zeros(1, dtype=np.int64),
    )


def sent_tally(groups: int = 1) -> SentTally:
    """Return counts of nothing."""
    return SentTally(np.zeros(CAUSES, dtype=np.int64), np.zeros((groups, SENT)))
