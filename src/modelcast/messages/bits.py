"""Bits, lengths and open types of unaligned packed encoding rules, read and written one message at a time.

References
----------
ITU-T X.691: length determinants, clause 11.9; open types, 11.2; extension additions, 19.7 to 19.9.

Notes
-----
A reader takes each value in its one shortest form only, and wants padding to be zero. So bytes that are
accepted are exactly the bytes that would be written. Fragmented lengths (16,384 octets and more) are refused:
no frame of this kind is as long as that.
"""

from collections.abc import Sequence

from modelcast.core.exceptions import CodecError

__all__ = ["MAX_OCTETS", "BitReader", "BitWriter"]

MAX_OCTETS = 16383
"""Longest open type: longer ones would be fragmented."""

_LONG_FORM = 0x8000
_SHORT_LENGTHS = 128
_SMALL_COUNTS = 64


class BitReader:
    """Takes values from octets, first bit first.

    Parameters
    ----------
    data
        All octets; offsets of errors count from their start.
    start, stop
        Octets to read from and up to.
    """

    __slots__ = ("_data", "_end", "position")

    def __init__(self, data: bytes, start: int = 0, stop: int | None = None) -> None:
        self._data = data
        self.position = 8 * start
        self._end = 8 * (len(data) if stop is None else stop)

    @property
    def left(self) -> int:
        """Bits left."""
        return self._end - self.position

    def bits(self, width: int) -> int:
        """Next bits as a whole number.

        Parameters
        ----------
        width
            How many.

        Raises
        ------
        CodecError
            Where fewer are left.
        """
        begin = self.position
        end = begin + width
        if end > self._end:
            raise CodecError(f"{width} bits needed, {self._end - begin} left: the message ends early", begin)
        self.position = end
        whole = int.from_bytes(self._data[begin >> 3 : (end + 7) >> 3], "big")
        return (whole >> (-end & 7)) & ((1 << width) - 1)

    def octets(self, count: int) -> bytes:
        """Next octets, wherever they begin.

        Parameters
        ----------
        count
            How many.

        Raises
        ------
        CodecError
            Where fewer are left.
        """
        if 8 * count > self.left:
            raise CodecError(f"{count} octets needed, {self.left} bits left", self.position)
        return self.bits(8 * count).to_bytes(count, "big")

    def length(self) -> int:
        """Next length determinant.

        Raises
        ------
        CodecError
            Where it is cut short, fragmented, or longer than it need be.
        """
        begin = self.position
        first = self.bits(8)
        if first < _SHORT_LENGTHS:
            return first
        if first >= 0xC0:
            raise CodecError("a fragmented length: 16,384 octets or more", begin)
        length = (first & 0x3F) << 8 | self.bits(8)
        if length < _SHORT_LENGTHS:
            raise CodecError(f"length {length} in the long form", begin)
        return length

    def open_type(self) -> bytes:
        """Next open type, its octets not looked into.

        Raises
        ------
        CodecError
            Where it is cut short or empty: even a value without bits takes one octet.
        """
        begin = self.position
        count = self.length()
        if count == 0:
            raise CodecError("an open type without octets", begin)
        return self.octets(count)

    def additions(self) -> tuple[bytes | None, ...]:
        """Next extension additions: None for each that is absent.

        Raises
        ------
        CodecError
            Where they are cut short, or none is present.
        """
        begin = self.position
        if self.bits(1):
            count = self.length()
            if count <= _SMALL_COUNTS:
                raise CodecError(f"{count} extension additions in the form for more than 64", begin)
        else:
            count = self.bits(6) + 1
        present = self.bits(count)
        if present == 0:
            raise CodecError("extension additions announced, and none present", begin)
        return tuple(self.open_type() if present >> (count - 1 - i) & 1 else None for i in range(count))

    def finish(self) -> None:
        """Check that nothing is left but zero bits up to a whole octet.

        Raises
        ------
        CodecError
            Where there is more.
        """
        begin = self.position
        if self.bits(-begin & 7):
            raise CodecError("padding that is not zero", begin)
        if self.left:
            raise CodecError(f"{self.left // 8} octets left over", self.position)


class BitWriter:
    """Puts values after one another, first bit first."""

    __slots__ = ("_whole", "_width")

    def __init__(self) -> None:
        self._whole = 0
        self._width = 0

    @property
    def position(self) -> int:
        """Bits written so far."""
        return self._width

    def bits(self, value: int, width: int) -> None:
        """Append a whole number.

        Parameters
        ----------
        value
            From 0 to 2**width - 1; the caller has checked that.
        width
            Bits it takes.
        """
        self._whole = self._whole << width | value
        self._width += width

    def length(self, count: int) -> None:
        """Append a length determinant.

        Parameters
        ----------
        count
            From 0 to `MAX_OCTETS`; the caller has checked that.
        """
        if count < _SHORT_LENGTHS:
            self.bits(count, 8)
        else:
            self.bits(_LONG_FORM | count, 16)

    def open_type(self, octets: bytes) -> None:
        """Append an open type.

        Parameters
        ----------
        octets
            One to `MAX_OCTETS`; the caller has checked that.
        """
        self.length(len(octets))
        self.bits(int.from_bytes(octets, "big"), 8 * len(octets))

    def additions(self, additions: Sequence[bytes | None]) -> None:
        """Append extension additions.

        Parameters
        ----------
        additions
            Octets of each, None where absent; at least one present.
        """
        count = len(additions)
        if count <= _SMALL_COUNTS:
            self.bits(count - 1, 7)
        else:
            self.bits(1, 1)
            self.length(count)
        for octets in additions:
            self.bits(octets is not None, 1)
        for octets in additions:
            if octets is not None:
                self.open_type(octets)

    def octets(self) -> bytes:
        """All that was written, padded with zero bits to whole octets."""
        padding = -self._width & 7
        return (self._whole << padding).to_bytes((self._width + padding) >> 3, "big")
