"""Claims about what ``modelcast decode`` makes of files that hold more, or other, than one message a line."""

import json
from pathlib import Path
from typing import Any

import pytest

from modelcast.cli.app import run
from modelcast.messages.bsm import BsmCore, encode_bsm
from modelcast.messages.ieee1609 import encode_unsecured


def frame(count: int, more: int = 0) -> bytes:
    core = BsmCore.from_values({"message_count": count, "temporary_id": 1, "yaw_rate_radps": 0.0})
    return encode_bsm(core, regional=((200, bytes(more)),) if more else ())


ONE, TWO, LONG = frame(1), frame(2), frame(3, 150)
SIGNED = b"\x03\x81\x00\x40" + encode_unsecured(ONE) + bytes.fromhex("400120") + bytes(80)
HASH_ONLY = b"\x03\x81\x00\x20\x80" + bytes(40)


def decoded(
    content: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> tuple[int, list[dict[str, Any]], list[str]]:
    """Code, documents, and complaints with the path taken off."""
    path = tmp_path / "given"
    path.write_bytes(content)
    code = run(["decode", "--json", str(path)])
    shown = capsys.readouterr()
    documents = [json.loads(line) for line in shown.out.splitlines()]
    return code, documents, shown.err.replace(f"modelcast: {path}", "").splitlines()


def counts(documents: list[dict[str, Any]]) -> list[int]:
    return [document.get("payload", document)["message_count"] for document in documents]


@pytest.mark.parametrize("payload", [ONE, LONG], ids=["short length", "long length"])
@pytest.mark.parametrize("text", [False, True])
def test_an_unsecured_spdu_is_decoded_and_named(
    payload: bytes, text: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = encode_unsecured(payload)
    code, documents, told = decoded(data.hex().encode() if text else data, tmp_path, capsys)
    assert (code, told) == (0, [])
    assert documents[0]["message"] == "ieee1609-unsecured"
    assert run(["decode", data.hex()]) == 0
    assert "an unsecured IEEE 1609.2 SPDU (03 80)" in capsys.readouterr().out
    assert run(["encode", json.dumps(documents[0])]) == 0
    assert capsys.readouterr().out == f"{data.hex()}\n"
    assert run(["decode", "--json", payload.hex()]) == 0
    assert json.loads(capsys.readouterr().out) == documents[0]["payload"]


@pytest.mark.parametrize(
    ("data", "name"),
    [
        (HASH_ONLY, "a signed IEEE 1609.2 SPDU (03 81): its content is not read"),
        (b"\x03\x82" + bytes(60), "an encrypted IEEE 1609.2 SPDU (03 82): its content is not read"),
        (b"\x03\x83\x05" + bytes(5), "a certificate request in an IEEE 1609.2 SPDU (03 83)"),
        (encode_unsecured(ONE)[:-1], "(03 80) with a payload of 40 octets, and 39 are here: cut short"),
        (
            encode_unsecured(b"\x00\x13\x01\x00"),
            "payload from octet 3 on: message id 19 where 20 is expected: signal",
        ),
        (bytes.fromhex("d4c3b2a1") + bytes(30), "record 1: the file ends within its head"),
        (bytes.fromhex("0a0d0d0a") + bytes(30), "a capture file (pcapng), and no message in it"),
        (bytes.fromhex("1f8b0800") + bytes(30), "a compressed file (gzip), and no message in it"),
    ],
)
def test_what_is_not_read_is_told_by_its_name(
    data: bytes, name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, documents, (told,) = decoded(data, tmp_path, capsys)
    assert (code, documents) == (2, [])
    assert name in told
    assert "octets needed" not in told


@pytest.mark.parametrize("text", [False, True])
def test_the_message_in_a_signed_spdu_is_shown_and_the_rest_counted(
    text: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, documents, told = decoded(SIGNED.hex().encode() if text else SIGNED, tmp_path, capsys)
    assert (code, counts(documents)) == (3, [1])
    assert (
        "4 octets in front of the message at octet 4 not read: a signed IEEE 1609.2 SPDU (03 81)" in told[0]
    )
    assert "83 octets left over" in told[1]
    assert "not verified" in told[1]


def test_a_message_behind_headers_is_found_and_its_place_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    spdu = encode_unsecured(ONE)
    wsmp = bytes([3, 0, 0x20, len(spdu)]) + spdu
    for data, place, name in (
        (wsmp, 4, "a WSMP header"),
        (bytes(12) + b"\x88\xdc" + wsmp, 18, "a link-layer header (88 dc) and a WSMP header"),
        (b"\x45" * 28 + ONE, 28, "45454545"),
    ):
        code, documents, (told,) = decoded(data, tmp_path, capsys)
        assert (code, counts(documents)) == (3, [1])
        assert f"in front of the message at octet {place} not read: {name}" in told


@pytest.mark.parametrize(
    ("content", "ends"),
    [
        (ONE + TWO + LONG, (0, [1, 2, 3], [])),
        (ONE + b"\n", (3, [1], [", octet 40: 1 octet left over: 0a"])),
        (
            ONE + b"\n" + TWO,
            (3, [1, 2], [", octet 40: 1 octet in front of the message at octet 41 not read: 0a"]),
        ),
        (ONE + bytes(60), (3, [1], [", octet 40: 60 octets left over: zeros"])),
        (
            (ONE + bytes(60)).hex().encode(),
            (3, [1], [", line 1, octet 40: 60 octets left over: zeros"]),
        ),
        (
            ONE + TWO[:20],
            (
                3,
                [1],
                [", octet 40: 20 octets left over: the beginning of a message of 40 octets, cut short"],
            ),
        ),
        (
            b'Messages\nfirst = "' + ONE.hex().encode() + b'"\n',
            (3, [1], [", line 1: column 1: 'M' is not a hexadecimal digit"]),
        ),
    ],
    ids=["several", "line end", "line end between", "padding", "padding in digits", "cut", "labels"],
)
def test_whole_messages_are_shown_and_the_rest_told(
    content: bytes,
    ends: tuple[int, list[int], list[str]],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    code, documents, told = decoded(content, tmp_path, capsys)
    assert (code, counts(documents), told) == ends


def test_wrapped_digits_are_one_message_or_one_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    digits = LONG.hex()
    lines = [digits[at : at + 60].encode() for at in range(0, len(digits), 60)]
    code, documents, told = decoded(b"\n".join(lines), tmp_path, capsys)
    assert (code, counts(documents), told) == (0, [3], [])
    code, documents, (only,) = decoded(b"\n".join(lines[:3]), tmp_path, capsys)
    assert (code, documents) == (2, [])
    assert ", lines 1 to 3: " in only
    assert f"the beginning of a message of {len(LONG)} octets, of which 90 are here" in only


def test_an_argument_is_read_as_a_file_is(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["decode", "--json", f"BSM = {ONE.hex()}\n{TWO.hex()[:40]}\n{TWO.hex()[40:]}"]) == 0
    assert counts([json.loads(line) for line in capsys.readouterr().out.splitlines()]) == [1, 2]
    assert run(["decode", f"{ONE.hex()[:-1]}x"]) == 2
    assert "column 80: 'x' is not a hexadecimal digit" in capsys.readouterr().err


def test_a_device_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["decode", "/dev/null"]) == 2
    assert "a device, not a file" in capsys.readouterr().err


def test_all_fields_that_are_missing_are_named_at_once(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["encode", "{}"]) == 2
    told = capsys.readouterr().err
    assert "message_count, temporary_id and yaw_rate_radps must be given" in told
    assert run(["encode", '{"message_count": 1}']) == 2
    assert "temporary_id and yaw_rate_radps must be given" in capsys.readouterr().err
