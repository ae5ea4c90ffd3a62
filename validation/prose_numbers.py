"""Numbers in the prose of a page, and which of them nothing on the page accounts for.

A number with a unit counts: ``42 %``, ``1.58 m``, ``3 times``; on some pages also one with a decimal point.
It is accounted for where

- a block of the page has the same digits, so that a table that is made anew and prose that was not differ;
  under a mark ``<!-- from NAME, NAME -->`` the block must be one of these; or
- a script that makes blocks of the page names it, or a command on the page, in this unit or as the metres,
  seconds or ratio that it is: it is a setting then; or
- `number_sources` says where it comes from; or
- it is code, a heading or in a link.

The rule is one of digits, not of meaning: small numbers meet by chance. What is left is loose: nothing would
notice if it were wrong. A loose number is not wrong; it is unguarded.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from page_blocks import blocks_in

__all__ = ["UNITS", "Number", "loose_numbers", "numbers_of", "quoted"]

UNITS = {
    "%": 0.01,
    "times": 1.0,
    "fold": 1.0,
    "cm": 0.01,
    "m": 1.0,
    "km": 1000.0,
    "ns": 1e-9,
    "µs": 1e-6,
    "ms": 0.001,
    "s": 1.0,
    "min": 60.0,
    "h": 3600.0,
    "Hz": 1.0,
    "kB": 1e3,
    "MB": 1e6,
    "MiB": 2.0**20,
    "GB": 1e9,
    "GiB": 2.0**30,
    "bytes": 1.0,
    "octets": 1.0,
}
"""Units of numbers that count, and what one of it is in the units of code."""
_UNIT = "(?:" + "|".join(unit if unit == "%" else rf"{unit}\b" for unit in UNITS) + ")"
_NUMBER = re.compile(
    rf"(?<![\w.,/-])(\d{{1,3}}(?:,\d{{3}})+|\d+(?:\.\d+)?)(?: to \d+(?:\.\d+)?)?[ \u00a0]{_UNIT}"
)
_DECIMAL = re.compile(rf"{_NUMBER.pattern}|(?<![\w.,/-])\d+\.\d+(?![\w.])")
_SMALL = {unit if unit == "%" else f" {unit}": UNITS[unit] for unit in ("%", "cm", "ms", "µs", "km")}
"""Units in which prose states what settings have in metres, seconds or as a ratio."""
_DIGITS = re.compile(r"\d{1,3}(?:,\d{3})+|\d+(?:\.\d+)?")
_FROM = re.compile(r"<!-- from ([^>]+) -->")
_HIDDEN = re.compile(r"`[^`]*`|\]\([^)]*\)|<!--.*?-->")


@dataclass(frozen=True, slots=True)
class Number:
    """A number in prose.

    Parameters
    ----------
    line
        Of the page, from 1.
    text
        The number with its unit.
    """

    line: int
    text: str


def numbers_of(text: str) -> set[str]:
    """Return all numbers in a text, however they are written."""
    return {_plain(found) for found in _DIGITS.findall(text)}


def _plain(digits: str) -> str:
    """A number as it is compared: 1,200 and 1200.0 are one, and so are 0.2 and 0.20."""
    return f"{float(digits.replace(',', '')):.10g}"


def loose_numbers(
    text: str, scripts: Sequence[str], sourced: Sequence[str] = (), *, decimals: bool = False
) -> list[Number]:
    r"""Return the numbers in a page's prose that nothing accounts for.

    Parameters
    ----------
    text
        The page.
    scripts
        Texts of the scripts that make its blocks.
    sourced
        Words of the page whose numbers have a source of their own.
    decimals
        Whether numbers with a decimal point count without a unit too: ratios.

    Examples
    --------
    >>> page = "\n".join(["It is 42 % of 7.5 m.", "", "<!-- begin a -->", "| 42 |", "<!-- end a -->"])
    >>> [one.text for one in loose_numbers(page, [])]
    ['7.5 m']
    >>> loose_numbers(page, [], ["of 7.5 m"])
    []
    """
    blocks = {name: numbers_of(" ".join(lines)) for name, lines in blocks_in(text).items()}
    commands = " ".join(line for line, kind in _lines(text) if kind == "code")
    settings = set[str]().union(*map(numbers_of, (*scripts, commands)))
    anywhere = set[str]().union(*blocks.values())
    spans = quoted(text, sourced)
    found: list[Number] = []
    known = anywhere
    start = 0
    for at, (line, kind) in enumerate(_lines(text), start=1):
        mark = _FROM.fullmatch(line.strip())
        if mark is not None:
            known = _of_blocks(blocks, mark[1].split(", "))
        elif not line.strip():  # a mark is good for its paragraph
            known = anywhere
        if kind == "prose":
            for one in (_DECIMAL if decimals else _NUMBER).finditer(
                _HIDDEN.sub(lambda hidden: " " * len(hidden[0]), line)
            ):
                within = any(begin <= start + one.start() < end for begin, end in spans)
                if not within and not _accounted(one[0], known, settings):
                    found.append(Number(at, one[0]))
        start += len(line) + 1
    return found


def quoted(text: str, sourced: Iterable[str]) -> list[tuple[int, int]]:
    """Return where words stand in a page, however its lines are broken: begin and end of each place."""
    patterns = (r"\s+".join(map(re.escape, words.split())) for words in sourced)
    return [one.span() for pattern in patterns for one in re.finditer(pattern, text)]


def _accounted(text: str, known: set[str], settings: set[str]) -> bool:
    """Whether all numbers of a text are known, or settings."""
    scale = next((size for unit, size in _SMALL.items() if text.endswith(unit)), 1.0)
    return all(
        one in known | settings or f"{float(one) * scale:.10g}" in settings for one in numbers_of(text)
    )


def _of_blocks(blocks: dict[str, set[str]], names: Iterable[str]) -> set[str]:
    missing = [name for name in names if name not in blocks]
    if missing:
        raise ValueError(f"no block {missing[0]} on this page")
    return set[str]().union(*(blocks[name] for name in names))


def _lines(text: str) -> Iterator[tuple[str, str]]:
    """Lines of a page, each with what it is: block, code, heading or prose."""
    inside = fenced = False
    for line in text.splitlines():
        if line.startswith(("<!-- begin ", "<!-- paper: ")):
            inside = True
        if line.lstrip().startswith("```"):
            fenced = not fenced
            yield line, "code"
        elif inside:
            yield line, "block"
        elif fenced:
            yield line, "code"
        else:
            yield line, "heading" if line.startswith("#") else "prose"
        if line.startswith(("<!-- end ", "<!-- /paper")):
            inside = False
