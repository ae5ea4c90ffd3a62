"""Many personal safety messages at once: values, codes and octets as arrays.

Only what every message holds is handled here. The faults found are those of `decode_psm`, at the same bits;
what is wrong there, `decode_psm` on the one row tells.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray, owned
from modelcast.messages import psm_kernels
from modelcast.messages.field_columns import FieldColumns, OctetArray, check_frames, field_layout
from modelcast.messages.psm_fields import (
    OPTION_NAMES,
    PERSON_FIELDS,
    PERSON_INDEX,
    PERSONAL_SAFETY_MESSAGE,
)
from modelcast.messages.psm_kernels import PersonWire

__all__ = [
    "PERSON_FRAME_OCTETS",
    "PersonBatch",
    "decode_people",
    "encode_people",
    "person_codes_of_values",
    "person_values_of_codes",
]

PERSON_FRAME_OCTETS: Final = 31
"""Octets of a frame with what every message holds; two fewer without the elevation."""

_COLUMNS: Final = FieldColumns(PERSON_FIELDS)
_ELEVATION: Final = PERSON_INDEX["elevation_m"]
_CLOSED: Final = (0, 0, 1)
"""A bit that must be zero: extensions, and regional extensions of the position."""
_FLAG: Final = (0, 1, 1)


def _wire() -> PersonWire:
    latitude = PERSON_INDEX["latitude_deg"]
    layouts = [field_layout(field) for field in PERSON_FIELDS]
    rows = [_CLOSED, *layouts[:latitude], _CLOSED, _FLAG, _CLOSED, *layouts[latitude:]]
    places = [1 + place + (3 if place >= latitude else 0) for place in range(len(layouts))]
    flag = rows.index(_FLAG)
    preamble_bits = 1 + len(OPTION_NAMES)
    gap = places[_ELEVATION]
    return PersonWire(
        whole=np.array(rows, np.int64),
        short=np.array(rows[:gap] + rows[gap + 1 :], np.int64),
        spread=np.array(places, np.int64),
        elevation=_ELEVATION,
        flag=flag,
        flag_bit=preamble_bits + sum(width for _, _, width in rows[:flag]),
        preamble_bits=preamble_bits,
        unavailable=PERSON_FIELDS[_ELEVATION].code_of(None),
        message_id=PERSONAL_SAFETY_MESSAGE,
    )


_WIRE: Final = _wire()


@dataclass(frozen=True, slots=True)
class PersonBatch:
    """What every personal safety message holds of many, or where they are faulty.

    Parameters
    ----------
    codes
        As on the wire, (B, 12); zeros where faulty.
    has_elevation
        Whether the elevation is there, (B,); where not, its code is the one for unavailable.
    fault_bits
        Bit of the first fault, (B,); -1 where there is none.
    more
        Whether anything follows that was not looked at, (B,): optional parts, extension additions.
    """

    codes: IntArray
    has_elevation: BoolArray
    fault_bits: IntArray
    more: BoolArray


def person_codes_of_values(values: FloatArray) -> IntArray:
    """Nearest codes of values, (B, 12).

    Parameters
    ----------
    values
        In SI units, columns in the order of `PERSON_FIELDS`, (B, 12); not a number where not known, the type
        of person as its code.

    Raises
    ------
    ValueError
        Where the shape is wrong, or a value has no code.
    """
    return _COLUMNS.codes_of(values)


def person_values_of_codes(codes: IntArray) -> FloatArray:
    """Values of codes in SI units, (B, 12); not a number where unavailable or reserved.

    Parameters
    ----------
    codes
        As on the wire, (B, 12).

    Raises
    ------
    ValueError
        Where the shape is wrong.
    """
    return _COLUMNS.values_of(codes)


def encode_people(codes: IntArray, has_elevation: BoolArray | None = None) -> tuple[OctetArray, IntArray]:
    """Octets of frames that hold what every message does, (B, 31), and how many of them count, (B,).

    Parameters
    ----------
    codes
        As on the wire, (B, 12).
    has_elevation
        Whether the elevation is written, (B,); None for all. Where not, its code is the one for unavailable.

    Raises
    ------
    ValueError
        Where the shapes do not fit, or a code is out of its range.

    Examples
    --------
    >>> values = np.full((2, 12), np.nan)
    >>> values[:, [0, 2, 3]] = 1.0, 7.0, 1.0
    >>> frames, lengths = encode_people(person_codes_of_values(values), np.array([True, False]))
    >>> frames[0, :8].tobytes().hex(), lengths.tolist()
    ('00201c000003fffe', [31, 29])
    """
    _COLUMNS.check(codes)
    rows = len(codes)
    there = np.ones(rows, np.bool_) if has_elevation is None else owned(has_elevation, np.bool_)
    if there.shape != (rows,):
        raise ValueError(f"has_elevation must be ({rows},), got {there.shape}")
    frames = np.zeros((rows, PERSON_FRAME_OCTETS), np.uint8)
    lengths = np.empty(rows, np.int64)
    whole = owned(codes, np.int64)
    row = psm_kernels.pack(_WIRE, whole, there, _row(), frames, lengths)
    if row >= 0:
        refusal = _COLUMNS.refusal(whole, row)
        left_out = f"code must be {_WIRE.unavailable} where it is left out, got {whole[row, _ELEVATION]}"
        raise refusal or ValueError(f"row {row}: elevation_m: {left_out}")
    return frames, lengths


def decode_people(frames: OctetArray, lengths: IntArray) -> PersonBatch:
    """What every message holds, of personal safety messages in their frames.

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
    found = PersonBatch(
        np.zeros((rows, len(PERSON_FIELDS)), np.int64),
        np.empty(rows, np.bool_),
        np.empty(rows, np.int64),
        np.empty(rows, np.bool_),
    )
    psm_kernels.unpack(
        _WIRE,
        owned(frames, np.uint8),
        owned(lengths, np.int64),
        _row(),
        found.codes,
        found.has_elevation,
        found.fault_bits,
        found.more,
    )
    return found


def _row() -> IntArray:
    """Room for a row of the wire."""
    return np.zeros(len(_WIRE.whole), np.int64)
