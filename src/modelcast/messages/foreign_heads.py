"""Octets that are no message, by the name of what they begin with."""

from modelcast.messages.ieee1609 import content_name, is_ieee1609_data

__all__ = ["head_name", "wsmp_octets"]

_MAGICS = {
    "a1b2c3d4": "a capture file (pcap)",
    "d4c3b2a1": "a capture file (pcap)",
    "a1b23c4d": "a capture file (pcap)",
    "4d3cb2a1": "a capture file (pcap)",
    "0a0d0d0a": "a capture file (pcapng)",
    "1f8b": "a compressed file (gzip)",
    "504b0304": "a compressed file (zip)",
    "fd377a58": "a compressed file (xz)",
    "28b52ffd": "a compressed file (zstd)",
}
_WSMP_VERSION = 3
_EXTENDED = 0x08
_ETHERTYPE = b"\x88\xdc"
_SEARCHED = 64


def head_name(data: bytes) -> str | None:
    """What octets begin with, with its article; None where that is not known.

    Parameters
    ----------
    data
        Any octets.

    Examples
    --------
    >>> head_name(bytes.fromhex("d4c3b2a102000400"))
    'a capture file (pcap)'
    """
    for magic, name in _MAGICS.items():
        if data.startswith(bytes.fromhex(magic)):
            return name
    if is_ieee1609_data(data):
        return content_name(data)
    if wsmp_octets(data) is not None:
        return "a WSMP header"
    at = data.find(_ETHERTYPE, 0, _SEARCHED)
    if at >= 0 and wsmp_octets(data[at + 2 :]) is not None:
        return "a link-layer header (88 dc) and a WSMP header"
    return None


def wsmp_octets(data: bytes) -> int | None:
    """Octets of the WSMP header that data begin with; None where they begin with none.

    A header is taken for one only where the length in it is that of the rest.

    Parameters
    ----------
    data
        A whole short message.

    References
    ----------
    IEEE Std 1609.3-2016: WSM header, clause 8.3; PSID, clause 8.1.3. From published descriptions.

    Examples
    --------
    >>> wsmp_octets(bytes.fromhex("03002003abcdef"))
    4
    """
    if not data or data[0] >> 4 or data[0] & 0x07 != _WSMP_VERSION:
        return None
    try:
        at = _past_elements(data, 1) if data[0] & _EXTENDED else 1
        transport = data[at]
        _, at = _counted(data, at + 1)
        at = _past_elements(data, at) if transport else at
        length, at = _counted(data, at)
    except IndexError:
        return None
    return at if transport <= 1 and at + length == len(data) else None


def _past_elements(data: bytes, at: int) -> int:
    """Where extension elements end: a count, then for each an id, a length and octets."""
    count, at = _counted(data, at)
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
