"""The tutorial does what it shows."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from tutorial import PAGE, agrees, followed

sys.path.pop(0)


@pytest.mark.parametrize(
    ("shown", "printed", "same"),
    [
        ("p90 0.56 m\n", "p90 0.57 m  \n", True),
        ("p90 0.56 m\n", "p90 0.66 m\n", False),
        ("3 trips\n", "6 trips\n", False),
        ("3 trips\n", "3 drives\n", False),
        ("a\n...\nz\n", "a\nb 1\nc 2\nz\n", True),
        ("a\n...\nz\n", "a\nb 1\nc 2\ny\n", False),
        ("a\n", "a\nb\n", False),
        ("sha256 ...\n", "sha256 12ab34\n", True),
    ],
)
def test_what_is_shown_agrees_where_words_are_alike_and_numbers_near(
    shown: str, printed: str, same: bool
) -> None:
    assert agrees(shown, printed) is same


@pytest.mark.slow
def test_the_tutorial_followed_in_an_empty_folder_shows_what_it_says(tmp_path: Path) -> None:
    for block, shown, printed in followed(tmp_path):
        assert not shown or agrees(shown, printed), f"{block.place}:\n{printed}"
    assert PAGE.read_text(encoding="utf-8").count("```console") > 6
    assert {"messages.csv", "mine.json"} <= {path.name for path in tmp_path.iterdir()}
    figures = tmp_path / "out" / "mine" / "figures"
    assert (figures / "message_rate.pdf").read_bytes().startswith(b"%PDF")
    repeated = (tmp_path / "out" / "again" / "summary.json").read_bytes()
    assert repeated == (tmp_path / "out" / "mine" / "summary.json").read_bytes()
