"""The basic safety messages in captures, for trips and for losses: who, when, what; nothing is verified.

A record counts as one of five:

================  =========================================================================================
``read``          a message whose envelope is read whole, signed or not
``behind``        a message behind a signature, a certificate or headers that are not read, as implicit
                  certificates and linkage data are: its payload stands before them in the octets
``cut``           captured in part
``no message``    a short message or data of IEEE 1609.2 without a basic safety message
``other``         anything else that the capture holds
================  =========================================================================================
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO, Literal, NamedTuple

from modelcast.core.exceptions import CodecError, DataFormatError
from modelcast.io.pcap import CapturedFrame, CaptureFile, frames_of, short_message_of
from modelcast.messages.bsm import BsmCore, decode_bsm
from modelcast.messages.ieee1609 import is_ieee1609_data, unsecured_payload
from modelcast.messages.security.signed import decode_signed, payload_of_signed
from modelcast.messages.sequence import begins_a_message
from modelcast.messages.wsmp import decode_wsm

__all__ = ["Captured", "CapturedMessage"]

_MINUTE_S = 60.0
_SIGNED = b"\x03\x81"

Kind = Literal["read", "behind", "cut", "no message", "other"]

_TOLD: dict[Kind, str] = {
    "behind": "messages behind signatures or certificates that are not read",
    "cut": "records captured in part",
    "no message": "short messages without a basic safety message",
    "other": "records of another kind",
}


class CapturedMessage(NamedTuple):
    """A basic safety message in a capture.

    Parameters
    ----------
    number
        Of its record, from 1.
    t_s
        When it says it is of: the instant next to the capture's own time that has its place in the minute;
        None where one of the two is missing [s].
    core
        Its Part I.
    """

    number: int
    t_s: float | None
    core: BsmCore

    @property
    def temporary_id(self) -> int:
        """Its sender."""
        return int(self.core.values()["temporary_id"] or 0)


@dataclass(slots=True)
class Captured:
    """A capture, read record by record.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    DataFormatError
        While it is read: where the file cannot be, is no capture, or is damaged.
    """

    path: str
    kinds: Counter[Kind] = field(default_factory=Counter[Kind])
    """How many records were of each kind, so far."""

    def messages(self) -> Iterator[CapturedMessage]:
        """Yield the basic safety messages in order."""
        with self._file() as file:
            for frame in frames_of(CaptureFile(file), self.path):
                kind, core = _opened(frame)
                self.kinds[kind] += 1
                if core is not None:
                    mark_s = core.values()["second_of_minute_s"]
                    t_s = None
                    if mark_s is not None and frame.t_ns is not None:
                        t_s = mark_s + _MINUTE_S * round((frame.t_ns / 1e9 - mark_s) / _MINUTE_S)
                    yield CapturedMessage(frame.number, t_s, core)

    def _file(self) -> BinaryIO:
        try:
            return Path(self.path).open("rb")
        except OSError as error:
            raise DataFormatError(
                self.path, f"cannot be read: {error.strerror}", remedy="Check the path."
            ) from error

    def told(self) -> list[str]:
        """What is to be said of the records that were not simply read, in words."""
        return [f"{self.kinds[kind]} {words}" for kind, words in _TOLD.items() if self.kinds[kind]]


def _opened(frame: CapturedFrame) -> tuple[Kind, BsmCore | None]:
    """What a record is, and Part I of its message."""
    if frame.cut:
        return "cut", None
    message = short_message_of(frame)
    if message is None:
        return "other", None
    kind: Kind = "read"
    try:
        if not (is_ieee1609_data(message) or begins_a_message(message)):
            message = decode_wsm(message).payload
        if message[:2] == _SIGNED:
            try:
                message = decode_signed(message).payload
            except CodecError:
                message, kind = payload_of_signed(message), "behind"
        elif is_ieee1609_data(message):
            message = unsecured_payload(message)
        return kind, decode_bsm(message).core
    except CodecError:
        return "no message", None
