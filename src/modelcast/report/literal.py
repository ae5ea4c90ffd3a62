"""Foreign text in a terminal table: shown as it is, and not obeyed."""

from dataclasses import dataclass

from rich.console import Console, ConsoleOptions, RenderResult
from rich.text import Text

from modelcast.core.printable import printable

__all__ = ["Prose", "literal"]

_LINE = 100
"""Columns that a line of prose takes at most, also where there is no end of room."""


def literal(text: str, style: str = "") -> Text:
    r"""Return a text of which nothing is markup and every character is a visible one.

    Parameters
    ----------
    text
        Any text: an identifier, a file's name, an error.
    style
        Style of all of it.

    Examples
    --------
    >>> literal("[red]car\x07").plain == r"[red]car\x07"
    True
    """
    return Text(printable(text), style=style)


@dataclass(frozen=True, slots=True)
class Prose:
    """Sentences, in lines that can be read: as wide as the terminal, and no wider than 100 columns.

    Parameters
    ----------
    text
        Shown as `literal` shows it.
    """

    text: str

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Render the lines."""
        yield from console.render(literal(self.text), options.update(width=min(options.max_width, _LINE)))
