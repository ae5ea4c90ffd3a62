"""Tables that scripts put into pages: what stands between the marks of a block is made anew."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

__all__ = ["blocks_in", "put"]

_BLOCK = re.compile(r"<!-- begin ([^>]+) -->\n(.*?)<!-- end \1 -->", re.DOTALL)
_PAPER = re.compile(r"<!-- (paper): [^>]+-->\n(.*?)<!-- /paper -->", re.DOTALL)


def blocks_in(text: str) -> dict[str, list[str]]:
    """Return the lines of a page's blocks, by name; that of ``make paper`` has marks of its own."""
    found = (*_BLOCK.findall(text), *_PAPER.findall(text))
    return {name: lines.strip().splitlines() for name, lines in found}


def _paged(text: str, found: Mapping[str, Sequence[str]]) -> str:
    """The page with its blocks made anew: lines between ``<!-- begin NAME -->`` and ``<!-- end NAME -->``."""
    for name, lines in found.items():
        begin, end = f"<!-- begin {name} -->", f"<!-- end {name} -->"
        before, opened, rest = text.partition(begin)
        _, closed, after = rest.partition(end)
        if not (opened and closed):
            raise SystemExit(f"the page has no block {name}")
        text = f"{before}{begin}\n\n" + "\n".join(lines) + f"\n\n{end}{after}"
    return text


def put(pages: Mapping[Path, Mapping[str, Sequence[str]]], *, check: bool) -> int:
    """Write pages with their blocks made anew; with ``check`` only return 1 where one would differ."""
    before = {page: page.read_text(encoding="utf-8") for page in pages}
    made = {page: _paged(before[page], blocks) for page, blocks in pages.items()}
    if check:
        return int(made != before)
    for page, text in made.items():
        page.write_text(text, encoding="utf-8", newline="\n")
    return 0
