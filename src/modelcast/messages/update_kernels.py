"""Compiled packing and reading of model updates: Part I and the model, many messages at once.

They do the common case, messages as modelcast sends them. What is anything else `unpack_update` leaves to
`modelcast.messages.mbc_update.read_update`, which says what it is, or what is wrong with it.
"""

from typing import NamedTuple

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    BoolVector,
    FloatMatrix,
    IntMatrix,
    IntVector,
    UInt8Matrix,
    UInt8Vector,
)
from modelcast.messages.bsm_fields import PREAMBLE_BITS
from modelcast.messages.codes_kernels import BITS
from modelcast.messages.field_kernels import FIRST, WIDTH, read_fields, write_fields

__all__ = ["ELSE", "MODEL", "PLAIN", "UpdateWire", "pack_updates", "unpack_updates"]

MODEL, PLAIN, ELSE = range(3)
"""What was read: a model of this profile, Part I alone, or something else that was not looked into."""

_ID_BITS, _COUNT_BITS, _REGION_BITS = 16, 2, 8
_PROFILE_BITS, _SUB_MODEL_BITS, _ALL_BITS, _LENGTH_BITS = 24, 3, 1, 7
_HEADER_BITS = 35
_LONG, _OVERLONG = 128, 0xC0
_LONG_FORM = 0x8000


class UpdateWire(NamedTuple):
    """What packing needs of a bank and its profile.

    Parameters
    ----------
    table, offsets, wire, wire_offsets
        As in `modelcast.messages.code_table.CodeTable`.
    layout
        Of Part I, as `field_kernels` takes it.
    plain
        Sub-models with which a message is a plain one, (M,).
    carries_all
        Whether the coefficients of all sub-models go out, or of the one in use alone.
    message_id, region, profile
        Numbers of the frame, the extension and the profile.
    """

    table: FloatMatrix
    offsets: IntVector
    wire: IntVector
    wire_offsets: IntVector
    layout: IntMatrix
    plain: BoolVector
    carries_all: bool
    message_id: int
    region: int
    profile: int


@kernel
def _put(out: UInt8Vector, at: int, value: int, width: int) -> int:
    """Write a whole number into zeros, first bit first; where the next one begins."""
    for bit in range(width - 1, -1, -1):
        if value >> bit & 1:
            out[at >> 3] |= 0x80 >> (at & 7)
        at += 1
    return at


@kernel
def _take(octets: UInt8Vector, at: int, width: int) -> int:
    """Read a whole number."""
    value = 0
    for place in range(at, at + width):
        value = value << 1 | int(octets[place >> 3]) >> (7 - (place & 7)) & 1
    return value


@kernel
def _put_length(out: UInt8Vector, at: int, count: int) -> int:
    """Write a length determinant."""
    if count < _LONG:
        return _put(out, at, count, 8)
    return _put(out, at, _LONG_FORM | count, 16)


@kernel
def _take_length(octets: UInt8Vector, at: int, stop: int) -> tuple[int, int]:
    """Read a length determinant before bit ``stop``: the length, -1 where it is none, and where it ends."""
    if at + 8 > stop:
        return -1, at
    count = _take(octets, at, 8)
    if count < _LONG:
        return count, at + 8
    if count >= _OVERLONG or at + 16 > stop:
        return -1, at
    count = _take(octets, at, 16) - _LONG_FORM
    return (count if count >= _LONG else -1), at + 16


@kernel
def _carried(w: UpdateWire, in_use: int, carries_all: bool) -> tuple[int, int, int]:
    """Return bounds of the coefficients carried, in the order of the wire, and the octets they take."""
    first, end = 0, w.wire.size
    if not carries_all:
        first, end = w.wire_offsets[in_use], w.wire_offsets[in_use + 1]
    bits = 0
    for k in range(first, end):
        bits += int(w.table[w.wire[k], BITS])
    return first, end, (bits + 7) >> 3


