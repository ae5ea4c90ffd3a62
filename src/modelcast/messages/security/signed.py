"""A signed message as octets: Ieee1609Dot2Data with signedData, in canonical octet encoding rules.

==============  ===============  ============================================================================
part            octets
==============  ===============  ============================================================================
head            03 81 00         version 3, signed data, hash SHA-256
payload         40 03 80 n ...   data present; unsecured data with their length and octets
header          40 01 20 t       generation time present; PSID; Time64, microseconds, 8 octets
signer          80 d             HashedId8 of the certificate, 8 octets
or              81 01 01 c       one certificate
signature       80 80 r s        ECDSA over P-256, r by its x coordinate, s
==============  ===============  ============================================================================

References
----------
IEEE Std 1609.2-2016: Ieee1609Dot2Data, 6.3.2; SignedData, 6.3.4; HeaderInfo, 6.3.9; the hash, 5.3.1.
"""

import hashlib
from dataclasses import KW_ONLY, dataclass

from modelcast.core.exceptions import CodecError
from modelcast.messages.ieee1609 import encode_unsecured
from modelcast.messages.psids import SAFETY_PSID
from modelcast.messages.security.certificate import (
    DIGEST_OCTETS,
    SIGNATURE_OCTETS,
    X_ONLY,
    Certificate,
    read_certificate,
    read_signature,
    signature_octets,
)
from modelcast.messages.security.coer import CoerReader, unsigned
from modelcast.messages.security.time64 import LAST_US

__all__ = [
    "MAX_SPDU_OCTETS",
    "SignedMessage",
    "decode_signed",
    "payload_of_signed",
    "signed_octets",
    "signed_part",
    "signed_part_of",
]

MAX_SPDU_OCTETS = 2304
"""More than a frame of IEEE 802.11 carries is refused before it is looked at."""

_LAST_PSID = 2**32 - 1
_SIGNED_HEAD = b"\3\x81"


@dataclass(frozen=True, slots=True)
class SignedMessage:
    """What arrived, before anything in it is believed.

    Parameters
    ----------
    generation_us
        When it was signed: TAI microseconds since 2004-01-01 00:00 UTC.
    payload
        1 to `MAX_SPDU_OCTETS` octets.
    signer
        The sender's certificate, or its digest.
    signature
        r and s, 64 octets.
    psid
        The application that it says it is of.
    r_tag
        Form of r on the wire: 80 x alone, 82 or 83 a compressed point.

    Raises
    ------
    ValueError
        Where a part does not fit.
    """

    generation_us: int
    payload: bytes
    signer: Certificate | bytes
    signature: bytes
    _: KW_ONLY
    psid: int = SAFETY_PSID
    r_tag: int = X_ONLY

    def __post_init__(self) -> None:
        if not 0 <= self.generation_us <= LAST_US:
            raise ValueError(f"generation_us must be from 0 to {LAST_US}, got {self.generation_us}")
        if not 1 <= len(self.payload) <= MAX_SPDU_OCTETS:
            raise ValueError(f"payload must have 1 to {MAX_SPDU_OCTETS} octets, got {len(self.payload)}")
        if isinstance(self.signer, bytes) and len(self.signer) != DIGEST_OCTETS:
            raise ValueError(f"a digest must have {DIGEST_OCTETS} octets, got {len(self.signer)}")
        if len(self.signature) != SIGNATURE_OCTETS:
            raise ValueError(f"signature must have {SIGNATURE_OCTETS} octets, got {len(self.signature)}")
        if not 0 <= self.psid <= _LAST_PSID:
            raise ValueError(f"psid must be from 0 to {_LAST_PSID}, got {self.psid}")
        if self.r_tag not in (X_ONLY, 0x82, 0x83):
            raise ValueError(f"r_tag must be 128, 130 or 131, got {self.r_tag}")

    @property
    def digest(self) -> bytes:
        """Digest of the sender's certificate."""
        return self.signer if isinstance(self.signer, bytes) else self.signer.digest

    @property
    def octets(self) -> bytes:
        """The message as it goes on the air."""
        if isinstance(self.signer, bytes):
            signer = b"\x80" + self.signer
        else:
            signer = b"\x81\1\1" + self.signer.octets
        signed = _to_be_signed(self.generation_us, self.payload, self.psid)
        return _SIGNED_HEAD + b"\0" + signed + signer + signature_octets(self.signature, self.r_tag)


