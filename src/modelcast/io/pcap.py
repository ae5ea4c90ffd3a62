"""Captures of what a radio heard: classic pcap and pcapng, read record by record; classic pcap, written.

==========================  ==================================================================================
link type                   where the short message (WSMP) begins
==========================  ==================================================================================
1, Ethernet                 behind EtherType 88 dc, VLAN tags skipped
105, IEEE 802.11            data frame: behind LLC and SNAP with 88 dc, or behind 88 dc alone (EPD)
127, radiotap               the same behind the radiotap header
147, user 0                 at once; or the frame is IEEE 1609.2 data or a message without any header
==========================  ==================================================================================

Both byte orders; micro- and nanoseconds; of pcapng the blocks SHB, IDB, EPB and SPB, others are skipped. A
record longer than 65,535 octets, or one that ends behind the file, ends the reading with a `DataFormatError`:
behind it nothing can be trusted. The work is linear in the octets.

References
----------
draft-ietf-opsawg-pcap and draft-ietf-opsawg-pcapng; the registry of link types at tcpdump.org; radiotap.org.
"""

import struct
from collections.abc import Iterable, Iterator
from typing import BinaryIO, NamedTuple

from modelcast.core.exceptions import DataFormatError

__all__ = [
    "ETHERTYPE_WSMP",
    "LINK_ETHERNET",
    "CaptureFile",
    "CapturedFrame",
    "frames_of",
    "is_capture",
    "pcap_octets",
    "short_message_of",
]

ETHERTYPE_WSMP = b"\x88\xdc"
LINK_ETHERNET = 1
_LINK_80211, _LINK_RADIOTAP, _LINK_USER0 = 105, 127, 147
_CLASSIC = {
    b"\xd4\xc3\xb2\xa1": ("<", 1_000_000),
    b"\xa1\xb2\xc3\xd4": (">", 1_000_000),
    b"\x4d\x3c\xb2\xa1": ("<", 1_000_000_000),
    b"\xa1\xb2\x3c\x4d": (">", 1_000_000_000),
}
_SECTION = b"\x0a\x0d\x0d\x0a"
_ORDERS = {b"\x4d\x3c\x2b\x1a": "<", b"\x1a\x2b\x3c\x4d": ">"}
_INTERFACE, _SIMPLE, _ENHANCED = 1, 3, 6
_TIME_RESOLUTION = 9
_MOST_OCTETS = 65_535
_NANOSECONDS = 1_000_000_000
_BROADCAST = b"\xff" * 6
_SNAP = b"\xaa\xaa\x03\x00\x00\x00"
_VLAN = (b"\x81\x00", b"\x88\xa8")


class CapturedFrame(NamedTuple):
    """A record of a capture.

    Parameters
    ----------
    number
        Its place among the records, from 1.
    t_ns
        When it was heard, since 1970-01-01 UTC [ns]; None where the capture does not tell.
    link
        Link type.
    octets
        What was captured.
    cut
        Octets that were on the air and not captured.
    """

    number: int
    t_ns: int | None
    link: int
    octets: bytes
    cut: int = 0


