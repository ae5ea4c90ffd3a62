"""Octets that are no message, by the name of what they begin with."""

from modelcast.messages.ieee1609 import content_name, is_ieee1609_data
from modelcast.messages.wsmp import wsmp_octets

__all__ = ["head_name"]

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
