"""Octets of messages in a file, text or binary, each with the place where it stands."""

import codecs
import stat
from collections.abc import Iterator
from pathlib import Path

from modelcast.core.exceptions import CodecError, DataFormatError
from modelcast.io.message_text import Piece, pieces_of_text
from modelcast.io.pcap import frames_of, is_capture, short_message_of
from modelcast.messages.ieee1609 import is_ieee1609_data
from modelcast.messages.sequence import begins_a_message
from modelcast.messages.wsmp import decode_wsm

__all__ = ["pieces_of", "read_octets"]

_BINARY_HEADS = (0, 2, 3, 0x80)
"""First octets of messages, none of which begins a text."""

_BLANKS = b"\t\n\v\f\r"
_LEAST_TEXT = 0.85
"""Share of printable characters from which on octets are text; those of a message come to 0.4."""

_MARKS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32-le"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)


def read_octets(path: str) -> bytes:
    """All octets of a file or a pipe.

    Parameters
    ----------
    path
        Its name.

    Raises
    ------
    DataFormatError
        Where it is a device.
    OSError
        Where there is none, or it cannot be read.
    """
    mode = Path(path).stat().st_mode
    if stat.S_ISCHR(mode) or stat.S_ISBLK(mode):
        raise DataFormatError(
            path, "a device, not a file", remedy="Name a file, or - for the standard input."
        )
    return Path(path).read_bytes()


def pieces_of(content: bytes) -> Iterator[Piece]:
    r"""Yield what stands in octets: runs of digits in a text, messages of a capture, or all of a binary file.

    Parameters
    ----------
    content
        All octets.

    Examples
    --------
    >>> [piece.octets.hex() for content in (b"00142501", b"\0\x14") for piece in pieces_of(content)]
    ['00142501', '0014']
    """
    if is_capture(content):
        yield from _captured(content)
        return
    text = _text(content)
    if text is not None:
        yield from pieces_of_text(text)
    elif content:
        yield Piece("", content)


def _captured(content: bytes) -> Iterator[Piece]:
    """Yield what each record of a capture holds behind its headers, or why it holds nothing."""
    try:
        for frame in frames_of(content):
            place = f"record {frame.number}"
            message = short_message_of(frame)
            if frame.cut:
                yield Piece(place, fault=f"{frame.cut} octets were not captured")
            elif message is None:
                yield Piece(place, fault=f"no WAVE short message (link type {frame.link})")
            else:
                yield _opened(place, message)
    except DataFormatError as error:
        yield Piece("capture", fault=str(error))


def _opened(place: str, message: bytes) -> Piece:
    if is_ieee1609_data(message) or begins_a_message(message):
        return Piece(place, message)
    try:
        return Piece(place, decode_wsm(message).payload)
    except CodecError as error:
        return Piece(place, fault=str(error))


def _text(content: bytes) -> str | None:
    """Text that octets are; None for a binary file."""
    for mark, encoding in _MARKS:
        if content.startswith(mark):
            return content[len(mark) :].decode(encoding, errors="replace")
    for encoding, zeros, letters in (
        ("utf-16-le", content[1::2], content[::2]),
        ("utf-16-be", content[::2], content[1::2]),
    ):
        if len(zeros) > 3 and not any(zeros) and _is_text(letters):
            return content.decode(encoding, errors="replace")
    if not _is_text(content):
        return None
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _is_text(content: bytes) -> bool:
    if not content or content[0] in _BINARY_HEADS:
        return not content
    plain = sum(0x20 <= octet < 0x7F or octet in _BLANKS for octet in content)
    return plain >= _LEAST_TEXT * len(content)
