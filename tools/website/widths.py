"""A Sphinx extension: what is long says so, for a style sheet that has to fit it into a phone's width.

A word of code breaks nowhere, so that ``--per`` never stands on two lines, unless it is ``long``. A cell of a
table that is ``long`` gets a width to be read in, and the table scrolls.
"""

from docutils import nodes
from sphinx.application import Sphinx

__all__ = ["setup"]

_LONG = "long"
_LONGEST_WORD = 32
"""Characters of code that fit beside a list's indent at 390 px."""

_LONGEST_CELL = 60
"""Characters of a cell that read well in a narrow column."""


def _mark(_app: Sphinx, doctree: nodes.document, _name: str) -> None:
    """Mark code and cells of a page."""
    for code in doctree.findall(nodes.literal):
        if max(map(len, code.astext().split()), default=0) > _LONGEST_WORD:
            code["classes"].append(_LONG)
    for cell in doctree.findall(nodes.entry):
        if len(cell.astext()) > _LONGEST_CELL:
            cell["classes"].append(_LONG)


def setup(app: Sphinx) -> dict[str, bool]:
    """Take part in a build."""
    app.connect("doctree-resolved", _mark)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
