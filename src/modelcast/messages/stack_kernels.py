"""Compiled cost of a message on the air: which carries the certificate, its bytes, its duration."""

from typing import NamedTuple

import numpy as np

from modelcast.channel.airtime_kernels import frame_airtime
from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, FloatVector, IntVector

__all__ = [
    "RULES",
    "StackNumbers",
    "airtime",
    "carries_certificate",
    "frame_bytes",
    "frames_bytes",
    "which_carry",
]

RULES = ("gap", "timer", "always", "digest", "unsigned")
"""Certificate rules by their numbers, as `modelcast.messages.airtime.Stack` describes them."""
_GAP, _TIMER, _ALWAYS = range(3)
_TIME_SLACK_S = 1e-9


class StackNumbers(NamedTuple):
    """A `modelcast.messages.airtime.Stack` as kernels take it.

    Parameters
    ----------
    rule
        Index in `RULES`.
    interval_s
        Of certificates [s].
    around_bytes, more_bytes
        Bytes round every payload, and how many more with the certificate.
    preamble_s, symbol_s, service_tail_bits, bits_per_symbol
        As in the stack.
    """

    rule: int
    interval_s: float
    around_bytes: int
    more_bytes: int
    preamble_s: float
    symbol_s: float
    service_tail_bits: int
    bits_per_symbol: int


@kernel(inlined=True)
def carries_certificate(
    rule: int, interval_s: float, sent_s: float, last_sent_s: float, last_certified_s: float
) -> bool:
    """Whether a message carries the certificate; before the first of a sender the others are at -inf."""
    if rule == _GAP:
        return sent_s - last_sent_s > interval_s + _TIME_SLACK_S
    if rule == _TIMER:
        return sent_s - last_certified_s >= interval_s - _TIME_SLACK_S
    return rule == _ALWAYS


@kernel(inlined=True)
def frame_bytes(payload_bytes: int, certificate: bool, stack: StackNumbers) -> int:
    """Return the bytes handed to the physical layer for a payload."""
    return payload_bytes + stack.around_bytes + (stack.more_bytes if certificate else 0)


@kernel(inlined=True)
def airtime(size_bytes: int, stack: StackNumbers) -> float:
    """Return how long a frame of that size is on the air [s]."""
    return frame_airtime(
        size_bytes, stack.preamble_s, stack.symbol_s, stack.service_tail_bits, stack.bits_per_symbol
    )


@kernel
def which_carry(t_s: FloatVector, stack: StackNumbers, out: BoolVector) -> None:
    """Which messages of one sender, at rising times (N,) [s], carry the certificate."""
    last_s, certified_s = -np.inf, -np.inf
    for i in range(t_s.size):
        out[i] = carries_certificate(stack.rule, stack.interval_s, t_s[i], last_s, certified_s)
        last_s = t_s[i]
        if out[i]:
            certified_s = t_s[i]


@kernel
def frames_bytes(
    payload_bytes: IntVector, certificate: BoolVector, stack: StackNumbers, out: IntVector
) -> None:
    """Bytes of many frames, (N,)."""
    for i in range(payload_bytes.size):
        out[i] = frame_bytes(payload_bytes[i], certificate[i], stack)
