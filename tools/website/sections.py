"""Pages that only the site has: what its front leads to, a page a section, and the interface by subject."""

import inspect
import posixpath
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from navigation import FRONT_PAGE, Group, Section
from sources import staged

import modelcast
from modelcast.core.public_names import names_by_subject, summary_of

__all__ = ["INTERFACE", "write_sections"]

INTERFACE = "Python"
"""The section that the interface's pages stand in, behind its own."""


@dataclass(frozen=True, slots=True)
class _Entry:
    """A page in a list: its title, its source, what it answers, and its title in menus."""

    title: str
    place: PurePosixPath
    answers: str
    in_menus: str


def write_sections(folder: Path, sections: Sequence[Section]) -> None:
    """Write the pages that no file of the project is, and let the front lead to all.

    Parameters
    ----------
    folder
        The site's sources, with the front page.
    sections
        The sections in order.
    """
    firsts: list[_Entry] = []
    for section in sections:
        listed = [
            (
                group,
                [_Entry(page.title, staged(page.path), page.answers, page.in_menus) for page in group.pages],
            )
            for group in section.groups
        ]
        if section.title == INTERFACE:
            listed.append((Group("By subject"), list(_write_interface(folder))))
        entries = [entry for _, some in listed for entry in some]
        place = entries[0].place
        if len(entries) > 1:
            place = PurePosixPath("sections") / f"{section.slug}.md"
            parts = "".join(_part(group, some, place) for group, some in listed)
            _write(folder / place, f"# {section.title}\n\n{parts}")
        firsts.append(_Entry(section.title, place, section.says, section.title))
    front = folder / staged(FRONT_PAGE)
    leads = "".join(f"- [{one.title}]({one.place}). {one.answers}\n" for one in firsts)
    text = front.read_text(encoding="utf-8").rstrip()
    _write(front, f"{text}\n\n## Where to go\n\n{leads}\n{_contents('', firsts)}")


def _part(group: Group, entries: Sequence[_Entry], place: PurePosixPath) -> str:
    """A group of pages: heading, table and contents."""
    text = f"## {group.title}\n\n" if group.title else ""
    text += f"{group.says}\n\n" if group.says else ""
    if entries:
        text += "| page | what it answers |\n|---|---|\n"
        for entry in entries:
            text += f"| [{entry.title}]({posixpath.relpath(entry.place, place.parent)}) | {entry.answers} |\n"
        text += f"\n{_contents(group.title, entries)}\n"
    return text


def _contents(title: str, entries: Sequence[_Entry]) -> str:
    """What the site's menus are made of."""
    caption = f":caption: {title}\n" if title else ""
    lines = "".join(f"{entry.in_menus} </{entry.place.with_suffix('')}>\n" for entry in entries)
    return f"```{{toctree}}\n:hidden:\n{caption}\n{lines}```\n"


def _write_interface(folder: Path) -> Iterator[_Entry]:
    """Write a page for each subject of the public interface."""
    homes: Mapping[str, str] = modelcast.__dict__["_HOMES"]
    for subject, names in names_by_subject(homes):
        place = PurePosixPath("api") / (subject.lower().replace(",", "").replace(" ", "-") + ".rst")
        # Pages of the reference have the same subjects: in tabs and among what was found this one says more.
        title = f"{INTERFACE}: {subject[:1].lower()}{subject[1:]}"
        lines = [title, "=" * len(title), "", ".. currentmodule:: modelcast", ""]
        summaries = {name: summary_of(name, homes[name]) for name in names}
        lines += [
            "Import these from ``modelcast``; below the list each has its parameters, units and errors.",
            "",
            ".. rst-class:: names",
            "",
        ]
        for name in names:
            lines += [f"`{name}`", f"   {summaries[name]}"]
        lines += [""]
        for name in names:
            kind = _kind(getattr(modelcast, name))
            # A constant has its text in the module that defines it, where Sphinx does not look.
            text = ["", f"   {summaries[name]}"] if kind == "py:data" else []
            lines += [f".. {kind}:: {name}", *text, ""]
        _write(folder / place, "\n".join(lines))
        linked = ", ".join(f"{{py:obj}}`~modelcast.{name}`" for name in names)
        yield _Entry(subject, place, linked, subject)


def _kind(thing: object) -> str:
    """What describes it."""
    if inspect.isclass(thing):
        return "autoexception" if issubclass(thing, BaseException) else "autoclass"
    return "autofunction" if inspect.isroutine(thing) else "py:data"


def _write(place: Path, text: str) -> None:
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_text(text, encoding="utf-8", newline="\n")
