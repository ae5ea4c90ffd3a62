"""Parts of a message that hold others: records, lists and choices, described as data.

A shape says how a part lies on the wire in unaligned packed encoding rules. Everything else is made from it:
reading, writing, documents, tables and the value that another codec takes. The standard leaves many types
open to later editions; what only a later edition has is refused by name.

===========  ========================================  ===================================================
shape        value                                     on the wire
===========  ========================================  ===================================================
`Number`     a code                                    the extension bit, where there is one, and the code
`Truth`      0 or 1                                    one bit
`Record`     a tuple, None for a member left out       the extension bit, a bit for each member that may be
                                                       left out, the members
`Series`     a tuple                                   how many, each
`Choice`     place of the alternative, and its value   the extension bit, the place, the value
===========  ========================================  ===================================================

References
----------
ITU-T X.691: enumerations, clause 14; sequences, 19; lists, 20; choices, 23.
"""

import dataclasses
from abc import ABC, abstractmethod
from dataclasses import KW_ONLY, dataclass
from operator import index
from typing import SupportsIndex, TypeAlias, cast

from modelcast.core.exceptions import CodecError
from modelcast.messages.bits import BitReader, BitWriter
from modelcast.messages.field_table import read_code
from modelcast.messages.fields import Field

__all__ = ["AbstractShape", "Choice", "Number", "Record", "Series", "Truth", "Value", "record_of"]

Value: TypeAlias = int | tuple["Value | None", ...]
"""What a part holds, as codes."""


class AbstractShape(ABC):
    """How a part lies on the wire."""

    __slots__ = ()

    name: str
    """Our name."""
    standard_name: str
    """Name in the standard."""

    @abstractmethod
    def checked(self, value: Value) -> Value:
        """A value with Python's own integers.

        Parameters
        ----------
        value
            As in the table above; any integers, NumPy's too.

        Raises
        ------
        ValueError
            Where it is not of this shape, or a code is out of its range.
        """

    @abstractmethod
    def read(self, reader: BitReader) -> Value:
        """Next value.

        Parameters
        ----------
        reader
            Where it begins.

        Raises
        ------
        CodecError
            Where it is cut short, a code is out of its range, or a later edition is needed to read it.
        """

    @abstractmethod
    def write(self, writer: BitWriter, value: Value) -> None:
        """Append a value.

        Parameters
        ----------
        writer
            Where to.
        value
            Of this shape; the caller has checked that.
        """


@dataclass(frozen=True, slots=True)
class Number(AbstractShape):
    """A field.

    Parameters
    ----------
    field
        The field.
    extensible
        Whether later editions may have more codes.
    """

    field: Field
    _: KW_ONLY
    extensible: bool = False
    name: str = dataclasses.field(init=False)
    """Name of the field."""
    standard_name: str = dataclasses.field(init=False)
    """Last part of the standard's name of the field."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", self.field.name)
        object.__setattr__(self, "standard_name", self.field.standard_name.rpartition(".")[2])

    def checked(self, value: Value) -> Value:
        """The code as Python's own integer."""
        return self.field.checked(cast("int", value))

    def read(self, reader: BitReader) -> Value:
        """Next code."""
        if self.extensible:
            _refuse_extension(reader, self.standard_name)
        return read_code(reader, self.field)

    def write(self, writer: BitWriter, value: Value) -> None:
        """Append a code."""
        field = self.field
        writer.bits(cast("int", value) - field.low, field.width_bits + self.extensible)


@dataclass(frozen=True, slots=True)
class Truth(AbstractShape):
    """Yes or no.

    Parameters
    ----------
    field
        With the codes 0 for no and 1 for yes.
    """

    field: Field
    name: str = dataclasses.field(init=False)
    """Name of the field."""
    standard_name: str = dataclasses.field(init=False)
    """The standard's name of the field."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", self.field.name)
        object.__setattr__(self, "standard_name", self.field.standard_name)

    def checked(self, value: Value) -> Value:
        """The code as Python's own integer."""
        return self.field.checked(cast("int", value))

    def read(self, reader: BitReader) -> Value:
        """Next code."""
        return read_code(reader, self.field)

    def write(self, writer: BitWriter, value: Value) -> None:
        """Append a code."""
        writer.bits(cast("int", value), 1)


