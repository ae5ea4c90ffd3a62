"""How a message carries what a sub-model adds to Part I: a table of whole numbers, each with a step.

Speed, heading, acceleration along the course and yaw rate stand in Part I of every basic safety message. What
a sub-model needs beyond them it names here, parameter by parameter. The codec (`modelcast.messages`) writes
the codes, and stations predict with what they stand for.
"""

from dataclasses import KW_ONLY, dataclass
from typing import Annotated

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.rules import FieldError, Fixed, Number, Whole, check_fields

__all__ = ["CORE_PARAMETERS", "MAX_FIELD_BITS", "STEP_AND_BITS", "PayloadField", "PayloadLayout"]

CORE_PARAMETERS = ("velocity_east_mps", "velocity_north_mps", "acceleration_mps2", "yaw_rate_radps")
"""Names of the parameters that Part I carries; acceleration along the course, yaw rate clockwise."""

MAX_FIELD_BITS = 32
"""Widest field."""

STEP = Number(1e-6, 1000.0)
"""What one code may be worth, in the parameter's unit."""

BITS = Whole(1, MAX_FIELD_BITS)
"""Width of a field."""

STEP_AND_BITS = Fixed((STEP, BITS))
"""A field as a sub-model names it: its step and its width."""


@dataclass(frozen=True, slots=True)
class PayloadField:
    """One parameter as a whole number.

    Parameters
    ----------
    name
        Name of the parameter, with its unit.
    step
        What one code is worth, in that unit.
    bits
        Width, 1 to `MAX_FIELD_BITS`.
    signed
        Whether codes run from ``-2^(bits-1)`` to ``2^(bits-1) - 1``, or from 0 to ``2^bits - 1``.

    Raises
    ------
    ValueError
        Where step or width is out of its range.
    """

    name: str
    step: Annotated[float, STEP]
    _: KW_ONLY
    bits: Annotated[int, BITS]
    signed: bool = True

    def __post_init__(self) -> None:
        try:
            check_fields(self)
        except FieldError as error:
            raise error.below(self.name) from None

    @property
    def low(self) -> int:
        """Lowest code."""
        return -(1 << self.bits - 1) if self.signed else 0

    @property
    def high(self) -> int:
        """Highest code."""
        return (1 << self.bits - 1) - 1 if self.signed else (1 << self.bits) - 1


@dataclass(frozen=True, slots=True)
class PayloadLayout:
    """The fields of one sub-model, in the order of the wire; none where Part I says all.

    Parameters
    ----------
    fields
        Fields with distinct names.

    Raises
    ------
    ValueError
        Where two fields share a name, or one has the name of a parameter of Part I.

    Examples
    --------
    >>> layout = PayloadLayout((PayloadField("a_m", 0.05, bits=6), PayloadField("b_m", 0.1, bits=5)))
    >>> layout.bits, layout.quantise(np.array([[0.27, -9.0]])).round(9).tolist()
    (11, [[0.25, -1.6]])
    """

    fields: tuple[PayloadField, ...] = ()

    def __post_init__(self) -> None:
        names = [field.name for field in self.fields]
        if len(set(names)) != len(names):
            raise ValueError(f"fields must have distinct names, got {', '.join(names)}")
        for name in CORE_PARAMETERS:
            if name in names:
                raise ValueError(f"{name} is in Part I: leave it out")

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(field.name for field in self.fields)

    @property
    def bits(self) -> int:
        """Bits of all fields."""
        return sum(field.bits for field in self.fields)

    def codes_of(self, values: FloatArray) -> IntArray:
        """Nearest codes, (B, F); a value beyond the range takes the last code.

        Parameters
        ----------
        values
            (B, F).

        Raises
        ------
        ValueError
            Where the shape is wrong, or a value is not a number: nothing stands for "not known".
        """
        self._check(values)
        if np.isnan(values).any():
            raise ValueError("every coefficient must be a number: there is no code for unknown ones")
        steps, low, high = self.table.T
        return np.rint(np.clip(values, low * steps, high * steps) / steps).astype(np.int64)

    def values_of(self, codes: IntArray) -> FloatArray:
        """Return what codes stand for, (B, F).

        Parameters
        ----------
        codes
            (B, F).
        """
        self._check(codes)
        return codes * self.table[:, 0]

    def quantise(self, values: FloatArray) -> FloatArray:
        """Values as a receiver holds them, (B, F).

        Parameters
        ----------
        values
            (B, F).
        """
        return self.values_of(self.codes_of(values))

    @property
    def table(self) -> FloatArray:
        """Step, lowest and highest code of every field, (F, 3)."""
        rows = [(field.step, float(field.low), float(field.high)) for field in self.fields]
        return np.array(rows, dtype=np.float64).reshape(len(rows), 3)

    def _check(self, table: FloatArray | IntArray) -> None:
        if table.ndim != 2 or table.shape[1] != len(self.fields):
            raise ValueError(f"one column a field is needed, (B, {len(self.fields)}), got {table.shape}")
