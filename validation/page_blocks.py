"""Tables that scripts put into pages: what stands between the marks of a block is made anew."""

from collections.abc import Mapping, Sequence
from pathlib import Path

__all__ = ["put"]


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
