"""Where links of built pages lead: to a file of the site and a place in it, or elsewhere on a click alone."""

from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

__all__ = ["dead_links"]

_ASKED = {"audio", "embed", "iframe", "img", "link", "object", "script", "source", "track", "video"}
"""Elements whose address a browser asks for by itself."""


@dataclass(slots=True)
class _Read(HTMLParser):
    """A page's places and addresses."""

    places: set[str] = field(default_factory=set[str])
    addresses: list[tuple[str, str]] = field(default_factory=list[tuple[str, str]])

    def __post_init__(self) -> None:
        HTMLParser.__init__(self)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take an element in."""
        for name, value in attrs:
            if value and name == "id":
                self.places.add(value)
            if value and name in {"href", "src"} and tag != "base":
                self.addresses.append((tag, value))


def dead_links(folder: Path) -> list[str]:
    """Return the addresses in the pages of a folder that lead nowhere, a line each.

    Pages may ask nothing of another host: only a link that somebody clicks may lead there.

    Parameters
    ----------
    folder
        The built site.
    """
    pages = {path: _read(path) for path in sorted(folder.rglob("*.html")) if "_static" not in path.parts}
    found: list[str] = []
    for path, page in pages.items():
        for tag, address in page.addresses:
            parts = urlsplit(address)
            name = path.relative_to(folder)
            if parts.scheme or parts.netloc:
                if tag in _ASKED and parts.scheme != "data":
                    found.append(f"{name}: asks {address} of another host")
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.is_file():
                found.append(f"{name}: {address} is no file of the site")
            elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].places:
                found.append(f"{name}: {address} is no place in that page")
    return found


def _read(path: Path) -> _Read:
    page = _Read()
    page.feed(path.read_text(encoding="utf-8"))
    return page
