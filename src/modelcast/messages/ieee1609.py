"""IEEE 1609.2 data by their first octets; unsecured data are opened and written, other content is only named.

=========  ======  ==================================================================================
part       octets
=========  ======  ==================================================================================
version    1       3
content    1       tag of the choice: 80 unsecured, 81 signed, 82 encrypted, 83 and 84 certificate requests
length     1 to 5  of unsecured data: one octet up to 127; above, 80 plus how many, then these
payload    n       of unsecured data
=========  ======  ==================================================================================

Signed data are read and written by `security.signed`.

References
----------
IEEE Std 1609.2: Ieee1609Dot2Data, 6.3.2, in canonical octet encoding rules (ITU-T X.696: lengths 8.6, tags
8.7).
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

from modelcast.core.exceptions import CodecError

__all__ = [
    "UNSECURED_KIND",
    "UnsecuredData",
    "content_name",
    "encode_unsecured",
    "is_ieee1609_data",
    "read_unsecured_head",
    "unsecured_document",
    "unsecured_payload",
]

UNSECURED_KIND = "ieee1609-unsecured"
"""What a document of unsecured data says it is."""

_VERSION = 3
_UNSECURED = 0x80
_CONTENTS = {
    _UNSECURED: "an unsecured",
    0x81: "a signed",
    0x82: "an encrypted",
    0x83: "a certificate request in an",
    0x84: "an X.509 certificate request in an",
}
_LONG_LENGTH = 0x80
_MOST_LENGTH_OCTETS = 4


class UnsecuredData(NamedTuple):
    """Where the payload of unsecured data lies.

    Parameters
    ----------
    start, stop
        Octets between which it lies, as the length says; the data may end before.
    shortest
        Whether the length is in its one canonical form.
    """

    start: int
    stop: int
    shortest: bool


def is_ieee1609_data(data: bytes) -> bool:
    """Whether octets begin as IEEE 1609.2 data: version 3, then the tag of a choice.

    Parameters
    ----------
    data
        Any octets.
    """
    return len(data) > 1 and data[0] == _VERSION and data[1] >> 6 == 0b10


def content_name(data: bytes) -> str:
    """What IEEE 1609.2 data are, with their article.

    Parameters
    ----------
    data
        Octets of which `is_ieee1609_data` is true.

    Examples
    --------
    >>> content_name(bytes.fromhex("038100"))
    'a signed IEEE 1609.2 SPDU (03 81)'
    """
    kind = _CONTENTS.get(data[1], "an unknown content in an")
    return f"{kind} IEEE 1609.2 SPDU ({data[0]:02x} {data[1]:02x})"


def read_unsecured_head(data: bytes) -> UnsecuredData | None:
    """Read the head of unsecured data; None where octets are anything else, or end within the head.

    Parameters
    ----------
    data
        Octets that begin with the data.
    """
    if not is_ieee1609_data(data) or data[1] != _UNSECURED or len(data) < 3:
        return None
    first = data[2]
    if first < _LONG_LENGTH:
        return UnsecuredData(3, 3 + first, shortest=True)
    count = first - _LONG_LENGTH
    octets = data[3 : 3 + count]
    if not 1 <= count <= _MOST_LENGTH_OCTETS or len(octets) < count:
        return None
    length = int.from_bytes(octets, "big")
    shortest = length >= _LONG_LENGTH and octets[0] > 0
    return UnsecuredData(3 + count, 3 + count + length, shortest)


def unsecured_payload(data: bytes) -> bytes:
    """The payload of unsecured data.

    Parameters
    ----------
    data
        One SPDU, no more and no fewer octets.

    Raises
    ------
    CodecError
        Where the content is another, the length has no form, or octets are missing or left over.

    Examples
    --------
    >>> unsecured_payload(bytes.fromhex("0380020014")).hex()
    '0014'
    """
    head = read_unsecured_head(data)
    if head is None:
        if is_ieee1609_data(data) and data[1] == _UNSECURED:
            raise CodecError(f"{content_name(data)} without a length of its payload", 16)
        if is_ieee1609_data(data):
            raise CodecError(f"{content_name(data)}: its content is not read", 0)
        raise CodecError("no IEEE 1609.2 SPDU", 0)
    if head.stop > len(data):
        raise CodecError(
            f"{content_name(data)} with a payload of {head.stop - head.start} octets, and "
            f"{len(data) - head.start} are here: cut short",
            8 * head.start,
        )
    if head.stop < len(data):
        raise CodecError(f"{len(data) - head.stop} octets left over", 8 * head.stop)
    return data[head.start : head.stop]


def encode_unsecured(payload: bytes) -> bytes:
    """Octets of unsecured data.

    Parameters
    ----------
    payload
        Any octets, fewer than 2**32.

    Examples
    --------
    >>> encode_unsecured(bytes(188))[:5].hex()
    '038081bc00'
    """
    count = len(payload)
    width = (count.bit_length() + 7) // 8
    length = (
        bytes([count])
        if count < _LONG_LENGTH
        else bytes([_LONG_LENGTH | width, *count.to_bytes(width, "big")])
    )
    return bytes([_VERSION, _UNSECURED]) + length + payload


def unsecured_document(payload: Mapping[str, Any]) -> dict[str, Any]:
    """Plain values of unsecured data, for JSON.

    Parameters
    ----------
    payload
        The document of its payload.
    """
    return {"message": UNSECURED_KIND, "payload": dict(payload)}
