"""Compiled packing of Part I for many basic safety messages at once, driven by the table of fields.

The columns of `layout` (F, 3) are lowest code, span of codes and bits of every field. Those of `meaning`
(F, 7) say what the codes stand for; `Field.code_of` and `Field.value_of` say the same for one value.
"""

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
from modelcast.messages.bsm_fields import PREAMBLE_BITS

__all__ = [
    "FIRST",
    "LAST",
    "LOW",
    "OUTSIDE",
    "SCALE",
    "SPAN",
    "STEP_DENOMINATOR",
    "STEP_NUMERATOR",
    "UNAVAILABLE",
    "WIDTH",
    "code_of",
    "codes_of",
    "pack",
    "quantise",
    "read_core",
    "unpack",
    "value_of",
    "values_of",
    "write_core",
]

LOW, SPAN, WIDTH = 0, 1, 2
FIRST, LAST, UNAVAILABLE, STEP_NUMERATOR, STEP_DENOMINATOR, SCALE, OUTSIDE = 0, 1, 2, 3, 4, 5, 6

_CLAMP, _TURN, _MERIDIAN, _REFUSE = 0.0, 2.0, 3.0, 4.0
"""Values of `fields.Outside`."""

_INTACT = -1
_OVERLONG = 0xC0
_LONG = 0x80


@kernel(inlined=True)
def write_core(codes: IntVector, layout: IntMatrix, preamble: int, out: UInt8Vector, at: int) -> int:
    """Write preamble and Part I from octet ``at`` on; the bit behind, -1 where a code is out of its range."""
    held = np.uint64(preamble)
    bits = PREAMBLE_BITS
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
def read_core(octets: UInt8Vector, at: int, end: int, layout: IntMatrix, codes: IntVector) -> int:
    """Read Part I from bit ``at``, before bit ``end``: the bit behind it, or ``~bit`` of its first fault."""
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


@kernel
def pack(codes: IntMatrix, layout: IntMatrix, header: UInt8Vector, out: UInt8Matrix) -> int:
    """Write frames, ``out`` (B, L); return the first row with a code out of its range, or -1."""
    for row in range(codes.shape[0]):
        for i in range(header.size):
            out[row, i] = header[i]
        if write_core(codes[row], layout, 0, out[row], header.size) < 0:
            return row
    return -1


@kernel
def _unpack_row(
    octets: UInt8Vector, length: int, layout: IntMatrix, message_id: int, codes: IntVector
) -> tuple[int, bool]:
    """Read one frame's Part I: the bit of its first fault or -1, and whether more follows Part I."""
    if length < 2:
        return (0 if length < 1 else 1), False
    more = octets[0] >= _LONG
    if ((octets[0] & 0x7F) << 8 | octets[1]) != message_id:
        return 1, False
    if length < 3:
        return 16, False
    start = 3
    size = np.int64(octets[2])
    if size >= _OVERLONG:
        return 16, False
    if size >= _LONG:
        if length < 4:
            return 24, False
        start = 4
        size = (size & 0x3F) << 8 | octets[3]
        if size < _LONG:
            return 16, False
    if size == 0:
        return 16, False
    if start + size > length:
        return 8 * start, False
    at = 8 * start
    end = at + 8 * size
    preamble = octets[start] >> 5
    at = read_core(octets, at + PREAMBLE_BITS, int(end), layout, codes)
    if at < 0:
        return ~at, False
    if preamble != 0:
        return _INTACT, True
    spare = -at & 7
    if octets[at >> 3] & ((1 << spare) - 1) != 0:
        return at, False
    if at + spare < end:
        return int(at + spare), False
    if not more and end < 8 * length:
        return int(end), False
    return _INTACT, more


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
        if fault_bits[row] != _INTACT:
            codes[row] = 0


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
