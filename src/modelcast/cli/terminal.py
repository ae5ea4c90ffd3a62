"""The one way to the terminal: text in which nothing foreign is obeyed."""

import sys

from rich.console import Console, RenderableType

from modelcast.core.printable import printable

__all__ = ["complain", "error_console", "say", "show"]


def complain(problem: object) -> None:
    """Print a problem, in one line, on the standard error.

    Parameters
    ----------
    problem
        An error or a text; what is not printable in it is escaped.
    """
    print(f"modelcast: {printable(str(problem))}", file=sys.stderr)


def say(line: str) -> None:
    """Print a line that is not wrapped.

    Parameters
    ----------
    line
        Any text; what is not printable in it is escaped.
    """
    print(printable(line))


def show(*tables: RenderableType) -> None:
    """Print tables, one below the other.

    Parameters
    ----------
    tables
        Foreign text in them has been through `printable`; square brackets and colons are no markup.
    """
    Console(markup=False, emoji=False).print(*tables, sep="\n")


def error_console() -> Console:
    """Return the console of progress bars: the standard error, without markup."""
    return Console(file=sys.stderr, markup=False, emoji=False)
