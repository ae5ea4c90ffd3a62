"""What goes round a message on the air, and how it is taken off again."""

import abc
import functools
from dataclasses import dataclass

from modelcast.core.exceptions import CodecError
from modelcast.messages.belonging import belongs_to, psid_of
from modelcast.messages.ieee1609 import encode_unsecured, read_unsecured_head, unsecured_payload
from modelcast.messages.psids import PSIDS, SAFETY_PSID
from modelcast.messages.security.signed import decode_signed
from modelcast.messages.wsmp import ShortMessage, decode_wsm, encode_wsm
from modelcast.runtime.transport.base import MOST_OCTETS

__all__ = ["NOT_VERIFIED", "AbstractEnvelope", "Bare", "Opened", "Unsecured", "opened_safety"]

NOT_VERIFIED = "not verified"
"""Why a message was taken of which nobody knows whose it is."""

_LEAST_HEADS, _MOST_HEADS = 4, 16
"""Octets that both heads take, with room."""

_PSID_AT = 2
"""Octet of a short message without extensions that names its application."""


@dataclass(frozen=True, slots=True)
class Opened:
    """A frame without its envelope.

    Parameters
    ----------
    octets
        The message; None where the frame is refused.
    why
        What became of it, in a word or two for counters: ``accepted``, or why not.
    """

    octets: bytes | None
    why: str


class AbstractEnvelope(abc.ABC):
    """One station's way to wrap what it sends and to open what it hears."""

    @abc.abstractmethod
    def wrap(self, octets: bytes, *, sent_s: float) -> bytes | None:
        """Return a message as it goes on the air; None where it must not, for want of credentials.

        Parameters
        ----------
        octets
            The message.
        sent_s
            When it leaves [s].
        """

    @abc.abstractmethod
    def open(self, frame: bytes, *, received_s: float) -> Opened:
        """Return what a frame holds. Nothing in it is trusted, and nothing is raised.

        Parameters
        ----------
        frame
            Whatever arrived.
        received_s
            When [s].
        """

    @abc.abstractmethod
    def rename(self) -> None:
        """Take other credentials, as the station takes another temporary id."""


class Bare(AbstractEnvelope):
    """No envelope: messages are frames as they are, as between the virtual transport's stations."""

    def wrap(self, octets: bytes, *, sent_s: float) -> bytes:  # noqa: ARG002 - nothing is dated
        """Return the message."""
        return octets

    def open(self, frame: bytes, *, received_s: float) -> Opened:  # noqa: ARG002 - nothing is checked
        """Return the frame."""
        return Opened(frame, "accepted")

    def rename(self) -> None:
        """Change nothing: there is nothing to change."""


class Unsecured(AbstractEnvelope):
    """A WAVE short message with unsecured IEEE 1609.2 data (docs/wire.md).

    What others sign is opened too, unverified: this host holds no keys. Receivers that require signatures
    refuse what it sends.

    Parameters
    ----------
    psid
        The application that the station speaks in.
    """

    def __init__(self, psid: int = SAFETY_PSID) -> None:
        self._psid = psid

    def wrap(self, octets: bytes, *, sent_s: float) -> bytes:  # noqa: ARG002 - nothing is dated
        """Return the message with its two heads."""
        return encode_wsm(encode_unsecured(octets), psid_of(octets, self._psid))

    def open(self, frame: bytes, *, received_s: float) -> Opened:  # noqa: ARG002 - nothing is dated
        """Return what is inside, or where it stops being what it should."""
        psid = frame[_PSID_AT] if len(frame) > _PSID_AT else -1
        heads = _shortest_heads(len(frame), psid) if psid in PSIDS else b""
        if heads and frame.startswith(heads):
            return _told(frame[len(heads) :], psid, "accepted")
        short = opened_safety(frame)
        if isinstance(short, Opened):
            return short
        try:
            if read_unsecured_head(short.payload) is not None:
                return _told(unsecured_payload(short.payload), short.psid, "accepted")
            signed = decode_signed(short.payload)
        except CodecError:
            return Opened(None, "no data of IEEE 1609.2")
        if signed.psid != short.psid:
            return Opened(None, "another application")
        return _told(signed.payload, signed.psid, NOT_VERIFIED)

    def rename(self) -> None:
        """Change nothing: there are no credentials."""


def _told(octets: bytes, psid: int, why: str) -> Opened:
    """A message that came in an application, where it belongs to that."""
    return Opened(octets, why) if belongs_to(octets, psid) else Opened(None, "another application")


def opened_safety(frame: bytes) -> ShortMessage | Opened:
    """The short message of safety messages that arrived, or that there is none.

    Parameters
    ----------
    frame
        Whatever arrived.
    """
    try:
        message = decode_wsm(frame)
    except CodecError:
        return Opened(None, "no short message")
    return message if message.psid in PSIDS else Opened(None, "another application")


@functools.lru_cache(maxsize=len(PSIDS) * MOST_OCTETS)
def _shortest_heads(octets: int, psid: int) -> bytes:
    """The heads with which `Unsecured` sends a frame of so many octets, empty where none has that length.

    Nearly all that arrives begins with them, and then nothing is left to read.
    """
    for size in range(octets - _MOST_HEADS, octets - _LEAST_HEADS):
        if 1 <= size < MOST_OCTETS - _MOST_HEADS:
            whole = encode_wsm(encode_unsecured(bytes(size)), psid)
            if len(whole) == octets:
                return whole[: octets - size]
    return b""
