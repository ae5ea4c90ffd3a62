"""The order of the site's pages: the front page's tables, between ``<!-- pages -->`` and ``<!-- /pages -->``.

A heading of the second level is a section, one of the third level a group in it, a table's row a page. So the
site and whoever reads the Markdown files by themselves see the same order, and it is written once.
"""

import posixpath
import re
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

__all__ = ["FRONT_PAGE", "Group", "Page", "Section", "SiteError", "read_navigation"]

FRONT_PAGE = PurePosixPath("docs/index.md")
"""The front page, from the project's root."""

_PAGES = re.compile(r"^<!-- pages -->$(.*)^<!-- /pages -->$", re.MULTILINE | re.DOTALL)
_ROW = re.compile(r"\| \[([^\]]+)\]\(([^)\s]+)\) \| (.+) \|")


class SiteError(Exception):
    """What is wrong with the pages: one line each."""


@dataclass(frozen=True, slots=True)
class Page:
    """A row of a table.

    Parameters
    ----------
    label
        Its short name.
    path
        Its file, from the project's root.
    answers
        What it answers, in Markdown.
    """

    label: str
    path: PurePosixPath
    answers: str

    @property
    def title(self) -> str:
        """Its short name, as a heading begins."""
        return self.label[:1].upper() + self.label[1:]

    @property
    def in_menus(self) -> str:
        """Its title in menus, where no table says what it answers: a number alone would say nothing."""
        return f"{self.label} {self.answers}" if self.label.isdigit() else self.title


@dataclass(slots=True)
class Group:
    """Pages under one heading.

    Parameters
    ----------
    title
        Its heading; the first group of a section has none.
    says
        What stands below it, in Markdown.
    pages
        Its pages in order.
    """

    title: str
    says: str = ""
    pages: list[Page] = field(default_factory=list[Page])


@dataclass(frozen=True, slots=True)
class Section:
    """A part of the site.

    Parameters
    ----------
    title
        Its heading.
    groups
        Its pages by group; what the section itself says is said by the first.
    """

    title: str
    groups: list[Group]

    @property
    def says(self) -> str:
        """What stands below its heading, in Markdown."""
        return self.groups[0].says

    @property
    def slug(self) -> str:
        """Its name in addresses."""
        return self.title.lower().replace(" ", "-")

    @property
    def pages(self) -> list[Page]:
        """All its pages in order."""
        return [page for group in self.groups for page in group.pages]


def read_navigation(root: Path) -> tuple[str, list[Section]]:
    """Return the front page without its tables, and the sections.

    Parameters
    ----------
    root
        The project's root.

    Raises
    ------
    SiteError
        Where the tables are missing or not understood, or a page stands in them twice or not at all.
    """
    text = (root / FRONT_PAGE).read_text(encoding="utf-8")
    found = _PAGES.search(text)
    if found is None:
        raise SiteError(f"{FRONT_PAGE}: no tables between <!-- pages --> and <!-- /pages -->")
    first = text[: found.start(1)].count("\n") + 1
    sections: list[Section] = []
    problems: list[str] = []
    for number, line in enumerate(found[1].splitlines(), first):
        if line.startswith("## "):
            sections.append(Section(line.removeprefix("## "), [Group("")]))
        elif sections and line.startswith("### "):
            sections[-1].groups.append(Group(line.removeprefix("### ")))
        elif sections and (row := _ROW.fullmatch(line)):
            path = PurePosixPath(posixpath.normpath(FRONT_PAGE.parent / row[2]))
            sections[-1].groups[-1].pages.append(Page(row[1], path, row[3]))
        elif sections and line.strip() and not line.startswith("|"):
            group = sections[-1].groups[-1]
            group.says = f"{group.says} {line.strip()}".strip()
        elif line.startswith("| ["):
            problems.append(f"{FRONT_PAGE}:{number}: not a row of a page and what it answers: {line}")
    problems += [f"{FRONT_PAGE}: {one.title} has no page" for one in sections if not one.pages]
    problems += _misplaced(root, [page.path for section in sections for page in section.pages])
    if problems:
        raise SiteError("\n".join(problems))
    return text[: found.start()] + text[found.end() :], sections


def _misplaced(root: Path, named: list[PurePosixPath]) -> list[str]:
    """What is wrong with the pages that are named."""
    written = {
        PurePosixPath(path.relative_to(root).as_posix()) for path in (root / FRONT_PAGE.parent).rglob("*.md")
    } - {FRONT_PAGE}
    return [
        *(f"{FRONT_PAGE}: {path} stands there twice" for path in sorted(set(named)) if named.count(path) > 1),
        *(f"{FRONT_PAGE}: there is no {path}" for path in named if not (root / path).is_file()),
        *(f"{path} stands in no table of {FRONT_PAGE}" for path in sorted(written - set(named))),
    ]
