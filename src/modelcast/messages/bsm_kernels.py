"""Compiled packing of Part I for many basic safety messages at once."""

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, IntMatrix, IntVector, UInt8Matrix, UInt8Vector
from modelcast.messages.bsm_fields import PREAMBLE_BITS
from modelcast.messages.field_kernels import INTACT, close_frame, open_frame, read_fields, write_fields

__all__ = ["pack", "unpack"]


@kernel
def pack(codes: IntMatrix, layout: IntMatrix, header: UInt8Vector, out: UInt8Matrix) -> int:
    """Write frames, ``out`` (B, L); return the first row with a code out of its range, or -1."""
    for row in range(codes.shape[0]):
        for i in range(header.size):
            out[row, i] = header[i]
        if write_fields(codes[row], layout, 0, PREAMBLE_BITS, out[row], header.size) < 0:
            return row
    return -1


@kernel
def _unpack_row(
    octets: UInt8Vector, length: int, layout: IntMatrix, message_id: int, codes: IntVector
) -> tuple[int, bool]:
    """Read one frame's Part I: the bit of its first fault or -1, and whether more follows Part I."""
    fault, start, stop = open_frame(octets, length, message_id)
    if fault != INTACT:
        return fault, False
    preamble = octets[start] >> (8 - PREAMBLE_BITS)
    at = read_fields(octets, 8 * start + PREAMBLE_BITS, 8 * stop, layout, codes)
    if at < 0:
        return ~at, False
    if preamble != 0:
        return INTACT, True
    return close_frame(octets, length, at, stop)


@kernel
def unpack(
    octets: UInt8Matrix,
    lengths: IntVector,
    layout: IntMatrix,
    message_id: int,
    codes: IntMatrix,
    fault_bits: IntVector,
    more: BoolVector,
) -> None:
    """Read Part I of frames (B, L) into ``codes`` (B, F), ``fault_bits`` (B,) and ``more`` (B,)."""
    for row in range(octets.shape[0]):
        fault_bits[row], more[row] = _unpack_row(octets[row], lengths[row], layout, message_id, codes[row])
        if fault_bits[row] != INTACT:
            codes[row] = 0
