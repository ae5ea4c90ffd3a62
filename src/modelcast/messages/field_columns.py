"""Columns of codes and values, one a field: many messages of one kind at once."""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.messages import field_kernels
from modelcast.messages.fields import Field

__all__ = ["FieldColumns", "OctetArray", "check_frames", "field_layout", "field_meaning"]

OctetArray = npt.NDArray[np.uint8]


def field_layout(field: Field) -> tuple[int, int, int]:
    """How a field lies on the wire, as `field_kernels` takes it: lowest code, span of codes, bits.

    Parameters
    ----------
    field
        Of a message.
    """
    return field.low, field.high - field.low, field.width_bits


def field_meaning(field: Field) -> tuple[float, ...]:
    """What the codes of a field stand for, as `field_kernels` takes it.

    Parameters
    ----------
    field
        Of a message.
    """
    unavailable = np.nan if field.unavailable is None else float(field.unavailable)
    return (*field.known_codes, unavailable, *field.step, field.si_per_unit, float(field.outside))


@dataclass(frozen=True, slots=True, eq=False)
class FieldColumns:
    """Columns in the order of some fields.

    Parameters
    ----------
    fields
        The fields, F of them.

    Examples
    --------
    >>> from modelcast.messages.bsm_fields import CORE_FIELDS
    >>> columns = FieldColumns(CORE_FIELDS[10:12])
    >>> columns.codes_of(np.array([[12.345, np.nan]])).tolist()
    [[617, 28800]]
    """

    fields: tuple[Field, ...]
    layout: IntArray = field(init=False)
    """How they lie on the wire, (F, 3)."""
    meaning: FloatArray = field(init=False)
    """What their codes stand for, (F, 7)."""

    def __post_init__(self) -> None:
        layout = np.array([field_layout(one) for one in self.fields], np.int64)
        meaning = np.array([field_meaning(one) for one in self.fields], np.float64)
        object.__setattr__(self, "layout", layout)
        object.__setattr__(self, "meaning", meaning)

    def codes_of(self, values: FloatArray) -> IntArray:
        """Nearest codes of values, (B, F).

        Parameters
        ----------
        values
            In SI units, (B, F); not a number where not known, enumerations and bit strings as their codes.

        Raises
        ------
        ValueError
            Where the shape is wrong, or a value has no code.
        """
        self.check(values)
        codes = np.empty(values.shape, np.int64)
        row, at = field_kernels.codes_of(np.ascontiguousarray(values, np.float64), self.meaning, codes)
        if row >= 0:
            try:
                self.fields[at].code_of(float(values[row, at]))
            except ValueError as error:
                raise ValueError(f"row {row}: {error}") from None
        return codes

    def values_of(self, codes: IntArray) -> FloatArray:
        """Values of codes in SI units, (B, F); not a number where unavailable or reserved.

        Parameters
        ----------
        codes
            As on the wire, (B, F).

        Raises
        ------
        ValueError
            Where the shape is wrong.
        """
        self.check(codes)
        values = np.empty(codes.shape, np.float64)
        field_kernels.values_of(np.ascontiguousarray(codes, np.int64), self.meaning, values)
        return values

    def check(self, table: FloatArray | IntArray) -> None:
        """Refuse what has not one column a field.

        Parameters
        ----------
        table
            Codes or values.

        Raises
        ------
        ValueError
            Where the shape is wrong.
        """
        if table.ndim != 2 or table.shape[1] != len(self.fields):
            raise ValueError(f"one column a field is needed, (B, {len(self.fields)}), got {table.shape}")

    def refusal(self, codes: IntArray, row: int) -> ValueError | None:
        """Error that tells the first code of a row that is out of its range; None where none is.

        Parameters
        ----------
        codes
            As on the wire, (B, F).
        row
            The row.
        """
        for one, code in zip(self.fields, codes[row].tolist(), strict=True):
            if not one.low <= code <= one.high:
                return ValueError(f"row {row}: {one.name}: code {code} must lie within {one.low}..{one.high}")
        return None


def check_frames(frames: OctetArray, lengths: IntArray) -> None:
    """Refuse octets of frames that do not fit their lengths.

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
    if frames.ndim != 2 or lengths.shape != frames.shape[:1]:
        raise ValueError(f"frames (B, L) and lengths (B,) do not fit: {frames.shape}, {lengths.shape}")
    if lengths.size and not 0 <= lengths.min() <= lengths.max() <= frames.shape[1]:
        raise ValueError(
            f"lengths must lie within 0..{frames.shape[1]}, got {lengths.min()}..{lengths.max()}"
        )
