"""Tables in a terminal, written in one place: every cell is shown as it is."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from operator import itemgetter

from rich.box import HEAVY_HEAD, SIMPLE_HEAD, Box
from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, RenderResult
from rich.padding import Padding
from rich.segment import Segment
from rich.style import Style
from rich.table import Table
from rich.text import Text

from modelcast.core.cells import Cells
from modelcast.core.printable import printable
from modelcast.report.literal import literal

__all__ = ["PlacedTable", "console_table", "placed_table"]

_PLACE = "place"
_LONGEST = 24
"""Letters of a name in the first column that stay in one line: six numbers fit beside it in 80 columns."""


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
) -> "PlacedTable":
    """Return a table in which rows of one place follow each other under its name.

    Parameters
    ----------
    cells
        Headings and rows; names in the first column stay in one piece up to 24 letters.
    places
        Where each row belongs: a line of its own, whatever the widths of the columns.
    title
        Above it.
    padding
        Above, right of, below and left of each cell.
    min_width
        Of columns of numbers.
    """
    shown = _empty(cells, title, SIMPLE_HEAD, padding=padding)
    longest = max((cell_len(printable(row[0])) for row in cells.rows), default=0)
    first = shown.columns[0]
    first.no_wrap, first.width = longest <= _LONGEST, None if longest <= _LONGEST else _LONGEST
    for column in shown.columns[1:]:
        column.min_width = min_width
    names: list[str] = []
    for place, rows in groupby(zip(places, cells.rows, strict=True), key=itemgetter(0)):
        shown.add_section()
        shown.add_row(Text("-", style=Style.from_meta({_PLACE: len(names)})))
        names.append(place)
        for _, row in rows:
            shown.add_row(*map(literal, row))
    return PlacedTable(shown, tuple(names))


@dataclass(frozen=True, slots=True)
class PlacedTable:
    """A table with lines across all its columns, which have no say in their widths.

    Parameters
    ----------
    table
        With a row for each of the names, of one cell whose style tells the name's number.
    names
        In the order of their rows.
    """

    table: Table
    names: tuple[str, ...]

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Render the table, its lines of names replaced."""
        for line in console.render_lines(self.table, options):
            metas = [part.style.meta for part in line if part.style is not None]
            numbers = [int(meta[_PLACE]) for meta in metas if _PLACE in meta]
            if numbers:
                yield Padding(literal(self.names[numbers[0]], style="bold"), (0, 1))
            else:
                yield from line
                yield Segment.line()


def _empty(cells: Cells, title: str | None, box: Box, *, padding: tuple[int, ...]) -> Table:
    shown = Table(title=None if title is None else literal(title), box=box, header_style="")
    shown.title_justify = "left"
    shown.padding = padding  # type: ignore[assignment]
    for at, head in enumerate(cells.heads):
        text = Text("\n".join(map(printable, head.split("\n"))))
        shown.add_column(text, justify="left" if cells.is_text(at) else "right", overflow="fold")
    return shown
