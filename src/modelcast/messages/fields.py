"""Fields of a message: which whole number on the wire stands for which value.

A field is a row of a table. Encoders, decoders, batches, documents and printed tables are all made from such
rows, so that a range or a step is written once.
"""

import math
from dataclasses import KW_ONLY, dataclass
from enum import IntEnum
from operator import index

__all__ = ["Field", "Outside", "as_float"]


_UNIT_SUFFIXES = ("_mps2", "_radps", "_mps", "_rad", "_deg", "_m", "_s")


class Outside(IntEnum):
    """What becomes of a value that has no code of its own."""

    CLAMP = 0
    """The nearest code that stands for a value."""
    UNAVAILABLE = 1
    """The code for unavailable."""
    TURN = 2
    """An angle: the same direction within one turn."""
    MERIDIAN = 3
    """A longitude: unavailable, but -180 degrees is the meridian of +180 degrees."""
    REFUSE = 4
    """A mistake of the caller: a count, a name, a set of flags."""


def as_float(number: float) -> float:
    """Nearest float; infinity for whole numbers beyond all floats, which Python's integers reach.

    Parameters
    ----------
    number
        Any number.

    Examples
    --------
    >>> as_float(3), as_float(-(10**400))
    (3.0, -inf)
    """
    try:
        return float(number)
    except OverflowError:
        return math.inf if number > 0 else -math.inf


@dataclass(frozen=True, slots=True)
class Field:
    """One whole number on the wire and what it stands for.

    Parameters
    ----------
    name
        Our name, with the SI unit.
    standard_name
        Name in the standard.
    low, high
        Range of the type: what the encoding allows.
    known
        Lowest and highest code that stand for a value; None for the whole range.
    unavailable
        Code for "not known", where there is one.
    step
        Numerator and denominator: what one code is worth, in units of the standard.
    unit
        Unit of the standard, for people.
    si_per_unit
        SI units in one unit of the standard.
    outside
        What becomes of values without a code.
    choices
        Names of the codes of an enumeration, by code.
    flags
        Names of the bits of a bit string, the first on the wire first.
    meaning
        What it is, in a few words.

    Raises
    ------
    ValueError
        Where the codes are not within the range.

    Examples
    --------
    >>> speed = Field("speed_mps", "speed", low=0, high=8191, known=(0, 8190), unavailable=8191, step=(1, 50))
    >>> speed.code_of(12.34), speed.code_of(None), speed.code_of(500.0), speed.value_of(617)
    (617, 8191, 8190, 12.34)
    """

    name: str
    standard_name: str
    _: KW_ONLY
    low: int
    high: int
    known: tuple[int, int] | None = None
    unavailable: int | None = None
    step: tuple[int, int] = (1, 1)
    unit: str = ""
    si_per_unit: float = 1.0
    outside: Outside = Outside.CLAMP
    choices: tuple[str, ...] = ()
    flags: tuple[str, ...] = ()
    meaning: str = ""

    def __post_init__(self) -> None:
        first, last = self.known_codes
        if not self.low <= first <= last <= self.high:
            raise ValueError(f"{self.name}: codes {first}..{last} must lie within {self.low}..{self.high}")
        if self.unavailable is not None and not self.low <= self.unavailable <= self.high:
            raise ValueError(f"{self.name}: {self.unavailable} must lie within {self.low}..{self.high}")

    @property
    def width_bits(self) -> int:
        """Bits on the wire: the least that hold the range (ITU-T X.691, clause 11.5.7)."""
        return (self.high - self.low).bit_length()

    @property
    def quantity(self) -> str:
        """Our name without its unit."""
        for suffix in _UNIT_SUFFIXES:
            if self.name.endswith(suffix):
                return self.name.removesuffix(suffix)
        return self.name

    @property
    def known_codes(self) -> tuple[int, int]:
        """Lowest and highest code that stand for a value."""
        return (self.low, self.high) if self.known is None else self.known

    @property
    def resolution(self) -> float:
        """What one code is worth, in SI units."""
        return self.step[0] / self.step[1] * self.si_per_unit

    def code_of(self, value: float | None) -> int:
        """Code nearest to a value.

        Parameters
        ----------
        value
            In SI units; None or not a number where it is not known.

        Raises
        ------
        ValueError
            Where nothing can stand for it: an unknown value in a field without a code for that, or a value
            that a field refuses.
        """
        first, last = self.known_codes
        exact = (
            math.nan if value is None else as_float(value) / self.si_per_unit * self.step[1] / self.step[0]
        )
        if math.isnan(exact):
            return self._unavailable_code()
        endless = math.isinf(exact)
        steps = (first - 2 if exact < 0 else last + 1) if endless else round(exact)
        if self.outside is Outside.REFUSE and not (first <= steps <= last and steps == value):
            raise ValueError(f"{self.name} must be a whole number within {first}..{last}, got {value}")
        if self.outside is Outside.TURN and not endless:
            return first + (steps - first) % (last - first + 1)
        if first <= steps <= last:
            return steps
        if self.outside is Outside.CLAMP:
            return min(max(steps, first), last)
        if self.outside is Outside.MERIDIAN and steps == first - 1:
            return last
        return self._unavailable_code()

    def _unavailable_code(self) -> int:
        if self.unavailable is None:
            raise ValueError(
                f"{self.name} is not known, and {self.standard_name} has no code for that: give it"
            )
        return self.unavailable

    def checked(self, code: int) -> int:
        """A code as Python's own integer, whatever integer it was.

        Parameters
        ----------
        code
            As on the wire; any integer, NumPy's too.

        Raises
        ------
        ValueError
            Where it is no integer, or out of the type's range.
        """
        try:
            whole = index(code)
        except TypeError:
            whole = None
        if whole is None or not self.low <= whole <= self.high:
            raise ValueError(f"{self.name} must be a whole number within {self.low}..{self.high}, got {code}")
        return whole

    def value_of(self, code: int) -> float | None:
        """Value a code stands for, in SI units; None for unavailable and for reserved codes.

        Parameters
        ----------
        code
            As on the wire, the lower end of the range already added.
        """
        first, last = self.known_codes
        if code == self.unavailable or not first <= code <= last:
            return None
        return code * self.step[0] / self.step[1] * self.si_per_unit

    def is_reserved(self, code: int) -> bool:
        """Whether a code stands for nothing: neither for a value nor for unavailable."""
        first, last = self.known_codes
        return code != self.unavailable and not first <= code <= last
