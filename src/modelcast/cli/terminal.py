"""The one way to the terminal: text in which nothing foreign is obeyed."""

import json
import os
import sys
from collections.abc import Callable, Generator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TYPE_CHECKING

from modelcast.core.printable import printable

if TYPE_CHECKING:
    from rich.console import Console, RenderableType

__all__ = ["beside", "complain", "error_console", "say", "say_json", "show"]

_NO_WIDTH = 10_000
_Aside = Callable[[], AbstractContextManager[None]]
_asides: list[_Aside] = []


@contextmanager
def beside(aside: _Aside) -> Generator[None]:
    """For as long as the block lasts, print between what is shown there anyhow.

    Parameters
    ----------
    aside
        Gives a context in which that is taken away.
    """
    _asides.append(aside)
    try:
        yield
    finally:
        _asides.remove(aside)


def _room() -> AbstractContextManager[None]:
    return _asides[-1]() if _asides else nullcontext()


def complain(problem: object) -> None:
    """Print a problem, in one line, on the standard error.

    Parameters
    ----------
    problem
        An error or a text; what is not printable in it is escaped.
    """
    with _room():
        print(f"modelcast: {printable(str(problem))}", file=sys.stderr)


def say(line: str) -> None:
    """Print a line that is not wrapped, at once: a program that reads it through a pipe may wait for it.

    Parameters
    ----------
    line
        Any text; what is not printable in it is escaped.
    """
    with _room():
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
    with _room():
        print(json.dumps(document, indent=2, sort_keys=sort))


def show(*tables: "RenderableType") -> None:
    """Print tables, one below the other.

    Parameters
    ----------
    tables
        Foreign text in them has been through `printable`; square brackets and colons are no markup.
    """
    from rich.console import Console

    with _room():
        # Only a terminal has a width: in a pipe or a file nothing is wrapped, unless COLUMNS asks for it.
        attended = sys.stdout.isatty()
        width = None if attended or os.environ.get("COLUMNS") else _NO_WIDTH
        console = Console(markup=False, emoji=False, width=width)
        if attended:
            console.print(*tables, sep="\n")
            return
        with console.capture() as captured:
            console.print(*tables, sep="\n")
        for line in captured.get().splitlines():
            print(line.rstrip())


def error_console() -> "Console":
    """Return the console of progress bars: a terminal at the standard error, without markup."""
    from rich.console import Console

    return Console(file=sys.stderr, markup=False, emoji=False, force_terminal=True)
