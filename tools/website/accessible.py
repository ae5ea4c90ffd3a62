"""A Sphinx extension: what screen readers cannot say of Sphinx's pages is written otherwise.

The parameters of a long signature are definitions without a term; here they are lines. An empty cell in a
table's head is a heading without words; here it is a cell, and a head of such cells alone is left out. Where
the first column has no heading, its cells are the headings of their rows.
"""

import re
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx

__all__ = ["setup"]

_PARAMETERS = re.compile(r"<dl>\n((?:<dd>.*</dd>\n)+)</dl>")
_EMPTY_HEADING = re.compile(r"<th([^>]*)>\s*(?:<p>\s*</p>)?\s*</th>")
_EMPTY_HEAD = re.compile(r"<thead>\s*<tr[^>]*>\s*(?:<td[^>]*></td>\s*)+</tr>\s*</thead>\s*")
_TABLE = re.compile(r"<table.*?</table>", re.DOTALL)
_UNNAMED_COLUMN = re.compile(r"<thead>\s*<tr[^>]*>\s*<td[^>]*></td>")
_FIRST_CELL = re.compile(r"(<tr[^>]*>\s*)<td([^>]*)>(?!\s*(?:<p>\s*</p>)?\s*</td>)(.*?)</td>", re.DOTALL)


def _rows(found: re.Match[str]) -> str:
    """The table with headings of rows, where its first column has none."""
    if not _UNNAMED_COLUMN.search(found[0]):
        return found[0]
    head, end, rows = found[0].partition("</thead>")
    return head + end + _FIRST_CELL.sub(r'\1<th scope="row"\2>\3</th>', rows)


def _lines(found: re.Match[str]) -> str:
    """The same in elements without a meaning of their own; a signature is inline text."""
    lines = found[1].replace("<dd>", '<span class="sig-line">').replace("</dd>", "</span>")
    return f"<span>\n{lines}</span>"


def _rewrite(
    _app: Sphinx, _name: str, _template: str, context: dict[str, Any], _doctree: nodes.document | None
) -> None:
    """Rewrite a page."""
    if "body" in context:
        body = _EMPTY_HEADING.sub(r"<td\1></td>", _PARAMETERS.sub(_lines, context["body"]))
        context["body"] = _TABLE.sub(_rows, _EMPTY_HEAD.sub("", body))


def setup(app: Sphinx) -> dict[str, bool]:
    """Take part in a build."""
    app.connect("html-page-context", _rewrite)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
