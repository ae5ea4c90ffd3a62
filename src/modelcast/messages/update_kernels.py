"""Compiled packing and reading of model updates: what a message states and the model, many at once.

They do the common case, messages as modelcast sends them. What is anything else `unpack_update` leaves to
`modelcast.messages.mbc_update.read_update`, which says what it is, or what is wrong with it.
"""

from typing import NamedTuple

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    BoolVector,
    FloatMatrix,
    IntMatrix,
    IntVector,
    UInt8Matrix,
    UInt8Vector,
)
from modelcast.messages.codes_kernels import BITS
from modelcast.messages.field_kernels import FIRST, WIDTH, read_fields, write_fields

__all__ = [
    "ELSE",
    "MODEL",
    "NO_COLUMN",
    "PLAIN",
    "TYPE_COLUMN",
    "HeadTable",
    "UpdateWire",
    "pack_updates",
    "unpack_updates",
]

MODEL, PLAIN, ELSE = range(3)
"""What was read: a model of this profile, Part I alone, or something else that was not looked into."""

NO_COLUMN, TYPE_COLUMN = -1, -2
"""In place of a column of Part I: a bit that is zero, and the type of person."""

_ID_BITS, _COUNT_BITS, _REGION_BITS = 16, 2, 8
_PROFILE_BITS, _SUB_MODEL_BITS, _ALL_BITS, _LENGTH_BITS = 24, 3, 1, 7
_HEADER_BITS = 35
_LONG, _OVERLONG = 128, 0xC0
_LONG_FORM = 0x8000


class HeadTable(NamedTuple):
    """The H heads of `modelcast.messages.message_heads`, their R rows in turn.

    Parameters
    ----------
    message_id, preamble, preamble_bits
        Of each, (H,).
    first
        Bounds of each head's rows, (H + 1,).
    layout, columns
        (R, 3) and (R,).
    unavailable
        Codes of Part I where nothing is stated, (25,).
    kinds
        Kind of road user by the type of person, (5,).
    """

    message_id: IntVector
    preamble: IntVector
    preamble_bits: IntVector
    first: IntVector
    layout: IntMatrix
    columns: IntVector
    unavailable: IntVector
    kinds: IntVector


class UpdateWire(NamedTuple):
    """What packing needs of a bank and its profile.

    Parameters
    ----------
    table, offsets, wire, wire_offsets
        As in `modelcast.messages.code_table.CodeTable`.
    heads
        Of all kinds of messages.
    head
        Which of them an update has, by its sub-model, (M,).
    person_type
        Code of the type of person that is written.
    plain
        Sub-models with which a message is a plain one, (M,).
    carries_all
        Whether the coefficients of all sub-models go out, or of the one in use alone.
    region, profile
        Numbers of the extension and the profile.
    """

    table: FloatMatrix
    offsets: IntVector
    wire: IntVector
    wire_offsets: IntVector
    heads: HeadTable
    head: IntVector
    person_type: int
    plain: BoolVector
    carries_all: bool
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


@kernel(inlined=True)
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
def _pack_update(
    w: UpdateWire, in_use: int, core: IntVector, codes: IntVector, row: IntVector, out: UInt8Vector
) -> int:
    """Write the frame of one update, codes within their ranges, into zeros; return its octets.

    ``row`` is room for the longest head.
    """
    plain, heads, h = w.plain[in_use], w.heads, w.head[in_use]
    first, end, count = _carried(w, in_use, w.carries_all)
    inner = (_HEADER_BITS + 8 * count + 7) >> 3
    bits = int(heads.preamble_bits[h])
    begin = heads.first[h]
    rows = heads.first[h + 1] - begin
    for r in range(rows):
        bits += int(heads.layout[begin + r, WIDTH])
        column = heads.columns[begin + r]
        if column == NO_COLUMN:
            row[r] = 0
        else:
            row[r] = w.person_type if column == TYPE_COLUMN else core[column]
    if not plain:
        bits += _COUNT_BITS + _REGION_BITS + (8 if inner < _LONG else 16) + 8 * inner
    value = (bits + 7) >> 3
    start = _put_length(out, _put(out, 0, int(heads.message_id[h]), _ID_BITS), value)
    preamble = int(heads.preamble[h]) | (0 if plain else 1)
    layout = heads.layout[begin : begin + rows]
    at = write_fields(row, layout, preamble, int(heads.preamble_bits[h]), out, start >> 3)
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
    room = np.empty(w.heads.layout.shape[0], np.int64)
    for row in range(core.shape[0]):
        lengths[row] = _pack_update(w, in_use[row], core[row], codes[row], room, out[row])


