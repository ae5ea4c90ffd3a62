"""Which command makes which figures of the pages, and whether the pages still say what the commands say.

``make figures`` makes the blocks that take seconds anew and puts them into their pages. Arguments choose:

    figures.py                     the quick ones, written
    figures.py --check             the quick ones, compared: 1 where a page has others
    figures.py --only cruise vru   the scripts of these names, however long they take
    figures.py --list              every block: its page, its command, what that needs and how long it takes
    figures.py --numbers           numbers in prose that nothing accounts for, and sources that differ
    figures.py --keep              keeps these numbers as known, in loose_numbers.toml

Blocks stand in pages between ``<!-- begin NAME -->`` and ``<!-- end NAME -->`` (`page_blocks`). Scripts that
take a folder get ``--folder``/NAME. What needs runs of ``modelcast`` beforehand has the calls in the script's
docstring, to be made into that folder first.
"""

import argparse
import os
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import Any

from number_sources import faults_of, sources
from page_blocks import blocks_in
from prose_numbers import Number, loose_numbers

__all__ = [
    "Maker",
    "blocks_made",
    "blocks_of_pages",
    "faults_of_sources",
    "kept_numbers",
    "loose_in_pages",
    "makers",
    "pages",
    "unread_pages",
]

ROOT = Path(__file__).resolve().parents[1]
RUNS = "runs"
"""What a script needs that no environment variable names: runs of modelcast, made beforehand."""
QUICK = "seconds"
KEPT = Path(__file__).with_name("loose_numbers.toml")
UNREAD = "unread"
FRONT = (
    "README.md",
    "docs/index.md",
    "docs/results-in-short.md",
    "docs/explanation/",
    "docs/how-to/",
    "docs/tutorial/",
)
"""Pages on which ratios count too."""
RECORDS = ("docs/decisions/", "docs/plugins-tried.md")


@dataclass(frozen=True, slots=True)
class Maker:
    """A script, and the blocks that it makes.

    Parameters
    ----------
    script
        Its file, from the project's root.
    blocks
        Names of blocks by the page that has them, from the project's root.
    takes
        How long it takes on two cores, its runs included: seconds, minutes or hours.
    words
        Its arguments before ``--write`` and ``--check``; FOLDER stands for a folder of its own.
    writing
        What has it put its blocks into the pages.
    needs
        What it needs.
    writes
        Whether it puts its blocks into the page; else it prints them, and a person does.
    checks
        Whether it takes ``--check``.
    whole
        Pages that it makes as a whole.
    """

    script: str
    blocks: Mapping[str, Sequence[str]]
    takes: str
    _: KW_ONLY
    words: Sequence[str] = ()
    writing: Sequence[str] = ("--write",)
    needs: Sequence[str] = ()
    writes: bool = True
    checks: bool = True
    whole: Sequence[str] = ()

    @property
    def name(self) -> str:
        """What it is called here."""
        return Path(self.script).stem

    def command(self, folder: Path) -> list[str]:
        """What is run, but for ``--write`` or ``--check``."""
        words = [str(folder / self.name) if word == "FOLDER" else word for word in self.words]
        return [sys.executable, str(ROOT / self.script), *words]


def makers() -> list[Maker]:
    """All makers, as ``figures.toml`` has them."""
    with Path(__file__).with_suffix(".toml").open("rb") as file:
        found: dict[str, dict[str, Any]] = tomllib.load(file)
    return [Maker(**one) for one in found.values()]


