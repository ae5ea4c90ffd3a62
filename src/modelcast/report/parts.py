"""A part of a page: a heading, what it is about, a table, and figures with captions."""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass

from matplotlib.figure import Figure

from modelcast.core.cells import escape, html_table

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
    heads, rows
        Of the table, plain text.
    text_columns
        How many of its columns hold text.
    figures
        Caption and figure by the stem of their files.
    """

    title: str
    scope: str
    _: KW_ONLY
    notes: Sequence[str] = ()
    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    text_columns: int
    figures: Mapping[str, tuple[str, Figure]]

    def markup(self) -> list[str]:
        """Return it as parts of a page's body."""
        found = [f"<h2>{escape(self.title)}</h2>", *(f"<p>{escape(line)}.</p>" for line in self.notes)]
        for name, (caption, _) in self.figures.items():
            found.append(
                f'<figure><img src="{escape(name)}.svg" alt="{escape(caption)}">'
                f"<figcaption>{escape(caption)}</figcaption></figure>"
            )
        scope = f'<p class="scope">{escape(self.scope)}</p>'
        return [*found, scope, html_table(self.heads, self.rows, text_columns=self.text_columns)]
