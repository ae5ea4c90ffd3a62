"""Compiled airtime of an IEEE 802.11 frame: preamble, then whole OFDM symbols."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector, IntVector

__all__ = ["SERVICE_TAIL_BITS", "frame_airtime", "frame_airtimes"]

SERVICE_TAIL_BITS = 22
"""Service and tail bits, 16 and 6; IEEE Std 802.11-2020, clause 17.3.5."""


@kernel(inlined=True)
def frame_airtime(
    size_bytes: int, preamble_s: float, symbol_s: float, service_tail_bits: int, bits_per_symbol: int
) -> float:
    """Return the duration of a frame [s]."""
    bits = service_tail_bits + 8 * size_bytes
    return preamble_s + symbol_s * ((bits + bits_per_symbol - 1) // bits_per_symbol)


@kernel
def frame_airtimes(
    size_bytes: IntVector, preamble_s: float, symbol_s: float, service_tail_bits: int, bits_per_symbol: int
) -> FloatVector:
    """Return the durations of frames, (N,) [s]."""
    airtime_s = np.empty(size_bytes.size)
    for n in range(size_bytes.size):
        airtime_s[n] = frame_airtime(size_bytes[n], preamble_s, symbol_s, service_tail_bits, bits_per_symbol)
    return airtime_s
