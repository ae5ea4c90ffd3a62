"""Tables that scripts put into pages: what stands between the marks of a block is made anew."""

from collections.abc import Mapping, Sequence

__all__ = ["paged"]


def paged(text: str, found: Mapping[str, Sequence[str]]) -> str:
    """The page with its blocks made anew: lines between ``<!-- begin NAME -->`` and ``<!-- end NAME -->``."""
    for name, lines in found.items():
        begin, end = f"<!-- begin {name} -->", f"<!-- end {name} -->"
        before, opened, rest = text.partition(begin)
        _, closed, after = rest.partition(end)
        if not (opened and closed):
            raise SystemExit(f"the page has no block {name}")
        text = f"{before}{begin}\n\n" + "\n".join(lines) + f"\n\n{end}{after}"
    return text
