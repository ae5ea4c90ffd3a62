"""The envelope of a signed message as a plain document, for JSON; nothing is verified.

::

    {"message": "signed", "generation_us": 5, "signer": {"digest": "..."}, "signature": "...", "payload": {}}

The payload is a document of its own. With the certificate, the signer is its parts by name.
"""

from collections.abc import Mapping
from typing import Any, cast, get_args

from modelcast.core.rules import shown
from modelcast.messages.digits import octets_of_digits
from modelcast.messages.psids import SAFETY_PSID
from modelcast.messages.security.certificate import X_ONLY, Certificate, DurationUnit
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
            "duration_unit": signer.duration_unit,
            "psids": list(signer.psids),
            "name": signer.name,
            "craca_id": signer.craca_id.hex(),
            "crl_series": signer.crl_series,
            "public_key": signer.public_key.hex(),
            "signature": signer.signature.hex(),
            "r_tag": signer.r_tag,
        },
        "psid": message.psid,
        "r_tag": message.r_tag,
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
            duration_unit=_unit(parts.get("duration_unit", "seconds")),
            psids=_psids(parts.get("psids", [SAFETY_PSID])),
            name=_name(parts.get("name")),
            craca_id=octets_of_digits("craca_id", parts.get("craca_id", "000000")),
            crl_series=_whole(parts, "crl_series", 0),
            r_tag=_whole(parts, "r_tag", X_ONLY),
        )
    signature = octets_of_digits("signature", document.get("signature"))
    return SignedMessage(
        _whole(document, "generation_us"),
        payload,
        by,
        signature,
        psid=_whole(document, "psid", SAFETY_PSID),
        r_tag=_whole(document, "r_tag", X_ONLY),
    )


def _unit(given: object) -> DurationUnit:
    for unit in get_args(DurationUnit):
        if unit == given:
            return unit
    raise ValueError(f"duration_unit must be one of {', '.join(get_args(DurationUnit))}, got {shown(given)}")


def _psids(given: object) -> tuple[int, ...]:
    numbers = cast("list[object]", given) if isinstance(given, list) else [given]
    psids = tuple(number for number in numbers if type(number) is int)
    if len(psids) != len(numbers):
        raise ValueError(f"psids must be a list of whole numbers, got {shown(numbers)}")
    return psids


def _name(given: object) -> str | None:
    if given is not None and not isinstance(given, str):
        raise ValueError(f"name must be text or null, got {shown(given)}")
    return given


def _whole(given: Mapping[str, object], name: str, default: int | None = None) -> int:
    value = given.get(name, default)
    if type(value) is not int:
        raise ValueError(f"{name} must be a whole number, got {shown(value)}")
    return value
