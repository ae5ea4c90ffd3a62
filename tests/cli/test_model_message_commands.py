"""Claims about ``modelcast decode`` and ``modelcast encode`` on modelcast's own messages."""

import json
import random
from pathlib import Path
from typing import Any

import pytest

from modelcast.cli.app import run as run_as_given
from modelcast.io.profile import write_profile
from modelcast.messages.bsm import BsmCore, encode_bsm
from modelcast.messages.mbc_codec import UpdateCodec
from modelcast.messages.mbc_profile import WireProfile
from modelcast.messages.mbc_update import UpdateMessage
from modelcast.messages.mbc_wire import IdentificationMessage, ModelExtension, encode_extension
from modelcast.messages.mbc_wire import encode_identification as identify
from modelcast.messages.security.certificate import Certificate
from modelcast.messages.security.signed import SignedMessage
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.profile import Profile
from modelcast.station.banks import bank_from_text

NORTH = BsmCore.from_values(
    {
        "message_count": 7,
        "temporary_id": 1,
        "second_of_minute_s": 5.0,
        "latitude_deg": 42.0,
        "longitude_deg": -83.0,
        "speed_mps": 10.0,
        "heading_rad": 0.0,
        "acceleration_forward_mps2": 2.0,
        "yaw_rate_radps": 0.0,
    }
)
WITH_COEFFICIENTS = Profile(bank_from_text("learned+ctra+gp-vehicle+cv"), start="guarded", identify="never")
WIRE = WireProfile.of_profile(WITH_COEFFICIENTS)
UPDATE = UpdateCodec(WIRE).encode(UpdateMessage(NORTH, 0, carries_all=False, codes=((0, 3, -12, 1, -2, 40),)))
OTHERS = tuple((0,) * len(layout.fields) for layout in WIRE.layouts[1:])
ALL = UpdateCodec(WIRE, carries_all=True).encode(
    UpdateMessage(NORTH, 1, carries_all=True, codes=((0, 3, -12, 1, -2, 40), *OTHERS))
)
TURNING = encode_bsm(NORTH, regional=((128, encode_extension(ModelExtension(WIRE.number, 1))),))
UNKNOWN = encode_bsm(
    NORTH, regional=((9, b"x"), (128, encode_extension(ModelExtension(1, 5, coefficients=b"\1\2"))))
)
DAMAGED = encode_bsm(NORTH, regional=((128, encode_extension(ModelExtension(WIRE.number, 7))),))
NO_PLACE = UpdateCodec(WIRE).encode(
    UpdateMessage(
        BsmCore.from_values({"message_count": 7, "temporary_id": 1, "yaw_rate_radps": 0.0}),
        1,
        carries_all=False,
        codes=((),),
    )
)
IDENTIFICATION = identify(IdentificationMessage(1, 7, sub_model=2, age=130))
IDENTIFIES: dict[str, Any] = {
    "message": "identification",
    "temporary_id": "00000001",
    "sequence": 7,
    "sub_model": 2,
    "age_s": 1.3,
}
CERTIFICATE = Certificate(
    bytes(8), 5, duration_s=60, public_key=b"\2" + bytes(32), signature=bytes(range(64))
)
SIGNED = SignedMessage(5, UPDATE, CERTIFICATE.digest, bytes(range(64))).octets
SIGNED_LONG = SignedMessage(5, IDENTIFICATION, CERTIFICATE, bytes(64)).octets


HELD: list[str] = []
"""File of the profile that the commands hold where a test names none."""


