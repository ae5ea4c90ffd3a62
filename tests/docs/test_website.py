"""What the site is gathered from, and what its checks find; `tests/verify/test_site.py` builds it."""

import json
import re
import shutil
import sys
from collections.abc import Callable
from pathlib import Path, PurePosixPath

import pytest

from modelcast.core.public_names import names_by_subject
from modelcast.report.style import IDENTIFICATION_COLOUR, POLICY_COLOURS

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[2] / "tools" / "website"))
from code_blocks import ROOT
from dead_links import dead_links
from docstring_text import short_signature
from navigation import FRONT_PAGE, Page, SiteError, read_navigation
from sources import staged, write_sources

sys.path.pop(0)
sys.path.pop(0)

Project = Callable[..., Path]
LIKE_AN_ARRAY = (
    "~n._Buffer | ~n._SupportsArray[~n.dtype[~t.Any]] | "
    "~n._NestedSequence[~n._SupportsArray[~n.dtype[~t.Any]]] | "
    "complex | bytes | str | ~n._NestedSequence[complex | bytes | str]"
)
"""As Sphinx has NumPy's `ArrayLike`."""


@pytest.fixture
def project(tmp_path: Path) -> Project:
    """A project of a front page and of other files, by their names."""

    def made(front: str, **files: str) -> Path:
        texts = {
            "docs/index.md": front,
            **{name.replace("__", "/") + ".md": text for name, text in files.items()},
        }
        for name, text in texts.items():
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).write_text(text)
        return tmp_path

    return made


def front_of(*rows: str) -> str:
    return "\n".join(
        ["# Front", "<!-- pages -->", "## One", "What it is.", "", *rows, "<!-- /pages -->", "End."]
    )


def test_the_front_page_names_every_page() -> None:
    front, sections = read_navigation(ROOT)
    assert len({section.slug for section in sections}) == len(sections)
    assert "## " not in front.partition("\n")[2].replace("### ", "")
    named = [page.path for section in sections for page in section.pages]
    assert len(named) > 80


def test_every_link_leads_to_a_file_and_to_a_heading_in_it(tmp_path: Path) -> None:
    """Of all pages and of what they link to, as those who read the files by themselves follow them."""
    front, sections = read_navigation(ROOT)
    pages = [FRONT_PAGE, *(page.path for section in sections for page in section.pages)]
    write_sources(ROOT, tmp_path, pages, {FRONT_PAGE: front})
    texts = {path: path.read_text(encoding="utf-8") for path in tmp_path.rglob("*.md")}
    places = {path: places_in(text) for path, text in texts.items()}
    dead: list[str] = []
    for path, text in texts.items():
        for target, place in re.findall(r"\]\(([^)\s#:]*)#([^)\s]+)\)", without_code(text)):
            if place not in places[(path.parent / target).resolve() if target else path]:
                dead.append(f"{path.relative_to(tmp_path)}: {target}#{place}")
    assert dead == []
    assert len(texts) > 100


def without_code(text: str) -> str:
    return re.sub(r"^ *(`{3,}).*?^ *\1$|(?<!`)`[^`\n]+`(?=[^\]])", "", text, flags=re.MULTILINE | re.DOTALL)


def places_in(text: str) -> set[str]:
    """Anchors of a page's headings: as GitHub makes them."""
    outside = re.sub(r"^ *(`{3,}).*?^ *\1$", "", text, flags=re.MULTILINE | re.DOTALL)
    found: list[str] = []
    for title in re.findall(r"^#+ (.+)$", outside, re.MULTILINE):
        words = re.sub(r"\]\([^)]*\)", "", title).lower()
        plain = re.sub(r"[^\w\- ]", "", words).strip().replace(" ", "-")
        found.append(plain if plain not in found else f"{plain}-{found.count(plain)}")
    return set(found)


def test_a_page_that_is_called_by_a_number_says_its_subject_in_menus() -> None:
    place = PurePosixPath("docs/a.md")
    assert Page("007", place, "the velocity estimator").in_menus == "007 the velocity estimator"
    assert Page("the idea", place, "why to send").in_menus == "The idea"


def test_a_page_in_no_table_is_told(project: Project) -> None:
    root = project(front_of("| [a](a.md) | what a is |"), docs__a="# A", docs__b="# B")
    with pytest.raises(SiteError, match=r"^docs/b.md stands in no table of docs/index.md$"):
        read_navigation(root)


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        (["| [a](a.md) | a |", "| [a](a.md) | a |"], "docs/a.md stands there twice"),
        (["| [a](a.md) | a |", "| [c](c.md) | c |"], "there is no docs/c.md"),
        (["| [a](a.md) |"], r"docs/index.md:6: not a row"),
        ([], "One has no page"),
    ],
)
def test_tables_that_are_not_understood_are_told(project: Project, rows: list[str], told: str) -> None:
    root = project(front_of(*rows), docs__a="# A")
    with pytest.raises(SiteError, match=told):
        read_navigation(root)


def test_a_front_page_without_tables_is_told(project: Project) -> None:
    with pytest.raises(SiteError, match="no tables between"):
        read_navigation(project("# Front"))


