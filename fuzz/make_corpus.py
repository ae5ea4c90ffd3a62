"""Write the committed corpus anew: messages of our own encoder, and the same cut, bent and padded.

The files are the starting points of the fuzzer, and the inputs of the bounded run in the tests. They hold
every shape a message can take, and every reason for which one is refused.
"""

import random
from pathlib import Path

from modelcast.messages.bits import BitWriter
from modelcast.messages.bsm import BsmCore, encode_bsm
from modelcast.messages.bsm_fields import BASIC_SAFETY_MESSAGE, CORE_BITS, CORE_FIELDS, LOCAL_REGION
from modelcast.messages.frame import encode_frame
from modelcast.messages.mbc_wire import (
    IdentificationMessage,
    ModelExtension,
    encode_extension,
    encode_identification,
)
from modelcast.messages.path_history_fields import MAX_CRUMBS
from modelcast.messages.psm import PersonalSafetyMessage, encode_psm
from modelcast.messages.psm_fields import PERSON_FIELDS, PERSON_INDEX
from modelcast.messages.security.certificate import Certificate
from modelcast.messages.security.signed import SignedMessage

__all__ = ["main"]

FOLDER = Path(__file__).parent / "corpus"


def messages(rng: random.Random) -> dict[str, bytes]:
    """Return messages of all shapes, by name."""
    cores = [BsmCore(tuple(rng.randint(f.low, f.high) for f in CORE_FIELDS)) for _ in range(8)]
    lowest = BsmCore(tuple(f.low for f in CORE_FIELDS))
    highest = BsmCore(tuple(f.high for f in CORE_FIELDS))
    some = [rng.randbytes(count) for count in (1, 7, 24, 126, 200, 1000)]
    return {
        "lowest": encode_bsm(lowest),
        "highest": encode_bsm(highest),
        "random": encode_bsm(cores[0]),
        "part-ii": encode_bsm(cores[1], part_ii=((0, some[3]), (2, some[1]))),
        "part-ii-full": encode_bsm(cores[2], part_ii=tuple((i, some[i % 3]) for i in range(8))),
        "regional": encode_bsm(cores[3], regional=((LOCAL_REGION, some[2]),)),
        "regional-full": encode_bsm(cores[4], regional=tuple((64 * i, some[i]) for i in range(4))),
        "both": encode_bsm(cores[5], part_ii=((1, some[0]),), regional=((LOCAL_REGION, some[4]),)),
        "additions": encode_bsm(cores[6], additions=(None, some[1], None)),
        "additions-65": encode_bsm(cores[6], additions=(*[None] * 64, some[0])),
        "additions-most-absent": encode_bsm(cores[6], additions=(*[None] * 16_000, some[0])),
        "additions-most": encode_bsm(lowest, additions=(some[0],) * 7000),
        "all": encode_bsm(
            cores[7],
            part_ii=((63, some[0]),),
            regional=((255, some[0]),),
            additions=(some[1],),
            frame_additions=(None, some[2]),
        ),
        "long": encode_bsm(lowest, regional=((LOCAL_REGION, rng.randbytes(16_300)),)),
        "update": encode_bsm(cores[3], regional=((LOCAL_REGION, _model(rng, 6)),)),
        "update-plain": encode_bsm(cores[4], regional=((LOCAL_REGION, _model(rng, 0)),)),
        "update-longest": encode_bsm(cores[5], regional=((LOCAL_REGION, _model(rng, 127)),)),
        **{
            f"update-known-{name}": encode_bsm(cores[6], regional=((LOCAL_REGION, octets),))
            for name, octets in known().items()
        },
        "other-identification": encode_identification(
            IdentificationMessage(rng.getrandbits(32), 100, sub_model=5, age=130)
        ),
        "other-model": _model(rng, 6),
        "other-message": encode_frame(18, some[2]),
        "other-message-extended": encode_frame(240, some[5], (some[0],)),
    }


def people(rng: random.Random) -> dict[str, bytes]:
    """Return personal safety messages of all shapes, and the same bent, by name."""
    codes = tuple(rng.randint(f.low, f.high) for f in PERSON_FIELDS)
    highest = tuple(f.high for f in PERSON_FIELDS)
    elevation = PERSON_INDEX["elevation_m"]
    unknown = (*codes[:elevation], PERSON_FIELDS[elevation].code_of(None), *codes[elevation + 1 :])
    crumb = (1000, -1000, 0, 100, 70, (1, 2, 3), 7)
    when = (2026, 11, 29, 9, 0, 1000, 60)
    place = (when, -742761437, 402397377, 0, 8898, (2, 70), (1, 2, 3), 16, (9, 9), (4, 5, 3))
    parts = (
        ("path_history", (place, 64, (crumb, (*crumb[:4], None, None, None)))),
        ("propulsion", (2, 3)), ("use_state", 64), ("cross_request", 1), ("cross_state", 0),
        ("cluster_size", 2), ("cluster_radius_m", 7), ("event_responder_type", 3), ("activity_type", 16),
        ("activity_sub_type", 32), ("assist_type", 8), ("sizing", 4), ("attachment", 2),
        ("attachment_radius_m", 20), ("animal_type", 1),
    )  # fmt: skip
    whole = PersonalSafetyMessage(
        codes,
        acceleration=(1, 2, 3, 4),
        path_prediction=(-300, 100),
        parts=parts,
        regional=((LOCAL_REGION, rng.randbytes(24)), (1, rng.randbytes(130))),
        additions=(None, rng.randbytes(7)),
        frame_additions=(rng.randbytes(3),),
    )
    long_path = ("path_history", (None, None, (crumb,) * MAX_CRUMBS))
    good = {
        "plain": PersonalSafetyMessage(codes),
        "highest": PersonalSafetyMessage(highest),
        "no-elevation": PersonalSafetyMessage(unknown, has_elevation=False),
        "path": PersonalSafetyMessage(codes, parts=(long_path,)),
        "all": whole,
    }
    octets = {name: encode_psm(message) for name, message in good.items()}
    plain, full = octets["plain"], octets["all"]
    bent = {
        "cut": plain[:-1],
        "cut-in-parts": full[:60],
        "left-over": plain + b"\0",
        "padding": plain[:-1] + bytes([plain[-1] | 1]),
        "later-type": plain[:5] + bytes([plain[5] | 0x10]) + plain[6:],
        "all-ones": plain[:3] + b"\xff" * 28,
    }
    return {f"other-person-{name}": one for name, one in octets.items()} | {
        f"refused-person-{name}": one for name, one in bent.items()
    }


