"""The envelope of a signed message as a plain document, for JSON; nothing is verified.

::

    {"message": "signed", "generation_us": 5, "signer": {"digest": "..."}, "signature": "...", "payload": {}}

The payload is a document of its own. With the certificate, the signer is its parts by name.
"""

from collections.abc import Mapping
from typing import Any, cast

from modelcast.core.rules import shown
from modelcast.messages.digits import octets_of_digits
from modelcast.messages.security.certificate import Certificate
from modelcast.messages.security.signed import SignedMessage

__all__ = ["SIGNED_KIND", "signed_document", "signed_of"]

SIGNED_KIND = "signed"


def signed_document(message: SignedMessage, payload: Mapping[str, Any]) -> dict[str, Any]:
    """Plain values of an envelope.

    Parameters
    ----------
    message
        The envelope.
    payload
        The document of its payload.
    """
    signer = message.signer
    return {
        "message": SIGNED_KIND,
        "generation_us": message.generation_us,
        "signer": {"digest": signer.hex()}
        if isinstance(signer, bytes)
        else {
            "issuer": signer.issuer.hex(),
            "start_s": signer.start_s,
            "duration_s": signer.duration_s,
            "public_key": signer.public_key.hex(),
            "signature": signer.signature.hex(),
        },
        "signature": message.signature.hex(),
        "payload": dict(payload),
    }


def signed_of(document: Mapping[str, object], payload: bytes) -> SignedMessage:
    """Envelope that a document describes.

    Parameters
    ----------
    document
        As `signed_document` makes.
    payload
        The octets of its payload.

    Raises
    ------
    ValueError
        Where a part is missing or does not fit.
    """
    signer = document.get("signer")
    parts = cast("Mapping[str, object]", signer if isinstance(signer, Mapping) else {})
    if "digest" in parts:
        by: Certificate | bytes = octets_of_digits("digest", parts.get("digest"))
    else:
        by = Certificate(
            octets_of_digits("issuer", parts.get("issuer")),
            _whole(parts, "start_s"),
            duration_s=_whole(parts, "duration_s"),
            public_key=octets_of_digits("public_key", parts.get("public_key")),
            signature=octets_of_digits("signature", parts.get("signature")),
        )
    signature = octets_of_digits("signature", document.get("signature"))
    return SignedMessage(_whole(document, "generation_us"), payload, by, signature)


def _whole(given: Mapping[str, object], name: str) -> int:
    value = given.get(name)
    if type(value) is not int:
        raise ValueError(f"{name} must be a whole number, got {shown(value)}")
    return value
