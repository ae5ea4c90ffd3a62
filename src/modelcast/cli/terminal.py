"""The one way to the terminal: text in which nothing foreign is obeyed."""

import json
import sys
from typing import TYPE_CHECKING

from modelcast.core.printable import printable

if TYPE_CHECKING:
    from rich.console import Console, RenderableType

__all__ = ["complain", "error_console", "say", "say_json", "show"]


def complain(problem: object) -> None:
    """Print a problem, in one line, on the standard error.

    Parameters
    ----------
    problem
        An error or a text; what is not printable in it is escaped.
    """
    print(f"modelcast: {printable(str(problem))}", file=sys.stderr)


def say(line: str) -> None:
    """Print a line that is not wrapped, at once: a program that reads it through a pipe may wait for it.

    Parameters
    ----------
    line
        Any text; what is not printable in it is escaped.
    """
    print(printable(line), flush=True)


def say_json(document: object, *, sort: bool = True) -> None:
    """Print a document as JSON, which escapes what is not printable.

    Parameters
    ----------
    document
        Plain values.
    sort
        Whether names are sorted; else they stand in the document's order.
    """
    print(json.dumps(document, indent=2, sort_keys=sort))


def show(*tables: "RenderableType") -> None:
    """Print tables, one below the other.

    Parameters
    ----------
    tables
        Foreign text in them has been through `printable`; square brackets and colons are no markup.
    """
    from rich.console import Console

    Console(markup=False, emoji=False).print(*tables, sep="\n")


def error_console() -> "Console":
    """Return the console of progress bars: the standard error, without markup."""
    from rich.console import Console

    return Console(file=sys.stderr, markup=False, emoji=False)
