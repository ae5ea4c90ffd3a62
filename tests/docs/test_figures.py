"""Every table in a page is made by a registered command, and numbers in prose are those of the tables."""

import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "validation"))
from figures import (
    blocks_made,
    blocks_of_pages,
    faults_of_sources,
    kept_numbers,
    loose_in_pages,
    makers,
    unread_pages,
)
from number_sources import Source, faults_of, sources
from prose_numbers import loose_numbers

sys.path.pop(0)

ROOT = Path(__file__).parents[2]


def test_every_block_of_a_page_is_made_by_one_registered_command() -> None:
    made = [(page, name) for page, name, _ in blocks_made()]
    assert Counter(blocks_of_pages()) == Counter(made)


def test_every_registered_command_takes_what_it_is_called_with() -> None:
    for maker in makers():
        text = (ROOT / maker.script).read_text(encoding="utf-8")
        assert ('"--check"' in text) is maker.checks, maker.script
        assert not maker.writes or all(f'"{word}"' in text for word in maker.writing), maker.script
        assert maker.takes in {"seconds", "minutes", "hours"}, maker.script


def test_loose_numbers_are_the_known_ones() -> None:
    """Numbers in prose that nothing accounts for, each by its text.

    ``python validation/figures.py --numbers`` tells where they stand. To take one away, put it into a block
    that a script makes, tell in ``number_sources.toml`` where it comes from, or say it without a number.
    ``--keep`` writes the list anew, for who has looked at each.
    """
    found = {page: Counter(one.text for one in loose) for page, loose in loose_in_pages().items() if loose}
    known = {page: Counter(texts) for page, texts in kept_numbers().items()}
    pages = found.keys() | known.keys()
    none = Counter[str]()
    new = {page: found.get(page, none) - known.get(page, none) for page in pages}
    gone = {page: known.get(page, none) - found.get(page, none) for page in pages}
    assert {page: sorted(texts) for page, texts in new.items() if texts} == {}, "not known"
    assert {page: sorted(texts) for page, texts in gone.items() if texts} == {}, "known, but gone"


def test_numbers_with_a_source_are_those_of_the_source() -> None:
    """What ``number_sources.toml`` quotes stands in the page, and in the code or block that it names."""
    assert faults_of_sources() == []


def test_pages_that_nobody_has_gone_through_are_pages_without_sources_or_blocks() -> None:
    assert set(unread_pages()) <= {
        page.relative_to(ROOT).as_posix() for page in (ROOT / "docs").rglob("*.md")
    }
    assert not set(unread_pages()) & {*sources(), *(page for page, _ in blocks_of_pages())}


@pytest.mark.slow
def test_pages_say_what_the_quick_commands_say() -> None:
    """``make figures`` would change no page."""
    ended = subprocess.run(  # noqa: S603 - ours
        [sys.executable, str(ROOT / "validation" / "figures.py"), "--check"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert ended.stdout.count("as the page has it") >= 3


PAGE = """\
It saves {saved} % at a threshold of 20 cm, p90 {p90} m, over 1,200 m of road.

<!-- begin gains -->
| saved | p90 |
|---|---|
| 42 | 1.58 |
<!-- end gains -->

{mark}
It saves 42 %.

<!-- begin others -->
| 7 |
<!-- end others -->
"""
SCRIPT = "THRESHOLD_M, LENGTH_M = 0.20, 1200.0"


@pytest.mark.parametrize(
    ("saved", "p90", "mark", "loose"),
    [
        ("42", "1.58", "", []),
        ("43", "1.58", "", ["43 %"]),
        ("42", "1.6", "", ["1.6 m"]),
        ("42", "1.58", "<!-- from gains -->", []),
        ("42", "1.58", "<!-- from others -->", ["42 %"]),
        ("42", "1.58", "<!-- from gains, others -->", []),
    ],
)
def test_prose_that_a_table_has_overtaken_is_found(saved: str, p90: str, mark: str, loose: list[str]) -> None:
    page = PAGE.format(saved=saved, p90=p90, mark=mark)
    assert [one.text for one in loose_numbers(page, [SCRIPT])] == loose


def test_settings_are_those_of_the_script_in_any_unit_of_length() -> None:
    page = PAGE.format(saved="42", p90="1.58", mark="")
    assert [one.text for one in loose_numbers(page, ["nothing is said here"])] == ["20 cm", "1,200 m"]


def test_ratios_count_where_decimals_do() -> None:
    page = "It needs 0.67 of the messages.\n"
    assert loose_numbers(page, []) == []
    assert [one.text for one in loose_numbers(page, [], decimals=True)] == ["0.67"]
    assert loose_numbers(page, [], ["needs 0.67 of"], decimals=True) == []


def test_a_mark_that_names_no_block_is_an_error() -> None:
    with pytest.raises(ValueError, match="no block gone"):
        loose_numbers("<!-- from gone -->\nIt is 3 %.\n", [])


TABLES = {"a.md": "<!-- begin rates -->\n| mbc | 0.88 | 1,200 |\n| cv | 0.70 | 7 |\n<!-- end rates -->\n"}
SENDS = "It sends 12 % fewer\nmessages, 7 of 1,200, within 0.45 s, in 2 s."
INTERVAL = ["modelcast.messages.airtime.Stack.certificate_interval_s"]


@pytest.mark.parametrize(
    ("source", "fault"),
    [
        (Source("sends 12 % fewer", block="a.md rates", row="mbc", sum=["1 - 0.88"]), ""),
        (Source("sends 12 % fewer", block="a.md rates", row="cv", sum=["1 - 0.88"]), "0.88 has no source"),
        (Source("sends 12 % fewer", block="a.md rates", sum=["1 - 0.70"]), "12 % is not what the source has"),
        (Source("sends 12 % fewer", block="a.md rates", sum=["0.88 + 12"]), "12 has no source"),
        (Source("7 of 1,200", sum=["7 * 1200 / 7"]), "7 has no source"),
        (Source("of 1,200", sum=["7 * 100 + 500"]), "500 has no source"),
        (Source("sends 2 of 100", block="a.md rates", sum=["2 * 0.88"]), "the page does not say so"),
        (Source("in 2 s", sum=["2 * 12"]), "2 s is not what the source has"),
        (Source("fewer messages, 7 of 1,200", block="a.md rates"), ""),
        (Source("7 of 1,200", block="a.md rates", row="cv"), "1,200 is not what the source has"),
        (Source("within 0.45 s", code=INTERVAL), ""),
        (Source("7 of 1,200", code=INTERVAL), "7 of is not what the source has"),
        (Source("within 0.46 s", code=INTERVAL), "the page does not say so"),
        (Source("within 0.45 s", given="a standard"), ""),
        (Source("within 0.45 s"), "it has no source"),
        (Source("within 0.45 s", code=["modelcast.gone.NAME"]), "modelcast.gone.NAME is not there"),
        (Source("within 0.45 s", block="a.md gone"), "a.md has no block gone"),
        (Source("within 0.45 s", block="a.md rates", row="free"), "no line of rates has free"),
    ],
)
def test_a_source_agrees_with_the_page_or_says_how_it_differs(source: Source, fault: str) -> None:
    assert (faults_of(source, SENDS, TABLES) or [""])[0] == fault
