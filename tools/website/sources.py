"""Files of the project as pages of the site: Markdown as it is, notebooks by cells, the rest as listings.

Pages below ``docs`` keep their names. What they link to elsewhere in the project becomes a page below
``repository``, so that the site is whole by itself. Links are rewritten to where the files went.
"""

import json
import posixpath
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path, PurePosixPath

from navigation import SiteError
from pygments.lexers import find_lexer_class_for_filename

__all__ = ["staged", "write_sources"]

_DOCS = PurePosixPath("docs")
_LINK = re.compile(r"(?<=\]\()[^)\s]+(?=[)\s])")
_CODE_SPAN = re.compile(r"(`+)(?!`).*?(?<!`)\1(?!`)")
_FENCE = "`" * 10


def staged(path: PurePosixPath) -> PurePosixPath:
    """Return the name of a project's file among the site's sources.

    Parameters
    ----------
    path
        Its name from the project's root.
    """
    if path.is_relative_to(_DOCS):
        return path.relative_to(_DOCS)
    place = PurePosixPath("repository") / path
    return place if path.suffix == ".md" else place.with_name(f"{place.name}.md")


def write_sources(
    root: Path, folder: Path, pages: Iterable[PurePosixPath], texts: Mapping[PurePosixPath, str]
) -> None:
    """Write pages, and whatever they link to, as sources of the site.

    Parameters
    ----------
    root
        The project's root.
    folder
        Where the sources go.
    pages
        Files from the root.
    texts
        Pages that read otherwise than their files.

    Raises
    ------
    SiteError
        Where a link leads to no file.
    """
    named = list(pages)
    waiting, known = list(named), set(named)
    problems: list[str] = []
    while waiting:
        path = waiting.pop()
        place = folder / staged(path)
        place.parent.mkdir(parents=True, exist_ok=True)
        if path.is_relative_to(_DOCS) and path.suffix != ".md":
            place.write_bytes((root / path).read_bytes())
            continue
        links: list[PurePosixPath] = []
        text = _rewritten(texts.get(path) or _as_markdown(root, path), path, links)
        if not path.is_relative_to(_DOCS) and path not in named:
            text = f"---\norphan: true\n---\n\n{text}"
        place.write_text(text, encoding="utf-8", newline="\n")
        missing = [link for link in links if not (root / link).is_file()]
        problems += [f"{path}: a link to {link}, which is no file" for link in missing]
        new = set(links) - set(missing) - known
        waiting += sorted(new)
        known |= new
    if problems:
        raise SiteError("\n".join(problems))


def _rewritten(text: str, path: PurePosixPath, links: list[PurePosixPath]) -> str:
    """A page whose links lead to where the files went; gathers the files that it links to."""

    def moved(link: re.Match[str]) -> str:
        target, mark, anchor = link[0].partition("#")
        if not target or re.match(r"[a-z][a-z+.-]*:", target):
            return link[0]
        found = PurePosixPath(posixpath.normpath(path.parent / target))
        links.append(found)
        return posixpath.relpath(staged(found), staged(path).parent) + mark + anchor

    return "\n".join(_outside_code(text.splitlines(), lambda part: _LINK.sub(moved, part))) + "\n"


def _outside_code(lines: Iterable[str], change: Callable[[str], str]) -> Iterator[str]:
    """The lines, changed where they are no code."""
    fence = ""
    for line in lines:
        opened = re.match(r"\s*(`{3,})", line)
        if fence:
            fence = "" if line.strip() == fence else fence
            yield line
        elif opened:
            fence = opened[1]
            yield line
        else:
            parts, at = "", 0
            for span in _CODE_SPAN.finditer(line):
                # A link around code has its target behind the code.
                parts += change(line[at : span.start()]) + span[0]
                at = span.end()
            yield parts + change(line[at:])


def _as_markdown(root: Path, path: PurePosixPath) -> str:
    """A file as a page."""
    text = (root / path).read_text(encoding="utf-8")
    if path.suffix == ".md":
        return text
    if path.suffix == ".ipynb":
        return f"The notebook `{path}`, without its outputs.\n\n" + "\n\n".join(_cells(text))
    return (
        f"# {path.name}\n\nThe file `{path}`.\n\n{_FENCE}{_language(path.name)}\n{text.rstrip()}\n{_FENCE}\n"
    )


def _cells(notebook: str) -> Iterator[str]:
    """The cells of a notebook."""
    for cell in json.loads(notebook)["cells"]:
        text = "".join(cell["source"])
        yield text if cell["cell_type"] == "markdown" else f"{_FENCE}python\n{text}\n{_FENCE}"


def _language(name: str) -> str:
    """What a fence says of a file."""
    lexer = find_lexer_class_for_filename(name)
    return lexer.aliases[0] if lexer else "text"
