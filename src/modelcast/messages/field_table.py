"""Fields of a message in the order of the wire, and what all messages do with their codes."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from operator import le
from typing import Final

from modelcast.core.exceptions import CodecError
from modelcast.messages.bits import BitReader
from modelcast.messages.fields import Field

__all__ = ["FieldTable", "read_code"]

_PLAIN: Final = {int}


@dataclass(frozen=True, slots=True)
class FieldTable:
    """Fields in the order of the wire.

    Parameters
    ----------
    fields
        The fields, their names differing.

    Examples
    --------
    >>> from modelcast.messages.bsm_fields import CORE_FIELDS
    >>> table = FieldTable(CORE_FIELDS[:2])
    >>> table.codes_of({"message_count": 7, "temporary_id": 1}), table.value_of((7, 1), "temporary_id")
    ((7, 1), 1.0)
    """

    fields: tuple[Field, ...]
    index: Mapping[str, int] = field(init=False)
    """Place of a field, by our name."""
    _lows: tuple[int, ...] = field(init=False)
    _highs: tuple[int, ...] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "index", {one.name: place for place, one in enumerate(self.fields)})
        object.__setattr__(self, "_lows", tuple(one.low for one in self.fields))
        object.__setattr__(self, "_highs", tuple(one.high for one in self.fields))

    def checked(self, name: str, codes: tuple[int, ...]) -> tuple[int, ...]:
        """Codes as Python's own integers; themselves where they are that.

        Parameters
        ----------
        name
            What the caller calls them.
        codes
            One a field; any integers, NumPy's too.

        Raises
        ------
        ValueError
            Where there are not as many as fields, or one is no integer or out of its range.
        """
        if len(codes) != len(self.fields):
            raise ValueError(f"{name} must be {len(self.fields)}, got {len(codes)}")
        if set(map(type, codes)) != _PLAIN:  # NumPy's integers have no room for a message
            codes = tuple(one.checked(code) for one, code in zip(self.fields, codes, strict=True))
        elif not self.holds(codes):
            at, code = next(
                (one, code)
                for one, code in zip(self.fields, codes, strict=True)
                if not one.low <= code <= one.high
            )
            raise ValueError(f"{at.name}: code {code} must lie within {at.low}..{at.high}")
        return codes

    def holds(self, codes: tuple[int, ...]) -> bool:
        """Whether each code lies within its range.

        Parameters
        ----------
        codes
            One a field.
        """
        return all(map(le, self._lows, codes)) and all(map(le, codes, self._highs))

    def read(self, reader: BitReader) -> tuple[int, ...]:
        """Next codes, field by field: slower than taking them all at once, and it tells the first fault.

        Parameters
        ----------
        reader
            Where the first field begins.

        Raises
        ------
        CodecError
            Where a field is cut short, or its code is out of its range.
        """
        return tuple([read_code(reader, one) for one in self.fields])

    def codes_of(self, values: Mapping[str, float | None]) -> tuple[int, ...]:
        """Nearest codes of values in SI units.

        Parameters
        ----------
        values
            By our names; enumerations and bit strings as their codes. A field that is left out, None, or not
            a number becomes unavailable.

        Raises
        ------
        ValueError
            Where a name is unknown, a value is refused, or a field without a code for unavailable is left
            out.
        """
        unknown = values.keys() - self.index.keys()
        if unknown:
            raise ValueError(f"no field is called {sorted(unknown)}; the fields are {list(self.index)}")
        return tuple(one.code_of(values.get(one.name)) for one in self.fields)

    def value_of(self, codes: tuple[int, ...], name: str) -> float | None:
        """Value of one field in SI units, None where unavailable or reserved.

        Parameters
        ----------
        codes
            One a field.
        name
            Our name of the field.

        Raises
        ------
        KeyError
            Where there is no such field.
        """
        place = self.index[name]
        return self.fields[place].value_of(codes[place])

    def values_of(self, codes: tuple[int, ...]) -> dict[str, float | None]:
        """Values of all fields in SI units, by name.

        Parameters
        ----------
        codes
            One a field.
        """
        return {one.name: one.value_of(code) for one, code in zip(self.fields, codes, strict=True)}


def read_code(reader: BitReader, one: Field) -> int:
    """Next code of a field.

    Parameters
    ----------
    reader
        Where the field begins.
    one
        The field.

    Raises
    ------
    CodecError
        Where it is cut short, or its code is out of its range.
    """
    begin = reader.position
    code = reader.bits(one.width_bits) + one.low
    if code > one.high:
        raise CodecError(f"{one.standard_name} {code} is beyond {one.high}", begin)
    return code
