"""Foreign text made safe to show: names, identifiers and values that came from a file or from the air.

A terminal obeys control characters, so whoever names a vehicle could move the cursor or change the colours of
whoever reads about it. Every text that goes to a terminal passes through `printable`.
"""

__all__ = ["printable"]


def printable(text: str) -> str:
    r"""Return a text in one line, every character that is no visible one written as its escape.

    Control characters, line ends, marks that change the direction of writing, and halves of surrogate pairs
    (octets of a file name that are no UTF-8) become ``\x1b``, ``\n``, ``\u202e``, ``\udc80``.

    Parameters
    ----------
    text
        Any text.

    Examples
    --------
    >>> print(printable("car\x1b[31m 7\n"))
    car\x1b[31m 7\n
    """
    if text.isprintable():
        return text
    return "".join(
        letter if letter.isprintable() else letter.encode("unicode_escape").decode("ascii") for letter in text
    )
