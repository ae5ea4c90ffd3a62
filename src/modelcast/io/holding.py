"""A reader that holds numbers of a file in memory, up to a limit that can be changed."""

from dataclasses import dataclass, replace
from typing import Self

from modelcast.io.base import AbstractTripReader
from modelcast.io.reading_limits import HELD_BYTES

__all__ = ["AbstractHoldingReader"]


@dataclass(frozen=True, slots=True)
class AbstractHoldingReader(AbstractTripReader):
    """One file format whose rows are gathered in memory.

    Parameters
    ----------
    held_bytes
        Octets of numbers that may be held at a time; a single trip over it is an error.
    """

    held_bytes: int = HELD_BYTES

    def within(self, held_bytes: int) -> Self:
        """Return the reader with another limit."""
        return replace(self, held_bytes=held_bytes)
