"""The receiving side: what became of a signed message, and its payload where all is well."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from enum import Enum
from types import MappingProxyType

from modelcast.messages.psids import SAFETY_PSID
from modelcast.messages.security.certificate import Certificate
from modelcast.messages.security.p256 import PublicKey
from modelcast.messages.security.parameters import DEFAULT_PARAMETERS, SecurityParameters
from modelcast.messages.security.replay import ReplayWindow
from modelcast.messages.security.signed import SignedMessage, decode_signed, signed_part_of
from modelcast.messages.security.store import CertificateStore, Sender
from modelcast.messages.security.time64 import SECONDS, microseconds

__all__ = ["Outcome", "Verification", "Verifier", "VerifierState"]


class Outcome(Enum):
    """What became of a signed message; tests are made in this order, the first that fails counts."""

    ACCEPTED = "accepted"
    TOO_OLD = "generated too long ago"
    IN_FUTURE = "generated in the future"
    UNKNOWN_CERTIFICATE = "digest of a certificate not held"
    UNTRUSTED_CERTIFICATE = "certificate not issued by a trusted authority"
    NOT_PERMITTED = "certificate not for this application"
    EXPIRED = "certificate, or its issuer's, not good at the time"
    REPLAYED = "seen before, or too old to tell"
    BAD_SIGNATURE = "signature does not fit"


@dataclass(frozen=True, slots=True)
class Verification:
    """The outcome for one message.

    Parameters
    ----------
    outcome
        What became of it.
    sender
        Digest of the certificate that it names; proved only where accepted.
    generation_s
        When it says it was signed, since the common instant [s].
    payload
        What was signed; None unless accepted.
    psid
        The application that it was signed for; proved only where accepted.
    """

    outcome: Outcome
    sender: bytes
    _: KW_ONLY
    generation_s: float
    payload: bytes | None = None
    psid: int = SAFETY_PSID


@dataclass(slots=True)
class VerifierState:
    """Certificates learnt, and what each sender sent lately, by digest of its certificate.

    It is owned by whoever verifies with it: each message that is accepted changes it, at a cost that does not
    depend on how many senders there are.

    Parameters
    ----------
    store
        Certificates learnt.
    windows
        Messages of each sender, as many senders at most as there may be certificates.
    floor_us
        A sender without a window is taken at generation times after this only: windows that reached up to it
        were forgotten.
    """

    store: CertificateStore = field(default_factory=CertificateStore)
    windows: dict[bytes, ReplayWindow] = field(default_factory=dict[bytes, ReplayWindow])
    floor_us: int = -1


@dataclass(frozen=True, slots=True)
class Verifier:
    """Verifies signed messages of all senders.

    Only a message that is accepted changes the state: so nobody fills the store, or moves a replay window,
    without a key that an authority vouched for.

    Parameters
    ----------
    authorities
        Certificates whose issue is trusted. How they came here is the caller's business.
    parameters
        Tolerances of time and limits of memory.

    Raises
    ------
    ValueError
        Where an authority's key is no point of the curve.
    """

    authorities: tuple[Certificate, ...]
    parameters: SecurityParameters = DEFAULT_PARAMETERS
    _trusted: Mapping[bytes, Sender] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        trusted = {one.digest: Sender(one, PublicKey(one.public_key)) for one in self.authorities}
        object.__setattr__(self, "_trusted", MappingProxyType(trusted))

    def verify(self, state: VerifierState, octets: bytes, *, t_s: float) -> Verification:
        """Take one message in, and return what became of it.

        Parameters
        ----------
        state
            What is held; changed where the message is accepted.
        octets
            As they arrived.
        t_s
            Now, since the common instant [s]. It may go back: what was forgotten is judged by generation
            times alone, so that no message is accepted twice whatever the clock does.

        Raises
        ------
        CodecError
            Where the octets are no signed message.
        """
        message = decode_signed(octets)
        now_us = microseconds(t_s)
        outcome = self._timely(message, now_us)
        sender = state.store.get(message.digest)
        if outcome is None and sender is None and isinstance(message.signer, Certificate):
            sender = self._vouched(message.signer)
            outcome = Outcome.UNTRUSTED_CERTIFICATE if sender is None else None
        if outcome is None:
            if sender is None:
                outcome = Outcome.UNKNOWN_CERTIFICATE
            else:
                outcome = self._judge(state, message, sender, now_us)
        payload = message.payload if outcome is Outcome.ACCEPTED else None
        when_s = message.generation_us / SECONDS
        return Verification(outcome, message.digest, generation_s=when_s, payload=payload, psid=message.psid)

    def _timely(self, message: SignedMessage, now_us: int) -> Outcome | None:
        if message.generation_us > now_us + round(self.parameters.max_ahead_s * SECONDS):
            return Outcome.IN_FUTURE
        if message.generation_us < self._oldest_us(now_us):
            return Outcome.TOO_OLD
        return None

    def _oldest_us(self, now_us: int) -> int:
        return now_us - round(self.parameters.max_age_s * SECONDS)

    def _vouched(self, certificate: Certificate) -> Sender | None:
        """The sender of a certificate that a trusted authority issued."""
        authority = self._trusted.get(certificate.issuer)
        if authority is None or authority.certificate.psids or not certificate.psids:
            return None
        signed = certificate.signed_part(authority.certificate)
        if not authority.key.verifies(signed, certificate.signature):
            return None
        try:
            key = PublicKey(certificate.public_key)
        except ValueError:  # an authority that signed what is no point of the curve
            return None
        return Sender(certificate, key)

    def _judge(self, state: VerifierState, message: SignedMessage, sender: Sender, now_us: int) -> Outcome:
        certificate = sender.certificate
        issuer = self._trusted.get(certificate.issuer)
        times_s = (message.generation_us / SECONDS, now_us / SECONDS)
        if issuer is None:
            return Outcome.UNTRUSTED_CERTIFICATE
        if message.psid not in certificate.psids:
            return Outcome.NOT_PERMITTED
        if not all(one.is_good_at(t_s) for one in (certificate, issuer.certificate) for t_s in times_s):
            return Outcome.EXPIRED
        content = signed_part_of(
            message.generation_us, message.payload, sender.certificate_hash, psid=message.psid
        )
        window = state.windows.get(message.digest, ReplayWindow(floor_us=state.floor_us))
        if window.holds(message.generation_us, content):
            return Outcome.REPLAYED
        if not sender.key.verifies(content, message.signature):
            return Outcome.BAD_SIGNATURE
        self._take(state, message, sender, content, now_us)
        return Outcome.ACCEPTED

    def _take(
        self, state: VerifierState, message: SignedMessage, sender: Sender, content: bytes, now_us: int
    ) -> None:
        digest = message.digest
        if state.store.get(digest) is not sender:
            state.store = state.store.add(sender, self.parameters.certificates, t_s=now_us / SECONDS)
        windows = state.windows
        window = windows.get(digest)
        if window is None:
            # A sender appears: a good moment to forget those of whom any message would be too old now.
            window = ReplayWindow(floor_us=state.floor_us)
            oldest_us = self._oldest_us(now_us)
            by_time = sorted(windows, key=lambda one: windows[one].newest_us)
            too_many = len(windows) + 1 - self.parameters.certificates
            for rank, one in enumerate(by_time):
                if rank >= too_many and windows[one].newest_us >= oldest_us:
                    break
                state.floor_us = max(state.floor_us, windows.pop(one).newest_us)
        windows[digest] = window.admit(message.generation_us, content, self.parameters.remembered)
