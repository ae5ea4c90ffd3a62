"""Lists of octets with an id each, kept and not looked into: Part II and regional extensions."""

from dataclasses import dataclass
from operator import index

from modelcast.messages.bits import BitReader, BitWriter
from modelcast.messages.bsm_fields import MAX_PART_II, MAX_REGIONAL, PART_II_ID, REGION_ID
from modelcast.messages.fields import Field
from modelcast.messages.frame import check_octets

__all__ = ["PART_II", "REGIONAL", "Content", "ContentList"]

Content = tuple[int, bytes]
"""An id and the octets of an open type."""


@dataclass(frozen=True, slots=True)
class ContentList:
    """How a list of contents is written: a count, then for each an id and an open type.

    Parameters
    ----------
    name
        Our name.
    identifier
        The id of each.
    most
        How many there are at most; one at least.
    """

    name: str
    identifier: Field
    most: int

    def check(self, contents: tuple[Content, ...]) -> None:
        """Refuse what cannot be written.

        Parameters
        ----------
        contents
            Empty where the list is absent.

        Raises
        ------
        ValueError
            Where there are too many, or an id or length is out of its range.
        """
        if len(contents) > self.most:
            raise ValueError(f"{self.name} must have {self.most} entries at most, got {len(contents)}")
        for number, octets in contents:
            self.identifier.checked(number)
            check_octets(f"each of {self.name}", octets)

    def read(self, reader: BitReader) -> tuple[Content, ...]:
        """Next contents.

        Parameters
        ----------
        reader
            Where the count begins.

        Raises
        ------
        CodecError
            Where they are cut short, or one is empty.
        """
        count = reader.bits(self._count_bits) + 1
        width = self.identifier.width_bits
        return tuple([(reader.bits(width), reader.open_type()) for _ in range(count)])

    def write(self, writer: BitWriter, contents: tuple[Content, ...]) -> None:
        """Append contents.

        Parameters
        ----------
        writer
            Where to.
        contents
            One at least; the caller has checked them.
        """
        writer.bits(len(contents) - 1, self._count_bits)
        for number, octets in contents:
            writer.bits(index(number), self.identifier.width_bits)
            writer.open_type(octets)

    @property
    def _count_bits(self) -> int:
        return (self.most - 1).bit_length()


PART_II = ContentList("part_ii", PART_II_ID, MAX_PART_II)
"""Part II of a basic safety message."""

REGIONAL = ContentList("regional", REGION_ID, MAX_REGIONAL)
"""Regional extensions of any message."""