def test_links_out_of_docs_lead_to_pages_of_the_site(project: Project, tmp_path: Path) -> None:
    """Code is left alone; what is linked to is followed; a page that is in no menu says so."""
    text = "[r](../../README.md#it) `[c](no.md)` [`a`](../../README.md)\n\n```text\n[c](no.md)\n```\n[w](https://a.b)\n"
    root = project("", docs__deep__a=text, docs__x="", README="[x](docs/x.md)")
    out = tmp_path / "out"
    write_sources(root, out, [PurePosixPath("docs/deep/a.md")], {})
    assert (out / "deep" / "a.md").read_text() == text.replace("../../README", "../repository/README")
    assert (out / "repository" / "README.md").read_text().endswith("\n[x](../x.md)\n")
    assert "orphan: true" in (out / "repository" / "README.md").read_text()


def test_a_link_to_nothing_is_told(project: Project, tmp_path: Path) -> None:
    root = project("", docs__a="[gone](../src/gone.py)")
    with pytest.raises(SiteError, match=r"^docs/a.md: a link to src/gone.py, which is no file$"):
        write_sources(root, tmp_path / "out", [PurePosixPath("docs/a.md")], {})


def test_notebooks_and_programs_become_pages(project: Project, tmp_path: Path) -> None:
    root = project("", docs__a="[n](../n.ipynb) [p](../p.py)")
    cells = [{"cell_type": "markdown", "source": ["# Title"]}, {"cell_type": "code", "source": ["1 + 1"]}]
    (root / "n.ipynb").write_text(json.dumps({"cells": cells}))
    (root / "p.py").write_text("print()\n")
    out = tmp_path / "out"
    write_sources(root, out, [PurePosixPath("docs/a.md")], {})
    assert (out / "a.md").read_text() == "[n](repository/n.ipynb.md) [p](repository/p.py.md)\n"
    assert re.search(r"# Title\n\n(`+)python\n1 \+ 1\n\1", (out / "repository" / "n.ipynb.md").read_text())
    assert "python\nprint()\n" in (out / "repository" / "p.py.md").read_text()


def test_what_built_pages_lead_to_is_looked_at(tmp_path: Path) -> None:
    (tmp_path / "a.html").write_text(
        '<h1 id="here"></h1><a href="#here"></a><a href="b.html#there"></a><a href="https://example.org"></a>'
        '<a href="b.html#nowhere"></a><img src="no.png"><script src="https://example.org/x.js"></script>'
    )
    (tmp_path / "b.html").write_text('<p id="there"></p>')
    assert dead_links(tmp_path) == [
        "a.html: b.html#nowhere is no place in that page",
        "a.html: no.png is no file of the site",
        "a.html: asks https://example.org/x.js of another host",
    ]


def test_a_name_of_a_layer_without_a_subject_is_told() -> None:
    with pytest.raises(LookupError, match="Thing is of elsewhere, which has no subject"):
        list(names_by_subject({"Thing": "elsewhere.thing"}))


def test_the_site_has_the_colours_of_the_figures() -> None:
    style = (ROOT / "tools" / "website" / "static" / "site.css").read_text(encoding="utf-8")
    primary = re.findall(r'data-theme="(\w+)".*?--pst-color-primary: (#\w+)', style, re.DOTALL)
    assert dict(primary) == {"light": POLICY_COLOURS["mbc"], "dark": IDENTIFICATION_COLOUR}


@pytest.mark.parametrize(
    ("sphinx", "shown"),
    [
        ("(a: ~typing.Annotated[int, ~rules.Number(0, (1, 2))] = 3)", "(a: int = 3)"),
        (
            "(a: ~typing.Annotated[A | None, Maybe(of=One(kinds=(<class 'A'>,), words='a ]'))] = 1)",
            "(a: A | None = 1)",
        ),
        ("(a: ~typing.Annotated[list[~typing.Annotated[int, X()]], Y()])", "(a: list[int])"),
        (
            "(a: Drivers = Drivers(gap_m=(1.0, 2.0), name=')'), b: int = 1)",
            "(a: Drivers = Drivers(...), b: int = 1)",
        ),
        ("(a: set[int] = frozenset())", "(a: set[int] = frozenset())"),
        ("(a: list[int] = <factory>)", "(a: list[int] = ...)"),
        (
            f"(a: {LIKE_AN_ARRAY} | None)",
            "(a: ~numpy.typing.ArrayLike | None)",
        ),
    ],
)
def test_signatures_say_kinds_and_defaults_shortly(sphinx: str, shown: str) -> None:
    assert short_signature(sphinx) == shown


def test_a_file_keeps_its_name_below_docs_alone() -> None:
    names = ("docs/a/b.md", "docs/data.json", "README.md", "src/a.py")
    assert [str(staged(PurePosixPath(name))) for name in names] == [
        "a/b.md",
        "data.json",
        "repository/README.md",
        "repository/src/a.py.md",
    ]


def test_pictures_are_copied(tmp_path: Path) -> None:
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "a.md").write_text("![what it shows](a.png)")
    shutil.copyfile(ROOT / "LICENSE", tmp_path / "docs" / "a.png")
    write_sources(tmp_path, tmp_path / "out", [PurePosixPath("docs/a.md")], {})
    assert (tmp_path / "out" / "a.png").read_bytes() == (ROOT / "LICENSE").read_bytes()