@pytest.fixture(scope="module", autouse=True)
def held(tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("held") / "profile.json"
    write_profile(WITH_COEFFICIENTS, path)
    HELD[:] = [str(path)]


def run(words: list[str]) -> int:
    return run_as_given([*words, *(() if "--profile" in words else ("--profile", *HELD))])


def document_of(octets: bytes, capsys: pytest.CaptureFixture[str], *more: str) -> dict[str, Any]:
    run(["decode", "--json", octets.hex(), *more])
    return json.loads(capsys.readouterr().out)


def test_golden_octets_of_an_identification(capsys: pytest.CaptureFixture[str]) -> None:
    assert document_of(bytes.fromhex("00f007000000010e8082"), capsys) == IDENTIFIES


@pytest.mark.parametrize(
    ("age_s", "ends"), [(-5, "8000"), (163.834, "bfff"), (1e9, "bfff"), (10**400, "bfff")]
)
def test_an_age_beyond_its_range_takes_the_last_code(
    age_s: float, ends: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["encode", json.dumps(IDENTIFIES | {"age_s": age_s})]) == 0
    assert capsys.readouterr().out.endswith(f"{ends}\n")


@pytest.mark.parametrize(("value", "held"), [(1e308, 1.55), (10**400, 1.55), (-(10**400), -1.6)])
def test_a_coefficient_beyond_its_range_takes_the_last_code(
    value: float, held: float, capsys: pytest.CaptureFixture[str]
) -> None:
    document = document_of(UPDATE, capsys)
    document["regional"][0]["model"]["coefficients"]["learned"]["along_0_m"] = value
    assert run(["encode", json.dumps(document)]) == 0
    again = document_of(bytes.fromhex(capsys.readouterr().out), capsys)
    found = again["regional"][0]["model"]["coefficients"]["learned"]["along_0_m"]
    assert found == pytest.approx(held)


@pytest.mark.parametrize(
    "octets", [UPDATE, ALL, TURNING, UNKNOWN, DAMAGED, NO_PLACE, IDENTIFICATION, SIGNED, SIGNED_LONG]
)
def test_json_of_a_message_encodes_to_its_octets(octets: bytes, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["encode", json.dumps(document_of(octets, capsys))]) == 0
    assert capsys.readouterr().out == f"{octets.hex()}\n"


def test_a_held_model_is_shown_with_names_units_and_path(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["decode", UPDATE.hex()]) == 0
    shown = capsys.readouterr()
    lines = [" ".join(line.replace("│", " ").split()) for line in shown.out.splitlines()]
    assert shown.err == ""
    for line in (
        f"profile {WIRE.number:06x}, held",
        "sub-model 0, learned",
        "learned: along 1 1.2 m",
        "learned: left 2 16 m",
    ):
        assert line in lines
    assert sum(line.startswith("displacement after") for line in lines) == 3
    assert max(len(line) for line in shown.out.splitlines()) <= 80


def test_an_unknown_profile_is_said_and_coasts(capsys: pytest.CaptureFixture[str]) -> None:
    """Ten metres a second north, whatever acceleration Part I tells."""
    assert run(["decode", UNKNOWN.hex()]) == 0
    assert "unknown profile: constant velocity" in capsys.readouterr().out
    model = document_of(UNKNOWN, capsys)["regional"][1]["model"]
    assert (model["held"], model["octets"]) == (False, "0102")
    for horizon, (east, north) in model["predicted_m"].items():
        assert (east, north) == pytest.approx((0.0, 10.0 * float(horizon)), abs=1e-9)


def test_a_profile_that_is_named_is_held(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Constant acceleration along a straight course: 10 t + t^2."""
    profile = Profile(Bank((ConstantVelocity(), ConstantTurnRateAcceleration()), "example"))
    path = tmp_path / "profile.json"
    write_profile(profile, path)
    wire = WireProfile.of_profile(profile)
    octets = UpdateCodec(wire).encode(UpdateMessage(NORTH, 1, carries_all=False, codes=((),)))
    assert document_of(octets, capsys)["regional"][0]["model"]["held"] is False
    document = document_of(octets, capsys, "--profile", str(path))
    model = document["regional"][0]["model"]
    assert model["name"] == "ctra"
    assert model["predicted_m"]["1"] == pytest.approx([0.0, 11.0], abs=1e-6)
    assert run(["encode", json.dumps(document), "--profile", str(path)]) == 0
    assert capsys.readouterr().out == f"{octets.hex()}\n"
    assert run(["encode", json.dumps(document)]) == 2
    assert "is not held" in capsys.readouterr().err


def test_a_damaged_model_leaves_the_message_and_ends_with_code_3(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["decode", DAMAGED.hex()]) == 3
    shown = capsys.readouterr()
    assert "10 m/s" in shown.out
    fault = document_of(DAMAGED, capsys)["fault"]
    assert f"bit {fault['bit']}: model: sub-model 7 of {len(WIRE.layouts)}" in shown.err


def test_without_a_place_nothing_is_predicted(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["decode", NO_PLACE.hex()]) == 0
    assert "nothing is predicted: Part I lacks" in " ".join(capsys.readouterr().out.split())
    assert document_of(NO_PLACE, capsys)["regional"][0]["model"]["predicted_m"] is None


def test_a_signed_message_is_opened(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["decode", SIGNED.hex()]) == 0
    shown = capsys.readouterr().out
    for text in (CERTIFICATE.digest.hex(), "the signature is not verified", "learned: along 1"):
        assert text in shown
    assert document_of(SIGNED_LONG, capsys)["signer"]["duration_s"] == 60


def test_a_signed_message_with_another_payload_is_shown_and_told(capsys: pytest.CaptureFixture[str]) -> None:
    octets = SignedMessage(5, b"\2other", bytes(8), bytes(64)).octets
    assert run(["decode", octets.hex()]) == 3
    assert "payload: bit" in capsys.readouterr().err
    assert run(["encode", json.dumps(document_of(octets, capsys))]) == 0
    assert capsys.readouterr().out == f"{octets.hex()}\n"


@pytest.mark.parametrize("octets", [UPDATE, IDENTIFICATION, SIGNED, SIGNED_LONG], ids=len)
def test_bent_and_cut_octets_never_end_in_an_internal_error(
    octets: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    chance = random.Random(4)  # noqa: S311 - not for secrets
    lines: list[str] = []
    for _ in range(60):
        bent = bytearray(octets[: chance.choice([len(octets), chance.randint(1, len(octets))])])
        bent[chance.randrange(len(bent))] ^= 1 << chance.randrange(8)
        lines.append(bent.hex())
    path = tmp_path / "bent.hex"
    path.write_text("\n".join(lines))
    assert run(["decode", "--json", str(path)]) in {0, 2, 3}
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("document", "told"),
    [
        ({"message": "identification"}, "an identification has"),
        (IDENTIFIES | {"temporary_id": "00 00 01"}, "temporary_id must be 8 hexadecimal digits"),
        (IDENTIFIES | {"temporary_id": "0000000z"}, "temporary_id must be 8 hexadecimal digits"),
        (IDENTIFIES | {"sequence": 10**400}, "sequence"),
        ({"message": "signed"}, "the payload of a signed message"),
        ({"message": "signed", "payload": {"message": "signed"}}, "the payload of a signed message"),
        ({"message": "signed", "payload": {"message": "octets", "octets": "00"}}, "issuer must be"),
        ({"message": "signed", "payload": {"message": "octets", "octets": "0z"}}, "octets must be"),
    ],
)
def test_documents_of_no_message_are_refused(
    document: dict[str, Any], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["encode", json.dumps(document)]) == 2
    assert told in capsys.readouterr().err


@pytest.mark.parametrize(
    "change",
    [
        {"profile": "zz"},
        {"profile": 3},
        {"profile": "14 2b "},
        {"sub_model": 9},
        {"sub_model": None},
        {"carries_all": 1},
        {"carries_all": True},
        {"coefficients": {"learned": {"along_0_m": "far"}}},
        {"coefficients": None},
        {"octets": "00"},
    ],
)
def test_models_that_do_not_fit_are_refused(
    change: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    document = document_of(UPDATE, capsys)
    document["regional"][0]["model"] |= change
    assert run(["encode", json.dumps(document)]) == 2
    assert capsys.readouterr().err.startswith("modelcast: argument, message 1: ")
