"""Who vouches for senders: a key with a certificate of its own, and the certificates it issues."""

from dataclasses import dataclass, replace

from modelcast.messages.psids import SAFETY_PSID
from modelcast.messages.security.certificate import SIGNATURE_OCTETS, Certificate, duration_unit
from modelcast.messages.security.p256 import PrivateKey

__all__ = ["Authority"]


@dataclass(frozen=True, slots=True)
class Authority:
    """A root: receivers that hold its certificate trust what it issues.

    There is one level: an authority issues to senders, and what a sender's key signs is no certificate.

    Parameters
    ----------
    key
        Its private key.
    certificate
        Its own certificate.

    Raises
    ------
    ValueError
        Where the certificate is of another key.
    """

    key: PrivateKey
    certificate: Certificate

    def __post_init__(self) -> None:
        if self.certificate.public_key != self.key.public_octets:
            raise ValueError("the certificate is of another key than the one given")

    @classmethod
    def create(cls, key: PrivateKey, *, start_s: int, duration_s: int) -> "Authority":
        """A new authority that issues its own certificate.

        Parameters
        ----------
        key
            Its private key.
        start_s, duration_s
            What its certificate is good for, whole seconds since the common instant.
        """
        return cls(key, _signed(key, None, key.public_octets, start_s=start_s, duration_s=duration_s))

    def issue(
        self,
        public_key: bytes,
        *,
        start_s: int,
        duration_s: int,
        psids: tuple[int, ...] = (SAFETY_PSID,),
    ) -> Certificate:
        """Certificate of a sender's key.

        Parameters
        ----------
        public_key
            The sender's, 33 octets.
        start_s, duration_s
            What it is good for, whole seconds since the common instant; inside the authority's own time.
        psids
            Applications that it is good for, one at least.

        Raises
        ------
        ValueError
            Where that time is not inside the authority's own.
        """
        own = self.certificate
        if not own.start_s <= start_s <= start_s + duration_s <= own.start_s + own.duration_s:
            raise ValueError(
                f"the authority is good from {own.start_s} s for {own.duration_s} s; "
                f"{start_s} s for {duration_s} s is not inside"
            )
        return _signed(self.key, own, public_key, start_s=start_s, duration_s=duration_s, psids=psids)


def _signed(
    key: PrivateKey,
    issuer: Certificate | None,
    public_key: bytes,
    *,
    start_s: int,
    duration_s: int,
    psids: tuple[int, ...] = (),
) -> Certificate:
    blank = Certificate(
        b"" if issuer is None else issuer.digest,
        start_s,
        duration_s=duration_s,
        public_key=public_key,
        signature=bytes(SIGNATURE_OCTETS),
        duration_unit=duration_unit(duration_s),
        psids=psids,
    )
    return replace(blank, signature=key.sign(blank.signed_part(issuer)))
