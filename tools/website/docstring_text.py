"""A Sphinx extension: docstrings and signatures read as their authors wrote them.

The first line of a property may have a colon without naming a type. Annotations are evaluated, and no longer
tell the names of arrays and bounds: arrays are ``NDArray`` of a kind again; bounds, which the text has, are
left out.
"""

import re
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx

__all__ = ["setup"]

_EARLY = 400
"""Before napoleon, which listens at 500."""

_ARRAY = re.compile(
    r"~?(?:numpy\.)?ndarray\[tuple\[~?(?:typing\.)?Any, \.\.\.\], ~?(?:numpy\.)?dtype\[([^\]]+)\]\]"
)
_BOUND = re.compile(
    r"~typing\.Annotated\[(.*?), ~modelcast\.core\.rules\.\w+\.\w+\((?:[^()]|\([^()]*\))*\)\]", re.DOTALL
)


def _keep_colon(_app: Sphinx, what: str, _name: str, _thing: Any, _options: Any, lines: list[str]) -> None:
    """Begin the text of a property with a comment: napoleon takes what stands before a colon for a type."""
    if what in {"attribute", "property"}:
        lines[:0] = ["..", ""]


def _short(text: str) -> str:
    return _BOUND.sub(r"\1", _ARRAY.sub(r"~numpy.typing.NDArray[\1]", text)).replace("<factory>", "...")


def _shorten(
    _app: Sphinx,
    _what: str,
    _name: str,
    _thing: Any,
    _options: Any,
    signature: str | None,
    returns: str | None,
) -> tuple[str | None, str | None]:
    """Name arrays and bounded values shortly; a default that is made is no Python, and left to the text."""
    short = [text and _short(text) for text in (signature, returns)]
    return short[0], short[1]


def _shorten_properties(_app: Sphinx, _domain: str, _kind: str, content: addnodes.desc_content) -> None:
    """Name the arrays that properties give shortly."""
    for annotation in content.parent.findall(addnodes.desc_annotation):
        text = annotation.astext()
        short = _ARRAY.sub(r"NDArray[\1]", text)
        if short != text:
            annotation.children = [nodes.Text(short)]


def setup(app: Sphinx) -> dict[str, bool]:
    """Take part in a build."""
    app.connect("autodoc-process-docstring", _keep_colon, priority=_EARLY)
    app.connect("autodoc-process-signature", _shorten)
    app.connect("object-description-transform", _shorten_properties)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
