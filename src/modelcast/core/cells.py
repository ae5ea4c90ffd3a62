"""Tables of text cells as markup: HTML and Markdown, each written in one place and every cell escaped."""

import math
from collections.abc import Iterable, Sequence
from html import escape as escape_markup

from modelcast.core.printable import printable

__all__ = ["escape", "html_table", "markdown", "markdown_table", "number"]


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
        Any text; what is not printable in it is escaped, and nothing in it is markup or ends a cell.

    Examples
    --------
    >>> markdown("a|b<c>")
    'a\\|b&lt;c>'
    """
    return printable(text).replace("&", "&amp;").replace("|", "\\|").replace("<", "&lt;")


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


def html_table(head: Sequence[str], rows: Iterable[Sequence[str]], *, text_columns: int = 0) -> str:
    """Return a table of plain text cells, which scrolls sideways where it is too wide.

    Parameters
    ----------
    head
        Headings.
    rows
        Cells.
    text_columns
        How many columns at the left hold text; the others hold numbers and are set to the right.

    Examples
    --------
    >>> "<td>&lt;b&gt;</td>" in html_table(["a"], [["<b>"]])
    True
    """

    def line(tag: str, cells: Sequence[str]) -> str:
        marked = (
            f'<{tag} class="text">{escape(cell)}</{tag}>'
            if at < text_columns
            else f"<{tag}>{escape(cell)}</{tag}>"
            for at, cell in enumerate(cells)
        )
        return f"<tr>{''.join(marked)}</tr>"

    body = "".join("\n" + line("td", row) for row in rows)
    return f'<div class="wide"><table><thead>{line("th", head)}</thead><tbody>{body}</tbody></table></div>'


def markdown_table(
    head: Sequence[str], rows: Iterable[Sequence[str]], *, text_columns: int | None = None
) -> list[str]:
    r"""Return the lines of a table of plain text cells.

    Parameters
    ----------
    head
        Headings.
    rows
        Cells.
    text_columns
        How many columns at the left hold text; those of numbers are set to the right. None leaves all to the
        reader's program.

    Examples
    --------
    >>> markdown_table(["a", "b"], [["x|y", "1"]], text_columns=1)
    ['| a | b |', '|---|---:|', '| x\\|y | 1 |']
    """
    marks = ["---" if text_columns is None or at < text_columns else "---:" for at in range(len(head))]
    lines = ["| " + " | ".join(map(markdown, cells)) + " |" for cells in (head, *rows)]
    return [lines[0], f"|{'|'.join(marks)}|", *lines[1:]]