def signed_part(
    generation_us: int, payload: bytes, certificate: Certificate, *, psid: int = SAFETY_PSID
) -> bytes:
    """What is signed, 64 octets: the hash of what is to be signed, then the hash of the certificate.

    The signature hashes them once more (IEEE Std 1609.2-2016, 5.3.1). A message with a digest and the same
    with the certificate have one signature; another certificate of the same key has not.

    Parameters
    ----------
    generation_us
        When it is signed: TAI microseconds since 2004-01-01 00:00 UTC.
    payload
        The octets to be signed.
    certificate
        The sender's.
    psid
        The application.
    """
    return signed_part_of(generation_us, payload, hashlib.sha256(certificate.canonical).digest(), psid=psid)


def signed_part_of(
    generation_us: int, payload: bytes, certificate_hash: bytes, *, psid: int = SAFETY_PSID
) -> bytes:
    """The same for a certificate whose hash is known.

    Parameters
    ----------
    generation_us, payload, psid
        As for `signed_part`.
    certificate_hash
        SHA-256 of the certificate's canonical octets.
    """
    return hashlib.sha256(_to_be_signed(generation_us, payload, psid)).digest() + certificate_hash


def decode_signed(data: bytes) -> SignedMessage:
    """The signed message in octets; its octets are again the same. Nothing is verified.

    Parameters
    ----------
    data
        One message, no more and no fewer octets.

    Raises
    ------
    CodecError
        Where they are not such a message, more than `MAX_SPDU_OCTETS`, or have parts that are not read here.
        No other error comes out, whatever the octets are.

    Examples
    --------
    >>> message = SignedMessage(5, b"payload", signer=bytes(8), signature=bytes(64))
    >>> decode_signed(message.octets) == message, len(message.octets) - len(b"payload")
    (True, 93)
    """
    if len(data) > MAX_SPDU_OCTETS:
        raise CodecError(f"{len(data)} octets, more than {MAX_SPDU_OCTETS}", 8 * MAX_SPDU_OCTETS)
    reader = CoerReader(data)
    message = _read(reader)
    reader.finish()
    return message


def signed_octets(data: bytes) -> int | None:
    """How many octets the signed message takes that data begin with.

    Parameters
    ----------
    data
        Any octets.

    Returns
    -------
    int or None
        None where they begin with no whole signed message that is read here.
    """
    if data[:2] != _SIGNED_HEAD:
        return None
    reader = CoerReader(data[:MAX_SPDU_OCTETS])
    try:
        _read(reader)
    except CodecError:
        return None
    return reader.position


def payload_of_signed(data: bytes) -> bytes:
    """The payload of a signed message, whatever stands behind it: other headers, certificates of any kind.

    So what is sent with implicit certificates or linkage data, which are not read, can still be looked at.

    Parameters
    ----------
    data
        One message; octets behind its payload are not looked at.

    Raises
    ------
    CodecError
        Where they do not begin as such a message, or are more than `MAX_SPDU_OCTETS`.

    Examples
    --------
    >>> message = SignedMessage(5, b"payload", signer=bytes(8), signature=bytes(64))
    >>> payload_of_signed(message.octets[:-80] + bytes(200))
    b'payload'
    """
    if len(data) > MAX_SPDU_OCTETS:
        raise CodecError(f"{len(data)} octets, more than {MAX_SPDU_OCTETS}", 8 * MAX_SPDU_OCTETS)
    return _read_payload(CoerReader(data))


def _read_payload(reader: CoerReader) -> bytes:
    reader.one_of((3,), "IEEE 1609.2 data of version")
    reader.one_of((0x81,), "content of kind")
    reader.one_of((0,), "hash of kind")
    reader.one_of((0x40,), "signed payload with the parts")
    reader.one_of((3,), "payload's data of version")
    reader.one_of((0x80,), "payload's content of kind")
    begin = reader.position
    payload = reader.counted()
    if not payload:
        raise CodecError("no payload", 8 * begin)
    return payload


def _read(reader: CoerReader) -> SignedMessage:
    payload = _read_payload(reader)
    reader.one_of((0x40,), "header with the parts")
    begin = reader.position
    psid = reader.unsigned()
    if psid > _LAST_PSID:
        raise CodecError(f"application {psid}", 8 * begin)
    generation_us = reader.number(8)
    signer: Certificate | bytes
    if reader.one_of((0x80, 0x81), "signer of kind") == 0x80:
        signer = reader.octets(DIGEST_OCTETS)
    else:
        begin = reader.position
        if (count := reader.unsigned()) != 1:
            raise CodecError(f"{count} certificates, and only one is read", 8 * begin)
        signer = read_certificate(reader)
    signature, r_tag = read_signature(reader)
    return SignedMessage(generation_us, payload, signer, signature, psid=psid, r_tag=r_tag)


def _to_be_signed(generation_us: int, payload: bytes, psid: int) -> bytes:
    """ToBeSignedData: the payload, and the header with application and time."""
    return b"\x40" + encode_unsecured(payload) + b"\x40" + unsigned(psid) + generation_us.to_bytes(8, "big")
