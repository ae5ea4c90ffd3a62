"""Claims about wrong uses: each is answered with cause and remedy, in few lines, and changes nothing."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest
from tests.cli.wrong_uses import GROUPS, WrongUse, made_files
from tests.cli.wrong_uses_answers import PAGE, Answer, answered, page

from modelcast.cli.app import app
from modelcast.cli.command_list import COMMANDS

USES = [use for uses in GROUPS.values() for use in uses]
MOST_LINES = 3
"""What an option means, the file and its fault, and that no trip is left."""


@pytest.fixture(name="answers", scope="module")
def _answers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Mapping[WrongUse, Answer]]:
    """What all of them are told, and that the folder is as it was."""
    folder = tmp_path_factory.mktemp("wrong")
    made_files(folder)
    before = _contents(folder)
    yield {use: answered(use, folder) for use in USES}
    assert _contents(folder) == before


def _contents(folder: Path) -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("use", USES, ids=[use.what for use in USES])
def test_a_wrong_use_is_told_its_cause_and_a_remedy(
    use: WrongUse, answers: Mapping[WrongUse, Answer]
) -> None:
    told = answers[use]
    assert told.code == use.code, told.err
    assert told.out == ""
    for one in (*use.cause, use.remedy):
        assert one in told.err
    assert "Traceback" not in told.err
    lines = told.err.splitlines()
    assert len(lines) <= MOST_LINES
    assert all(line.startswith("modelcast: ") for line in lines)


def test_there_are_at_least_forty_and_none_twice() -> None:
    assert len({use.words for use in USES}) + len([use for use in USES if use.absent]) >= 40
    assert len({(use.words, use.absent) for use in USES}) == len(USES)


def test_what_the_answers_tell_to_type_exists(answers: Mapping[WrongUse, Answer]) -> None:
    """Options and commands in answers, but those that the user made up."""
    options = {"--help"}
    for name in COMMANDS:
        command = app[name]
        subs = [command[sub] for sub in command if not sub.startswith("-")]
        for one in subs or [command]:
            options |= {name for each in one.assemble_argument_collection() for name in each.names}
    for use, told in answers.items():
        made_up = {word for word in use.words if word.startswith("--")}
        assert set(re.findall(r"--[a-z][a-z-]*", told.err)) - made_up <= options | {"--upgrade"}
        for command in re.findall(r"modelcast ([a-z-]+) (?:--help|good)|'modelcast ([a-z-]+)'", told.err):
            assert set(command) - {""} <= set(COMMANDS)


def test_the_page_of_wrong_uses_shows_what_is_said(answers: Mapping[WrongUse, Answer]) -> None:
    """Mended by ``python -m tests.cli.wrong_uses_page --write``."""
    assert PAGE.read_text(encoding="utf-8") == page(dict(answers))
