"""Fenced blocks of Markdown pages, and what they say they print.

========  ==========================================================================================
fence     what it holds
========  ==========================================================================================
python    a program; it runs, and prints what the next ``text`` block or the comments on it say
console   commands after ``$`` and their output; they run
sh        commands; they parse, and their targets, extras and options exist
json      one document
toml      one document
text      the output of the program above it, or a notation (a formula, a picture)
========  ==========================================================================================

A comment behind a ``print`` is what it prints, perhaps followed by a colon and an explanation; so are the
comment lines right behind one, a line each for every time it runs. ``<!-- not run: reason -->`` above a
program says that it is only compiled. ``<!-- file: PATH -->`` above any block says that it repeats that file.
"""

import ast
import io
import re
import tokenize
from dataclasses import dataclass, replace
from pathlib import Path
from textwrap import dedent

__all__ = ["PAGES", "ROOT", "Block", "Printed", "blocks_of", "printed_by"]

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]

_NOT_RUN = re.compile(r"<!-- not run: (.+) -->")
_FILE = re.compile(r"<!-- file: (.+) -->")


@dataclass(frozen=True, slots=True)
class Block:
    """A fenced block.

    Parameters
    ----------
    page
        File, from the project's root.
    line
        Of its opening fence.
    language
        What stands on that fence.
    text
        Its content, without the indentation of the fence.
    not_run
        Why it is not run; empty where it is.
    result
        The ``text`` block right behind a program, or None.
    file
        The file that it repeats, from the project's root; empty where it repeats none.
    """

    page: str
    line: int
    language: str
    text: str
    not_run: str = ""
    result: str | None = None
    file: str = ""

    @property
    def place(self) -> str:
        """Page and line."""
        return f"{self.page}:{self.line}"


def blocks_of(page: Path) -> list[Block]:
    """Return the blocks of a page in order."""
    lines = page.read_text(encoding="utf-8").splitlines()
    found: list[Block] = []
    at = behind = 0
    while at < len(lines):
        if not lines[at].lstrip().startswith("```"):
            at += 1
            continue
        stop = next(i for i in range(at + 1, len(lines)) if lines[i].strip() == "```")
        text = dedent("\n".join(lines[at + 1 : stop])) + "\n"
        marker = _NOT_RUN.fullmatch(lines[at - 1].strip()) if at else None
        language = lines[at].strip().removeprefix("```")
        close = bool(found) and not any(line.strip() for line in lines[behind:at])
        if language == "text" and close and found[-1].language == "python":
            found[-1] = replace(found[-1], result=text)
        place = page.relative_to(ROOT).as_posix()
        repeated = _FILE.fullmatch(lines[at - 1].strip()) if at else None
        reason, file = (one[1] if one else "" for one in (marker, repeated))
        found.append(Block(place, at + 1, language, text, reason, file=file))
        at = behind = stop + 1
    return found


@dataclass(frozen=True, slots=True)
class Printed:
    """What a call of ``print`` says it prints.

    Parameters
    ----------
    first, last
        Lines of the call.
    lines
        What it prints, whenever it runs.
    """

    first: int
    last: int
    lines: tuple[str, ...]


def printed_by(program: str) -> list[Printed]:
    """Return the calls of ``print`` with a result beside or below them."""
    comments: dict[int, tuple[str, bool]] = {}
    for token in tokenize.generate_tokens(io.StringIO(program).readline):
        if token.type == tokenize.COMMENT:
            alone = not token.line[: token.start[1]].strip()
            comments[token.start[0]] = (token.string.removeprefix("#").removeprefix(" "), alone)
    found: list[Printed] = []
    for node in ast.walk(ast.parse(program)):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "print":
            last = node.end_lineno or node.lineno
            own = [comments[last][0]] if last in comments else []
            below = last + 1
            while not own and below in comments and comments[below][1]:
                below += 1
            lines = own or [comments[line][0] for line in range(last + 1, below)]
            if lines:
                found.append(Printed(node.lineno, last, tuple(lines)))
    return found