def pages() -> list[Path]:
    """All pages that people read: those of docs, the README and that of the validation."""
    return [ROOT / "README.md", ROOT / "validation" / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def blocks_of_pages() -> list[tuple[str, str]]:
    """Every block that stands in a page: the page, from the project's root, and the block's name."""
    return [(_name(page), name) for page in pages() for name in blocks_in(page.read_text(encoding="utf-8"))]


def blocks_made() -> Iterator[tuple[str, str, Maker]]:
    """Every block that is made: its page, its name, and what makes it."""
    for maker in makers():
        for page, names in maker.blocks.items():
            yield from ((page, name, maker) for name in names)


def loose_in_pages() -> dict[str, list[Number]]:
    """Numbers in the prose of pages that nothing accounts for, by page.

    Left out are pages that a script makes as a whole; decisions without blocks and a transcript, which tell
    what was measured on their day and are not kept up; and those that `unread_pages` names.
    """
    scripts: dict[str, set[str]] = {}
    for page, _, maker in blocks_made():
        scripts.setdefault(page, set()).add((ROOT / maker.script).read_text(encoding="utf-8"))
    whole = {page for maker in makers() for page in maker.whole}
    said = {page: [one.says for one in own] for page, own in sources().items()}
    read = (
        page
        for page in map(_name, pages())
        if page in scripts or not (page in whole or page in unread_pages() or page.startswith(RECORDS))
    )
    return {
        page: loose_numbers(
            (ROOT / page).read_text(encoding="utf-8"),
            sorted(scripts.get(page, ())),
            said.get(page, ()),
            decimals=page.startswith(FRONT),
        )
        for page in sorted(read)
    }


def faults_of_sources() -> list[str]:
    """What is wrong with the sources of numbers: the page, the words, and how they differ."""
    texts = {_name(page): page.read_text(encoding="utf-8") for page in pages()}
    return [
        f"{page}: {one.says}: {fault}"
        for page, own in sources().items()
        for one in own
        for fault in faults_of(one, texts[page], texts)
    ]


def unread_pages() -> list[str]:
    """Pages whose numbers nobody has gone through yet."""
    return _kept()[UNREAD]


def kept_numbers() -> dict[str, list[str]]:
    """Loose numbers that are known, with their units, by page."""
    return {page: texts for page, texts in _kept().items() if page != UNREAD}


def _kept() -> dict[str, list[str]]:
    found: dict[str, list[str]] = tomllib.loads(KEPT.read_text(encoding="utf-8"))
    return found


def _keep(loose: Mapping[str, Sequence[Number]]) -> None:
    """Write the loose numbers as the known ones."""
    lines = [
        "# Pages whose numbers nobody has gone through yet, and numbers in the prose of others that no",
        "# block of their page has, no setting explains, number_sources.toml has not: `figures.py --keep`.",
        "",
        f"{UNREAD} = [",
        *(f'    "{page}",' for page in unread_pages()),
        "]",
    ]
    for page, found in loose.items():
        if found:
            lines += ["", f'"{page}" = [', *(f'    "{one.text}",' for one in found), "]"]
    KEPT.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def _name(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def _run(chosen: Sequence[Maker], folder: Path, *, check: bool) -> int:
    """Run scripts one after another; how many failed, or found the page to be another."""
    failed = 0
    for maker in chosen:
        why = _left_out(maker, check=check)
        if why:
            print(f"{maker.name}: left out: {why}", flush=True)
            continue
        words = [*maker.command(folder), *(("--check",) if check else maker.writing)]
        ended = subprocess.run(words, cwd=ROOT, stdout=subprocess.DEVNULL, check=False)  # noqa: S603 - ours
        failed += ended.returncode != 0
        found = "as the page has it" if check else "written"
        print(f"{maker.name}: {'failed, or the page differs' if ended.returncode else found}", flush=True)
    return failed


def _left_out(maker: Maker, *, check: bool) -> str:
    """Why a script is not run; empty where it is."""
    without = [name for name in maker.needs if name != RUNS and not os.environ.get(name)]
    if without:
        return f"{' and '.join(without)} is not set"
    if not maker.writes:
        return "it prints, and a person puts it into the page"
    return "it measures times, which never come twice" if check and not maker.checks else ""


def main() -> int:
    """Make, compare or list."""
    known = makers()
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=[one.name for one in known])
    parser.add_argument("--folder", type=Path, default=ROOT / "out" / "figures", help="of runs that are kept")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--check", action="store_true", help="compare; write nothing")
    what.add_argument("--list", action="store_true", help="say what makes what")
    what.add_argument("--numbers", action="store_true", help="list loose numbers")
    what.add_argument("--keep", action="store_true", help="keep loose numbers as known ones")
    given = parser.parse_args()
    if given.list:
        for page, name, maker in blocks_made():
            needs = f"; needs {', '.join(maker.needs)}" if maker.needs else ""
            print(f"{page}: {name}: {' '.join((maker.script, *maker.words))}; {maker.takes}{needs}")
        return 0
    if given.keep:
        _keep(loose_in_pages())
        return 0
    if given.numbers:
        for page, found in loose_in_pages().items():
            for one in found:
                print(f"{page}:{one.line}: {one.text}")
        print(*faults_of_sources(), sep="\n")
        return 0
    chosen = [one for one in known if (one.name in given.only if given.only else one.takes == QUICK)]
    return int(_run(chosen, given.folder, check=given.check) > 0)


if __name__ == "__main__":
    sys.exit(main())
