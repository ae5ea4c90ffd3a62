"""A Sphinx extension: docstrings and signatures read as their authors wrote them.

The first line of a property may have a colon without naming a type. Annotations are evaluated, and no longer
tell the names of arrays and bounds: arrays are ``NDArray`` of a kind and ``ArrayLike`` again; bounds, which
the text has, are left out. Defaults that are objects of many fields are named without these, and numbers are
written as in the source: ``4 / 3`` has no sixteen digits.
"""

import ast
import dataclasses
import inspect
import re
from textwrap import dedent
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx

__all__ = ["setup", "short_signature"]

_EARLY = 400
"""Before napoleon, which listens at 500."""

_ARRAY = re.compile(
    r"~?(?:numpy\.)?ndarray\[tuple\[~?(?:typing\.)?Any, \.\.\.\], ~?(?:numpy\.)?dtype\[([^\]]+)\]\]"
)
_LIKE_AN_ARRAY = re.compile(
    r"~?[\w.]*_Buffer \| ~?[\w.]*_SupportsArray\[.*?_NestedSequence\[complex \| bytes \| str\]"
)
_BOUNDED = re.compile(r"~(?:typing|types)\.Annotated\[")
_MADE = re.compile(r"(?<= = )[\w.]+\((?=\w+=)")
"""The beginning of a default that is an object, told by its fields."""

_CALLED = re.compile(r"<(?:class|function) '?(?:[\w.]*\.)?(\w+)'?(?: at 0x[0-9a-f]+)?>")
"""A default that is a class or function, which has a name."""

_LONGEST_NUMBER = 9
"""Characters of a number that reads well as it is."""

_OPENING, _CLOSING = "([{", ")]}"


def _keep_colon(_app: Sphinx, what: str, _name: str, _thing: Any, _options: Any, lines: list[str]) -> None:
    """Begin the text of a property with a comment: napoleon takes what stands before a colon for a type."""
    if what in {"attribute", "property"}:
        lines[:0] = ["..", ""]


def _end(text: str, begin: int, *, at_comma: bool = False) -> int:
    """Where a bracket that was opened before ``begin`` closes, or its first comma; quoted text is skipped."""
    depth, quote = 0, ""
    for at in range(begin, len(text)):
        letter = text[at]
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "'\"":
            quote = letter
        elif depth == 0 and (letter in _CLOSING or (at_comma and letter == ",")):
            return at
        else:
            depth += (letter in _OPENING) - (letter in _CLOSING)
    raise ValueError(f"a bracket is not closed: {text}")


def _without_bounds(text: str) -> str:
    """Each ``Annotated[kind, bound]`` as its kind."""
    while bounded := _BOUNDED.search(text):
        begin = bounded.end()
        kind = text[begin : _end(text, begin, at_comma=True)]
        text = text[: bounded.start()] + kind + text[_end(text, begin) + 1 :]
    return text


def _without_fields(text: str) -> str:
    """Each default that is told by its fields, by its class alone."""
    begin = 0
    while made := _MADE.search(text, begin):
        text = f"{text[: made.end()]}...{text[_end(text, made.end()) :]}"
        begin = made.end()
    return text


def _own_names(thing: Any, text: str) -> str:
    """Defaults that only their module knows by a name, as their values where these read well."""
    called = thing.__init__ if isinstance(thing, type) else thing
    known: dict[str, Any] = getattr(called, "__globals__", {})

    def shown(name: re.Match[str]) -> str:
        value = known.get(name[0])
        plain = isinstance(value, int | float) and len(repr(value)) <= _LONGEST_NUMBER
        return repr(value) if plain else name[0]

    return re.sub(r"(?<= = )_?[A-Z][A-Z_]+\b", shown, text)


def _numbers_as_written(thing: Any, text: str) -> str:
    """Long numbers among the defaults of a class as its source has them."""
    if not (isinstance(thing, type) and dataclasses.is_dataclass(thing)):
        return text
    values = {one.name: one.default for one in dataclasses.fields(thing)}
    written = ast.parse(dedent(inspect.getsource(thing))).body[0]
    for line in getattr(written, "body", []):
        if isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name) and line.value is not None:
            name, shown = line.target.id, repr(values.get(line.target.id))
            source = ast.unparse(line.value)
            if isinstance(values.get(name), float) and len(shown) > _LONGEST_NUMBER and source[0] != "_":
                text = re.sub(rf"(\b{name}: [^=]+ = ){re.escape(shown)}", rf"\g<1>{source}", text)
    return text


def short_signature(text: str) -> str:
    """Return a signature, or what it returns, with short names of kinds and defaults.

    Parameters
    ----------
    text
        As Sphinx has it.

    Examples
    --------
    >>> short_signature("(n: ~typing.Annotated[int, Number(0, (1, 2))] = 3, d: Drivers = Drivers(a=(1, 2)))")
    '(n: int = 3, d: Drivers = Drivers(...))'
    >>> short_signature("(each: Each = <class 'map'>, n: ~types.Annotated[int | None, Maybe(1)] = None)")
    '(each: Each = map, n: int | None = None)'
    """
    text = _CALLED.sub(r"\1", _LIKE_AN_ARRAY.sub("~numpy.typing.ArrayLike", _without_bounds(text)))
    return _without_fields(_ARRAY.sub(r"~numpy.typing.NDArray[\1]", text).replace("<factory>", "..."))


def _shorten(
    _app: Sphinx,
    _what: str,
    _name: str,
    thing: Any,
    _options: Any,
    signature: str | None,
    returns: str | None,
) -> tuple[str | None, str | None]:
    """Name arrays and bounded values shortly; a default that is made is no Python, and left to the text."""
    short = [
        text and short_signature(_own_names(thing, _numbers_as_written(thing, text)))
        for text in (signature, returns)
    ]
    return short[0], short[1]


def _leave_out_object(_app: Sphinx, _domain: str, kind: str, content: addnodes.desc_content) -> None:
    """Of a class that is derived from nothing, do not say so."""
    first = content.children[0] if content.children else None
    if kind == "class" and isinstance(first, nodes.paragraph) and first.astext() == "Bases: object":
        content.remove(first)


def _shorten_properties(_app: Sphinx, _domain: str, _kind: str, content: addnodes.desc_content) -> None:
    """Name the arrays that properties give shortly; a value that is no Python is left out."""
    for annotation in list(content.parent.findall(addnodes.desc_annotation)):
        text = annotation.astext()
        short = _ARRAY.sub(r"NDArray[\1]", text)
        if "(<" in text:
            annotation.parent.remove(annotation)
        elif short != text:
            annotation.children = [nodes.Text(short)]


def setup(app: Sphinx) -> dict[str, bool]:
    """Take part in a build."""
    app.connect("autodoc-process-docstring", _keep_colon, priority=_EARLY)
    app.connect("autodoc-process-signature", _shorten)
    app.connect("object-description-transform", _shorten_properties)
    app.connect("object-description-transform", _leave_out_object)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
