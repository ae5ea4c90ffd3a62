"""Compiled packing of fields for many messages at once, driven by their table, and the frame around them.

The columns of `layout` (F, 3) are lowest code, span of codes and bits of every field. Those of `meaning`
(F, 7) say what the codes stand for; `Field.code_of` and `Field.value_of` say the same for one value.
"""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import (
    FloatMatrix,
    IntMatrix,
    IntVector,
    UInt8Vector,
)
from modelcast.messages.frame import MAX_FRAME_OCTETS

__all__ = [
    "FIRST",
    "INTACT",
    "LAST",
    "LOW",
    "OUTSIDE",
    "SCALE",
    "SPAN",
    "STEP_DENOMINATOR",
    "STEP_NUMERATOR",
    "UNAVAILABLE",
    "WIDTH",
    "close_frame",
    "code_of",
    "codes_of",
    "open_frame",
    "quantise",
    "read_fields",
    "value_of",
    "values_of",
    "write_fields",
]

LOW, SPAN, WIDTH = 0, 1, 2
FIRST, LAST, UNAVAILABLE, STEP_NUMERATOR, STEP_DENOMINATOR, SCALE, OUTSIDE = 0, 1, 2, 3, 4, 5, 6

_CLAMP, _TURN, _MERIDIAN, _REFUSE = 0.0, 2.0, 3.0, 4.0
"""Values of `fields.Outside`."""

INTACT = -1
"""In place of the bit of a fault, where there is none."""

_OVERLONG = 0xC0
_LONG = 0x80


@kernel(inlined=True)
def write_fields(
    codes: IntVector, layout: IntMatrix, preamble: int, preamble_bits: int, out: UInt8Vector, at: int
) -> int:
    """Write preamble and fields from octet ``at`` on; the bit behind, -1 where a code is out of its range."""
    held = np.uint64(preamble)
    bits = preamble_bits
    for f in range(layout.shape[0]):
        raw = codes[f] - layout[f, LOW]
        if raw < 0 or raw > layout[f, SPAN]:
            return -1
        held = (held << np.uint64(layout[f, WIDTH])) | np.uint64(raw)
        bits += layout[f, WIDTH]
        while bits >= 8:
            bits -= 8
            out[at] = (held >> np.uint64(bits)) & np.uint64(0xFF)
            at += 1
    if bits > 0:
        out[at] = (held << np.uint64(8 - bits)) & np.uint64(0xFF)
    return 8 * at + bits


@kernel(inlined=True)
def read_fields(octets: UInt8Vector, at: int, end: int, layout: IntMatrix, codes: IntVector) -> int:
    """Read fields from bit ``at``, before bit ``end``: the bit behind, or ``~bit`` of the first fault."""
    for f in range(layout.shape[0]):
        width = layout[f, WIDTH]
        if at + width > end:
            return ~at
        raw = np.int64(0)
        byte = at >> 3
        last = (at + width - 1) >> 3
        raw = np.int64(octets[byte]) & (0xFF >> (at & 7))
        while byte < last:
            byte += 1
            raw = raw << 8 | octets[byte]
        raw >>= 7 - ((at + width - 1) & 7)
        if raw > layout[f, SPAN]:
            return ~at
        codes[f] = raw + layout[f, LOW]
        at += width
    return at


@kernel(inlined=True)
def open_frame(octets: UInt8Vector, length: int, message_id: int) -> tuple[int, int, int]:
    """Read what stands before a message: the bit of the first fault or -1, and the message's octets."""
    if length > MAX_FRAME_OCTETS:
        return 8 * MAX_FRAME_OCTETS, 0, 0
    if length < 2:
        return (0 if length < 1 else 1), 0, 0
    if ((octets[0] & 0x7F) << 8 | octets[1]) != message_id:
        return 1, 0, 0
    if length < 3:
        return 16, 0, 0
    start = 3
    size = np.int64(octets[2])
    if size >= _OVERLONG:
        return 16, 0, 0
    if size >= _LONG:
        if length < 4:
            return 24, 0, 0
        start = 4
        size = (size & 0x3F) << 8 | octets[3]
        if size < _LONG:
            return 16, 0, 0
    if size == 0:
        return 16, 0, 0
    if start + size > length:
        return 8 * start, 0, 0
    return INTACT, start, int(start + size)


