"""Tables of text cells as markup: HTML and Markdown, each written in one place and every cell escaped."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape as escape_markup

from modelcast.core.printable import printable

__all__ = ["Cells", "escape", "markdown", "number"]


def escape(text: str) -> str:
    r"""Return a text as markup that shows it: nothing in it is a tag, and every character is a visible one.

    Parameters
    ----------
    text
        Any text.

    Examples
    --------
    >>> print(escape("<b>\x07"))
    &lt;b&gt;\x07
    """
    return escape_markup(printable(text))


def markdown(text: str) -> str:
    r"""Return foreign text for a cell or a line of Markdown.

    Parameters
    ----------
    text
        Any text; what is not printable in it is escaped, and nothing in it is markup or ends a cell; a sign
        that begins no tag stays.

    Examples
    --------
    >>> markdown("a|b<c>"), markdown("1 < 2")
    ('a\\|b&lt;c>', '1 < 2')
    """
    escaped = printable(text).replace("&", "&amp;").replace("|", "\\|")
    return re.sub("<(?=[A-Za-z/!?])", "&lt;", escaped)


def number(value: float | None, digits: int = 3) -> str:
    """Return a number to so many significant digits, without an exponent; a dash where there is none.

    Parameters
    ----------
    value
        Any number; None and what is not finite are none.
    digits
        At least so many where the number is not whole in fewer.

    Examples
    --------
    >>> number(0.12345), number(1234.5), number(None), number(2.0)
    ('0.123', '1234', '-', '2.00')
    """
    if value is None or not math.isfinite(value):
        return "-"
    if value == 0:
        return "0"
    decimals = digits - 1 - math.floor(math.log10(abs(value)))
    return f"{value:.{min(max(decimals, 0), 6)}f}"


@dataclass(frozen=True, slots=True)
class Cells:
    r"""A table as people read it: plain text in every cell.

    Parameters
    ----------
    heads
        Headings, one a column.
    rows
        Cells, one a column.
    text_columns
        How many columns at the left hold text; the others hold numbers and are set to the right. None for
        all.

    Examples
    --------
    >>> shown = Cells(["a", "b"], [["x|<b>", "1"]], text_columns=1)
    >>> shown.markdown()
    ['| a | b |', '|---|---:|', '| x\\|&lt;b> | 1 |']
    >>> '<td class="text">x|&lt;b&gt;</td><td>1</td>' in shown.html()
    True
    """

    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    text_columns: int | None = None

    def is_text(self, at: int) -> bool:
        """Whether a column holds text.

        Parameters
        ----------
        at
            Its place, from 0.
        """
        return self.text_columns is None or at < self.text_columns

    def markdown(self) -> list[str]:
        """Return the lines of the table in Markdown."""
        marks = ["---" if self.is_text(at) else "---:" for at in range(len(self.heads))]
        lines = ["| " + " | ".join(map(markdown, cells)) + " |" for cells in (self.heads, *self.rows)]
        return [lines[0], f"|{'|'.join(marks)}|", *lines[1:]]

    def html(self) -> str:
        """Return the table as markup, which scrolls sideways where it is too wide."""
        body = "".join("\n" + self._html_line("td", row) for row in self.rows)
        head = self._html_line("th", self.heads)
        return f'<div class="wide"><table><thead>{head}</thead><tbody>{body}</tbody></table></div>'

    def _html_line(self, tag: str, cells: Sequence[str]) -> str:
        marked = (
            f'<{tag} class="text">{escape(cell)}</{tag}>'
            if self.is_text(at)
            else f"<{tag}>{escape(cell)}</{tag}>"
            for at, cell in enumerate(cells)
        )
        return f"<tr>{''.join(marked)}</tr>"
