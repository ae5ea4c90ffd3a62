"""The sending side: sign a payload, and attach the certificate when it is due."""

from dataclasses import dataclass

from modelcast.messages.psids import SAFETY_PSID
from modelcast.messages.security.certificate import Certificate
from modelcast.messages.security.p256 import PrivateKey
from modelcast.messages.security.parameters import DEFAULT_PARAMETERS, SecurityParameters
from modelcast.messages.security.signed import SignedMessage, signed_part
from modelcast.messages.security.time64 import SECONDS, microseconds

__all__ = ["Signer", "SignerState"]


@dataclass(frozen=True, slots=True)
class SignerState:
    """What a signer remembers.

    Parameters
    ----------
    attached_us
        When the certificate last went along [µs since the common instant]; None for never.
    """

    attached_us: int | None = None


@dataclass(frozen=True, slots=True)
class Signer:
    """Signs the payloads of one sender.

    The certificate goes along with the first message, and whenever more than ``certificate_interval_s``
    passed since it last did; its digest goes along with the others.

    Parameters
    ----------
    key
        The sender's private key.
    certificate
        Its certificate.
    parameters
        The rule of the certificate.

    Raises
    ------
    ValueError
        Where the certificate is of another key.

    Examples
    --------
    >>> from modelcast.messages.security.authority import Authority
    >>> from modelcast.messages.security.verifier import Verifier, VerifierState
    >>> authority = Authority.create(PrivateKey(1), start_s=0, duration_s=3600)
    >>> key = PrivateKey(2)
    >>> signer = Signer(key, authority.issue(key.public_octets, start_s=0, duration_s=600))
    >>> octets, state = signer.sign(SignerState(), b"payload", t_s=10.0)
    >>> verifier = Verifier((authority.certificate,))
    >>> verified = verifier.verify(VerifierState(), octets, t_s=10.01)
    >>> verified.outcome.name, verified.payload
    ('ACCEPTED', b'payload')
    >>> len(octets), len(signer.sign(state, b"payload", t_s=10.4)[0])
    (226, 100)
    """

    key: PrivateKey
    certificate: Certificate
    parameters: SecurityParameters = DEFAULT_PARAMETERS

    def __post_init__(self) -> None:
        if self.certificate.public_key != self.key.public_octets:
            raise ValueError("the certificate is of another key than the one given")

    def sign(
        self, state: SignerState, payload: bytes, *, t_s: float, psid: int = SAFETY_PSID
    ) -> tuple[bytes, SignerState]:
        """Octets of the signed message, and the new state.

        Parameters
        ----------
        state
            When the certificate last went along.
        payload
            1 to 2,304 octets less what goes round them.
        t_s
            Now, since the common instant [s].
        psid
            The application; whether the certificate is good for it is for receivers to judge.

        Raises
        ------
        ValueError
            Where the payload is too long or empty, or the certificate is not good now.
        """
        now_us = microseconds(t_s)
        if not self.certificate.is_good_at(now_us / SECONDS):
            own = self.certificate
            raise ValueError(
                f"the certificate is good from {own.start_s} s for {own.duration_s} s, not at {t_s} s"
            )
        last_us = state.attached_us
        due = last_us is None or now_us - last_us > round(self.parameters.certificate_interval_s * SECONDS)
        signature = self.key.sign(signed_part(now_us, payload, self.certificate, psid=psid))
        signer = self.certificate if due else self.certificate.digest
        message = SignedMessage(now_us, payload, signer, signature, psid=psid)
        return message.octets, SignerState(now_us) if due else state
