"""An explicit certificate of IEEE 1609.2: a public key, what it may be used for, and who vouches for it."""

import hashlib
from dataclasses import KW_ONLY, dataclass
from typing import Literal, get_args

from modelcast.core.exceptions import CodecError
from modelcast.messages.psids import SAFETY_PSID
from modelcast.messages.security.coer import CoerReader, counted, unsigned

__all__ = [
    "DIGEST_OCTETS",
    "KEY_OCTETS",
    "SIGNATURE_OCTETS",
    "X_ONLY",
    "Certificate",
    "DurationUnit",
    "duration_unit",
    "read_certificate",
    "read_signature",
    "signature_octets",
]

DIGEST_OCTETS = 8
KEY_OCTETS = 33
SIGNATURE_OCTETS = 64

X_ONLY = 0x80
"""Tag of a point of which the x coordinate alone is given."""

DurationUnit = Literal["seconds", "minutes", "hours", "sixtyHours", "years"]
_UNITS_S: dict[DurationUnit, int] = {
    "seconds": 1,
    "minutes": 60,
    "hours": 3600,
    "sixtyHours": 216_000,
    "years": 31_556_952,
}
_FIRST_UNIT_TAG = 0x82
_LAST_COUNT = 2**16 - 1
_LAST_S = 2**32 - 1
_HALF = SIGNATURE_OCTETS // 2
_COMPRESSED = (2, 3)
_R_TAGS = (X_ONLY, 0x82, 0x83)
_SENDER, _AUTHORITY = 0x10, 0x08
_ISSUES_ALL = bytes.fromhex("01010081")
_MOST_NAME_OCTETS = 255
_MOST_PSIDS = 16


