"""Make the test vectors of ``docs/wire.md`` and its tables; ``--check`` only compares.

``--agree N`` sends N random messages through modelcast's encoder and the second decoder that was written from
the page alone (``tests/wire_decoder.py``), and counts those on which they differ.
"""

import argparse
import json
import random
import runpy
import sys
from pathlib import Path
from typing import Any

from modelcast.messages.airtime import Stack
from modelcast.messages.bsm import BsmCore, decode_bsm, encode_bsm
from modelcast.messages.bsm_fields import CORE_FIELDS
from modelcast.messages.fields import Field
from modelcast.messages.ieee1609 import encode_unsecured
from modelcast.messages.mbc_update import update_octets
from modelcast.messages.mbc_wire import (
    IdentificationMessage,
    ModelExtension,
    encode_extension,
    encode_identification,
)
from modelcast.messages.message_heads import HEADS
from modelcast.messages.psids import PEOPLE_PSID
from modelcast.messages.psm import PersonalSafetyMessage, encode_psm, person_codes
from modelcast.messages.psm_fields import ACCELERATION_FIELDS, PERSON_FIELDS, PERSON_INDEX
from modelcast.messages.security.authority import Authority
from modelcast.messages.security.p256 import PrivateKey
from modelcast.messages.security.signed import SignedMessage, signed_part
from modelcast.messages.wsmp import encode_wsm
from page_blocks import put

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "wire.md"
VECTORS = ROOT / "docs" / "wire-vectors.json"
AUTHORITY = Authority.create(PrivateKey(0x1609), start_s=700_000_000, duration_s=3600 * 24 * 365)
KEY = PrivateKey(0x2735)
CERTIFICATE = AUTHORITY.issue(KEY.public_octets, start_s=700_000_000, duration_s=7 * 86_400)


def random_frame(rng: random.Random) -> tuple[bytes, dict[str, Any]]:
    """A random frame, and what a decoder finds in it."""
    if rng.random() < 0.2:
        parts = {"temporary_id": rng.getrandbits(32), "sequence": rng.getrandbits(7)}
        parts |= {"sub_model": rng.getrandbits(3), "age": rng.getrandbits(14)}
        message = IdentificationMessage(
            parts["temporary_id"], parts["sequence"], sub_model=parts["sub_model"], age=parts["age"]
        )
        return encode_identification(message), parts
    if rng.random() < 0.3:
        return random_person(rng)
    codes = random_codes(rng, CORE_FIELDS)
    part_ii = [(rng.getrandbits(6), rng.randbytes(rng.randint(1, 150))) for _ in range(rng.randint(0, 2))]
    regional, said = random_model(rng)
    octets = encode_bsm(BsmCore(tuple(codes)), part_ii=tuple(part_ii), regional=tuple(regional))
    return octets, {"codes": codes, "part_ii": part_ii, "regional": regional, "model": said}


def random_codes(rng: random.Random, fields: tuple[Field, ...]) -> list[int]:
    """Codes of fields, often at their ends."""
    return [rng.choice((field.low, field.high, rng.randint(field.low, field.high))) for field in fields]


def random_person(rng: random.Random) -> tuple[bytes, dict[str, Any]]:
    """A random personal safety message, with and without the parts that models need."""
    codes, has_elevation = random_codes(rng, PERSON_FIELDS), rng.random() < 0.5
    if not has_elevation:
        codes[PERSON_INDEX["elevation_m"]] = -4096
    acceleration = random_codes(rng, ACCELERATION_FIELDS) if rng.random() < 0.5 else []
    regional, said = random_model(rng)
    message = PersonalSafetyMessage(
        tuple(codes),
        has_elevation=has_elevation,
        acceleration=tuple(acceleration),
        regional=tuple(regional),
    )
    found = {"person_codes": codes, "acceleration": acceleration, "regional": regional, "model": said}
    return encode_psm(message), found


