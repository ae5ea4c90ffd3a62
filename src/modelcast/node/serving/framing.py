"""Where one message ends and the next begins: four octets of length before each, little-endian."""

from modelcast.node.serving.schema import FrameError

__all__ = ["LENGTH_BYTES", "framed", "length_of"]

LENGTH_BYTES = 4


def framed(octets: bytes) -> bytes:
    """A message with its length before it.

    Parameters
    ----------
    octets
        The message.

    Examples
    --------
    >>> framed(b"abc").hex(" ")
    '03 00 00 00 61 62 63'
    """
    return len(octets).to_bytes(LENGTH_BYTES, "little") + octets


def length_of(head: bytes, most: int) -> int:
    """How many octets follow.

    Parameters
    ----------
    head
        `LENGTH_BYTES` octets.
    most
        The longest message.

    Raises
    ------
    FrameError
        Where a message is longer, or empty.
    """
    length = int.from_bytes(head, "little")
    if not 0 < length <= most:
        raise FrameError(f"a frame of {length} octets: from 1 to {most}")
    return length
