"""The certificates of senders that a receiver has verified, by digest."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from modelcast.messages.security.certificate import Certificate
from modelcast.messages.security.p256 import PublicKey

__all__ = ["CertificateStore", "Sender"]


@dataclass(frozen=True, slots=True)
class Sender:
    """A verified certificate with its key made ready.

    Parameters
    ----------
    certificate
        As it arrived.
    key
        Its public key.
    """

    certificate: Certificate
    key: PublicKey
    certificate_hash: bytes = field(init=False, repr=False)
    """SHA-256 of the certificate, which goes into all that it signs."""

    def __post_init__(self) -> None:
        own = hashlib.sha256(self.certificate.canonical).digest()
        object.__setattr__(self, "certificate_hash", own)


def _nobody() -> Mapping[bytes, Sender]:
    return MappingProxyType({})


@dataclass(frozen=True, slots=True)
class CertificateStore:
    """Senders by the digest of their certificate, in the order in which they came."""

    senders: Mapping[bytes, Sender] = field(default_factory=_nobody)

    def get(self, digest: bytes) -> Sender | None:
        """The sender, where held.

        Parameters
        ----------
        digest
            Of its certificate, 8 octets.
        """
        return self.senders.get(digest)

    def add(self, sender: Sender, limit: int, *, t_s: float) -> "CertificateStore":
        """The store with one more sender, without expired ones; beyond the limit the first to come go.

        Parameters
        ----------
        sender
            A sender whose certificate was verified.
        limit
            Senders held at most.
        t_s
            Now, since the common instant [s].
        """
        kept = {
            digest: held
            for digest, held in self.senders.items()
            if t_s < held.certificate.start_s + held.certificate.duration_s
        }
        kept[sender.certificate.digest] = sender
        return CertificateStore(MappingProxyType(dict(list(kept.items())[-limit:])))