def random_model(rng: random.Random) -> tuple[list[tuple[int, bytes]], dict[str, Any] | None]:
    """Regional extensions, none or a random model, and what a decoder finds in it."""
    regional: list[tuple[int, bytes]] = []
    said: dict[str, Any] | None = None
    if rng.random() < 0.6:
        size = rng.choice((0, rng.randint(0, 127)))
        model: dict[str, Any] = {
            "profile": rng.getrandbits(24),
            "sub_model": rng.getrandbits(3),
            "all": rng.getrandbits(1),
        }
        model["coefficients"] = rng.randbytes(size)
        extension = ModelExtension(
            model["profile"],
            model["sub_model"],
            carries_all=bool(model["all"]),
            coefficients=model["coefficients"],
        )
        regional.append((128, encode_extension(extension)))
        said = model
    return regional, said


def random_message(rng: random.Random) -> tuple[bytes, dict[str, Any]]:
    """A random short message, and what a decoder finds in it; its signature is random too."""
    payload, found = random_frame(rng)
    kind = rng.randrange(3)
    if kind == 0:
        return encode_wsm(encode_unsecured(payload)), {"frame": found}
    signer = CERTIFICATE if kind == 1 else rng.randbytes(8)
    generation_us, signature = rng.getrandbits(64), rng.randbytes(64)
    octets = SignedMessage(generation_us, payload, signer, signature).octets
    return encode_wsm(octets), {"frame": found, "generation_us": generation_us, "signature": signature}


def disagreements(count: int, seed: int = 1609) -> int:
    """How many of some random messages the second decoder reads otherwise."""
    read = runpy.run_path(str(ROOT / "tests" / "wire_decoder.py"))["read"]
    rng = random.Random(seed)  # noqa: S311 - not for secrets
    differ = 0
    for _ in range(count):
        octets, wanted = random_message(rng)
        found = read(octets)["data"]
        differ += any(found[name] != value for name, value in wanted.items())
    return differ


def vectors() -> list[dict[str, Any]]:
    """The vectors: each form of what goes round a frame, signed with keys that are told."""
    values = {
        "message_count": 7,
        "temporary_id": 0x01020304,
        "second_of_minute_s": 12.3,
        "yaw_rate_radps": 0.0,
    }
    values |= {
        "latitude_deg": 42.3003247,
        "longitude_deg": -83.6998268,
        "speed_mps": 15.0,
        "heading_rad": 0.5,
    }
    core = BsmCore.from_values(values)
    extension = encode_extension(ModelExtension(0x44136F, 1, coefficients=bytes(range(6))))
    frames = {
        "basic safety message": encode_bsm(core),
        "update": encode_bsm(core, regional=((128, extension),)),
        "identification": encode_identification(IdentificationMessage(0x01020304, 7, sub_model=2, age=130)),
    }
    out: list[dict[str, Any]] = []
    for name, payload in frames.items():
        at_us = 700_000_001_000_000
        signature = KEY.sign(signed_part(at_us, payload, CERTIFICATE))
        forms = {
            "unsecured": encode_unsecured(payload),
            "signed, digest": SignedMessage(at_us, payload, CERTIFICATE.digest, signature).octets,
            "signed, certificate": SignedMessage(at_us, payload, CERTIFICATE, signature).octets,
        }
        codes = list(decode_bsm(payload).core.codes) if name != "identification" else None
        out += [
            {
                "name": f"{name}, {form}",
                "short_message": encode_wsm(data).hex(),
                "frame": payload.hex(),
                "generation_us": None if form == "unsecured" else at_us,
                "part_i_codes": codes,
            }
            for form, data in forms.items()
        ]
    return out + people(extension)


