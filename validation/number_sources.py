"""Where numbers in prose come from that no block of their own page has, and whether they still agree.

``number_sources.toml`` has a list for every page. A row quotes words of the page (``says``) and tells what
every number in them comes from:

``block = "PAGE NAME"``
    a block that a registered command makes, on any page; ``row`` are words of the line meant, else it is any
``code = "modelcast.channel.base.NAME"``
    a value of the code: a constant, the default of a field or of a parameter, or behind ``()`` of what a
    function returns; of a script, ``"tools/drawings.py THRESHOLD_M"``, or words of a file that have the
    numbers, ``"src/modelcast/world/drive.py rng.uniform(13.0, 18.0)"``; several in a list
``sum = "1 - 0.88"``
    arithmetic, one or several in a list: of numbers of that block or of the page, of ``a``, ``b``, ... for
    the values in ``code``, and of 1, 2, 100 and 1000, with ``sqrt`` and the like; numbers of the page are
    those outside the words quoted, so that none is its own source
``given = "SAE J2945/1, 6.3.8"``
    a standard, a publication, a data set, a device or another program says so: nothing here can be compared
``example = "what for"``
    the sentence supposes it

All but the last two are compared with the number as it is written, to its last digit. A quotation that the
page no longer has is an error too.
"""

import ast
import dataclasses
import importlib
import inspect
import math
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import KW_ONLY, dataclass
from operator import add, mul, sub, truediv
from pathlib import Path
from typing import Any

import numpy as np

from page_blocks import blocks_in
from prose_numbers import UNITS, quoted

__all__ = ["Source", "faults_of", "sources"]

ROOT = Path(__file__).resolve().parents[1]
LISTED = Path(__file__).with_suffix(".toml")
_STATED = re.compile(
    r"(?<![\w.,/_-])(\d{1,3}(?:,\d{3})+|\d+(?:\.\d+)?|\.\d+)(?![\w°])(?!\.\d)"
    r"(?:(?=(?:(?:,| to| and| or) \d+(?:\.\d+)?)*[ \u00a0]([%\w/]+)))?"
)
_OTHERS = {"km/h": 1.0 / 3.6, "mm": 1e-3, "mm/s": 1e-3}
"""Units that do not count in prose, or not as their first part says."""
_BARE = {1.0, 2.0, 100.0, 1000.0}
"""Numbers that arithmetic may use without a source."""
_FUNCTIONS = {"ceil", "exp", "sqrt", "cos", "sin", "tan", "radians", "degrees"}
_SIGNS = {ast.Add: add, ast.Sub: sub, ast.Mult: mul, ast.Div: truediv, ast.Pow: pow}


@dataclass(frozen=True, slots=True)
class Source:
    """Words of a page, and what the numbers in them come from; the module says what each field holds."""

    says: str
    _: KW_ONLY
    block: str = ""
    row: str = ""
    code: Sequence[str] = ()
    sum: Sequence[str] = ()
    given: str = ""
    example: str = ""


def sources() -> dict[str, list[Source]]:
    """All sources, by page."""
    found: dict[str, list[dict[str, Any]]] = tomllib.loads(LISTED.read_text(encoding="utf-8"))
    return {page: [_source(row) for row in rows] for page, rows in found.items()}


def _source(row: Mapping[str, Any]) -> Source:
    many = {name: [row[name]] for name in ("code", "sum") if isinstance(row.get(name), str)}
    return Source(**{**row, **many})


def faults_of(source: Source, page: str, texts: Mapping[str, str]) -> list[str]:
    """Return what is wrong with a source; empty where page and source agree.

    Parameters
    ----------
    source
        The source.
    page
        Text of the page that it is of.
    texts
        Texts of all pages with blocks, by their names from the project's root.

    Examples
    --------
    >>> half = Source("sends 12 % fewer", block="a.md rates", sum=["1 - 0.88"])
    >>> lines = ["<!-- begin rates -->", "| 0.88 |", "<!-- end rates -->"]
    >>> faults_of(half, "It sends 12 % fewer.", {"a.md": chr(10).join(lines)})
    []
    """
    if not quoted(page, [source.says]):
        return ["the page does not say so"]
    if source.given or source.example:
        return []
    try:
        values, operands = _values(source, page, texts)
    except ValueError as error:
        return [str(error)]
    return [
        f"{number} {unit}".rstrip() + " is not what the source has"
        for number, unit in _STATED.findall(source.says)
        if not _agree(number, unit, values, rounded=bool(source.sum)) and _value(number) not in operands
    ]


def _values(source: Source, page: str, texts: Mapping[str, str]) -> tuple[set[float], set[float]]:
    """The values that a source has, and the numbers that its arithmetic is of."""
    named = [value for name in source.code for value in values_of(name)]
    known = _block(source, texts) if source.block else set[float]()
    if not source.sum:
        if not named and not known:
            raise ValueError("it has no source")
        return {*named, *known}, set()
    trees = [ast.parse(one, mode="eval").body for one in source.sum]
    operands = {float(one.value) for tree in trees for one in ast.walk(tree) if isinstance(one, ast.Constant)}
    allowed = known or _numbers(_without(page, source.says))
    sums = {_sum(tree, allowed | _BARE, named) for tree in trees}
    return {*sums, *named}, (operands & allowed) - _BARE


def _without(page: str, says: str) -> str:
    """The page but for the words quoted."""
    ends = [0, *(end for span in quoted(page, [says]) for end in span), len(page)]
    return " ".join(page[first:last] for first, last in zip(ends[::2], ends[1::2], strict=True))


