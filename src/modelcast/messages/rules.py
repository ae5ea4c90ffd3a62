"""Names of the certificate rules: the one list that stack, settings and command line share."""

from typing import Literal

__all__ = ["CertificateRule"]

CertificateRule = Literal["gap", "timer", "always", "digest", "unsigned"]
"""Which messages carry the certificate, as `modelcast.messages.airtime.Stack` describes them."""
