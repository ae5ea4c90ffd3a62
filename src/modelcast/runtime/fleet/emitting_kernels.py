"""Compiled accounting of what the closed loop's senders hand to the radio: bytes, certificates, airtime."""

from math import ceil

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector
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

__all__ = ["CERTIFICATE_RULES", "airtime", "emit", "frame_bytes"]

CERTIFICATE_RULES = ("gap", "timer", "always", "digest", "unsigned")
_GAP, _TIMER, _ALWAYS = range(3)
_TIME_SLACK_S = 1e-9


@kernel(inlined=True)
def _has_certificate(s: SenderArrays, v: int, sent_s: float, rule: int, interval_s: float) -> bool:
    """Whether a message carries the certificate, as `modelcast.messages.airtime.Stack` says."""
    if rule == _GAP:
        return sent_s - s.sent_s[v] > interval_s + _TIME_SLACK_S
    if rule == _TIMER:
        return sent_s - s.certified_s[v] >= interval_s - _TIME_SLACK_S
    return rule == _ALWAYS


@kernel(inlined=True)
def frame_bytes(payload: float, certificate: bool, stack: FloatVector) -> float:
    """Return the bytes handed to the physical layer for a payload."""
    return payload + stack[2] + (stack[3] if certificate else 0.0)


@kernel(inlined=True)
def airtime(size_bytes: float, stack: FloatVector) -> float:
    """Return how long a frame of that size is on the air [s]."""
    return stack[4] + stack[5] * ceil((stack[6] + 8.0 * size_bytes) / stack[7])


@kernel(inlined=True)
def emit(
    models: LoopModels,
    limits: tuple[float, float, float],
    stack: FloatVector,
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
    certificate = _has_certificate(s, v, sent_s, int(stack[0]), stack[1])
    frame = frame_bytes(row[CONTENT_BYTES], certificate, stack)
    k = out.filled[0]
    out.sender[k], out.ready_s[k], out.size_bytes[k] = v, sent_s, int(frame)
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
