"""Many basic safety messages at once: values, codes and octets as arrays.

Only Part I is handled here: that is all a simulation needs of a plain message. The faults found are those of
`decode_bsm`, at the same bits; what is wrong there, `decode_bsm` on the one row tells.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray, owned
from modelcast.messages import bsm_kernels
from modelcast.messages.bsm_fields import BASIC_SAFETY_MESSAGE, CORE_FIELDS, CORE_OCTETS
from modelcast.messages.field_columns import FieldColumns, OctetArray, check_frames

__all__ = [
    "CORE_FRAME_OCTETS",
    "CORE_LAYOUT",
    "CORE_MEANING",
    "CoreBatch",
    "codes_of_values",
    "decode_cores",
    "encode_cores",
    "values_of_codes",
]

_COLUMNS: Final = FieldColumns(CORE_FIELDS)
_HEADER: Final = np.array([BASIC_SAFETY_MESSAGE >> 8, BASIC_SAFETY_MESSAGE & 0xFF, CORE_OCTETS], np.uint8)
CORE_FRAME_OCTETS: Final = _HEADER.size + CORE_OCTETS
"""Octets of a frame that holds Part I alone: 40."""

CORE_LAYOUT: Final = _COLUMNS.layout
"""How Part I lies on the wire, as `field_kernels` takes it, (25, 3)."""

CORE_MEANING: Final = _COLUMNS.meaning
"""What the codes of Part I stand for, as `field_kernels` takes it, (25, 7)."""


@dataclass(frozen=True, slots=True)
class CoreBatch:
    """Part I of many messages, or where they are faulty.

    Parameters
    ----------
    codes
        As on the wire, (B, 25); zeros where faulty.
    fault_bits
        Bit of the first fault, (B,); -1 where there is none.
    more
        Whether anything follows Part I that was not looked at, (B,): Part II, regional extensions, extension
        additions.
    """

    codes: IntArray
    fault_bits: IntArray
    more: BoolArray


def codes_of_values(values: FloatArray) -> IntArray:
    """Nearest codes of values, (B, 25).

    Parameters
    ----------
    values
        In SI units, columns in the order of `CORE_FIELDS`, (B, 25); not a number where not known,
        enumerations and bit strings as their codes.

    Raises
    ------
    ValueError
        Where the shape is wrong, or a value has no code.
    """
    return _COLUMNS.codes_of(values)


def values_of_codes(codes: IntArray) -> FloatArray:
    """Values of codes in SI units, (B, 25); not a number where unavailable or reserved.

    Parameters
    ----------
    codes
        As on the wire, (B, 25).

    Raises
    ------
    ValueError
        Where the shape is wrong.
    """
    return _COLUMNS.values_of(codes)


def encode_cores(codes: IntArray) -> tuple[OctetArray, IntArray]:
    """Octets of frames that hold Part I alone, (B, 40), and how many of them count, (B,).

    Parameters
    ----------
    codes
        As on the wire, (B, 25).

    Raises
    ------
    ValueError
        Where the shape is wrong, or a code is out of its range.

    Examples
    --------
    >>> values = np.full((1, 25), np.nan)
    >>> values[0, [0, 1, 16]] = 7.0, 1.0, 0.0
    >>> frames, lengths = encode_cores(codes_of_values(values))
    >>> frames[0, :8].tobytes().hex(), lengths.tolist()
    ('00142501c0000000', [40])
    """
    _COLUMNS.check(codes)
    frames = np.empty((codes.shape[0], CORE_FRAME_OCTETS), np.uint8)
    whole = np.ascontiguousarray(codes, np.int64)
    row = bsm_kernels.pack(whole, CORE_LAYOUT, _HEADER, frames)
    refusal = None if row < 0 else _COLUMNS.refusal(whole, row)
    if refusal is not None:
        raise refusal
    return frames, np.full(len(frames), CORE_FRAME_OCTETS, np.int64)


def decode_cores(frames: OctetArray, lengths: IntArray) -> CoreBatch:
    """Part I of basic safety messages in their frames.

    Parameters
    ----------
    frames
        Octets, one frame a row, (B, L).
    lengths
        How many octets of each row count, (B,).

    Raises
    ------
    ValueError
        Where the shapes do not fit, or a length is beyond its row.
    """
    check_frames(frames, lengths)
    rows = len(frames)
    found = CoreBatch(
        np.zeros((rows, len(CORE_FIELDS)), np.int64), np.empty(rows, np.int64), np.empty(rows, np.bool_)
    )
    bsm_kernels.unpack(
        owned(frames, np.uint8),
        owned(lengths, np.int64),
        CORE_LAYOUT,
        BASIC_SAFETY_MESSAGE,
        found.codes,
        found.fault_bits,
        found.more,
    )
    return found
