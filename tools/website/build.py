"""The documentation site: sources gathered, checked and built, offline; any problem is the end.

The front page, ``docs/index.md``, has the order of the pages. Every public name is described.
"""

import argparse
import os
import shutil
import sys
import time
from pathlib import Path

from dead_links import dead_links
from docstrings import docstring_faults
from navigation import FRONT_PAGE, SiteError, read_navigation
from sections import write_sections
from sources import write_sources
from sphinx.cmd.build import main as sphinx

__all__ = ["build", "main"]

_HERE = Path(__file__).resolve().parent
ROOT = _HERE.parents[1]


def build(folder: Path, base: str) -> None:
    """Build the site.

    Parameters
    ----------
    folder
        Where it goes; what is there is deleted. Its sources are beside it.
    base
        Path that it will have on its host, from ``/`` to ``/``; only the page for what is not found needs it.

    Raises
    ------
    SiteError
        Where a page, a link or a docstring is wrong.
    """
    sources = folder.with_name(f"{folder.name}-sources")
    for place in (folder, sources):
        shutil.rmtree(place, ignore_errors=True)
    front, sections = read_navigation(ROOT)
    _require(docstring_faults())
    pages = [FRONT_PAGE, *(page.path for section in sections for page in section.pages)]
    write_sources(ROOT, sources, pages, {FRONT_PAGE: front})
    write_sections(sources, sections)
    os.environ.update(SOURCE_DATE_EPOCH="0", SITE_BASE=base)
    words = ["-q", "-W", "--keep-going", "-j", "auto", "-c", str(_HERE), "-b", "html"]
    if sphinx([*words, "-d", str(sources / "_build"), str(sources), str(folder)]):
        raise SiteError("Sphinx told of problems; they stand above")
    _require(dead_links(folder))


def _require(faults: list[str]) -> None:
    """Raise what is wrong."""
    if faults:
        raise SiteError("\n".join(faults))


def main() -> int:
    """Build the site; return 1 and tell where something is wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "site", help="folder of the site")
    parser.add_argument("--base", default="/", help="path of the site on its host, as /modelcast/")
    asked = parser.parse_args()
    out: Path = asked.out.resolve()
    began_s = time.perf_counter()
    try:
        build(out, asked.base)
    except SiteError as problem:
        print(problem, file=sys.stderr)
        return 1
    print(f"{out / 'index.html'} ({time.perf_counter() - began_s:.0f} s)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
