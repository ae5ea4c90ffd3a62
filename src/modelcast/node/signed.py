"""Signed frames: what a node signs as it leaves, and verifies as it arrives."""

from typing import final

from modelcast.core.exceptions import CodecError
from modelcast.messages.ieee1609 import read_unsecured_head, unsecured_payload
from modelcast.messages.security.parameters import SecurityParameters
from modelcast.messages.security.signed import decode_signed
from modelcast.messages.security.signer import SignerState
from modelcast.messages.security.time64 import since_2004_s
from modelcast.messages.security.verifier import Outcome, Verifier, VerifierState
from modelcast.messages.wsmp import encode_wsm
from modelcast.node.credentials import Credentials
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
    credentials
        What it signs with, and whom it trusts.
    utc_at_zero_s
        UTC at time 0 of the node, since 1970 without leap seconds [s].
    required
        Whether what is not verified is refused. Where it is not, unsigned messages are taken and those of
        senders whom nobody vouches for, all counted as not verified; one that is forged is refused all the
        same.
    parameters
        Tolerances of time and limits of memory.

    Raises
    ------
    ValueError
        As for `Verifier`.
    """

    def __init__(
        self,
        credentials: Credentials,
        *,
        utc_at_zero_s: float,
        required: bool = True,
        parameters: SecurityParameters = _PARAMETERS,
    ) -> None:
        self._own, self._required = credentials.own, required
        self._at = 0
        self._attached = SignerState()
        self._zero_s = since_2004_s(utc_at_zero_s)
        self._verifier, self._held = Verifier(credentials.trusted, parameters), VerifierState()

    def wrap(self, octets: bytes, *, sent_s: float) -> bytes | None:
        """Return the message signed, with its head; None where no certificate is good now."""
        t_s = self._zero_s + sent_s
        if not self._own[self._at].certificate.is_good_at(t_s) and not self._next_good(t_s):
            return None
        signed, self._attached = self._own[self._at].sign(self._attached, octets, t_s=t_s)
        return encode_wsm(signed)

    def open(self, frame: bytes, *, received_s: float) -> Opened:
        """Return what is inside where it is verified, or taken unverified; else why not."""
        message = opened_safety(frame)
        if isinstance(message, Opened):
            return message
        try:
            if read_unsecured_head(message) is None:
                return self._verified(message, received_s)
            payload = unsecured_payload(message)
        except CodecError:
            return Opened(None, "no data of IEEE 1609.2")
        return Opened(None, "not signed") if self._required else Opened(payload, NOT_VERIFIED)

    def _verified(self, message: bytes, received_s: float) -> Opened:
        """Return what is signed, or why it is refused."""
        told = self._verifier.verify(self._held, message, t_s=self._zero_s + received_s)
        if told.outcome in _STRANGERS and not self._required:
            return Opened(decode_signed(message).payload, NOT_VERIFIED)
        return Opened(told.payload, told.outcome.value)

    def rename(self) -> None:
        """Sign with the next certificate from now on; the first message carries it."""
        self._at = (self._at + 1) % len(self._own)
        self._attached = SignerState()

    def _next_good(self, t_s: float) -> bool:
        """Go on to a certificate that is good now, if there is any."""
        for step in range(1, len(self._own)):
            at = (self._at + step) % len(self._own)
            if self._own[at].certificate.is_good_at(t_s):
                self._at, self._attached = at, SignerState()
                return True
        return False