@dataclass(frozen=True, slots=True)
class Certificate:
    """An explicit certificate of one ECDSA key on P-256, as `docs/wire.md` tells its octets.

    Parameters
    ----------
    issuer
        HashedId8 of the issuer's certificate; no octets where it is its own issuer.
    start_s
        First second it is good for, since 2004-01-01 00:00 UTC, leap seconds counted.
    duration_s
        Good from the start on for as many seconds, the end excluded: at most 65,535 of the unit.
    public_key
        Compressed point: 33 octets, beginning with 2 or 3.
    signature
        By the issuer: r and s, 32 octets each.
    duration_unit
        Unit in which the wire counts the duration.
    psids
        Applications for which the key may sign, 16 at most, without service-specific permissions; none for an
        authority, which issues certificates and signs nothing else.
    name
        A name; None for a certificate without one.
    craca_id, crl_series
        Who would revoke it, 3 octets, and in which series.
    r_tag
        Form of the signature's r on the wire: 80 x alone, 82 or 83 a compressed point.

    Raises
    ------
    ValueError
        Where a part has another length, or a number does not fit.

    References
    ----------
    IEEE Std 1609.2-2016: ExplicitCertificate, 6.4.6; ToBeSignedCertificate, 6.4.8.
    """

    issuer: bytes
    start_s: int
    _: KW_ONLY
    duration_s: int
    public_key: bytes
    signature: bytes
    duration_unit: DurationUnit = "seconds"
    psids: tuple[int, ...] = (SAFETY_PSID,)
    name: str | None = None
    craca_id: bytes = bytes(3)
    crl_series: int = 0
    r_tag: int = X_ONLY

    def __post_init__(self) -> None:
        if len(self.issuer) not in (0, DIGEST_OCTETS):
            raise ValueError(f"issuer must have {DIGEST_OCTETS} octets or none, got {len(self.issuer)}")
        for name, octets in (("public_key", KEY_OCTETS), ("signature", SIGNATURE_OCTETS), ("craca_id", 3)):
            if len(getattr(self, name)) != octets:
                raise ValueError(f"{name} must have {octets} octets, got {len(getattr(self, name))}")
        if self.public_key[0] not in _COMPRESSED:
            raise ValueError(f"public_key must be a compressed point: 2 or 3 first, got {self.public_key[0]}")
        self._check_times()
        if len(self.psids) > _MOST_PSIDS or not all(0 <= psid <= _LAST_S for psid in self.psids):
            raise ValueError(f"psids must be {_MOST_PSIDS} at most, each from 0 to {_LAST_S}")
        if len((self.name or "").encode()) > _MOST_NAME_OCTETS:
            raise ValueError(f"name must have {_MOST_NAME_OCTETS} octets at most")
        if not 0 <= self.crl_series <= _LAST_COUNT:
            raise ValueError(f"crl_series must be from 0 to {_LAST_COUNT}, got {self.crl_series}")
        if self.r_tag not in _R_TAGS:
            raise ValueError(f"r_tag must be one of {_R_TAGS}, got {self.r_tag}")

    def _check_times(self) -> None:
        if not 0 <= self.start_s <= _LAST_S:
            raise ValueError(f"start_s must be from 0 to {_LAST_S}, got {self.start_s}")
        if self.duration_unit not in get_args(DurationUnit):
            known = ", ".join(get_args(DurationUnit))
            raise ValueError(f"duration_unit must be one of {known}, got {self.duration_unit!r}")
        unit_s = _UNITS_S[self.duration_unit]
        if self.duration_s % unit_s or not 0 <= self.duration_s <= _LAST_COUNT * unit_s:
            raise ValueError(
                f"duration_s must be a multiple of {unit_s} from 0 to {_LAST_COUNT * unit_s}, "
                f"got {self.duration_s}"
            )

    @property
    def to_be_signed(self) -> bytes:
        """ToBeSignedCertificate: what the issuer's hash begins with."""
        name = b"\x83" if self.name is None else b"\x81" + counted(self.name.encode())
        unit = get_args(DurationUnit).index(self.duration_unit)
        count = self.duration_s // _UNITS_S[self.duration_unit]
        duration = bytes([_FIRST_UNIT_TAG + unit]) + count.to_bytes(2, "big")
        rights = _ISSUES_ALL
        if self.psids:
            rights = unsigned(len(self.psids)) + b"".join(b"\0" + unsigned(psid) for psid in self.psids)
        return (
            bytes([_SENDER if self.psids else _AUTHORITY])
            + name
            + self.craca_id
            + self.crl_series.to_bytes(2, "big")
            + self.start_s.to_bytes(4, "big")
            + duration
            + rights
            + bytes([0x80, 0x80, X_ONLY + self.public_key[0]])
            + self.public_key[1:]
        )

    def signed_part(self, issuer: "Certificate | None") -> bytes:
        """What the issuer signs, 64 octets: hash of `to_be_signed`, hash of the issuer's certificate.

        Parameters
        ----------
        issuer
            Its certificate; None where the certificate is its own issuer.

        References
        ----------
        IEEE Std 1609.2-2016, 5.3.1.
        """
        who = b"" if issuer is None else issuer.canonical
        return hashlib.sha256(self.to_be_signed).digest() + hashlib.sha256(who).digest()

    @property
    def octets(self) -> bytes:
        """All of it as it goes on the air."""
        return self._octets(self.r_tag)

    @property
    def canonical(self) -> bytes:
        """Its octets as they are hashed: with the x coordinate alone of the signature's r."""
        return self._octets(X_ONLY)

    def _octets(self, r_tag: int) -> bytes:
        issuer = b"\x80" + self.issuer if self.issuer else b"\x81\0"
        return b"\x80\3\0" + issuer + self.to_be_signed + signature_octets(self.signature, r_tag)

    @property
    def digest(self) -> bytes:
        """HashedId8: the last 8 octets of its SHA-256 (IEEE Std 1609.2-2016, 6.3.26)."""
        return hashlib.sha256(self.canonical).digest()[-DIGEST_OCTETS:]

    def is_good_at(self, t_s: float) -> bool:
        """Whether a time lies in its duration.

        Parameters
        ----------
        t_s
            Time since 2004-01-01 00:00 UTC, leap seconds counted [s].
        """
        return self.start_s <= t_s < self.start_s + self.duration_s

    @classmethod
    def from_octets(cls, octets: bytes) -> "Certificate":
        """The certificate in octets.

        Parameters
        ----------
        octets
            All of it and nothing else.

        Raises
        ------
        CodecError
            Where they are no certificate of the kind that is read here.
        """
        reader = CoerReader(octets)
        certificate = read_certificate(reader)
        reader.finish()
        return certificate


