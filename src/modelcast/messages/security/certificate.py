"""A certificate: a public key, the time it is good for, and the signature of who vouches for it."""

import hashlib
from dataclasses import KW_ONLY, dataclass

from modelcast.core.exceptions import CodecError

__all__ = ["CERTIFICATE_OCTETS", "DIGEST_OCTETS", "KEY_OCTETS", "SIGNATURE_OCTETS", "Certificate"]

DIGEST_OCTETS = 8
KEY_OCTETS = 33
SIGNATURE_OCTETS = 64
_TIME_OCTETS = 4
_SIGNED_OCTETS = DIGEST_OCTETS + 2 * _TIME_OCTETS + KEY_OCTETS

CERTIFICATE_OCTETS = _SIGNED_OCTETS + SIGNATURE_OCTETS
"""113: every certificate takes as many."""

_LAST_S = 2**32 - 1
_COMPRESSED = (2, 3)


@dataclass(frozen=True, slots=True)
class Certificate:
    """An explicit certificate of one key, in an encoding of our own.

    =============  ======  ===================================================================
    part           octets
    =============  ======  ===================================================================
    issuer         8       digest of the issuer's certificate; zeros where it is its own issuer
    start          4       first second it is good for, since the common instant
    duration       4       seconds it is good for
    public key     33      compressed point of P-256
    signature      64      r and s, over all before
    =============  ======  ===================================================================

    Parameters
    ----------
    issuer
        The issuer's digest, 8 octets.
    start_s, duration_s
        Whole seconds; good from the start on for the duration, its end excluded.
    public_key
        33 octets, beginning with 2 or 3.
    signature
        By the issuer, 64 octets.

    Raises
    ------
    ValueError
        Where a part has another length, or a number does not fit.
    """

    issuer: bytes
    start_s: int
    _: KW_ONLY
    duration_s: int
    public_key: bytes
    signature: bytes

    def __post_init__(self) -> None:
        for name, octets in (
            ("issuer", DIGEST_OCTETS),
            ("public_key", KEY_OCTETS),
            ("signature", SIGNATURE_OCTETS),
        ):
            if len(getattr(self, name)) != octets:
                raise ValueError(f"{name} must have {octets} octets, got {len(getattr(self, name))}")
        if self.public_key[0] not in _COMPRESSED:
            raise ValueError(f"public_key must be a compressed point: 2 or 3 first, got {self.public_key[0]}")
        for name in ("start_s", "duration_s"):
            if not 0 <= getattr(self, name) <= _LAST_S:
                raise ValueError(f"{name} must be from 0 to {_LAST_S}, got {getattr(self, name)}")

    @property
    def signed_part(self) -> bytes:
        """What the issuer signs: all but the signature."""
        times = self.start_s.to_bytes(_TIME_OCTETS, "big") + self.duration_s.to_bytes(_TIME_OCTETS, "big")
        return self.issuer + times + self.public_key

    @property
    def octets(self) -> bytes:
        """All of it, `CERTIFICATE_OCTETS` long."""
        return self.signed_part + self.signature

    @property
    def digest(self) -> bytes:
        """Last 8 octets of its SHA-256, as HashedId8 of IEEE 1609.2."""
        return hashlib.sha256(self.octets).digest()[-DIGEST_OCTETS:]

    def is_good_at(self, t_s: float) -> bool:
        """Whether a time lies in its duration.

        Parameters
        ----------
        t_s
            Time since the common instant [s].
        """
        return self.start_s <= t_s < self.start_s + self.duration_s

    @classmethod
    def from_octets(cls, octets: bytes, offset_bits: int = 0) -> "Certificate":
        """The certificate in octets.

        Parameters
        ----------
        octets
            All of it and nothing else.
        offset_bits
            Where it begins in what was received.

        Raises
        ------
        CodecError
            Where the length is another, or the key is no compressed point.
        """
        if len(octets) != CERTIFICATE_OCTETS:
            raise CodecError(
                f"a certificate of {len(octets)} octets instead of {CERTIFICATE_OCTETS}", offset_bits
            )
        times_at, key_at = DIGEST_OCTETS, DIGEST_OCTETS + 2 * _TIME_OCTETS
        if octets[key_at] not in _COMPRESSED:
            raise CodecError(
                f"a public key that begins with {octets[key_at]}, not 2 or 3", offset_bits + 8 * key_at
            )
        return cls(
            octets[:DIGEST_OCTETS],
            int.from_bytes(octets[times_at : times_at + _TIME_OCTETS], "big"),
            duration_s=int.from_bytes(octets[times_at + _TIME_OCTETS : key_at], "big"),
            public_key=octets[key_at : key_at + KEY_OCTETS],
            signature=octets[-SIGNATURE_OCTETS:],
        )
