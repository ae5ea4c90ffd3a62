"""Claims about ``modelcast decode`` and ``modelcast encode``."""

import io
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from modelcast.cli.app import run
from modelcast.messages.bsm import BasicSafetyMessage, BsmCore, encode_message
from modelcast.messages.bsm_fields import CORE_FIELDS

CORE = BsmCore.from_values(
    {"message_count": 5, "temporary_id": 0x01020304, "speed_mps": 12.34, "yaw_rate_radps": 0.0}
)
PLAIN = encode_message(BasicSafetyMessage(CORE))
RICH = encode_message(
    BasicSafetyMessage(
        BsmCore(tuple(field.high for field in CORE_FIELDS)),
        part_ii=((0, b"part"), (9, b"two")),
        regional=((200, b"other"),),
        additions=(None, b"later"),
        frame_additions=(b"frame",),
    )
)
RESERVED = encode_message(BasicSafetyMessage(BsmCore((*CORE.codes[:2], 61234, *CORE.codes[3:]))))


def given_standard_input(monkeypatch: pytest.MonkeyPatch, octets: bytes) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(octets)))


@pytest.mark.parametrize("written", [PLAIN.hex(), PLAIN.hex(" ").upper(), f"0x{PLAIN.hex()}"])
def test_a_message_in_digits_is_shown_with_units(written: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["decode", written]) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    lines = [" ".join(line.replace("│", " ").split()) for line in shown.out.splitlines()]
    assert "argument: basic safety message, 40 bytes" in lines
    assert "speed speed 12.34 m/s 617" in lines
    assert "latitude lat unavailable 900000001" in lines
    assert "temporary id id 01020304 16909060" in lines
    assert max(len(line) for line in shown.out.splitlines()) <= 80
    assert len([line for line in lines if line.endswith(tuple("0123456789"))]) == len(CORE_FIELDS)


def test_what_is_not_looked_into_is_shown_as_octets(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["decode", RICH.hex()]) == 0
    shown = capsys.readouterr().out
    for text in (
        "part II, id 0, vehicle safety extensions, 4 bytes: 70617274",
        "part II, id 9, unknown, 3 bytes",
        "regional extension, id 200, 5 bytes: 6f74686572",
        "extension addition, number 1, 5 bytes",
        "extension addition of the frame, number 0, 5 bytes",
    ):
        assert text in shown


@pytest.mark.parametrize("octets", [PLAIN, RICH, RESERVED], ids=["plain", "rich", "reserved"])
def test_json_of_a_message_encodes_to_its_octets(
    octets: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """From a file, from the standard input, as an argument; the flag changes nothing."""
    assert run(["decode", "--json", octets.hex()]) == 0
    document = capsys.readouterr().out
    path = tmp_path / "message.json"
    path.write_text(json.dumps(json.loads(document), indent=2))
    given_standard_input(monkeypatch, document.encode())
    for arguments in (["encode", str(path)], ["encode"], ["encode", "--json", document]):
        assert run(arguments) == 0
        assert capsys.readouterr().out == f"{octets.hex()}\n"


def test_json_has_si_units_names_and_nulls(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["decode", RICH.hex(), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["heading_rad"] is None
    assert document["elevation_m"] == 6143.9
    assert document["message_count"] == 127
    assert document["temporary_id"] == "ffffffff"
    assert document["transmission"] == "unavailable"
    assert document["wheel_brakes"][0] == "unavailable"
    assert document["regional"] == [{"id": 200, "octets": b"other".hex()}]
    assert document["additions"] == [None, b"later".hex()]


@pytest.mark.parametrize(
    "lines", [f"{PLAIN.hex()}\n{RICH.hex()}\n", f"# two\n\n{PLAIN.hex()}\r\n 0x{RICH.hex()}"]
)
def test_a_text_file_holds_one_message_a_line(
    lines: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "messages.hex"
    path.write_bytes(lines.encode())
    assert run(["decode", str(path), "--json"]) == 0
    found = capsys.readouterr().out
    assert len(found.splitlines()) == 2
    given_standard_input(monkeypatch, found.encode())
    assert run(["encode", "-"]) == 0
    assert capsys.readouterr().out == f"{PLAIN.hex()}\n{RICH.hex()}\n"


def test_a_binary_file_is_one_message(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "message.bin"
    path.write_bytes(PLAIN)
    assert run(["decode", str(path)]) == 0
    assert "12.34 m/s" in capsys.readouterr().out


def test_faulty_lines_are_named_and_the_others_shown(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "messages.hex"
    path.write_text(f"{PLAIN.hex()}\n{PLAIN.hex()}00\nxyz\n")
    assert run(["decode", str(path), "--json"]) == 3
    shown = capsys.readouterr()
    assert len(shown.out.splitlines()) == 2
    assert f"{path}, line 2, octet 40: 1 octet left over: zeros" in shown.err
    assert f"{path}, line 3: column 1: 'x' is not a hexadecimal digit" in shown.err


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["decode", "nowhere.hex"], "neither a file nor"),
        (["decode", "001"], "neither a file nor"),
        (["decode", "0014"], "bit 16"),
        (["decode", "ab" * 3000], "bit 1: message id"),
        (["encode", "nowhere.json"], "no file nowhere.json"),
        (["encode", "{}"], "message_count, temporary_id and yaw_rate_radps must be given"),
        (["encode", "[]"], "holds no message"),
        (["encode", ""], "holds no message"),
        (["decode", ""], "neither a file nor"),
        (["decode", "00f007000000010e80"], "bit 24: 7 octets needed, 6 left"),
        (["encode", "[1]"], "an object with fields"),
        (["encode", "{"], "not JSON"),
        (["encode", "[" * 100_000], "not JSON"),
        (["encode", '{"speed": 3}'], "no field is called speed"),
    ],
)
def test_what_is_no_message_ends_with_code_2_and_a_reason(
    arguments: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(arguments) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert told in shown.err
    assert "Traceback" not in shown.err


def test_files_without_messages_and_unreadable_ones_end_with_code_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    empty = tmp_path / "empty"
    empty.write_bytes(b"\n# nothing\n")
    assert run(["decode", str(empty)]) == 2
    assert "holds no message" in capsys.readouterr().err
    assert run(["decode", str(tmp_path)]) == 2
    assert str(tmp_path) in capsys.readouterr().err
    binary = tmp_path / "binary"
    binary.write_bytes(b"\xff\xfe")
    assert run(["encode", str(binary)]) == 2
    assert "is not text" in capsys.readouterr().err


def test_a_document_that_fails_is_named_and_the_others_written(capsys: pytest.CaptureFixture[str]) -> None:
    good: dict[str, Any] = {
        "message_count": 5,
        "temporary_id": "01020304",
        "speed_mps": 12.34,
        "yaw_rate_radps": 0,
    }
    assert run(["encode", json.dumps([good, {}, good])]) == 3
    shown = capsys.readouterr()
    assert shown.out == f"{PLAIN.hex()}\n" * 2
    assert "argument, message 2: message_count" in shown.err


def test_the_commands_compile_nothing(tmp_path: Path) -> None:
    """A message is read without the compiled batch code, so that the answer comes at once."""
    script = (
        "import sys; from modelcast.cli.app import run\n"
        f"run(['decode', '--json', '{PLAIN.hex()}'])\n"
        "assert not {'numba', 'asn1tools', 'polars'} & set(sys.modules)\n"
    )
    ended = subprocess.run(  # noqa: S603 - our own script
        [sys.executable, "-W", "error", "-c", script],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (ended.returncode, ended.stderr) == (0, "")
