"""Names in a sentence, and the one that was meant where a name is misspelt."""

from collections.abc import Iterable
from difflib import SequenceMatcher, get_close_matches

__all__ = ["listed", "near"]


_LEAST = 0.6
"""Likeness below which a name is another one."""

_AS_GOOD = 0.1
"""Names that are less like it than the nearest by this are not meant."""


def listed(names: Iterable[str], word: str = "or") -> str:
    """Names in a sentence.

    Parameters
    ----------
    names
        At least one.
    word
        Before the last.

    Examples
    --------
    >>> listed(["one", "two", "three"]), listed(["one", "two"], "and")
    ('one, two or three', 'one and two')
    """
    *first, last = names
    return f"{', '.join(first)} {word} {last}" if first else last


def near(name: str, known: Iterable[str]) -> str:
    """A question for the name that was meant, where one is near; else nothing.

    Parameters
    ----------
    name
        What was given.
    known
        What there is.

    Examples
    --------
    >>> near("gian", ["gain", "loss"]), near("GAIN", ["gain", "loss"])
    (' (is gain meant?)', ' (is gain meant?)')
    """
    spelt: dict[str, list[str]] = {}
    for one in known:
        spelt.setdefault(one.casefold(), []).append(one)
    word = name.casefold()
    likeness = [SequenceMatcher(None, key, word).ratio() for key in get_close_matches(word, list(spelt), n=1)]
    least = max(_LEAST, likeness[0] - _AS_GOOD) if likeness else _LEAST
    close = get_close_matches(word, list(spelt), cutoff=least)
    return f" (is {listed(one for key in close for one in spelt[key])} meant?)" if close else ""