@kernel
def _pack_update(w: UpdateWire, in_use: int, core: IntVector, codes: IntVector, out: UInt8Vector) -> int:
    """Write the frame of one update, codes within their ranges, into zeros; return its octets."""
    plain = w.plain[in_use]
    first, end, count = _carried(w, in_use, w.carries_all)
    inner = (_HEADER_BITS + 8 * count + 7) >> 3
    bits = PREAMBLE_BITS
    for f in range(w.layout.shape[0]):
        bits += w.layout[f, WIDTH]
    if not plain:
        bits += _COUNT_BITS + _REGION_BITS + (8 if inner < _LONG else 16) + 8 * inner
    value = (bits + 7) >> 3
    start = _put_length(out, _put(out, 0, w.message_id, _ID_BITS), value)
    at = write_fields(core, w.layout, 0 if plain else 1, PREAMBLE_BITS, out, start >> 3)
    if not plain:
        at = _put(out, at, 0, _COUNT_BITS)
        at = _put(out, at, w.region, _REGION_BITS)
        at = _put_length(out, at, inner)
        at = _put(out, at, w.profile, _PROFILE_BITS)
        at = _put(out, at, in_use, _SUB_MODEL_BITS)
        at = _put(out, at, 1 if w.carries_all else 0, _ALL_BITS)
        at = _put(out, at, count, _LENGTH_BITS)
        for k in range(first, end):
            i = w.wire[k]
            at = _put(out, at, int(codes[i]) - int(w.table[i, FIRST]), int(w.table[i, BITS]))
    return (start >> 3) + value


@kernel
def pack_updates(
    w: UpdateWire, in_use: IntVector, core: IntMatrix, codes: IntMatrix, out: UInt8Matrix, lengths: IntVector
) -> None:
    """Write frames (B, L) of zeros and how many of their octets count, (B,)."""
    for row in range(core.shape[0]):
        lengths[row] = _pack_update(w, in_use[row], core[row], codes[row], out[row])


@kernel
def _unpack_update(
    w: UpdateWire, octets: UInt8Vector, length: int, core: IntVector, codes: IntVector
) -> tuple[int, int]:
    """Read a frame: what it is, and the sub-model in use or -1."""
    stop = 8 * length
    if length < 4 or _take(octets, 0, _ID_BITS) != w.message_id:
        return ELSE, -1
    value, at = _take_length(octets, _ID_BITS, stop)
    if value < 0 or at + 8 * value != stop:
        return ELSE, -1
    if at + PREAMBLE_BITS > stop:
        return ELSE, -1
    preamble = _take(octets, at, PREAMBLE_BITS)
    at = read_fields(octets, at + PREAMBLE_BITS, stop, w.layout, core)
    if at < 0:
        return ELSE, -1
    found, in_use = PLAIN, -1
    if preamble != 0:
        if preamble != 1 or at + _COUNT_BITS + _REGION_BITS > stop:
            return ELSE, -1
        if _take(octets, at, _COUNT_BITS + _REGION_BITS) != w.region:
            return ELSE, -1
        inner, at = _take_length(octets, at + _COUNT_BITS + _REGION_BITS, stop)
        end = at + 8 * inner
        if 8 * inner < _HEADER_BITS or end > stop or _take(octets, at, _PROFILE_BITS) != w.profile:
            return ELSE, -1
        at += _PROFILE_BITS
        in_use = _take(octets, at, _SUB_MODEL_BITS)
        carries_all = _take(octets, at + _SUB_MODEL_BITS, _ALL_BITS) == 1
        count = _take(octets, at + _SUB_MODEL_BITS + _ALL_BITS, _LENGTH_BITS)
        at += _SUB_MODEL_BITS + _ALL_BITS + _LENGTH_BITS
        if in_use >= w.plain.size:
            return ELSE, -1
        first, last, wanted = _carried(w, in_use, carries_all)
        if count != wanted or at + 8 * count > end or end - at - 8 * count >= 8:
            return ELSE, -1
        for k in range(first, last):
            i = w.wire[k]
            bits = int(w.table[i, BITS])
            codes[i] = _take(octets, at, bits) + int(w.table[i, FIRST])
            at += bits
        if _take(octets, at, end - at) != 0:
            return ELSE, -1
        found, at = MODEL, end
    if stop - at >= 8 or _take(octets, at, stop - at) != 0:
        return ELSE, -1
    return found, in_use


@kernel
def unpack_updates(
    w: UpdateWire,
    frames: UInt8Matrix,
    lengths: IntVector,
    found: IntVector,
    in_use: IntVector,
    core: IntMatrix,
    codes: IntMatrix,
) -> None:
    """Read frames (B, L): what each is, (B,), the sub-model in use, Part I (B, 25), coefficients (B, P)."""
    for row in range(frames.shape[0]):
        found[row], in_use[row] = _unpack_update(w, frames[row], lengths[row], core[row], codes[row])