def people(extension: bytes) -> list[dict[str, Any]]:
    """Vectors of a cyclist: plain, and with a model that needs the acceleration set."""
    values = {"basic_type": 2, "message_count": 7, "temporary_id": 0x01020304, "second_of_minute_s": 12.3}
    values |= {
        "latitude_deg": 42.3003247,
        "longitude_deg": -83.6998268,
        "speed_mps": 5.0,
        "heading_rad": 0.5,
    }
    codes = person_codes(values)
    acceleration = tuple(
        field.code_of(value) for field, value in zip(ACCELERATION_FIELDS, (0.5, None, None, 0.1), strict=True)
    )
    frames = {
        "personal safety message": PersonalSafetyMessage(codes, has_elevation=False),
        "update of a cyclist": PersonalSafetyMessage(
            codes, has_elevation=False, acceleration=acceleration, regional=((128, extension),)
        ),
    }
    return [
        {
            "name": f"{name}, unsecured",
            "short_message": encode_wsm(encode_unsecured(encode_psm(message)), PEOPLE_PSID).hex(),
            "frame": encode_psm(message).hex(),
            "generation_us": None,
            "person_codes": list(codes),
        }
        for name, message in frames.items()
    ]


def document() -> str:
    """The file of vectors."""
    whole = {
        "made": "python validation/wire_vectors.py",
        "authority": {"private_key": f"{0x1609:064x}", "certificate": AUTHORITY.certificate.octets.hex()},
        "sender": {
            "private_key": f"{0x2735:064x}",
            "certificate": CERTIFICATE.octets.hex(),
            "digest": CERTIFICATE.digest.hex(),
        },
        "vectors": vectors(),
    }
    return json.dumps(whole, indent=1) + "\n"


def part_i() -> list[str]:
    """Rows of Part I."""
    rows = [
        "| field | SAE J2735 | bits | lowest code | highest | none | step |",
        "|---|---|---|---|---|---|---|",
    ]
    for field in CORE_FIELDS:
        top, bottom = field.step
        step = f"{top}/{bottom} {field.unit}" if field.unit else ""
        none = "" if field.unavailable is None else field.unavailable
        name = f"| `{field.name}` | `{field.standard_name}` | {field.width_bits} "
        rows.append(f"{name}| {field.low} | {field.high} | {none} | {step} |")
    return rows


def plain_sizes() -> list[str]:
    """Octets of frames, by kind of message."""
    names = ("basic safety message", "personal safety message", "the same with the acceleration set")
    rows = [
        f"| {name} | {head.frame_octets()} | {update_octets(0, head)} |"
        for name, head in zip(names, HEADS, strict=True)
    ]
    return ["| frame | plain | with a model, before its coefficients |", "|---|---|---|", *rows]


def sizes() -> list[str]:
    """What goes round a payload of 40 octets, here and in the evaluation."""
    stack, payload = Stack(), bytes(40)
    digest = SignedMessage(0, payload, bytes(8), bytes(64)).octets
    attached = SignedMessage(0, payload, CERTIFICATE, bytes(64)).octets
    rows = [
        ("WSMP, payload up to 127 octets", len(encode_wsm(payload)) - 40, stack.wsmp_bytes),
        ("WSMP, payload of 128 and more", len(encode_wsm(digest)) - len(digest), stack.wsmp_bytes),
        ("1609.2 with digest", len(digest) - 40, stack.digest_bytes),
        ("1609.2 with certificate", len(attached) - 40, stack.certificate_bytes),
    ]
    head = ["| round 40 octets of payload | this encoder | evaluation |", "|---|---|---|"]
    return head + [f"| {name} | {ours} | {counted} |" for name, ours, counted in rows]


def main() -> int:
    """Write or compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--check", action="store_true")
    which.add_argument("--write", action="store_true", help="what it does where nothing is asked")
    parser.add_argument("--agree", type=int, default=0)
    given = parser.parse_args()
    if given.agree:
        differ = disagreements(given.agree)
        print(f"{given.agree} messages, {differ} read otherwise")
        return int(differ > 0)
    text = document()
    stale = put(
        {PAGE: {"part-i": part_i(), "plain-sizes": plain_sizes(), "sizes": sizes()}}, check=given.check
    )
    if given.check:
        return stale or int(VECTORS.read_text("ascii") != text)
    VECTORS.write_text(text, "ascii", newline="\n")
    return stale


if __name__ == "__main__":
    sys.exit(main())
