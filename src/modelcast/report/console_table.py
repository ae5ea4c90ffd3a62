"""Tables in a terminal, written in one place: every cell is shown as it is."""

from collections.abc import Sequence

from rich.box import HEAVY_HEAD, SIMPLE_HEAD, Box
from rich.table import Table
from rich.text import Text

from modelcast.core.cells import Cells
from modelcast.core.printable import printable
from modelcast.report.literal import literal

__all__ = ["console_table", "placed_table"]


def console_table(cells: Cells, title: str | None = None, *, box: Box = HEAVY_HEAD) -> Table:
    """Return a table for the terminal.

    Parameters
    ----------
    cells
        Headings and rows.
    title
        Above it.
    box
        Its lines.
    """
    shown = _empty(cells, title, box, padding=(0, 1))
    for row in cells.rows:
        shown.add_row(*map(literal, row))
    return shown


def placed_table(
    cells: Cells,
    places: Sequence[str],
    title: str | None = None,
    *,
    padding: tuple[int, int, int, int] = (0, 1, 0, 0),
    min_width: int | None = None,
) -> Table:
    """Return a table in which rows of one place follow each other under its name.

    Parameters
    ----------
    cells
        Headings and rows; names in the first column stay in one piece.
    places
        Where each row belongs.
    title
        Above it.
    padding
        Above, right of, below and left of each cell.
    min_width
        Of columns of numbers.
    """
    shown = _empty(cells, title, SIMPLE_HEAD, padding=padding)
    shown.columns[0].no_wrap = True
    for column in shown.columns[1:]:
        column.min_width = min_width
    before = None
    for place, row in zip(places, cells.rows, strict=True):
        if place != before:
            shown.add_section()
            shown.add_row(literal(place, style="bold"))
        shown.add_row(*map(literal, row))
        before = place
    return shown


def _empty(cells: Cells, title: str | None, box: Box, *, padding: tuple[int, ...]) -> Table:
    shown = Table(title=None if title is None else literal(title), box=box, header_style="")
    shown.title_justify = "left"
    shown.padding = padding  # type: ignore[assignment]
    for at, head in enumerate(cells.heads):
        text = Text("\n".join(map(printable, head.split("\n"))))
        shown.add_column(text, justify="left" if cells.is_text(at) else "right", overflow="fold")
    return shown