@kernel(inlined=True)
def _head_of(heads: HeadTable, message_id: int, octets: UInt8Vector, at: int, stop: int) -> tuple[int, int]:
    """Which head a message of octets up to bit ``stop`` has, -1 for none that is known, and its preamble."""
    for h in range(heads.message_id.size):
        if heads.message_id[h] != message_id or at + heads.preamble_bits[h] > stop:
            continue
        preamble = _take(octets, at, int(heads.preamble_bits[h]))
        if preamble & ~1 == heads.preamble[h]:
            return h, preamble
    return -1, 0


@kernel(inlined=True)
def _read_head(
    heads: HeadTable, h: int, octets: UInt8Vector, at: int, stop: int, row: IntVector, core: IntVector
) -> tuple[int, int]:
    """Read what a message states: the bit behind or ``~bit`` of a fault, and the kind of road user."""
    begin, end = heads.first[h], heads.first[h + 1]
    at = read_fields(octets, at, stop, heads.layout[begin:end], row)
    for column in range(core.size):
        core[column] = heads.unavailable[column]
    kind = 0
    if at < 0:
        return at, kind
    for r in range(end - begin):
        place = heads.columns[begin + r]
        if place >= 0:
            core[place] = row[r]
        elif place == TYPE_COLUMN:
            kind = int(heads.kinds[row[r]])
    return at, kind


@kernel
def _unpack_update(
    w: UpdateWire, octets: UInt8Vector, length: int, row: IntVector, core: IntVector, codes: IntVector
) -> tuple[int, int, int]:
    """Read a frame: what it is, the sub-model in use or -1, and the kind of road user."""
    stop = 8 * length
    if length < 4:
        return ELSE, -1, 0
    value, at = _take_length(octets, _ID_BITS, stop)
    if value < 0 or at + 8 * value != stop:
        return ELSE, -1, 0
    h, preamble = _head_of(w.heads, _take(octets, 0, _ID_BITS), octets, at, stop)
    if h < 0:
        return ELSE, -1, 0
    at, kind = _read_head(w.heads, h, octets, at + int(w.heads.preamble_bits[h]), stop, row, core)
    if at < 0:
        return ELSE, -1, 0
    found, in_use = PLAIN, -1
    if preamble & 1 != 0:
        if at + _COUNT_BITS + _REGION_BITS > stop:
            return ELSE, -1, 0
        if _take(octets, at, _COUNT_BITS + _REGION_BITS) != w.region:
            return ELSE, -1, 0
        inner, at = _take_length(octets, at + _COUNT_BITS + _REGION_BITS, stop)
        end = at + 8 * inner
        if 8 * inner < _HEADER_BITS or end > stop or _take(octets, at, _PROFILE_BITS) != w.profile:
            return ELSE, -1, 0
        at += _PROFILE_BITS
        in_use = _take(octets, at, _SUB_MODEL_BITS)
        carries_all = _take(octets, at + _SUB_MODEL_BITS, _ALL_BITS) == 1
        count = _take(octets, at + _SUB_MODEL_BITS + _ALL_BITS, _LENGTH_BITS)
        at += _SUB_MODEL_BITS + _ALL_BITS + _LENGTH_BITS
        if in_use >= w.plain.size:
            return ELSE, -1, 0
        first, last, wanted = _carried(w, in_use, carries_all)
        if count != wanted or at + 8 * count > end or end - at - 8 * count >= 8:
            return ELSE, -1, 0
        for k in range(first, last):
            i = w.wire[k]
            bits = int(w.table[i, BITS])
            codes[i] = _take(octets, at, bits) + int(w.table[i, FIRST])
            at += bits
        if _take(octets, at, end - at) != 0:
            return ELSE, -1, 0
        found, at = MODEL, end
    if stop - at >= 8 or _take(octets, at, stop - at) != 0:
        return ELSE, -1, 0
    return found, in_use, kind


@kernel
def unpack_updates(
    w: UpdateWire,
    frames: UInt8Matrix,
    lengths: IntVector,
    found: IntVector,
    in_use: IntVector,
    kind: IntVector,
    core: IntMatrix,
    codes: IntMatrix,
) -> None:
    """Read frames (B, L): what each is, sub-model in use, kind of road user, (B,) each.

    And what it states as Part I (B, 25), and the coefficients (B, P).
    """
    room = np.empty(w.heads.layout.shape[0], np.int64)
    for row in range(frames.shape[0]):
        found[row], in_use[row], kind[row] = _unpack_update(
            w, frames[row], lengths[row], room, core[row], codes[row]
        )
