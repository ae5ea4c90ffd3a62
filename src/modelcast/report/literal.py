"""Foreign text in a terminal table: shown as it is, and not obeyed."""

from rich.text import Text

from modelcast.core.printable import printable

__all__ = ["literal"]


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
