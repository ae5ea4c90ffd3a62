"""The numbers that sender and receiver of signed messages go by."""

from dataclasses import KW_ONLY, dataclass

__all__ = ["DEFAULT_PARAMETERS", "SecurityParameters"]


@dataclass(frozen=True, slots=True)
class SecurityParameters:
    """When a certificate goes along, how old a message may be, and how much a receiver remembers.

    Parameters
    ----------
    certificate_interval_s
        Time since the sender's last certificate after which the next message carries it again [s] -
        vMaxCertDigestInterval of SAE J2945/1, 450 ms. The value is sure; that standard's exact text was not
        at hand.
    max_age_s
        Oldest message taken, by its generation time [s]. Ours: several times what a channel access and a
        queue take, and less than a message is worth keeping. IEEE 1609.2 leaves it to the application.
    max_ahead_s
        Farthest a generation time may lie ahead of the receiver's clock [s]. Ours: GNSS clocks agree to
        milliseconds (vTimeAccuracy of J2945/1 is 1 ms).
    certificates
        Certificates of other senders held at most; the one longest in the store goes first. Ours.
    remembered
        Messages of each sender that the replay window remembers at most. Ours: more than ``max_age_s`` at
        10 Hz.

    Raises
    ------
    ValueError
        Where one is not positive.
    """

    certificate_interval_s: float = 0.45
    _: KW_ONLY
    max_age_s: float = 2.0
    max_ahead_s: float = 0.1
    certificates: int = 1024
    remembered: int = 32

    def __post_init__(self) -> None:
        for name in ("certificate_interval_s", "max_age_s", "max_ahead_s", "certificates", "remembered"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")


DEFAULT_PARAMETERS = SecurityParameters()
"""Those of a sender or receiver that is told no others."""
