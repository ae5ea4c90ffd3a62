"""The frame around every message: an id that says what it is, and its octets.

A frame's contents are an open type, so a frame can be read without knowing the message in it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from modelcast.core.exceptions import CodecError
from modelcast.messages.bits import MAX_OCTETS, BitReader, BitWriter
from modelcast.messages.bsm_fields import MESSAGE_ID

__all__ = [
    "FRAME_NAMES",
    "MAX_FRAME_OCTETS",
    "FrameHeader",
    "MessageFrame",
    "check_additions",
    "check_octets",
    "decode_frame",
    "encode_frame",
    "read_header",
    "read_tail",
]

MAX_FRAME_OCTETS = MAX_OCTETS + 4
"""Longest frame that is read: two octets of id, two of length, and the longest open type."""

FRAME_NAMES = {
    18: "map data",
    19: "signal phase and timing",
    20: "basic safety message",
    21: "common safety request",
    22: "emergency vehicle alert",
    23: "intersection collision",
    24: "NMEA corrections",
    25: "probe data management",
    26: "probe vehicle data",
    27: "road side alert",
    28: "RTCM corrections",
    29: "signal request",
    30: "signal status",
    31: "traveler information",
    32: "personal safety message",
    240: "sub-model identification of modelcast",
}
"""Messages by the id of their frame (DSRCmsgID of SAE J2735); 240 is modelcast's own."""


@dataclass(frozen=True, slots=True)
class MessageFrame:
    """A message id and the message's octets.

    Parameters
    ----------
    message_id
        From 0 to 32,767; 20 is the basic safety message.
    value
        The message, 1 to `MAX_OCTETS` octets.
    additions
        Octets of extension additions of the frame itself, None where absent; kept, not understood.

    Raises
    ------
    ValueError
        Where the id or a length is out of its range.
    """

    message_id: int
    value: bytes
    additions: tuple[bytes | None, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "message_id", MESSAGE_ID.checked(self.message_id))
        check_octets("value", self.value)
        check_additions("additions", self.additions)


class FrameHeader(NamedTuple):
    """What stands before a message in its frame; a tuple, for one is made with every message read.

    Parameters
    ----------
    message_id
        As in `MessageFrame`.
    extended
        Whether extension additions follow the message.
    start, stop
        Octets between which the message lies.
    """

    message_id: int
    extended: bool
    start: int
    stop: int


def check_octets(name: str, octets: bytes) -> None:
    """Refuse what no open type can hold.

    Parameters
    ----------
    name
        What the caller calls it.
    octets
        Its octets.

    Raises
    ------
    ValueError
        Where there are none, or more than `MAX_OCTETS`.
    """
    if not 1 <= len(octets) <= MAX_OCTETS:
        raise ValueError(f"{name} must take 1 to {MAX_OCTETS} octets, got {len(octets)}")


def check_additions(name: str, additions: Sequence[bytes | None]) -> None:
    """Refuse extension additions that cannot be written.

    Parameters
    ----------
    name
        What the caller calls them.
    additions
        Octets of each, None where absent; an empty sequence for none at all.

    Raises
    ------
    ValueError
        Where none of them is present, one is empty or too long, or there are more than `MAX_OCTETS`.
    """
    if len(additions) > MAX_OCTETS:
        raise ValueError(f"{name} must be {MAX_OCTETS} at most, got {len(additions)}")
    present = [octets for octets in additions if octets is not None]
    if additions and not present:
        raise ValueError(f"{name} must hold at least one that is present, or be empty")
    for octets in present:
        check_octets(f"each of {name}", octets)


def encode_frame(message_id: int, value: bytes, additions: tuple[bytes | None, ...] = ()) -> bytes:
    """Octets of a frame.

    Parameters
    ----------
    message_id, value, additions
        As in `MessageFrame`.

    Raises
    ------
    ValueError
        Where they cannot be written, or the frame would be longer than `MAX_FRAME_OCTETS`.

    Examples
    --------
    >>> encode_frame(20, bytes(3)).hex()
    '001403000000'
    """
    frame = MessageFrame(message_id, value, additions)
    if not additions:
        size = len(value)
        header = frame.message_id << 8 | size if size < 128 else frame.message_id << 16 | 0x8000 | size
        return header.to_bytes(3 if size < 128 else 4, "big") + value
    writer = BitWriter()
    writer.bits(1 << 15 | frame.message_id, 16)
    writer.open_type(frame.value)
    writer.additions(frame.additions)
    octets = writer.octets()
    if len(octets) > MAX_FRAME_OCTETS:
        raise ValueError(f"a frame takes {MAX_FRAME_OCTETS} octets at most, this one {len(octets)}")
    return octets


def read_header(data: bytes, expected_id: int | None = None) -> FrameHeader:
    """Read what stands before a message in its frame.

    Parameters
    ----------
    data
        The octets of the frame.
    expected_id
        Refuse any other message id; None to take all.

    Raises
    ------
    CodecError
        Where the frame is too long, cut short, empty, or holds another message.
    """
    octets = len(data)
    if octets > MAX_FRAME_OCTETS:
        raise CodecError(f"{octets} octets, a frame has {MAX_FRAME_OCTETS} at most", 8 * MAX_FRAME_OCTETS)
    if octets > 3 and data[0] < 0x80 and 0 < data[2] < 0x80 and data[2] <= octets - 3:
        # The common case, without a reader: no additions, a length in one octet.
        message_id = data[0] << 8 | data[1]
        if expected_id is None or message_id == expected_id:
            return FrameHeader(message_id, extended=False, start=3, stop=3 + data[2])
    reader = BitReader(data)
    extended = bool(reader.bits(1))
    message_id = reader.bits(15)
    if expected_id is not None and message_id != expected_id:
        name = f": {FRAME_NAMES[message_id]}" if message_id in FRAME_NAMES else ""
        raise CodecError(f"message id {message_id} where {expected_id} is expected{name}", 1)
    size = reader.length()
    if size == 0:
        raise CodecError("a frame without a message", 16)
    if 8 * size > reader.left:
        raise CodecError(f"{size} octets needed, {reader.left // 8} left", reader.position)
    start = reader.position >> 3
    return FrameHeader(message_id, extended, start, start + size)


def read_tail(data: bytes, header: FrameHeader) -> tuple[bytes | None, ...]:
    """Read what stands after the message: extension additions and nothing else.

    Parameters
    ----------
    data
        The octets of the frame.
    header
        As `read_header` found it.

    Raises
    ------
    CodecError
        Where additions are cut short, or anything is left over.
    """
    if not header.extended and header.stop == len(data):
        return ()
    reader = BitReader(data, header.stop)
    additions = reader.additions() if header.extended else ()
    reader.finish()
    return additions


def decode_frame(data: bytes) -> MessageFrame:
    """Read a frame, whatever message it holds.

    Parameters
    ----------
    data
        Its octets, no more and no fewer.

    Raises
    ------
    CodecError
        Where they are not a frame.

    Examples
    --------
    >>> decode_frame(bytes.fromhex("001403000000")).message_id
    20
    """
    header = read_header(data)
    return MessageFrame(header.message_id, data[header.start : header.stop], read_tail(data, header))
