"""The WAVE short message: what goes round IEEE 1609.2 data in a frame with EtherType 88 dc.

=========  ======  ==================================================================================
part       octets
=========  ======  ==================================================================================
version    1       03: subtype 0, no extensions, version 3
transport  1       00: the message goes to an application by its PSID
PSID       1 to 4  p-encoded: leading ones of the first octet say how many more follow; 20
length     1 or 2  below 128 in one octet; otherwise 8000 plus the length
payload    n
=========  ======  ==================================================================================

Extension elements (a count, then each an id, a length and octets) are skipped.

References
----------
IEEE Std 1609.3-2016: WSM header, clause 8.3; PSID, clause 8.1.3. From published descriptions, and as other
dissectors read it.
"""

from typing import NamedTuple

from modelcast.core.exceptions import CodecError
from modelcast.messages.psids import SAFETY_PSID

__all__ = ["MAX_WSM_OCTETS", "ShortMessage", "decode_wsm", "encode_wsm", "wsmp_octets"]

MAX_WSM_OCTETS = 2304
"""Longest short message: what a frame of IEEE 802.11 carries at most."""

_WSMP_VERSION = 3
_EXTENDED = 0x08
_MOST_ELEMENTS = 32
_ONE_OCTET = 0x80


class ShortMessage(NamedTuple):
    """A short message.

    Parameters
    ----------
    psid
        The application, as its p-encoded octets read as a number (20 for safety messages).
    payload
        What it carries.
    """

    psid: int
    payload: bytes


def encode_wsm(payload: bytes, psid: int = SAFETY_PSID) -> bytes:
    """Octets of a short message, without extensions.

    Parameters
    ----------
    payload
        Octets, with the header `MAX_WSM_OCTETS` at most.
    psid
        The application, one whose number takes one octet, 0 to 127.

    Raises
    ------
    ValueError
        Where they are too many, or the application's number is too long.

    Examples
    --------
    >>> encode_wsm(b"abc").hex(), encode_wsm(bytes(200))[:5].hex()
    ('03002003616263', '03002080c8')
    """
    count = len(payload)
    length = bytes([count]) if count < _ONE_OCTET else (_ONE_OCTET << 8 | count).to_bytes(2, "big")
    if not 0 <= psid < _ONE_OCTET:
        raise ValueError(f"psid must be from 0 to {_ONE_OCTET - 1}, got {psid}")
    whole = bytes([_WSMP_VERSION, 0, psid]) + length + payload
    if len(whole) > MAX_WSM_OCTETS:
        raise ValueError(f"a short message has {MAX_WSM_OCTETS} octets at most, got {len(whole)}")
    return whole


def decode_wsm(data: bytes) -> ShortMessage:
    """The short message in octets.

    Parameters
    ----------
    data
        A whole short message, its padding removed.

    Raises
    ------
    CodecError
        Where they are none, of another version, or more than `MAX_WSM_OCTETS`. No other error comes out.

    Examples
    --------
    >>> decode_wsm(bytes.fromhex("03002003616263"))
    ShortMessage(psid=32, payload=b'abc')
    """
    if len(data) > MAX_WSM_OCTETS:
        raise CodecError(f"{len(data)} octets, more than {MAX_WSM_OCTETS}", 8 * MAX_WSM_OCTETS)
    found = _head(data)
    if found is None:
        raise CodecError("no short message of version 3 (WSMP)", 0)
    psid, start, length = found
    if start + length > len(data):
        raise CodecError(f"a payload of {length} octets, and {len(data) - start} are here", 8 * start)
    if start + length < len(data):
        raise CodecError(f"{len(data) - start - length} octets left over", 8 * (start + length))
    return ShortMessage(psid, data[start:])


def wsmp_octets(data: bytes) -> int | None:
    """Octets of the WSMP header that data begin with; None where they begin with none.

    A header is taken for one only where the length in it is that of the rest.

    Parameters
    ----------
    data
        A whole short message.

    Examples
    --------
    >>> wsmp_octets(bytes.fromhex("03002003abcdef"))
    4
    """
    found = _head(data)
    return found[1] if found is not None and sum(found[1:]) == len(data) else None


def _head(data: bytes) -> tuple[int, int, int] | None:
    """PSID, octets of the header, octets of the payload as told."""
    if not data or data[0] >> 4 or data[0] & 0x07 != _WSMP_VERSION:
        return None
    try:
        at = _past_elements(data, 1) if data[0] & _EXTENDED else 1
        transport = data[at]
        begin = at + 1
        _, at = _counted(data, begin)
        psid = int.from_bytes(data[begin:at], "big")
        at = _past_elements(data, at) if transport else at
        length, at = _counted(data, at)
    except IndexError:
        return None
    return (psid, at, length) if transport <= 1 else None


def _past_elements(data: bytes, at: int) -> int:
    """Where extension elements end: a count, then for each an id, a length and octets."""
    count, at = _counted(data, at)
    if count > _MOST_ELEMENTS:
        raise IndexError(at)
    for _ in range(count):
        length, at = _counted(data, at + 1)
        at += length
    return at


def _counted(data: bytes, at: int) -> tuple[int, int]:
    """Read a number whose leading ones say how many octets follow the first, and tell where it ends."""
    first = data[at]
    more = 8 - (first ^ 0xFF).bit_length()
    if more > 3:
        raise IndexError(at)
    octets = data[at : at + 1 + more]
    return int.from_bytes(octets, "big") & ((1 << (7 + 7 * more)) - 1), at + 1 + more
