"""A signed message as octets.

==============  ===========  ================================================================================
part            octets
==============  ===========  ================================================================================
head            1            2 with a digest, 3 with a certificate: format 1 in the upper seven bits
generation      8            microseconds since the common instant, as Time64 of IEEE 1609.2; first bit zero
payload         1 or 2 + n   length determinant of ITU-T X.691 clause 11.9, then the octets
signer          8 or 113     digest of the certificate, or the certificate
signature       64           r and s of ECDSA over P-256 with SHA-256
==============  ===========  ================================================================================
"""

import hashlib
from dataclasses import dataclass

from modelcast.core.exceptions import CodecError
from modelcast.messages.bits import MAX_OCTETS, BitReader, BitWriter
from modelcast.messages.security.certificate import (
    CERTIFICATE_OCTETS,
    DIGEST_OCTETS,
    SIGNATURE_OCTETS,
    Certificate,
)
from modelcast.messages.security.time64 import LAST_US

__all__ = [
    "CERTIFICATE_OVERHEAD_BYTES",
    "DIGEST_OVERHEAD_BYTES",
    "SignedMessage",
    "decode_signed",
    "signed_octets",
    "signed_part",
]

_FORMAT = 1
_GENERATION_BITS = 64

DIGEST_OVERHEAD_BYTES = 1 + 8 + 1 + DIGEST_OCTETS + SIGNATURE_OCTETS
"""What a message with a digest takes more than its payload of up to 127 octets; from there on one more."""

CERTIFICATE_OVERHEAD_BYTES = DIGEST_OVERHEAD_BYTES - DIGEST_OCTETS + CERTIFICATE_OCTETS
"""The same with the certificate."""


@dataclass(frozen=True, slots=True)
class SignedMessage:
    """What arrived, before anything in it is believed.

    Parameters
    ----------
    generation_us
        When it was signed: microseconds since the common instant.
    payload
        1 to 16,383 octets.
    signer
        The sender's certificate, or its digest.
    signature
        64 octets.

    Raises
    ------
    ValueError
        Where a part does not fit.
    """

    generation_us: int
    payload: bytes
    signer: Certificate | bytes
    signature: bytes

    def __post_init__(self) -> None:
        if not 0 <= self.generation_us <= LAST_US:
            raise ValueError(f"generation_us must be from 0 to {LAST_US}, got {self.generation_us}")
        if not 1 <= len(self.payload) <= MAX_OCTETS:
            raise ValueError(f"payload must have 1 to {MAX_OCTETS} octets, got {len(self.payload)}")
        if isinstance(self.signer, bytes) and len(self.signer) != DIGEST_OCTETS:
            raise ValueError(f"a digest must have {DIGEST_OCTETS} octets, got {len(self.signer)}")
        if len(self.signature) != SIGNATURE_OCTETS:
            raise ValueError(f"signature must have {SIGNATURE_OCTETS} octets, got {len(self.signature)}")

    @property
    def digest(self) -> bytes:
        """Digest of the sender's certificate."""
        return self.signer if isinstance(self.signer, bytes) else self.signer.digest

    @property
    def octets(self) -> bytes:
        """The message as it goes on the air."""
        attached = isinstance(self.signer, Certificate)
        signer = self.signer.octets if isinstance(self.signer, Certificate) else self.signer
        head = _FORMAT << 1 | attached
        return bytes([head]) + _timed(self.generation_us, self.payload) + signer + self.signature


def signed_part(generation_us: int, payload: bytes, certificate: Certificate) -> bytes:
    """What is signed, 64 octets: the hash of time and payload, then the hash of the certificate.

    Hashed once more by the signature, it is built as IEEE 1609.2 5.3.1.2 builds it. A message with a digest
    and the same with the certificate have one signature; another certificate of the same key has not.

    Parameters
    ----------
    generation_us
        When it is signed: microseconds since the common instant.
    payload
        The octets to be signed.
    certificate
        The sender's.
    """
    timed = hashlib.sha256(_timed(generation_us, payload)).digest()
    return timed + hashlib.sha256(certificate.octets).digest()


def decode_signed(data: bytes) -> SignedMessage:
    """The signed message in octets; its octets are again the same. Nothing is verified.

    Parameters
    ----------
    data
        One message, no more and no fewer octets.

    Raises
    ------
    CodecError
        Where they are not such a message. No other error comes out, whatever the octets are.

    Examples
    --------
    >>> message = SignedMessage(5, b"payload", signer=bytes(8), signature=bytes(64))
    >>> decode_signed(message.octets) == message, len(message.octets) - len(b"payload")
    (True, 82)
    """
    reader = BitReader(data)
    head = reader.bits(7)
    if head != _FORMAT:
        raise CodecError(f"signed message of format {head}, not {_FORMAT}", 0)
    attached = reader.bits(1)
    generation_us = reader.bits(_GENERATION_BITS)
    if generation_us > LAST_US:
        raise CodecError(f"generated {generation_us} µs after the common instant, {LAST_US} at most", 8)
    payload = reader.open_type()
    begin = reader.position
    signer: Certificate | bytes = reader.octets(CERTIFICATE_OCTETS if attached else DIGEST_OCTETS)
    if attached:
        signer = Certificate.from_octets(signer, begin)
    signature = reader.octets(SIGNATURE_OCTETS)
    reader.finish()
    return SignedMessage(generation_us, payload, signer, signature)


def signed_octets(data: bytes) -> int | None:
    """How many octets the signed message takes that data begin with; they may end before.

    Parameters
    ----------
    data
        Any octets.

    Returns
    -------
    int or None
        None where they begin with no signed message, or end within its head.
    """
    reader = BitReader(data)
    try:
        head = reader.bits(7)
        attached = reader.bits(1)
        reader.bits(_GENERATION_BITS)
        count = reader.length()
    except CodecError:
        return None
    if head != _FORMAT or count == 0:
        return None
    signer = CERTIFICATE_OCTETS if attached else DIGEST_OCTETS
    return (reader.position >> 3) + count + signer + SIGNATURE_OCTETS


def _timed(generation_us: int, payload: bytes) -> bytes:
    writer = BitWriter()
    writer.bits(generation_us, _GENERATION_BITS)
    writer.open_type(payload)
    return writer.octets()
