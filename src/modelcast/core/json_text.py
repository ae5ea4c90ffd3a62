"""JSON from somebody else: measured before it is parsed, and plain throughout.

Size and depth are looked at in the text itself, so that a file of a hundred thousand brackets is refused
without a parser that calls itself as often. After that every number is finite, every text printable and every
key stands once, wherever it is; what a field must be is for `modelcast.core.rules`.
"""

import json
import math
import re
from collections.abc import Iterator, Sequence
from typing import Any, cast

from modelcast.core.rules import FieldError, is_clean, shown

__all__ = ["LARGEST_BYTES", "LARGEST_NUMBER", "MOST_DEPTH", "MOST_ITEMS", "parse_json", "schema_of"]

LARGEST_BYTES = 1 << 24
"""Octets of the whole, 16 MiB: thirty times the shipped profile."""

MOST_DEPTH = 32
"""Brackets inside brackets; the shipped profile has seven."""

MOST_ITEMS = 1_000_000
"""Commas and brackets of the whole, as good as values; the shipped profile has about four thousand."""

LARGEST_NUMBER = 2**53
"""Size of any number outside an array: beyond it not every whole number is a float."""

_PIECES = re.compile(r'"[^"\\]*(?:\\.[^"\\]*)*"|[\[{]|[\]}]', re.DOTALL)


class _Twice(dict[str, Any]):
    """A mapping that had a key twice."""

    key = ""


def parse_json(text: str) -> Any:
    """The plain value that a text describes.

    Parameters
    ----------
    text
        JSON.

    Raises
    ------
    ValueError
        Where it is too large, too deep or no JSON.
    FieldError
        Where a key stands twice, a number is not finite or too large, or a text holds control characters.

    Examples
    --------
    >>> parse_json('{"a": [1, 2.5]}')
    {'a': [1, 2.5]}
    """
    if len(text) > LARGEST_BYTES:
        raise ValueError(f"it has {len(text)} characters; at most {LARGEST_BYTES} are read")
    items = sum(text.count(mark) for mark in ",[{")
    if items > MOST_ITEMS:
        raise ValueError(f"it has about {items} values; at most {MOST_ITEMS} are read")
    _require_shallow(text)
    try:
        value = json.loads(text, object_pairs_hook=_mapping)
    except ValueError as error:
        raise ValueError(f"no JSON: {error}") from error
    for path, item in _walk(value, ("$",)):
        _require_plain(path, item)
    return value


def schema_of(document: Any, known: int) -> int:
    """The schema that a document says it has, up to the newest known one.

    Parameters
    ----------
    document
        A mapping with ``schema``.
    known
        The newest that this version reads.

    Raises
    ------
    ValueError
        Where there is none, or it is of a newer modelcast.
    """
    if not isinstance(document, dict) or "schema" not in document:
        raise FieldError("$", cast("object", document), "a mapping with 'schema'")
    found: Any = cast("dict[str, Any]", document)["schema"]
    if type(found) is not int or found < 1:
        raise FieldError("$.schema", found, f"a whole number from 1 to {known}")
    if found > known:
        raise ValueError(
            f"$.schema: schema {shown(found)} was made by a newer modelcast; this one reads up to {known}"
        )
    return found


def _require_shallow(text: str) -> None:
    depth = 0
    for piece in _PIECES.finditer(text):
        mark = text[piece.start()]
        if mark != '"':
            depth += 1 if mark in "[{" else -1
            if depth > MOST_DEPTH:
                raise ValueError(f"brackets are more than {MOST_DEPTH} deep at character {piece.start()}")


def _mapping(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) == len(pairs):
        return found
    twice = _Twice(found)
    seen: set[str] = set()
    for key, _ in pairs:
        if key in seen:
            twice.key = key
        seen.add(key)
    return twice


def _walk(value: Any, path: tuple[Any, ...]) -> Iterator[tuple[tuple[Any, ...], Any]]:
    """Every value of a plain one, from outside inwards, with the keys that lead there."""
    yield path, value
    if isinstance(value, dict):
        for key, item in cast("dict[str, Any]", value).items():
            yield (*path, key), key
            yield from _walk(item, (*path, key))
    elif isinstance(value, list):
        for at, item in enumerate(cast("list[Any]", value)):
            if type(item) is float and -LARGEST_NUMBER <= item <= LARGEST_NUMBER:
                continue  # most items are such
            yield from _walk(item, (*path, at))


def _require_plain(path: tuple[Any, ...], value: Any) -> None:
    if isinstance(value, _Twice):
        raise FieldError(_named(path), value.key, "a mapping whose keys stand once")
    if isinstance(value, str):
        if not is_clean(value):
            raise FieldError(_named(path), value, "a text without control characters")
    elif isinstance(value, float) and not math.isfinite(value):
        raise FieldError(_named(path), value, "a finite number")
    elif isinstance(value, int | float) and not -LARGEST_NUMBER <= value <= LARGEST_NUMBER:
        raise FieldError(_named(path), value, f"a number of at most {LARGEST_NUMBER} in size")


def _named(path: Sequence[Any]) -> str:
    parts = [f"[{part}]" if isinstance(part, int) else f".{_key(str(part))}" for part in path[1:]]
    return "$" + "".join(parts)


def _key(key: str) -> str:
    return key if is_clean(key) and len(key) < 40 else shown(key)