def duration_unit(duration_s: int) -> DurationUnit:
    """The smallest unit that counts a duration in 16 bits.

    Parameters
    ----------
    duration_s
        Whole seconds.

    Raises
    ------
    ValueError
        Where none counts it exactly.

    Examples
    --------
    >>> duration_unit(600), duration_unit(7 * 86_400)
    ('seconds', 'minutes')
    """
    for unit, unit_s in _UNITS_S.items():
        if duration_s % unit_s == 0 and 0 <= duration_s <= _LAST_COUNT * unit_s:
            return unit
    raise ValueError(f"duration_s must be up to 65,535 whole seconds, minutes or hours, got {duration_s}")


def signature_octets(signature: bytes, r_tag: int) -> bytes:
    """Octets of Signature, its choice ecdsaNistP256Signature.

    Parameters
    ----------
    signature
        r and s, 32 octets each.
    r_tag
        Form of r: 80 x alone, 82 or 83 a compressed point.
    """
    return bytes([0x80, r_tag]) + signature


def read_signature(reader: CoerReader) -> tuple[bytes, int]:
    """Read a Signature: r and s, and the form of r.

    Parameters
    ----------
    reader
        At its first octet.

    Raises
    ------
    CodecError
        Where it is of another curve, or r in another form, or it is cut short.
    """
    reader.one_of((0x80,), "signature of kind")
    r_tag = reader.one_of(_R_TAGS, "r in form")
    return reader.octets(SIGNATURE_OCTETS), r_tag


def read_certificate(reader: CoerReader) -> Certificate:
    """Read an explicit certificate.

    Parameters
    ----------
    reader
        At its first octet.

    Raises
    ------
    CodecError
        Where it is cut short, not canonical, or has parts that are not read here.
    """
    reader.one_of((0x80,), "certificate with the parts")
    reader.one_of((3,), "certificate of version")
    reader.one_of((0,), "certificate of type")
    issuer = b""
    if reader.one_of((0x80, 0x81), "issuer of kind") == X_ONLY:
        issuer = reader.octets(DIGEST_OCTETS)
    else:
        reader.one_of((0,), "issuer's hash of kind")
    parts = reader.one_of((_SENDER, _AUTHORITY), "certificate's contents with the parts")
    name = None
    if reader.one_of((0x81, 0x83), "certificate's id of kind") == 0x81:
        name = _name(reader)
    craca_id, crl_series, start_s = reader.octets(3), reader.number(2), reader.number(4)
    units = get_args(DurationUnit)
    tags = tuple(range(_FIRST_UNIT_TAG, _FIRST_UNIT_TAG + len(units)))
    unit: DurationUnit = units[reader.one_of(tags, "duration in the unit") - _FIRST_UNIT_TAG]
    duration_s = reader.number(2) * _UNITS_S[unit]
    psids = _psids(reader) if parts == _SENDER else ()
    if parts == _AUTHORITY:
        for octet in _ISSUES_ALL:
            reader.one_of((octet,), "permission to issue")
    reader.one_of((0x80,), "key indicator of kind")
    reader.one_of((0x80,), "key of kind")
    sign = reader.one_of((0x82, 0x83), "key in the form")
    public_key = bytes([sign - X_ONLY]) + reader.octets(KEY_OCTETS - 1)
    signature, r_tag = read_signature(reader)
    return Certificate(
        issuer,
        start_s,
        duration_s=duration_s,
        public_key=public_key,
        signature=signature,
        duration_unit=unit,
        psids=psids,
        name=name,
        craca_id=craca_id,
        crl_series=crl_series,
        r_tag=r_tag,
    )


def _name(reader: CoerReader) -> str:
    begin = reader.position
    octets = reader.counted()
    if len(octets) > _MOST_NAME_OCTETS:
        raise CodecError(f"a name of {len(octets)} octets", 8 * begin)
    try:
        return octets.decode()
    except UnicodeDecodeError as error:
        raise CodecError("a name that is not UTF-8", 8 * begin) from error


def _psids(reader: CoerReader) -> tuple[int, ...]:
    begin = reader.position
    count = reader.unsigned()
    if not 1 <= count <= _MOST_PSIDS:
        raise CodecError(f"permissions for {count} applications, 1 to {_MOST_PSIDS} are read", 8 * begin)
    psids: list[int] = []
    for _ in range(count):
        begin = reader.position
        reader.one_of((0,), "permission with the parts")
        psid = reader.unsigned()
        if psid > _LAST_S:
            raise CodecError(f"application {psid}", 8 * begin)
        psids.append(psid)
    return tuple(psids)
