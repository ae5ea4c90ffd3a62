"""Claims: each picture of the pages is light, is shown by a page, and is said in words there."""

import re
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[2] / "tools"))
from code_blocks import PAGES, ROOT

from page_screenshots import SHOWN

sys.path.pop(0)
sys.path.pop(0)

MOST_OCTETS = 150_000
FEWEST_WORDS = 8
"""Of the text for who does not see a picture: a name alone says nothing of what it shows."""


class Shown(NamedTuple):
    """A picture on a page."""

    page: str
    words: str
    file: Path


SHOWINGS = [
    Shown(page.relative_to(ROOT).as_posix(), words, (page.parent / target).resolve())
    for page in PAGES
    for words, target in re.findall(r"!\[([^\]]*)\]\(([^)\s]+)\)", page.read_text(encoding="utf-8"))
]
PICTURES = sorted((ROOT / "docs" / "images").iterdir())


@pytest.mark.parametrize("picture", PICTURES, ids=lambda path: path.name)
def test_a_picture_is_light_and_shown(picture: Path) -> None:
    assert picture.stat().st_size < MOST_OCTETS
    assert picture in {one.file for one in SHOWINGS}


@pytest.mark.parametrize("shown", SHOWINGS, ids=lambda one: f"{one.page}:{one.file.name}")
def test_a_picture_is_said_in_words_where_it_is_shown(shown: Shown) -> None:
    assert shown.file.is_file()
    assert len(shown.words.split()) >= FEWEST_WORDS


def test_pictures_of_pages_are_those_that_the_command_makes() -> None:
    assert {path.stem for path in PICTURES if path.suffix == ".webp"} == set(SHOWN)