@dataclass(frozen=True, slots=True)
class Record(AbstractShape):
    """Members one after another.

    Parameters
    ----------
    name, standard_name
        Of the record.
    members
        In the order of the wire, their names differing.
    optional
        Our names of the members that may be left out.
    extensible
        Whether later editions may have more members.
    """

    name: str
    standard_name: str
    _: KW_ONLY
    members: tuple[AbstractShape, ...]
    optional: frozenset[str] = frozenset()
    extensible: bool = False

    def checked(self, value: Value) -> Value:
        """One value a member, None where it is left out."""
        if not isinstance(value, tuple) or len(value) != len(self.members):
            raise ValueError(f"{self.name} must be {len(self.members)} values, got {value!r}")
        found: list[Value | None] = []
        for member, one in zip(self.members, value, strict=True):
            if one is None and member.name not in self.optional:
                raise ValueError(f"{self.name}: {member.name} cannot be left out")
            found.append(None if one is None else member.checked(one))
        return tuple(found)

    def read(self, reader: BitReader) -> Value:
        """Next members."""
        if self.extensible:
            _refuse_extension(reader, self.standard_name)
        present = reader.bits(len(self.optional))
        found: list[Value | None] = []
        left = len(self.optional)
        for member in self.members:
            if member.name in self.optional:
                left -= 1
                if not present >> left & 1:
                    found.append(None)
                    continue
            found.append(member.read(reader))
        return tuple(found)

    def write(self, writer: BitWriter, value: Value) -> None:
        """Append members."""
        pairs = list(zip(self.members, cast("tuple[Value | None, ...]", value), strict=True))
        writer.bits(0, int(self.extensible))
        for member, one in pairs:
            if member.name in self.optional:
                writer.bits(one is not None, 1)
        for member, one in pairs:
            if one is not None:
                member.write(writer, one)


@dataclass(frozen=True, slots=True)
class Series(AbstractShape):
    """A list.

    Parameters
    ----------
    name, standard_name
        Of the list.
    item
        What it holds.
    most
        How many it holds at most; one at least.
    """

    name: str
    standard_name: str
    _: KW_ONLY
    item: AbstractShape
    most: int

    def checked(self, value: Value) -> Value:
        """One value an item."""
        if not isinstance(value, tuple) or not 1 <= len(value) <= self.most or None in value:
            raise ValueError(f"{self.name} must be 1 to {self.most} values, got {value!r}")
        return tuple(self.item.checked(one) for one in cast("tuple[Value, ...]", value))

    def read(self, reader: BitReader) -> Value:
        """Next items."""
        begin = reader.position
        count = reader.bits((self.most - 1).bit_length()) + 1
        if count > self.most:
            raise CodecError(f"{count} of {self.standard_name}, at most {self.most}", begin)
        return tuple([self.item.read(reader) for _ in range(count)])

    def write(self, writer: BitWriter, value: Value) -> None:
        """Append items."""
        items = cast("tuple[Value, ...]", value)
        writer.bits(len(items) - 1, (self.most - 1).bit_length())
        for one in items:
            self.item.write(writer, one)


@dataclass(frozen=True, slots=True)
class Choice(AbstractShape):
    """One of several, with room for more in later editions.

    Parameters
    ----------
    name, standard_name
        Of the choice.
    alternatives
        What it may be, their names differing.
    """

    name: str
    standard_name: str
    _: KW_ONLY
    alternatives: tuple[AbstractShape, ...]

    def checked(self, value: Value) -> Value:
        """The alternative's place and value."""
        places = range(len(self.alternatives))
        match value:
            case (SupportsIndex() as place, one) if one is not None and index(place) in places:
                return index(place), self.alternatives[index(place)].checked(one)
            case _:
                raise ValueError(
                    f"{self.name} must be the place of one of {len(places)} and its value, got {value!r}"
                )

    def read(self, reader: BitReader) -> Value:
        """Next alternative."""
        _refuse_extension(reader, self.standard_name)
        begin = reader.position
        place = reader.bits(self._place_bits)
        if place >= len(self.alternatives):
            raise CodecError(f"{self.standard_name} has no alternative {place}", begin)
        return place, self.alternatives[place].read(reader)

    def write(self, writer: BitWriter, value: Value) -> None:
        """Append an alternative."""
        place, one = cast("tuple[int, Value]", value)
        writer.bits(place, 1 + self._place_bits)
        self.alternatives[place].write(writer, one)

    @property
    def _place_bits(self) -> int:
        return (len(self.alternatives) - 1).bit_length()


def record_of(name: str, standard_name: str, fields: tuple[Field, ...]) -> Record:
    """A record of fields that are always there, closed to later editions.

    Parameters
    ----------
    name, standard_name
        Of the record.
    fields
        In the order of the wire.
    """
    return Record(name, standard_name, members=tuple(Number(field) for field in fields))


def _refuse_extension(reader: BitReader, standard_name: str) -> None:
    begin = reader.position
    if reader.bits(1):
        raise CodecError(f"{standard_name} of a later edition", begin)