def _block(source: Source, texts: Mapping[str, str]) -> set[float]:
    """The numbers of a block, or of those of its lines that the row's words are in."""
    page, _, name = source.block.partition(" ")
    lines = blocks_in(texts[page]).get(name)
    if lines is None:
        raise ValueError(f"{page} has no block {name}")
    kept = [line for line in lines if source.row in line]
    if not kept:
        raise ValueError(f"no line of {name} has {source.row}")
    return _numbers(" ".join(kept))


def _numbers(text: str) -> set[float]:
    return {_value(found) for found in re.findall(r"\d{1,3}(?:,\d{3})+|\d+(?:\.\d+)?", text)}


def _value(digits: str) -> float:
    return float(digits.replace(",", ""))


def _agree(number: str, unit: str, values: Iterable[float], *, rounded: bool) -> bool:
    """Whether a number, in its unit or in the one that code has, is one of the values."""
    stated = _value(number)
    last = 0.5 * 10.0 ** -len(number.partition(".")[2]) if rounded else 0.0
    scales = {1.0, _OTHERS.get(unit) or UNITS.get(unit.partition("/")[0], 1.0)}
    return any(abs(stated - value / scale) <= last + 1e-9 * stated for value in values for scale in scales)


def _sum(node: ast.expr, known: set[float], values: Sequence[float]) -> float:
    """The value of arithmetic whose numbers are known."""
    match node:
        case ast.BinOp(left, sign, right) if type(sign) in _SIGNS:
            return float(_SIGNS[type(sign)](_sum(left, known, values), _sum(right, known, values)))
        case ast.UnaryOp(ast.USub(), operand):
            return -_sum(operand, known, values)
        case ast.Name(name) if len(name) == 1 and ord(name) - ord("a") < len(values):
            return values[ord(name) - ord("a")]
        case ast.Call(ast.Name(name), [of]) if name in _FUNCTIONS:
            return float(getattr(math, name)(_sum(of, known, values)))
        case ast.Constant(float() | int() as value):
            if float(value) not in known:
                raise ValueError(f"{value} has no source")
            return float(value)
        case _:
            raise ValueError(f"{ast.unparse(node)} is no arithmetic")


def values_of(name: str) -> list[float]:
    """Return the numbers that a name of the code has: one, or those of a sequence.

    Parameters
    ----------
    name
        With its module; behind a class a field or attribute, behind a function a parameter.

    Raises
    ------
    ValueError
        Where the code has no such name, or it is no number.
    """
    if " " in name:
        return _numbers_in(_assigned(*name.split(" ", 1)), name)
    value: Any = None
    parts = name.split(".")
    end = len(parts)
    while end and value is None:
        with suppress(ModuleNotFoundError):
            value = importlib.import_module(".".join(parts[:end]))
        end -= 1
    try:
        for part in parts[end + 1 :]:
            value = _part(value, part)
    except (AttributeError, KeyError) as error:
        raise ValueError(f"{name} is not there") from error
    return _numbers_in(value, name)


def _assigned(script: str, name: str) -> Any:
    """What a script says by itself that a name is, without being run; one in C++ and the like too."""
    if not name.isidentifier():
        if name not in (ROOT / script).read_text(encoding="utf-8"):
            raise ValueError(f"{script} has no {name}")
        return [float(found) for found in re.findall(r"\d[\d_]*(?:\.\d+)?(?:e-?\d+)?", name)]
    if not script.endswith(".py"):
        values = re.findall(rf"\b{name}\s?=\s?(\d+(?:\.\d+)?)", (ROOT / script).read_text(encoding="utf-8"))
        return [float(value) for value in values]
    for node in ast.parse((ROOT / script).read_text(encoding="utf-8")).body:
        match node:
            case ast.Assign([ast.Name(found)], value) if found == name:
                return ast.literal_eval(value)
            case ast.Assign([ast.Tuple(names)], ast.Tuple(values)):
                for target, value in zip(names, values, strict=True):
                    if isinstance(target, ast.Name) and target.id == name:
                        return ast.literal_eval(value)
            case _:
                pass
    raise ValueError(f"{script} has no {name}")


def _numbers_in(value: Any, name: str) -> list[float]:
    numbers = list(_flat(value))
    if not numbers:
        raise ValueError(f"{name} is no number but {value!r}")
    return numbers


def _flat(value: Any) -> Iterator[float]:
    """The numbers of a value, and of whatever it holds."""
    if isinstance(value, (int, float)):
        yield float(value)
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        yield from _flat([getattr(value, one.name) for one in dataclasses.fields(value)])
    elif isinstance(value, np.ndarray):
        yield from _flat(value.tolist())
    elif isinstance(value, Mapping):
        yield from _flat(tuple(value.values()))
    elif isinstance(value, (tuple, list, set, frozenset)):
        for one in value:
            yield from _flat(one)


def _part(value: Any, part: str) -> Any:
    """An attribute, an item, the default of a field or parameter, or with ``()`` what a call returns."""
    if part.endswith("()"):
        return _part(value, part.removesuffix("()"))()
    if isinstance(value, Mapping):
        return value[part]
    if dataclasses.is_dataclass(value) and isinstance(value, type):
        for one in dataclasses.fields(value):
            if one.name == part and one.default is not dataclasses.MISSING:
                return one.default
    if callable(value) and not isinstance(value, type):
        return inspect.signature(value).parameters[part].default
    return getattr(value, part)
