"""Compiled accounting of what the closed loop's senders hand to the radio: bytes, certificates, airtime."""

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector
from modelcast.messages.airtime_kernels import StackNumbers, airtime, carries_certificate, frame_bytes
from modelcast.runtime.fleet.arrays import Contents, Outbox, SenderArrays, Tally
from modelcast.runtime.fleet.composing_kernels import LoopModels, compose
from modelcast.runtime.fleet.layout_kernels import (
    AIRTIME_S,
    BELIEF_NUMBER,
    BELIEF_STEP,
    CERTIFICATES,
    CONTENT_BYTES,
    CONTENT_FIT_S,
    CONTENT_MEMBER,
    CONTENT_NUMBER,
    CONTENT_SENT_S,
    CONTENT_VEHICLE,
    FRAME_BYTES,
    MESSAGES,
    MESSAGES_KEPT,
    MODELS,
    PAYLOAD_BYTES,
    POWER_DBM,
    SENDER_BITS,
)

__all__ = ["emit"]


@kernel(inlined=True)
def emit(
    models: LoopModels,
    limits: tuple[float, float, float],
    stack: StackNumbers,
    s: SenderArrays,
    v: int,
    at: int,
    t_s: float,
    message: tuple[float, float, float, float],
    contents: Contents,
    out: Outbox,
    tally: Tally,
    scratch: FloatVector,
) -> None:
    """Compose a message, put it into the outbox and account for it.

    ``message`` is when it goes to the radio, its power, whether it is believed received, its cause.
    """
    sent_s, power_dbm, believed, cause = message
    number = s.number[v]
    ring = number % MESSAGES_KEPT
    row = contents.rows[v, ring]
    compose(models, limits, s, v, at, t_s, row, scratch)
    contents.beliefs[v, ring, BELIEF_NUMBER], contents.beliefs[v, ring, BELIEF_STEP] = number, -1
    row[CONTENT_VEHICLE], row[CONTENT_NUMBER] = s.vehicle[v], number
    row[CONTENT_FIT_S], row[CONTENT_SENT_S] = t_s, sent_s
    certificate = carries_certificate(stack.rule, stack.interval_s, sent_s, s.sent_s[v], s.certified_s[v])
    frame = frame_bytes(int(row[CONTENT_BYTES]), certificate, stack)
    k = out.filled[0]
    out.sender[k], out.ready_s[k], out.size_bytes[k] = v, sent_s, frame
    out.power_dbm[k], out.message_id[k] = power_dbm, (number << SENDER_BITS) | v
    out.filled[0] = k + 1
    if believed > 0.0:
        s.believed[v] = number
    if certificate:
        s.certified_s[v] = sent_s
    s.sent_s[v], s.number[v] = sent_s, number + 1
    tally.causes[int(cause)] += 1
    tally.sums[MESSAGES] += 1.0
    if row[CONTENT_MEMBER] < models.payload_bytes.size - 1:
        tally.sums[MODELS] += 1.0
    if certificate:
        tally.sums[CERTIFICATES] += 1.0
    tally.sums[PAYLOAD_BYTES] += row[CONTENT_BYTES]
    tally.sums[FRAME_BYTES] += frame
    tally.sums[AIRTIME_S] += airtime(frame, stack)
    tally.sums[POWER_DBM] += power_dbm
