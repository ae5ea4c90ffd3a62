"""A part of a page: a heading, what it is about, a table, and figures with captions."""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass

from matplotlib.figure import Figure

from modelcast.core.cells import Cells, escape
from modelcast.report.page import figure

__all__ = ["Part"]


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a page.

    Parameters
    ----------
    title, scope
        Plain text.
    notes
        What must be known first, a line each.
    cells
        The table.
    figures
        Caption and figure by the stem of their files.
    """

    title: str
    scope: str
    _: KW_ONLY
    notes: Sequence[str] = ()
    cells: Cells
    figures: Mapping[str, tuple[str, Figure]]

    def markup(self) -> list[str]:
        """Return it as parts of a page's body."""
        found = [f"<h2>{escape(self.title)}</h2>", *(f"<p>{escape(line)}.</p>" for line in self.notes)]
        found += [figure(f"{name}.svg", caption) for name, (caption, _) in self.figures.items()]
        return [*found, f'<p class="scope">{escape(self.scope)}</p>', self.cells.html()]