@kernel(inlined=True)
def close_frame(octets: UInt8Vector, length: int, at: int, stop: int) -> tuple[int, bool]:
    """Check what stands behind fields that end at bit ``at``, in a message that ends at octet ``stop``.

    The bit of the first fault or -1, and whether additions to the frame follow, which are not looked at.
    """
    spare = -at & 7
    if octets[at >> 3] & ((1 << spare) - 1) != 0:
        return at, False
    if at + spare < 8 * stop:
        return at + spare, False
    more = octets[0] >= _LONG
    if not more and stop < length:
        return 8 * stop, False
    return INTACT, more


@kernel
def code_of(value: float, meaning: FloatMatrix, f: int) -> tuple[float, bool]:
    """Code of field ``f`` nearest to a value, and whether there is one."""
    first, last, unavailable = meaning[f, FIRST], meaning[f, LAST], meaning[f, UNAVAILABLE]
    known = not np.isnan(unavailable)
    if np.isnan(value):
        return unavailable, known
    outside = meaning[f, OUTSIDE]
    steps = np.rint(value / meaning[f, SCALE] * meaning[f, STEP_DENOMINATOR] / meaning[f, STEP_NUMERATOR])
    if outside == _REFUSE:
        return steps, first <= steps <= last and steps == value
    if first <= steps <= last:
        return steps, True
    if outside == _TURN and not np.isinf(steps):
        turn = last - first + 1.0
        return first + np.fmod(np.fmod(steps - first, turn) + turn, turn), True
    if outside == _CLAMP:
        return min(max(steps, first), last), True
    if outside == _MERIDIAN and steps == first - 1.0:
        return last, True
    return unavailable, known


@kernel
def codes_of(values: FloatMatrix, meaning: FloatMatrix, codes: IntMatrix) -> tuple[int, int]:
    """Write codes of values, (B, F) both; return row and field of the first refused value, or -1, -1."""
    for row in range(values.shape[0]):
        for f in range(values.shape[1]):
            code, held = code_of(values[row, f], meaning, f)
            if not held:
                return row, f
            codes[row, f] = np.int64(code)
    return -1, -1


@kernel
def value_of(code: float, meaning: FloatMatrix, f: int) -> float:
    """Value of a code of field ``f``; not a number where unavailable or reserved."""
    if code == meaning[f, UNAVAILABLE] or code < meaning[f, FIRST] or code > meaning[f, LAST]:
        return np.nan
    return code * meaning[f, STEP_NUMERATOR] / meaning[f, STEP_DENOMINATOR] * meaning[f, SCALE]


@kernel
def values_of(codes: IntMatrix, meaning: FloatMatrix, values: FloatMatrix) -> None:
    """Write values of codes, (B, F) both; not a number where unavailable or reserved."""
    for row in range(codes.shape[0]):
        for f in range(codes.shape[1]):
            values[row, f] = value_of(float(codes[row, f]), meaning, f)


@kernel
def quantise(
    values: FloatMatrix, meaning: FloatMatrix, owner: IntVector, in_use: IntVector
) -> tuple[int, int]:
    """Put what the codes of values stand for in their places, (B, F); row and field of the first refused.

    A field that belongs to a sub-model, ``owner`` (F,), is not a number in the rows in which another is
    ``in_use`` (B,); an owner of -1 is none.
    """
    for row in range(values.shape[0]):
        for f in range(values.shape[1]):
            if owner[f] >= 0 and owner[f] != in_use[row]:
                values[row, f] = np.nan
                continue
            code, held = code_of(values[row, f], meaning, f)
            if not held:
                return row, f
            # A whole number in between, as on the wire: no zero with a sign.
            values[row, f] = value_of(float(np.int64(code)), meaning, f)
    return -1, -1
