"""Compiled packing of what every personal safety message holds, many messages at once.

A message is fields without a gap, with or without the elevation. Two layouts of the wire say so; each has,
beside the fields, the bits in front of the type of person and of the position as fields of one bit. A row of
the wire holds all of them in the order of its layout; ``spread`` tells where each field stands in the longer
one, and what is behind the elevation stands one place earlier in the shorter.
"""

from typing import NamedTuple

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolVector, IntMatrix, IntVector, UInt8Matrix, UInt8Vector
from modelcast.messages.field_kernels import (
    INTACT,
    close_frame,
    open_frame,
    read_fields,
    write_fields,
)

__all__ = ["PersonWire", "pack", "unpack"]

_LENGTH_AT = 2
_HEADER_OCTETS = 3


class PersonWire(NamedTuple):
    """How messages of people lie on the wire.

    Parameters
    ----------
    whole, short
        Low, span and width of what is written, with and without the elevation, (W, 3) and (W - 1, 3).
    spread
        Place of every field in a row of the wire, (F,).
    elevation
        Place of the elevation among the fields.
    flag
        Place in a row of the wire of the bit that tells whether the elevation is there.
    flag_bit
        Bits of a message in front of that bit.
    preamble_bits
        Bits in front of the first of the layout.
    unavailable
        Code of an elevation that is not known.
    message_id
        Of the frame.
    """

    whole: IntMatrix
    short: IntMatrix
    spread: IntVector
    elevation: int
    flag: int
    flag_bit: int
    preamble_bits: int
    unavailable: int
    message_id: int


@kernel(inlined=True)
def _pack_row(w: PersonWire, codes: IntVector, has_elevation: bool, wire: IntVector, out: UInt8Vector) -> int:
    """Write one frame; return its octets, or -1 where a code is out of its range."""
    wire[w.flag] = 1 if has_elevation else 0
    gap = w.spread[w.elevation]
    for f in range(codes.size):
        place = w.spread[f]
        if has_elevation or place < gap:
            wire[place] = codes[f]
        elif place > gap:
            wire[place - 1] = codes[f]
        elif codes[f] != w.unavailable:
            return -1
    layout = w.whole if has_elevation else w.short
    out[0] = w.message_id >> 8
    out[1] = w.message_id & 0xFF
    end = write_fields(wire, layout, 0, w.preamble_bits, out, _HEADER_OCTETS)
    if end < 0:
        return -1
    octets = (end + 7) >> 3
    out[_LENGTH_AT] = octets - _HEADER_OCTETS
    return octets


@kernel
def pack(
    w: PersonWire,
    codes: IntMatrix,
    has_elevation: BoolVector,
    wire: IntVector,
    out: UInt8Matrix,
    lengths: IntVector,
) -> int:
    """Write frames, ``out`` (B, L) of zeros; the first row with a code out of its range, or -1.

    ``wire`` (W,) is room for a row of the wire, zeros where no field stands.
    """
    for row in range(codes.shape[0]):
        octets = _pack_row(w, codes[row], has_elevation[row], wire, out[row])
        if octets < 0:
            return row
        lengths[row] = octets
    return -1


@kernel(inlined=True)
def _unpack_row(
    w: PersonWire, octets: UInt8Vector, length: int, wire: IntVector, codes: IntVector
) -> tuple[int, bool, bool]:
    """Read one frame: bit of its first fault or -1, whether the elevation is there, whether more follows."""
    fault, start, stop = open_frame(octets, length, w.message_id)
    if fault != INTACT:
        return fault, False, False
    begin = 8 * start
    if begin + w.preamble_bits > 8 * stop:
        return begin, False, False
    flag = begin + w.flag_bit
    # Without the bit itself, the message is cut short in front of it, in either layout.
    has_elevation = flag < 8 * stop and (octets[flag >> 3] >> (7 - (flag & 7))) & 1 == 1
    layout = w.whole if has_elevation else w.short
    at = read_fields(octets, begin + w.preamble_bits, 8 * stop, layout, wire)
    if at < 0:
        return ~at, False, False
    gap = w.spread[w.elevation]
    for f in range(codes.size):
        place = w.spread[f]
        if has_elevation or place < gap:
            codes[f] = wire[place]
        else:
            codes[f] = wire[place - 1] if place > gap else w.unavailable
    last = start + (w.preamble_bits >> 3)
    preamble = octets[last] >> (8 - (w.preamble_bits & 7))
    for place in range(start, last):
        preamble |= octets[place]
    if preamble != 0:
        return INTACT, has_elevation, True
    fault, more = close_frame(octets, length, at, stop)
    return fault, has_elevation, more


@kernel
def unpack(
    w: PersonWire,
    octets: UInt8Matrix,
    lengths: IntVector,
    wire: IntVector,
    codes: IntMatrix,
    has_elevation: BoolVector,
    fault_bits: IntVector,
    more: BoolVector,
) -> None:
    """Read frames (B, L) into ``codes`` (B, F), ``has_elevation``, ``fault_bits`` and ``more``, (B,) each.

    ``wire`` (W,) is room for a row of the wire.
    """
    for row in range(octets.shape[0]):
        fault, has, rest = _unpack_row(w, octets[row], lengths[row], wire, codes[row])
        fault_bits[row] = fault
        more[row] = rest
        has_elevation[row] = has
        if fault != INTACT:
            codes[row] = 0
            has_elevation[row] = False