def known() -> dict[str, bytes]:
    """Return models of profiles that the fuzz target knows, by name: read, and refused for each reason."""
    return {
        name: encode_extension(
            ModelExtension(profile, sub_model, carries_all=carries_all, coefficients=bytes.fromhex(digits))
        )
        for name, profile, sub_model, carries_all, digits in (
            ("one", 0x44136F, 0, False, "a480"),
            ("none", 0x44136F, 1, False, ""),
            ("all", 0x44136F, 2, True, "a4d2"),
            ("sub-model", 0x44136F, 3, False, ""),
            ("length", 0x44136F, 0, False, "a4"),
            ("padding", 0x44136F, 0, False, "a481"),
            ("wide", 1, 1, False, "0123456789abcdef01234567"),
            ("path", 1, 2, False, "0123456789abcd"),
            ("wide-all", 1, 0, True, "0123456789ab" + "cdef01234567" * 2 + "89abcdef0123" + "4580"),
        )
    }


def _model(rng: random.Random, octets: int) -> bytes:
    """Return a model with that many octets of coefficients."""
    return encode_extension(ModelExtension(rng.getrandbits(24), 2, coefficients=rng.randbytes(octets)))


def signed(rng: random.Random, payloads: dict[str, bytes]) -> dict[str, bytes]:
    """Return signed messages of some payloads, and a certificate, by name; nobody signed them."""
    certificate = Certificate(
        rng.randbytes(8),
        rng.getrandbits(32),
        duration_s=3600,
        public_key=b"\x03" + rng.randbytes(32),
        signature=rng.randbytes(64),
    )
    contents = (
        ("digest", certificate.digest, rng.randbytes(64)),
        ("certificate", certificate, rng.randbytes(40)),
        ("long", certificate.digest, rng.randbytes(700)),
        *((name, certificate.digest, octets) for name, octets in payloads.items()),
    )
    return {"other-certificate": certificate.octets} | {
        f"other-signed-{name}": SignedMessage(rng.getrandbits(52), payload, signer, rng.randbytes(64)).octets
        for name, signer, payload in contents
    }


def extended(value: bytes, preamble: int, *after: tuple[int, int]) -> bytes:
    """Return Part I of a message that has nothing else, with another preamble and some bits after it."""
    writer = BitWriter()
    writer.bits(preamble, 3)
    writer.bits(int.from_bytes(value, "big") >> 8 * len(value) - 3 - CORE_BITS, CORE_BITS)
    for number, width in after:
        writer.bits(number, width)
    return encode_frame(BASIC_SAFETY_MESSAGE, writer.octets())


def refused(good: dict[str, bytes]) -> dict[str, bytes]:
    """Return octets that are refused, by reason."""
    core, full = good["random"], good["all"]
    value = core[3:]
    return {
        "empty": b"",
        "one-octet": core[:1],
        "no-length": core[:2],
        "cut-in-part-i": core[:20],
        "value-cut-in-part-i": core[:2] + bytes([17]) + core[3:20],
        "cut-in-additions": full[:-5],
        "left-over": core + b"\0",
        "left-over-in-value": core[:2] + bytes([len(value) + 2]) + value + b"\0\0",
        "padding": core[:-1] + bytes([core[-1] | 1]),
        "length-long-form": core[:2] + bytes([0x80, len(value)]) + value,
        "length-fragmented": core[:2] + b"\xc1" + bytes(16_384),
        "no-value": core[:2] + b"\0",
        "all-ones": b"\0\x14\x25" + b"\xff" * 37,
        "all-zero": bytes(40),
        "ones": b"\xff" * 300,
        "too-long": bytes(16_500),
        "model-cut": good["other-model"][:-1],
        "identification-cut": good["other-identification"][:-1],
        "empty-open-type": extended(value, 1, (0, 2), (LOCAL_REGION, 8), (0, 8)),
        "no-addition-present": extended(value, 4, (2, 7), (0, 3)),
        "few-additions-in-long-form": extended(value, 4, (1, 1), (3, 8), (7, 3)),
    }


def main() -> None:
    """Write all files."""
    FOLDER.mkdir(exist_ok=True)
    for old in FOLDER.iterdir():
        old.unlink()
    good = messages(random.Random(4))  # noqa: S311 - not for secrets
    inside = {name: good[name] for name in ("update-known-path", "other-identification")}
    sealed = signed(random.Random(1609), inside)  # noqa: S311 - not for secrets
    for name, octets in {
        **good,
        **sealed,
        **people(random.Random(32)),  # noqa: S311 - not for secrets
        **{f"refused-{name}": octets for name, octets in refused(good).items()},
    }.items():
        (FOLDER / name).write_bytes(octets)


if __name__ == "__main__":
    main()
