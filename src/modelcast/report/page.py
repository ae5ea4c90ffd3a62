"""An HTML page and a table in it, with every string escaped."""

import math
from collections.abc import Iterable, Mapping, Sequence
from html import escape as escape_markup
from typing import Any, cast

from modelcast.core.printable import printable

__all__ = ["CSS", "escape", "number", "option_rows", "page", "table"]

CSS = """
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif; color: #222;
  background: #fff; max-width: 62rem; margin: 2rem auto; padding: 0 1.25rem; }
h1 { font-size: 1.6rem; margin: 0 0 .25rem; }
h2 { font-size: 1.15rem; margin: 2.2rem 0 .6rem; border-bottom: 1px solid #ddd; padding-bottom: .2rem; }
.scope { color: #555; margin: 0 0 .75rem; }
.note { color: #555; font-size: .85rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .8rem; font-variant-numeric: tabular-nums; margin: .4rem 0; }
th, td { padding: .22rem .55rem; text-align: right; vertical-align: top; border-bottom: 1px solid #eee; }
th { font-weight: 600; vertical-align: bottom; border-bottom: 1px solid #999; }
th.text, td.text { text-align: left; overflow-wrap: anywhere; min-width: 4.5rem; }
tbody tr:nth-child(even) { background: #f7f8fa; }
figure { margin: 1.4rem 0 2rem; }
figure img { max-width: 100%; height: auto; display: block; }
figcaption { font-size: .85rem; color: #444; margin-top: .5rem; max-width: 46rem; }
summary { cursor: pointer; font-weight: 600; margin: .4rem 0; }
@media print {
  @page { margin: 15mm; }
  body { max-width: none; margin: 0; padding: 0; font-size: 10pt; }
  figure, tr { break-inside: avoid; }
  h2 { break-after: avoid; }
  thead { display: table-header-group; }
  table { font-size: 6.5pt; }
  th, td { padding: .1rem .25rem; }
  .wide { overflow: visible; }
}
"""


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


def page(title: str, css: str, body: Iterable[str]) -> str:
    """Return a whole document; the parts of the body are markup already.

    Parameters
    ----------
    title
        Plain text.
    css
        The style sheet.
    body
        Parts of the body, in order.
    """
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{css}</style>\n</head>\n<body>\n"
        + "\n".join(part for part in body if part)
        + "\n</body>\n</html>\n"
    )


def table(head: Sequence[str], rows: Iterable[Sequence[str]], *, text_columns: int = 0) -> str:
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
    >>> "<td>&lt;b&gt;</td>" in table(["a"], [["<b>"]])
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


def number(value: float | None, digits: int = 3) -> str:
    """Return a number to so many significant digits, without an exponent; a dash where there is none.

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


def option_rows(options: Mapping[str, Any], prefix: str = "") -> list[list[str]]:
    """Return options as rows of name and value; what is nested gets a dotted name.

    Parameters
    ----------
    options
        As plain values.
    prefix
        Put before every name.

    Examples
    --------
    >>> option_rows({"seed": 0, "sensor": {"name": "ins"}})
    [['seed', '0'], ['sensor.name', 'ins']]
    """
    rows: list[list[str]] = []
    for name, value in options.items():
        if isinstance(value, Mapping):
            rows += option_rows(cast("Mapping[str, Any]", value), f"{prefix}{name}.")
        else:
            rows.append([f"{prefix}{name}", str(value)])
    return rows
