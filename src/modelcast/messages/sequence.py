"""Messages one after another in octets: where each begins and ends, and what lies between them."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from modelcast.core.exceptions import CodecError
from modelcast.messages.bits import BitReader
from modelcast.messages.bsm import decode_bsm
from modelcast.messages.bsm_fields import MESSAGE_ID
from modelcast.messages.foreign_heads import head_name
from modelcast.messages.frame import FRAME_NAMES, MAX_FRAME_OCTETS
from modelcast.messages.ieee1609 import is_ieee1609_data, read_unsecured_head, unsecured_payload
from modelcast.messages.mbc_wire import IDENTIFICATION_MESSAGE, decode_identification
from modelcast.messages.psm import decode_psm
from modelcast.messages.psm_fields import PERSONAL_SAFETY_MESSAGE
from modelcast.messages.security.signed import MAX_SPDU_OCTETS, signed_octets
from modelcast.messages.wsmp import wsmp_octets

__all__ = ["Part", "announced_octets", "begins_a_message", "is_message", "parts_of"]

_HEADS = re.compile(rb"\x00[\x14\x20\xf0]|\x03[\x80\x81]")
"""First octets of messages that are looked for in other octets."""

_DECODERS: Final[Mapping[int, Callable[[bytes], object]]] = {
    IDENTIFICATION_MESSAGE: decode_identification,
    PERSONAL_SAFETY_MESSAGE: decode_psm,
}
"""What reads a message by its id; all others are taken for basic safety messages."""

_VERSION = 3
_SIGNED = b"\x03\x81"
_HEAD_OCTETS = 16
_SHOWN_OCTETS = 16


@dataclass(frozen=True, slots=True)
class Part:
    """A stretch of octets.

    Parameters
    ----------
    start
        Octet at which it begins.
    octets
        All of it.
    fault
        Why it is not read; empty for a message, or for what should be one.
    """

    start: int
    octets: bytes
    fault: str = ""


def announced_octets(data: bytes) -> int | None:
    """How many octets the message takes that data begin with, as its head tells; they may end before.

    Parameters
    ----------
    data
        Any octets.

    Returns
    -------
    int or None
        None where they begin with no message that is read here, or end within its head.

    Examples
    --------
    >>> announced_octets(bytes.fromhex("00142501")), announced_octets(bytes.fromhex("038028001425"))
    (40, 43)
    """
    if data[:2] == _SIGNED:
        return signed_octets(data)
    if is_ieee1609_data(data):
        head = read_unsecured_head(data)
        return None if head is None else head.stop
    reader = BitReader(data)
    try:
        extended = reader.bits(1)
        if reader.bits(15) not in FRAME_NAMES:
            return None
        size = reader.length()
        if not extended or size == 0 or 8 * size > reader.left:
            return size and (reader.position >> 3) + size
        reader.octets(size)
        reader.additions()
    except CodecError:
        return None
    return (reader.position + 7) >> 3


def is_message(data: bytes) -> bool:
    """Whether octets are one whole message that is read here, no more and no fewer.

    Parameters
    ----------
    data
        Any octets.
    """
    try:
        if data[:2] == _SIGNED:
            return signed_octets(data) == len(data)
        if is_ieee1609_data(data):
            return is_message(unsecured_payload(data))
        number = MESSAGE_ID.high & int.from_bytes(data[:2], "big")
        _DECODERS.get(number, decode_bsm)(data)
    except CodecError:
        return False
    return True


def begins_a_message(data: bytes) -> bool:
    """Whether octets begin as a message does: a known frame, or IEEE 1609.2 data.

    Parameters
    ----------
    data
        Any octets.
    """
    if is_ieee1609_data(data):
        return True
    return MESSAGE_ID.high & int.from_bytes(data[:2], "big") in FRAME_NAMES and len(data) > 1


def parts_of(data: bytes) -> list[Part]:
    """Messages and what lies between them, in order; together they are all octets.

    A message of an id that is not read, or with a fault in it, is a part like a message: who reads it tells
    what is wrong. Octets in which nothing is found are one such part.

    Parameters
    ----------
    data
        Any octets.

    Examples
    --------
    >>> [(part.start, part.fault) for part in parts_of(bytes.fromhex("00f007000000010e80820a"))]
    [(0, ''), (10, '1 octet left over: 0a')]
    """
    parts: list[Part] = []
    signed = False
    at = 0
    while at < len(data):
        stop = _end(data, at)
        if stop is not None:
            parts.append(Part(at, data[at:stop]))
        else:
            stop = _next(data, at + 1)
            if stop is None and not parts:
                return [Part(0, data)]
            rest = data[at:stop]
            name = head_name(data if at == 0 else rest) or ""
            signed = signed or name.startswith("a signed")
            parts.append(
                Part(at, rest, _left_over(rest, signed) if stop is None else _between(rest, name, stop))
            )
            stop = at + len(rest)
        at = stop
    return parts


def _end(data: bytes, at: int) -> int | None:
    """Where the message ends that begins at an octet; None where none begins, or the octets end before."""
    head = data[at : at + _HEAD_OCTETS]
    if head[:2] == _SIGNED:
        head = data[at : at + MAX_SPDU_OCTETS]
    elif head[0] & 0x80:
        head = data[at : at + 2 * MAX_FRAME_OCTETS]
    count = announced_octets(head)
    if not count or at + count > len(data):
        return None
    stop = at + count
    # A WSMP header begins with 3 as well; it fits the whole of what is there, or is none.
    if head[0] == _VERSION and not is_message(data[at:stop]) and wsmp_octets(data[at:]) is not None:
        return None
    return stop


def _next(data: bytes, at: int) -> int | None:
    """Where the next whole message begins, from an octet on."""
    while found := _HEADS.search(data, at):
        at = found.start()
        stop = _end(data, at)
        if stop is not None and is_message(data[at:stop]):
            return at
        at += 1
    return None


def _left_over(rest: bytes, signed: bool) -> str:
    """What octets at the end are."""
    announced = announced_octets(rest)
    if announced and announced > len(rest):
        return f"{_count(rest)} left over: the beginning of a message of {announced} octets, cut short"
    if not any(rest):
        return f"{_count(rest)} left over: zeros"
    what = "what a signed SPDU has behind its payload, not read and not verified, " if signed else ""
    return f"{_count(rest)} left over: {what}{_shown(rest)}"


def _between(rest: bytes, name: str, stop: int) -> str:
    """What octets in front of a message are."""
    what = f"{name}, " if name else ""
    return f"{_count(rest)} in front of the message at octet {stop} not read: {what}{_shown(rest)}"


def _count(octets: bytes) -> str:
    return f"{len(octets)} {'octet' if len(octets) == 1 else 'octets'}"


def _shown(octets: bytes) -> str:
    return octets[:_SHOWN_OCTETS].hex() + ("..." if len(octets) > _SHOWN_OCTETS else "")
