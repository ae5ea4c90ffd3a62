"""Tables in a terminal, written in one place: every cell is shown as it is, and no number is cut or wrapped.

Where a table is wider than the terminal, its columns of numbers are put below one another in parts, each
behind the same names. In a pipe, which has no width, it stays whole.
"""

from collections.abc import Iterable, Sequence
from dataclasses import KW_ONLY, dataclass
from itertools import groupby
from operator import itemgetter
from textwrap import wrap

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

__all__ = ["ConsoleTable", "console_table", "placed_table"]

_PLACE = "place"
_LONGEST = 24
"""Letters of a name in the first column that stay in one line: six numbers fit beside it in 80 columns."""


@dataclass(frozen=True, slots=True)
class ConsoleTable:
    """A table that shows itself as the width it is given allows.

    Parameters
    ----------
    cells
        Headings and rows.
    title
        Above it; None for none.
    places
        Where each row belongs, a line across all columns before the first of them, which has no say in the
        widths; empty where rows have no place.
    box
        Its lines.
    padding
        Above, right of, below and left of each cell.
    min_width
        Of columns of numbers.
    longest
        Letters of a name in the first column that stay in one line; None for as many as fit.
    keys
        How many columns stand in every part; None for those that hold text.
    """

    cells: Cells
    title: str | None
    _: KW_ONLY
    places: tuple[str, ...] = ()
    box: Box = HEAVY_HEAD
    padding: tuple[int, int, int, int] = (0, 1, 0, 1)
    min_width: int = 0
    longest: int | None = None
    keys: int | None = None

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Render the table, in as many parts as the width asks for."""
        everything = range(len(self.cells.heads))
        if self._width(everything, [self._natural(at) for at in everything]) <= options.max_width:
            yield from self._lines((everything, self.title), console, options, tight=False)
            return
        for at, columns in enumerate(self._parts(options.max_width)):
            yield from self._lines((columns, None if at else self.title), console, options, tight=True)

    @property
    def _keys(self) -> int:
        """How many columns stand in every part."""
        texts = self.cells.text_columns if self.keys is None else self.keys
        return len(self.cells.heads) if texts is None else max(texts, 1)

    def _parts(self, width: int) -> list[list[int]]:
        """Columns of each part."""
        keys = list(range(self._keys))
        parts: list[list[int]] = [[]]
        for at in range(self._keys, len(self.cells.heads)):
            tried = [*keys, *parts[-1], at]
            if parts[-1] and self._width(tried, [self._narrowest(one) for one in tried]) > width:
                parts.append([])
            parts[-1].append(at)
        return [[*keys, *part] for part in parts]

    def _width(self, columns: Sequence[int], widths: Iterable[int]) -> int:
        """Width of a table of columns that are so wide."""
        _, right, _, left = self.padding
        return len(columns) + 1 + sum(width + left + right for width in widths)

    def _natural(self, at: int) -> int:
        """Width of a column in which nothing is wrapped."""
        longest = _longest((*self.cells.heads[at].split("\n"), *(row[at] for row in self.cells.rows)))
        return longest if at < self._keys else max(longest, self.min_width)

    def _narrowest(self, at: int) -> int:
        """The narrowest that a column can be: its longest number, or what of its names stays in one piece."""
        head = _longest(self.cells.heads[at].split())
        if at >= self._keys:
            return max(head, _longest(row[at] for row in self.cells.rows), self.min_width)
        most = self.longest or _LONGEST
        pieces = [one for row in self.cells.rows for one in ([row[at]] if self.places else row[at].split())]
        return max(head, min(_longest(pieces), most))

    def _lines(
        self,
        part: tuple[Sequence[int], str | None],
        console: Console,
        options: ConsoleOptions,
        *,
        tight: bool,
    ) -> RenderResult:
        """Some of the columns under a title; in a tight table words of headings stand below one another."""
        columns, title = part
        table = self._table(columns, title, tight=tight)
        if self.places:
            size = self._narrowest if tight else self._natural
            others = self._width(columns, [0, *map(size, columns[1:])])
            self._set_first(table, options.max_width - others)
        if not self.places:
            for row in self.cells.rows:
                table.add_row(*(literal(row[at]) for at in columns))
            yield table
            return
        names: list[str] = []
        for place, rows in groupby(zip(self.places, self.cells.rows, strict=True), key=itemgetter(0)):
            table.add_section()
            table.add_row(Text("-", style=Style.from_meta({_PLACE: len(names)})))
            names.append(place)
            for _, row in rows:
                table.add_row(*(literal(row[at]) for at in columns))
        for line in console.render_lines(table, options, pad=False):
            metas = [part.style.meta for part in line if part.style is not None]
            numbers = [int(meta[_PLACE]) for meta in metas if _PLACE in meta]
            if numbers:
                yield Padding(literal(names[numbers[0]], style="bold"), (0, 1), expand=False)
            else:
                yield from line
                yield Segment.line()

    def _table(self, columns: Sequence[int], title: str | None, *, tight: bool) -> Table:
        shown = Table(title=None if title is None else literal(title), box=self.box, header_style="")
        shown.title_justify = "left"
        shown.padding = self.padding
        for at in columns:
            lines = self.cells.heads[at].split("\n")
            if at >= self._keys and tight:
                width = self._narrowest(at)
                lines = [piece for line in lines for piece in wrap(line, width, break_on_hyphens=False)]
            head = Text("\n".join(map(printable, lines)))
            shown.add_column(head, justify="left" if self.cells.is_text(at) else "right", overflow="fold")
            if at >= self._keys:
                shown.columns[-1].no_wrap, shown.columns[-1].min_width = True, self.min_width or None
        if not self.places and self.longest is not None:
            shown.columns[0].max_width = self.longest
        return shown

    def _set_first(self, shown: Table, room: int) -> None:
        """Names in one piece where none is long and there is room, else folded."""
        most = max(min(self.longest or _LONGEST, room), 1)
        longest = _longest(row[0] for row in self.cells.rows)
        shown.columns[0].no_wrap = longest <= most
        shown.columns[0].width = None if longest <= most else most


def _longest(texts: Iterable[str]) -> int:
    """Columns that the longest text takes."""
    return max((cell_len(printable(text)) for text in texts), default=0)


def console_table(
    cells: Cells,
    title: str | None = None,
    *,
    box: Box = HEAVY_HEAD,
    padding: tuple[int, int, int, int] = (0, 1, 0, 1),
    longest: int | None = None,
    keys: int | None = None,
) -> ConsoleTable:
    """Return a table for the terminal.

    Parameters
    ----------
    cells
        Headings and rows.
    title
        Above it.
    box
        Its lines.
    padding
        Above, right of, below and left of each cell.
    longest
        Letters of a name in the first column that stay in one line; None for as many as fit.
    keys
        Columns that stand in every part of a table that is too wide; None for those that hold text.
    """
    return ConsoleTable(cells, title, box=box, padding=padding, longest=longest, keys=keys)


def placed_table(
    cells: Cells,
    places: Sequence[str],
    title: str | None = None,
    *,
    padding: tuple[int, int, int, int] = (0, 1, 0, 0),
    min_width: int = 0,
) -> ConsoleTable:
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
    return ConsoleTable(
        cells, title, places=tuple(places), box=SIMPLE_HEAD, padding=padding, min_width=min_width
    )
