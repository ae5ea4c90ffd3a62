"""Claims about ``modelcast decode`` and ``modelcast encode`` of personal safety messages."""

import json
from pathlib import Path

import pytest

from modelcast.cli.app import run
from modelcast.io.pcap import pcap_octets
from modelcast.messages.bsm import BsmCore, encode_bsm
from modelcast.messages.ieee1609 import encode_unsecured
from modelcast.messages.psm import PersonalSafetyMessage, encode_psm, person_codes
from modelcast.messages.wsmp import decode_wsm, encode_wsm

CODES = person_codes({"basic_type": 2, "message_count": 7, "temporary_id": 1, "speed_mps": 4.2})
CRUMB = (100, -100, 0, 250, 70, None, 60)
PLAIN = encode_psm(PersonalSafetyMessage(CODES))
RICH = encode_psm(
    PersonalSafetyMessage(
        CODES,
        acceleration=(100, 0, 0, 0),
        path_prediction=(-123, 100),
        parts=(
            ("path_history", (None, None, (CRUMB, CRUMB))),
            ("propulsion", (2, 3)),
            ("use_state", 0b000001000),
            ("cross_state", 1),
            ("attachment_radius_m", 15),
        ),
        regional=((200, b"other"),),
        additions=(None, b"later"),
    )
)


def test_a_message_is_shown_with_units_and_its_optional_parts(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    assert run(["decode", RICH.hex()]) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    lines = [" ".join(line.replace("│", " ").split()) for line in shown.out.splitlines()]
    for line in (
        f"argument: personal safety message, {len(RICH)} bytes",
        "basic type basicType aPEDALCYCLIST 2",
        "speed speed 4.2 m/s 210",
        "latitude position.lat unavailable 900000001",
        "acceleration accelSet",
        "acceleration forward long 1 m/s² 100",
        "path radius radiusOfCurve -12.3 m -123",
        "crumb PathHistoryPoint",
        "age timeOffset 2.5 s 250",
        "motor motor bicycle 3",
        "use state useState calling 8",
        "cross state crossState yes 1",
        "attachment radius attachmentRadius 1.5 m 15",
        "regional extension, id 200, 5 bytes: 6f74686572",
        "extension addition, number 1, 5 bytes: 6c61746572",
    ):
        assert line in lines
    assert max(len(line) for line in shown.out.splitlines()) <= 80


@pytest.mark.parametrize("octets", [PLAIN, RICH, encode_unsecured(RICH)], ids=["plain", "rich", "unsecured"])
def test_json_of_a_message_encodes_to_its_octets(octets: bytes, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["decode", "--json", octets.hex()]) == 0
    document = capsys.readouterr().out
    told = json.loads(document)
    assert told.get("payload", told)["message"] == "psm"
    assert run(["encode", document]) == 0
    assert capsys.readouterr().out == f"{octets.hex()}\n"


def test_messages_of_people_and_vehicles_are_read_one_after_another(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    vehicle = encode_bsm(BsmCore.from_values({"message_count": 9, "temporary_id": 2, "yaw_rate_radps": 0.0}))
    path = tmp_path / "messages.bin"
    path.write_bytes(PLAIN + vehicle + RICH + PLAIN)
    assert run(["decode", "--json", str(path)]) == 0
    found = [json.loads(line)["message"] for line in capsys.readouterr().out.splitlines()]
    assert found == ["psm", "bsm", "psm", "psm"]


def test_a_capture_of_the_application_of_people_is_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    wsm = encode_wsm(encode_unsecured(RICH))
    wsm = wsm[:2] + b"\x27" + wsm[3:]
    assert decode_wsm(wsm).psid == 0x27
    path = tmp_path / "people.pcap"
    path.write_bytes(b"".join(pcap_octets([(1_700_000_000 * 10**9, wsm)])))
    assert run(["decode", "--json", str(path)]) == 0
    (document,) = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert document["payload"]["propulsion"] == {"motor": "bicycle"}


def test_a_message_that_cannot_be_read_tells_the_bit_and_the_reason(
    capsys: pytest.CaptureFixture[str],
) -> None:
    bent = bytearray(PLAIN)
    bent[3 + 78 // 8] |= 0x80 >> 78 % 8
    assert run(["decode", bent.hex()]) == 2
    assert "bit 102: extensions of position are not read" in capsys.readouterr().err
    assert run(["encode", json.dumps({"message": "psm", "message_count": 1})]) == 2
    assert "temporary_id must be given; all other fields may be left out" in capsys.readouterr().err
