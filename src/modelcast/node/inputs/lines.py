"""Lines out of chunks of octets, however they were cut; none longer than stated."""

import re

__all__ = ["LineSplitter"]

_ENDS = re.compile(rb"[\r\n]+")


class LineSplitter:
    r"""Puts lines together; CR, LF or both end one, and empty ones are left out.

    Parameters
    ----------
    most_octets
        Of a line. A longer one is passed over up to its end and counted; what is held never exceeds this.

    Examples
    --------
    >>> splitter = LineSplitter(8)
    >>> splitter.feed(b"one\r\ntw"), splitter.feed(b"o\nfar too long"), splitter.feed(b"er\nthree\n")
    ([b'one'], [b'two'], [b'three'])
    >>> splitter.overlong, splitter.held
    (1, 0)
    """

    def __init__(self, most_octets: int) -> None:
        self._most = most_octets
        self._begun = b""
        self._passing_over = False
        self.overlong = 0
        """Lines that were too long."""

    @property
    def held(self) -> int:
        """Octets of the line that has no end yet."""
        return len(self._begun)

    def feed(self, chunk: bytes) -> list[bytes]:
        """Lines that a chunk completes.

        Parameters
        ----------
        chunk
            The next octets.
        """
        *ended, begun = _ENDS.split(chunk)
        lines: list[bytes] = []
        for piece in ended:
            line, self._begun = self._begun + piece, b""
            if self._passing_over or len(line) > self._most:
                self.overlong += not self._passing_over
                self._passing_over = False
            elif line:
                lines.append(line)
        if not self._passing_over:
            self._begun += begun
            if len(self._begun) > self._most:
                self._begun, self._passing_over = b"", True
                self.overlong += 1
        return lines
