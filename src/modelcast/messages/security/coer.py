"""Octets of canonical octet encoding rules, read once from front to back, and written.

Only the forms that the messages here need: lengths, unsigned whole numbers, counts of a sequence-of, octet
strings, tags of a choice. A reader takes each in its one canonical form only, so that what is read is written
back to the same octets. It never looks back: the work is linear in the octets.

References
----------
ITU-T X.696: lengths, clause 8.6; tags, 8.7; whole numbers, 10; sequence-of, 17.
"""

from modelcast.core.exceptions import CodecError

__all__ = ["CoerReader", "counted", "unsigned"]

_LONG = 0x80
_MOST_LENGTH_OCTETS = 4


class CoerReader:
    """Takes values from octets; its position is an octet.

    Parameters
    ----------
    data
        All octets; offsets of errors count from their start.
    start
        Octet to read from.
    """

    __slots__ = ("_data", "position")

    def __init__(self, data: bytes, start: int = 0) -> None:
        self._data = data
        self.position = start

    @property
    def left(self) -> int:
        """Octets left."""
        return len(self._data) - self.position

    def octets(self, count: int) -> bytes:
        """Next octets.

        Parameters
        ----------
        count
            How many.

        Raises
        ------
        CodecError
            Where fewer are left.
        """
        begin = self.position
        if count > self.left:
            raise CodecError(f"{count} octets needed, {self.left} left", 8 * begin)
        self.position = begin + count
        return self._data[begin : self.position]

    def number(self, count: int) -> int:
        """Next whole number of fixed width.

        Parameters
        ----------
        count
            Its octets.

        Raises
        ------
        CodecError
            Where fewer are left.
        """
        return int.from_bytes(self.octets(count), "big")

    def one_of(self, known: tuple[int, ...], what: str) -> int:
        """Next octet, which must be one of some.

        Parameters
        ----------
        known
            What it may be.
        what
            What it is, for the error.

        Raises
        ------
        CodecError
            Where it is another, or none is left.
        """
        begin = self.position
        found = self.number(1)
        if found not in known:
            names = " or ".join(f"{one:02x}" for one in known)
            raise CodecError(f"{what} {found:02x}, and only {names} is read", 8 * begin)
        return found

    def length(self) -> int:
        """Next length.

        Raises
        ------
        CodecError
            Where it is cut short or longer than it need be.
        """
        begin = self.position
        first = self.number(1)
        if first < _LONG:
            return first
        count = first - _LONG
        if not 1 <= count <= _MOST_LENGTH_OCTETS:
            raise CodecError(f"a length that begins with {first:02x}", 8 * begin)
        length = self.number(count)
        if length < _LONG or length >> 8 * (count - 1) == 0:
            raise CodecError(f"length {length} in a form longer than it need be", 8 * begin)
        return length

    def counted(self) -> bytes:
        """Next octets with their length in front.

        Raises
        ------
        CodecError
            Where they are cut short, or their length is not canonical.
        """
        return self.octets(self.length())

    def unsigned(self) -> int:
        """Next whole number without an upper bound: a length, then as many octets as it needs.

        Raises
        ------
        CodecError
            Where it is cut short or longer than it need be.
        """
        begin = self.position
        octets = self.counted()
        if not octets or (octets[0] == 0 and len(octets) > 1):
            raise CodecError("a whole number in a form that is not its shortest", 8 * begin)
        return int.from_bytes(octets, "big")

    def finish(self) -> None:
        """Check that nothing is left.

        Raises
        ------
        CodecError
            Where there is more.
        """
        if self.left:
            raise CodecError(f"{self.left} octets left over", 8 * self.position)


def counted(octets: bytes) -> bytes:
    """Octets with their length in front.

    Parameters
    ----------
    octets
        Fewer than 2**32.

    Examples
    --------
    >>> counted(b"ab").hex(), counted(bytes(128))[:3].hex()
    ('026162', '818000')
    """
    count = len(octets)
    if count < _LONG:
        return bytes([count]) + octets
    width = (count.bit_length() + 7) // 8
    return bytes([_LONG | width]) + count.to_bytes(width, "big") + octets


def unsigned(value: int) -> bytes:
    """Octets of a whole number without an upper bound.

    Parameters
    ----------
    value
        Not negative.

    Examples
    --------
    >>> unsigned(0x20).hex(), unsigned(0).hex(), unsigned(256).hex()
    ('0120', '0100', '020100')
    """
    return counted(value.to_bytes(max((value.bit_length() + 7) // 8, 1), "big"))
