"""Signed frames: what a node signs as it leaves, and verifies as it arrives."""

from collections.abc import Sequence
from typing import final

from modelcast.core.exceptions import CodecError
from modelcast.messages.belonging import belongs_to, psid_of
from modelcast.messages.ieee1609 import read_unsecured_head, unsecured_payload
from modelcast.messages.psids import SAFETY_PSID
from modelcast.messages.security.certificate import Certificate
from modelcast.messages.security.parameters import SecurityParameters
from modelcast.messages.security.signed import decode_signed
from modelcast.messages.security.signer import Signer, SignerState
from modelcast.messages.security.time64 import since_2004_s
from modelcast.messages.security.verifier import Outcome, Verifier, VerifierState
from modelcast.messages.wsmp import ShortMessage, encode_wsm
from modelcast.node.envelope import NOT_VERIFIED, AbstractEnvelope, Opened, opened_safety

__all__ = ["Signed"]

_PARAMETERS = SecurityParameters(certificates=4096)
"""A host hears a thousand others, each under more than one name in the time that certificates are held."""

_STRANGERS = frozenset({Outcome.UNKNOWN_CERTIFICATE, Outcome.UNTRUSTED_CERTIFICATE})


@final
class Signed(AbstractEnvelope):
    """A WAVE short message with signed IEEE 1609.2 data (docs/wire.md).

    Parameters
    ----------
    trusted
        Certificates of authorities.
    own
        A signer a pseudonym. Where only a certificate is known, as in a replay, what it would sign leaves as
        it is.
    utc_at_zero_s
        UTC at time 0 of the node, since 1970 without leap seconds [s].
    first
        Which of its own signs first. A node draws it: its starts are not known by one certificate.
    psid
        The application that the station speaks in.
    required
        Whether what is not verified is refused. Where it is not, unsigned messages are taken and those of
        senders whom nobody vouches for, all counted as not verified; one that is forged is refused all the
        same.
    parameters
        Tolerances of time and limits of memory.

    Raises
    ------
    ValueError
        Where there is nothing to sign with, or as for `Verifier`.
    """

    def __init__(
        self,
        trusted: Sequence[Certificate],
        own: Sequence[Signer | Certificate],
        *,
        utc_at_zero_s: float,
        first: int = 0,
        psid: int = SAFETY_PSID,
        required: bool = True,
        parameters: SecurityParameters = _PARAMETERS,
    ) -> None:
        if not own:
            raise ValueError("own must hold one at least")
        self._own, self._required = tuple(own), required
        self._at = first % len(self._own)
        self._attached, self._psid = SignerState(), psid
        self._zero_s = since_2004_s(utc_at_zero_s)
        self._verifier, self._held = Verifier(tuple(trusted), parameters), VerifierState()

    def wrap(self, octets: bytes, *, sent_s: float) -> bytes | None:
        """Return the message signed, with its head; None where no certificate is good now."""
        t_s, psid = self._zero_s + sent_s, psid_of(octets, self._psid)
        if not self._is_good(self._at, t_s, psid) and not self._next_good(t_s, psid):
            return None
        own = self._own[self._at]
        if isinstance(own, Certificate):
            return octets
        signed, self._attached = own.sign(self._attached, octets, t_s=t_s, psid=psid)
        return encode_wsm(signed, psid)

    def open(self, frame: bytes, *, received_s: float) -> Opened:
        """Return what is inside where it is verified, or taken unverified; else why not."""
        short = opened_safety(frame)
        if isinstance(short, Opened):
            return short
        try:
            if read_unsecured_head(short.payload) is None:
                return self._verified(short, received_s)
            payload = unsecured_payload(short.payload)
        except CodecError:
            return Opened(None, "no data of IEEE 1609.2")
        if self._required:
            return Opened(None, "not signed")
        return _unverified(payload, short.psid)

    def _verified(self, short: ShortMessage, received_s: float) -> Opened:
        """Return what is signed in a short message, or why it is refused."""
        told = self._verifier.verify(self._held, short.payload, t_s=self._zero_s + received_s)
        if told.outcome in _STRANGERS and not self._required:
            opened = _unverified(decode_signed(short.payload).payload, told.psid)
        elif told.payload is not None and not belongs_to(told.payload, told.psid):
            opened = Opened(None, Outcome.NOT_PERMITTED.value)
        else:
            opened = Opened(told.payload, told.outcome.value)
        if opened.octets is not None and told.psid != short.psid:
            return Opened(None, "another application")
        return opened

    def rename(self) -> None:
        """Sign with the next certificate from now on; the first message carries it."""
        self._at = (self._at + 1) % len(self._own)
        self._attached = SignerState()

    def _is_good(self, at: int, t_s: float, psid: int) -> bool:
        own = self._own[at]
        certificate = own if isinstance(own, Certificate) else own.certificate
        return psid in certificate.psids and certificate.is_good_at(t_s)

    def _next_good(self, t_s: float, psid: int) -> bool:
        """Go on to a certificate that is good now for an application, if there is any."""
        for step in range(1, len(self._own)):
            at = (self._at + step) % len(self._own)
            if self._is_good(at, t_s, psid):
                self._at, self._attached = at, SignerState()
                return True
        return False


def _unverified(octets: bytes, psid: int) -> Opened:
    """A message of which nobody knows whose it is, where it belongs to its application."""
    taken = belongs_to(octets, psid)
    return Opened(octets, NOT_VERIFIED) if taken else Opened(None, Outcome.NOT_PERMITTED.value)
