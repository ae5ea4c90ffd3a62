"""Write the golden octets of model updates and identifications anew.

Every sub-model is fitted to one window, a car that turns and brakes with some millimetres of deterministic
noise, and its parameters become codes of the wire. The octets are then written by asn1tools over
our ASN.1 modules, the coefficients as a text of binary digits: no packing code of modelcast is used.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np

from modelcast.core.geodesy import Origin
from modelcast.messages.asn1 import reference_codec, reference_encode
from modelcast.messages.bsm import BasicSafetyMessage
from modelcast.messages.mbc import ModelUpdate
from modelcast.messages.mbc_profile import WireProfile
from modelcast.messages.mbc_update import UpdateMessage
from modelcast.messages.mbc_values import LocalFrame, update_to_wire
from modelcast.models.bank import Bank
from modelcast.models.base import Windows
from modelcast.models.profile import default_profile
from modelcast.station.banks import bank_from_text, member_names

__all__ = ["BANKS", "NUMBER", "main", "sent"]

FILE = Path(__file__).parent / "vectors" / "models.json"
NUMBER = 0x44136F
"""Of a made-up profile."""

_WITHOUT_VELOCITY = ("gp-linear", "gp-vehicle", "gp-derivative", "gp-regime")
BANKS = (
    *(
        (f"{name}+cv" if name.startswith(_WITHOUT_VELOCITY) else name, False)
        for name in member_names(default_profile())
    ),
    ("paper", True),
    ("gp-vehicle+learned+cv", True),
)
"""Banks by name, and whether the coefficients of all sub-models are carried."""

FRAME = LocalFrame(Origin(42.3, -83.7, 250.0), minute_s=0.0)
DT_S = 0.1
IDENTIFICATIONS = ((0, 0, 0, 0), (0x01020304, 7, 2, 130), (2**32 - 1, 127, 7, 16383))
"""Temporary id, sequence, sub-model and age."""


def window() -> Windows:
    """Return a car at 15 m/s that brakes at 1 m/s² and turns right at 0.1 rad/s."""
    t = np.arange(-24, 1) * DT_S
    speed, course = 15.0 - t, 0.5 + 0.1 * t
    velocity = speed * np.array([np.sin(course), np.cos(course)])
    moved = np.stack([np.concatenate([[0.0], np.cumsum(0.5 * DT_S * (v[1:] + v[:-1]))]) for v in velocity])
    noise_m = 0.002 * (np.array([7, 11])[:, None] * np.arange(25) % 5 - 2.0)
    position = moved + noise_m
    same = np.ones_like(t)
    return Windows(np.stack([*position, *velocity, -same, 0.1 * same, 0.003 * same], axis=1)[None], dt_s=DT_S)


def sent(name: str, *, carries_all: bool) -> tuple[UpdateMessage, WireProfile, Bank]:
    """Return what a sender with this bank sends of the window, its first sub-model in use.

    Parameters
    ----------
    name
        Of the bank.
    carries_all
        Whether the coefficients of all sub-models go out.
    """
    plain = bank_from_text(name)
    bank, given = plain.carried(), window()
    update = ModelUpdate(
        0x01020304,
        7,
        12.3,
        position_m=given.samples[0, -1, :2],
        in_use=0,
        parameters=bank.fit(given)[0, 1:],
        dt_s=DT_S,
    )
    wire = WireProfile.of(plain, NUMBER)
    return update_to_wire(update, bank, wire, FRAME, carries_all=carries_all), wire, bank


def update_vector(name: str, *, carries_all: bool) -> dict[str, Any]:
    """Return one update and its octets."""
    message, wire, bank = sent(name, carries_all=carries_all)
    members = wire.carried(message.sub_model, carries_all=carries_all)
    coefficients = {
        bank.members[member].name: dict(zip(wire.layouts[member].names, codes, strict=True))
        for member, codes in zip(members, message.codes, strict=True)
    }
    digits = "".join(
        f"{code - field.low:0{field.bits}b}"
        for member, codes in zip(members, message.codes, strict=True)
        for field, code in zip(wire.layouts[member].fields, codes, strict=True)
    )
    digits += "0" * (-len(digits) % 8)
    model = {
        "profile": NUMBER.to_bytes(3, "big"),
        "subModel": message.sub_model,
        "carriesAll": carries_all,
        "coefficients": bytes(int(digits[at : at + 8], 2) for at in range(0, len(digits), 8)),
    }
    extension = bytes(reference_codec().encode("ModelExtension", model))
    octets = reference_encode(BasicSafetyMessage(message.core, regional=((128, extension),)))
    return {
        "bank": name,
        "carries_all": carries_all,
        "part_i": list(message.core.codes),
        "coefficients": coefficients,
        "octets": octets.hex(),
    }


def identification_vector(temporary_id: int, sequence: int, sub_model: int, age: int) -> dict[str, Any]:
    """Return one identification and its octets."""
    value = {"id": temporary_id.to_bytes(4, "big"), "sequence": sequence, "subModel": sub_model, "age": age}
    inner = reference_codec().encode("SubModelIdentification", value)
    octets = reference_codec().encode("MessageFrame", {"messageId": 240, "value": inner})
    fields = {"temporary_id": temporary_id, "sequence": sequence, "sub_model": sub_model, "age": age}
    return {**fields, "octets": bytes(octets).hex()}


def main() -> None:
    """Write the file."""
    document = {
        "made": "python tests/messages/make_model_vectors.py: fitted by modelcast, packed by asn1tools",
        "profile": f"{NUMBER:06x}",
        "updates": [update_vector(name, carries_all=carries_all) for name, carries_all in BANKS],
        "identifications": [identification_vector(*values) for values in IDENTIFICATIONS],
    }
    FILE.parent.mkdir(exist_ok=True)
    FILE.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
