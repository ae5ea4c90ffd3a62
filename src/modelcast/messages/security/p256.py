"""ECDSA over P-256 with SHA-256: the one module that imports the ``cryptography`` package.

Keys and signatures go in and out as octets of fixed length. Signing is deterministic (RFC 6979): the same key
and octets give the same signature, and no random number can betray the key.
"""

from dataclasses import dataclass, field

from modelcast.core.exceptions import MissingExtraError

try:
    from cryptography.exceptions import InvalidSignature
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.hazmat.primitives.asymmetric.utils import decode_dss_signature, encode_dss_signature
    from cryptography.hazmat.primitives.hashes import SHA256
    from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat
except ImportError as error:
    raise MissingExtraError("signing", "node") from error

__all__ = ["SECRET_OCTETS", "SEED_OCTETS", "PrivateKey", "PublicKey"]

_ORDER = 0xFFFFFFFF_00000000_FFFFFFFF_FFFFFFFF_BCE6FAAD_A7179E84_F3B9CAC2_FC632551
"""Order of the group, SP 800-186 3.2.1.3."""

SECRET_OCTETS = 32
SEED_OCTETS = 48
_SIGNING = ec.ECDSA(SHA256(), deterministic_signing=True)
_VERIFYING = ec.ECDSA(SHA256())


@dataclass(frozen=True, slots=True)
class PublicKey:
    """A point of the curve; signatures are checked against it.

    Parameters
    ----------
    octets
        The compressed point, 33 octets.

    Raises
    ------
    ValueError
        Where they are no point of the curve.
    """

    octets: bytes
    _key: ec.EllipticCurvePublicKey = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        try:
            key = ec.EllipticCurvePublicKey.from_encoded_point(ec.SECP256R1(), self.octets)
        except ValueError as error:
            raise ValueError(f"octets must be a point of P-256, got {self.octets.hex()}") from error
        object.__setattr__(self, "_key", key)

    def verifies(self, data: bytes, signature: bytes) -> bool:
        """Whether a signature over these octets was made with the private key.

        Parameters
        ----------
        data
            What was signed.
        signature
            r and s, 32 octets each.
        """
        r = int.from_bytes(signature[:SECRET_OCTETS], "big") % _ORDER  # of a point, x goes on the air
        s = int.from_bytes(signature[SECRET_OCTETS:], "big")
        try:
            self._key.verify(encode_dss_signature(r, s), data, _VERIFYING)
        except InvalidSignature:
            return False
        return True


@dataclass(frozen=True, slots=True)
class PrivateKey:
    """A secret number from 1 to the order less one; it never shows in ``repr``.

    Parameters
    ----------
    secret
        The number.

    Raises
    ------
    ValueError
        Where it is out of range.
    """

    secret: int = field(repr=False)
    _key: ec.EllipticCurvePrivateKey = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not 1 <= self.secret < _ORDER:
            raise ValueError("secret must be from 1 to the order of P-256 less one")
        object.__setattr__(self, "_key", ec.derive_private_key(self.secret, ec.SECP256R1()))

    @classmethod
    def from_random(cls, octets: bytes) -> "PrivateKey":
        """The key of 48 random octets (FIPS 186-5 A.2.1), drawn by the caller: ``os.urandom(48)`` say.

        Parameters
        ----------
        octets
            The random octets.

        Raises
        ------
        ValueError
            Where they are not 48.
        """
        if len(octets) != SEED_OCTETS:
            raise ValueError(f"{SEED_OCTETS} random octets are needed, got {len(octets)}")
        return cls(int.from_bytes(octets, "big") % (_ORDER - 1) + 1)

    @property
    def public_octets(self) -> bytes:
        """The public key, a compressed point of 33 octets."""
        return self._key.public_key().public_bytes(Encoding.X962, PublicFormat.CompressedPoint)

    def sign(self, data: bytes) -> bytes:
        """Signature over octets: r and s, 32 octets each.

        Parameters
        ----------
        data
            What to sign; hashed with SHA-256 first.
        """
        r, s = decode_dss_signature(self._key.sign(data, _SIGNING))
        return r.to_bytes(SECRET_OCTETS, "big") + s.to_bytes(SECRET_OCTETS, "big")
