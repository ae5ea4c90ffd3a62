"""Claims about foreign text on the terminal: shown as it is, never obeyed."""

import io
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

import modelcast.cli
from modelcast.cli.app import run
from modelcast.cli.terminal import complain, show
from modelcast.core.printable import printable
from modelcast.messages.bsm import BsmCore, encode_bsm
from modelcast.report.literal import literal

HOSTILE = "car\x1b[31m\x07\u202e[red]:bomb:\x9b2J"
SHOWN = r"car\x1b[31m\x07\u202e[red]:bomb:\x9b2J"
MESSAGE = encode_bsm(BsmCore.from_values({"message_count": 1, "temporary_id": 1, "yaw_rate_radps": 0.0}))
CONTROL = re.compile(r"[\x00-\x09\x0b-\x1f\x7f-\x9f\u202a-\u202e]")


@given(st.text(st.characters(exclude_categories=()) | st.characters(categories=["Cc", "Cs"])))
def test_any_text_becomes_one_visible_line(text: str) -> None:
    shown = printable(text)
    assert shown.isprintable()
    shown.encode("utf-8")
    assert printable(shown) == shown


def test_markup_and_control_characters_are_shown(capsys: pytest.CaptureFixture[str]) -> None:
    complain(HOSTILE)
    show(literal(HOSTILE))
    shown = capsys.readouterr()
    assert shown.err == f"modelcast: {SHOWN}\n"
    assert shown.out == f"{SHOWN}\n"


def test_a_coloured_terminal_gets_no_foreign_colour() -> None:
    out = io.StringIO()
    Console(file=out, force_terminal=True, markup=False, emoji=False).print(literal(HOSTILE))
    assert "\x1b[31m" not in out.getvalue()
    assert "[red]" in out.getvalue()


def given_trips(folder: Path, vehicle: str) -> Path:
    """A generated straight drive as CSV, with a vehicle of that name."""
    path = folder / f"{HOSTILE}.csv"
    rows = [f"{vehicle},{i / 10},{i},{0.01 * i * i / 100}\n" for i in range(200)]
    path.write_text("vehicle,t,x,y\n" + "".join(rows), encoding="utf-8")
    return path


@pytest.mark.slow
@pytest.mark.parametrize("command", ["trips", "evaluate"])
def test_names_of_files_and_vehicles_are_not_obeyed(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = given_trips(tmp_path, HOSTILE)
    broken = tmp_path / f"broken{HOSTILE}.csv"
    broken.write_text("vehicle,t,x,y\na,0,b,c\n")
    arguments = [command, str(path), str(broken), "--columns", "t=t,east=x,north=y,vehicle=vehicle"]
    if command == "evaluate":
        arguments += ["--out", str(tmp_path / "out"), "--threshold", "0.5", "--per", "0", "--seeds", "1"]
    assert run(arguments) in (0, 3)
    shown = capsys.readouterr()
    assert not CONTROL.search(shown.out + shown.err)
    assert "[red]" in shown.out + shown.err
    if command == "evaluate":
        report = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
        assert not CONTROL.search(report)


@pytest.mark.parametrize(
    "arguments",
    [
        ["decode", HOSTILE],
        ["encode", HOSTILE],
        ["trips", HOSTILE],
        ["evaluate", f"--{HOSTILE}"],
        ["evaluate", "x.csv", "--threshold", HOSTILE],
        [HOSTILE],
        ["encode", f'{{"message": "{SHOWN}"}}'.replace("\\x", "\\u00")],
    ],
    ids=["decode", "encode", "trips", "option", "value", "command", "field"],
)
def test_errors_quote_without_obeying(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(arguments) == 2
    shown = capsys.readouterr()
    assert not CONTROL.search(shown.out + shown.err)
    assert "[31m" in shown.out + shown.err


def test_labels_in_a_file_of_digits_are_not_obeyed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / HOSTILE
    path.write_text(f"{HOSTILE}: {MESSAGE.hex()}\n{HOSTILE}\n", encoding="utf-8")
    assert run(["decode", str(path)]) == 3
    shown = capsys.readouterr()
    assert not CONTROL.search(shown.out + shown.err)
    assert SHOWN in shown.out.replace("\n", "")
    assert SHOWN in shown.err


@pytest.mark.parametrize("words", [["trips"], ["trips", "--rank"]], ids=["trips", "rank"])
def test_a_command_in_a_pipe_pads_no_line(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    path = given_trips(tmp_path, "car")
    assert run([*words, str(path), "--columns", "t=t,east=x,north=y,vehicle=vehicle"]) == 0
    lines = capsys.readouterr().out.split("\n")
    assert len(lines) > 3
    assert [line for line in lines if line.endswith(" ")] == []
    assert max(map(len, lines)) < 250


@pytest.mark.parametrize("words", [[], ["--version"], ["trips", "mine.csv"], ["trips", "mine.csv", "--json"]])
def test_an_output_that_is_closed_is_as_one_that_nobody_reads(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.csv").write_text("t,x,y\n" + "".join(f"{i / 10},{i},0\n" for i in range(50)), encoding="utf-8")
    monkeypatch.setattr("sys.stdout", None)
    assert run(words) == 0


def test_commands_reach_the_terminal_one_way_only() -> None:
    """Problems, lines and tables go through `cli/terminal.py`; what else is printed is JSON or digits."""
    for path in Path(modelcast.cli.__file__).parent.glob("*.py"):
        if path.name == "terminal.py":
            continue
        source = path.read_text(encoding="utf-8")
        assert "Console(" not in source, path.name
        assert "file=sys.stderr" not in source, path.name
        printed = re.findall(r"^(?!\s*>>>).*\bprint\((.*)\)", source, re.MULTILINE)
        assert all(re.fullmatch(r"|json_format\.dumps\(.*|octets\.hex\(\)", text) for text in printed), (
            path.name
        )
