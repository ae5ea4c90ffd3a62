"""What a message costs on the air: one stated table of what goes round its payload, and its duration.

The table is that of a WAVE short message on IEEE 802.11p, 10 MHz, at 6 Mb/s. Who gets a message can only
check its signature with the sender's certificate, so that some messages carry it, and all others its digest.
"""

from dataclasses import KW_ONLY, dataclass
from typing import get_args

import numpy as np

from modelcast.channel.airtime_kernels import frame_airtimes
from modelcast.core.arrays import BoolArray, FloatArray, IntArray, owned
from modelcast.messages import stack_kernels as kernels
from modelcast.messages.rules import CertificateRule

__all__ = ["Stack"]


@dataclass(frozen=True, slots=True)
class Stack:
    """Bytes round a payload, and the time that bytes take.

    Parameters
    ----------
    certificates
        ``gap`` (default): a message whose predecessor of the same sender is more than
        `certificate_interval_s` older carries the certificate, the first too. ``timer``: a message carries it
        where the last that did is that old. ``always``; ``digest``: none does; ``unsigned``: no security
        header at all.
    certificate_interval_s
        SAE J2945/1, vCertificate interval, 450 ms, as used by public implementations.
    mac_bytes, fcs_bytes
        Header of an IEEE 802.11 data frame with three addresses, and its check sequence (clause 9.2.4). A
        frame with quality of service has 2 bytes more.
    llc_bytes
        EtherType protocol discrimination, as IEEE 802.11-2016 has it for 5.9 GHz; from memory, not from the
        text. Older stations send 8 (LLC and SNAP).
    wsmp_bytes
        IEEE 1609.3-2016 without extensions: version, transport id, PSID of one byte, length of two; from
        memory of the format.
    digest_bytes
        IEEE 1609.2 signed data with the certificate's 8-byte digest: counted field by field in the published
        ASN.1 (11 of framing, 11 of header with PSID and generation time, 5 of hash, payload and tags, 66 of
        P-256 signature and tags); a second-hand report says about 93 too.
    certificate_bytes
        The same with an implicit pseudonym certificate of 77 bytes in place of the digest: counted likewise
        (80 for 9). Field reports of 180 and 250 bytes for a message without and with it differ by 70.
    other_bytes
        Bytes that every message carries and its content does not count, signed or not: of a basic safety
        message path history and path prediction.
    preamble_s, symbol_s
        Preamble and signal field of 32 and 8 µs; an OFDM symbol (IEEE 802.11, clause 17, 10 MHz).
    service_tail_bits, bits_per_symbol
        Service and tail bits, 16 and 6; data bits in a symbol at 6 Mb/s (QPSK, rate ½).

    Raises
    ------
    ValueError
        Where a value is out of its range.

    Examples
    --------
    At 6 Mb/s a frame of 180, 250 or 350 bytes lasts 288, 384 or 512 µs:

    >>> bare = Stack("unsigned", mac_bytes=0, fcs_bytes=0, llc_bytes=0, wsmp_bytes=0)
    >>> (1e6 * bare.airtime_s(np.array([180, 250, 350]), np.zeros(3, bool))).round(3).tolist()
    [288.0, 384.0, 512.0]
    >>> Stack().carries_certificate(np.array([0.0, 0.1, 0.4, 0.9])).tolist()
    [True, False, False, True]
    """

    certificates: CertificateRule = "gap"
    _: KW_ONLY
    certificate_interval_s: float = 0.45
    mac_bytes: int = 24
    fcs_bytes: int = 4
    llc_bytes: int = 2
    wsmp_bytes: int = 5
    digest_bytes: int = 93
    certificate_bytes: int = 164
    other_bytes: int = 0
    preamble_s: float = 40e-6
    symbol_s: float = 8e-6
    service_tail_bits: int = 22
    bits_per_symbol: int = 48

    def __post_init__(self) -> None:
        if self.certificates not in get_args(CertificateRule):
            known = ", ".join(get_args(CertificateRule))
            raise ValueError(f"certificates must be one of {known}, got {self.certificates!r}")
        for name in ("certificate_interval_s", "symbol_s", "bits_per_symbol"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        counted = ("mac_bytes", "fcs_bytes", "llc_bytes", "wsmp_bytes", "digest_bytes", "other_bytes")
        for name in (*counted, "preamble_s"):
            if not getattr(self, name) >= 0:
                raise ValueError(f"{name} must not be negative, got {getattr(self, name)}")
        if not self.certificate_bytes >= self.digest_bytes:
            raise ValueError(f"certificate_bytes must be at least {self.digest_bytes}")

    @property
    def numbers(self) -> kernels.StackNumbers:
        """The stack as kernels take it."""
        signed = self.certificates != "unsigned"
        around = self.mac_bytes + self.fcs_bytes + self.llc_bytes + self.wsmp_bytes + self.other_bytes
        return kernels.StackNumbers(
            kernels.RULES.index(self.certificates),
            float(self.certificate_interval_s),
            int(around + (self.digest_bytes if signed else 0)),
            int(self.certificate_bytes - self.digest_bytes if signed else 0),
            float(self.preamble_s),
            float(self.symbol_s),
            int(self.service_tail_bits),
            int(self.bits_per_symbol),
        )

    def carries_certificate(self, t_s: FloatArray) -> BoolArray:
        """Which messages of one sender carry the certificate, (N,).

        Parameters
        ----------
        t_s
            When each was sent, rising, (N,) [s].
        """
        carried = np.zeros(t_s.size, np.bool_)
        kernels.which_carry(owned(t_s), self.numbers, carried)
        return carried

    def frame_bytes(self, payload_bytes: IntArray, certificate: BoolArray) -> IntArray:
        """Bytes of each frame on the air, (N,).

        Parameters
        ----------
        payload_bytes
            Of each message, (N,).
        certificate
            Which carry the certificate, (N,).
        """
        out = np.zeros(payload_bytes.size, np.int64)
        kernels.frames_bytes(owned(payload_bytes, np.int64), owned(certificate, np.bool_), self.numbers, out)
        return out

    def airtime_s(self, payload_bytes: IntArray, certificate: BoolArray) -> FloatArray:
        """How long each frame lasts, (N,) [s].

        Parameters
        ----------
        payload_bytes, certificate
            As in `frame_bytes`.
        """
        n = self.numbers
        return frame_airtimes(
            self.frame_bytes(payload_bytes, certificate),
            n.preamble_s,
            n.symbol_s,
            n.service_tail_bits,
            n.bits_per_symbol,
        )

    def sent_airtime_s(self, t_s: FloatArray, payload_bytes: IntArray) -> FloatArray:
        """How long each message of one sender lasts, by the certificate rule, (N,) [s].

        Parameters
        ----------
        t_s
            When each was sent, rising, (N,) [s].
        payload_bytes
            Of each message, (N,).
        """
        return self.airtime_s(payload_bytes, self.carries_certificate(t_s))
