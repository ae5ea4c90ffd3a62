"""Claims about help: a group and a line for each command, a sentence and an example that can be typed."""

import re
import shlex
from pathlib import Path

import pytest

from modelcast.cli.app import app, run
from modelcast.cli.command_list import COMMAND_GROUPS, COMMANDS, FIRST_STEPS

WIDEST_LINE = 66
"""So that a line of a command fits beside its name in 80 columns."""


def test_the_whole_lists_every_command_under_its_group_with_a_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["--help"]) == 0
    shown = capsys.readouterr().out
    at = [shown.index(f" {title} ") for title in COMMAND_GROUPS]
    assert at == sorted(at)
    for place, (title, lines) in enumerate(COMMAND_GROUPS.items()):
        end = at[place + 1] if place + 1 < len(at) else len(shown)
        within = shown[at[place] : end]
        for name, line in lines.items():
            assert re.search(rf"│ {name} +{re.escape(line)} +│", within), (title, name)


def test_lines_fit_and_say_different_things() -> None:
    lines = [line for group in COMMAND_GROUPS.values() for line in group.values()]
    assert len(set(lines)) == len(lines)
    assert max(map(len, lines)) <= WIDEST_LINE


def test_alone_it_shows_the_first_three_commands(capsys: pytest.CaptureFixture[str]) -> None:
    assert run([]) == 0
    shown = capsys.readouterr().out
    assert shown.splitlines() == FIRST_STEPS.splitlines()
    assert re.findall(r"^  modelcast (\w+)", shown, re.MULTILINE) == ["demo", "trips", "evaluate"]


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_begins_with_a_sentence_and_an_example_that_is_taken(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run([command, "--help"]) == 0
    usage, sentence, example, *_ = capsys.readouterr().out.split("\n\n")
    assert usage.startswith(f"Usage: modelcast {command}")
    assert re.fullmatch(r"[A-Z].*[.]", " ".join(sentence.split()))
    typed = re.fullmatch(r"For example: modelcast (.*)", " ".join(example.split()))
    assert typed is not None
    words = shlex.split(typed[1])
    assert words[0] == command
    app.parse_args(words, exit_on_error=False, print_error=False)  # raises where it is not taken


def test_completion_is_written_for_a_shell_and_names_commands_and_options(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    script = tmp_path / "completion.bash"
    assert run(["--install-completion", "--shell", "bash", "--output", str(script)]) == 0
    assert str(script) in capsys.readouterr().out
    text = script.read_text(encoding="utf-8")
    for word in (*COMMANDS, "--threshold", "--penetration"):
        assert word in text
    assert str(script) in (tmp_path / ".bashrc").read_text(encoding="utf-8")