class CaptureFile:
    """The octets of a capture in a file, read as they are asked for.

    Parameters
    ----------
    file
        Open for reading, in any place.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._size = file.seek(0, 2)

    def __len__(self) -> int:
        return self._size

    def __getitem__(self, part: slice) -> bytes:
        begin, end, _ = part.indices(self._size)
        self._file.seek(begin)
        return self._file.read(max(end - begin, 0))


def is_capture(head: bytes) -> bool:
    """Whether octets begin as a capture does.

    Parameters
    ----------
    head
        The first octets of a file, four at least.
    """
    return head[:4] in _CLASSIC or (head[:4] == _SECTION and head[8:12] in _ORDERS)


def frames_of(content: bytes | CaptureFile, path: str = "capture") -> Iterator[CapturedFrame]:
    """Yield the records of a capture in order.

    Parameters
    ----------
    content
        All of it.
    path
        What errors call it.

    Raises
    ------
    DataFormatError
        Where it is no capture, a record is longer than 65,535 octets, or the file ends within one.
    """
    if content[:4] in _CLASSIC:
        yield from _classic(content, path)
    elif is_capture(content[:12]):
        yield from _blocks(content, path)
    else:
        raise DataFormatError(
            path, "no capture", remedy="Give a file of tcpdump, tshark or an on-board unit."
        )


def _fault(path: str, what: str, number: int) -> DataFormatError:
    return DataFormatError(
        path, f"record {number}: {what}", remedy="Capture again, or cut the file before it."
    )


def _classic(content: bytes | CaptureFile, path: str) -> Iterator[CapturedFrame]:
    order, ticks = _CLASSIC[content[:4]]
    if len(content) < 24:
        raise _fault(path, "the file ends within its head", 0)
    link = struct.unpack(order + "I", content[20:24])[0] & 0xFFFF
    at, number = 24, 1
    while at < len(content):
        if len(content) - at < 16:
            raise _fault(path, "the file ends within its head", number)
        seconds, parts, count, whole = struct.unpack(order + "IIII", content[at : at + 16])
        at += 16
        if count > min(_MOST_OCTETS, len(content) - at):
            raise _fault(path, f"{count} octets, and {len(content) - at} are left", number)
        t_ns = seconds * _NANOSECONDS + parts * (_NANOSECONDS // ticks)
        yield CapturedFrame(number, t_ns, link, content[at : at + count], max(whole - count, 0))
        at, number = at + count, number + 1


class _Interface(NamedTuple):
    link: int
    longest: int
    ticks: int


def _blocks(content: bytes | CaptureFile, path: str) -> Iterator[CapturedFrame]:
    order = "<"
    interfaces: list[_Interface] = []
    at, number = 0, 1
    while at < len(content):
        if content[at : at + 4] == _SECTION:
            found = _ORDERS.get(content[at + 8 : at + 12])
            if found is None:
                raise _fault(path, "a section without a byte order", number)
            order, interfaces = found, []
        if len(content) - at < 12:
            raise _fault(path, "the file ends within a block", number)
        kind, size = struct.unpack(order + "II", content[at : at + 8])
        if size < 12 or size % 4 or size > len(content) - at:
            raise _fault(path, f"a block of {size} octets, and {len(content) - at} are left", number)
        body = content[at + 8 : at + size - 4]
        at += size
        if kind == _INTERFACE:
            interfaces.append(_interface(body, order, path, number))
        elif kind in (_ENHANCED, _SIMPLE):
            yield _packet(kind, body, order, interfaces=interfaces, path=path, number=number)
            number += 1


def _interface(body: bytes, order: str, path: str, number: int) -> _Interface:
    if len(body) < 8:
        raise _fault(path, "an interface cut short", number)
    link, _, longest = struct.unpack_from(order + "HHI", body)
    ticks, at = 1_000_000, 8
    while len(body) - at >= 4:
        code, size = struct.unpack_from(order + "HH", body, at)
        if code == 0:
            break
        if code == _TIME_RESOLUTION and size == 1 and at + 4 < len(body):
            value = body[at + 4]
            ticks = 2 ** (value & 0x7F) if value & 0x80 else 10 ** min(value, 18)
        at += 4 + (size + 3) // 4 * 4
    return _Interface(link, longest, ticks)


def _packet(
    kind: int, body: bytes, order: str, *, interfaces: list[_Interface], path: str, number: int
) -> CapturedFrame:
    head = 20 if kind == _ENHANCED else 4
    if len(body) < head:
        raise _fault(path, "a packet cut short", number)
    which, t_ns = 0, None
    if kind == _ENHANCED:
        which, high, low, count, whole = struct.unpack_from(order + "IIIII", body)
    else:
        high = low = 0
        whole = struct.unpack_from(order + "I", body)[0]
        count = whole
    if which >= len(interfaces):
        raise _fault(path, f"interface {which} is not described", number)
    interface = interfaces[which]
    if kind == _ENHANCED:
        t_ns = (high << 32 | low) * _NANOSECONDS // interface.ticks
    else:
        count = min(whole, interface.longest or whole, len(body) - head)
    if count > min(_MOST_OCTETS, len(body) - head):
        raise _fault(path, f"{count} octets, and {len(body) - head} are there", number)
    return CapturedFrame(number, t_ns, interface.link, body[head : head + count], max(whole - count, 0))


def short_message_of(frame: CapturedFrame) -> bytes | None:
    """What stands behind the link-layer header; None where it is no WAVE short message.

    Parameters
    ----------
    frame
        A record.
    """
    octets = frame.octets
    if frame.link == _LINK_USER0:
        return octets or None
    if frame.link == LINK_ETHERNET:
        at = 12
        while octets[at : at + 2] in _VLAN:
            at += 4
        return octets[at + 2 :] if octets[at : at + 2] == ETHERTYPE_WSMP else None
    check = 0
    if frame.link == _LINK_RADIOTAP:
        if len(octets) < 8:
            return None
        check = 4 if _has_check_sequence(octets) else 0
        octets = octets[int.from_bytes(octets[2:4], "little") :]
    elif frame.link != _LINK_80211:
        return None
    return _behind_80211(octets[: len(octets) - check] if check else octets)


def _has_check_sequence(octets: bytes) -> bool:
    """Whether radiotap's flags say that the frame has its check sequence behind it."""
    present = int.from_bytes(octets[4:8], "little")
    if not present & 2:
        return False
    at, word = 8, present
    while word >> 31 and at + 4 <= len(octets):
        word = int.from_bytes(octets[at : at + 4], "little")
        at += 4
    if present & 1:
        at = (at + 7) // 8 * 8 + 8
    return at < len(octets) and bool(octets[at] & 0x10)


def _behind_80211(octets: bytes) -> bytes | None:
    if len(octets) < 24 or octets[0] & 0x0C != 0x08 or octets[0] & 0x40:
        return None  # no data frame, or one without data
    at = 24 + (6 if octets[1] & 3 == 3 else 0) + (2 if octets[0] & 0x80 else 0)
    if octets[at : at + 6] == _SNAP:
        at += 6
    return octets[at + 2 :] if octets[at : at + 2] == ETHERTYPE_WSMP else None


def pcap_octets(messages: Iterable[tuple[int, bytes]], *, source: bytes = bytes(6)) -> Iterator[bytes]:
    """Yield a classic capture piece by piece: the head, then each record.

    Link type Ethernet, broadcast with EtherType 88 dc, which other dissectors follow to the IEEE 1609.2 data;
    little endian, nanoseconds.

    Parameters
    ----------
    messages
        When each was sent or heard, since 1970-01-01 UTC [ns], and the short message (WSMP) with its header.
    source
        Address of the sender, 6 octets.
    """
    yield struct.pack("<IHHiIII", 0xA1B23C4D, 2, 4, 0, 0, _MOST_OCTETS, LINK_ETHERNET)
    for t_ns, message in messages:
        frame = _BROADCAST + source + ETHERTYPE_WSMP + message
        seconds, parts = divmod(t_ns, _NANOSECONDS)
        yield struct.pack("<IIII", seconds, parts, len(frame), len(frame)) + frame
