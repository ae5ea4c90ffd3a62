"""Ratios in words: fewer, as many, more; from which to which; how many of how many."""

from collections.abc import Iterable, Sequence
from math import isfinite

__all__ = ["ERROR", "MESSAGES", "counted", "numbers", "range_text", "share_text", "verdict"]

MESSAGES = ("fewer messages than", "as many messages as", "more messages than")
"""Verdicts on ratios of messages."""

ERROR = ("smaller than", "as large as", "larger than")
"""Verdicts on ratios of errors."""

_ALIKE = 0.03
"""Ratios that are no farther from 1 are about 1."""


def numbers(values: Iterable[float | None]) -> list[float]:
    """Return those values that are numbers.

    Parameters
    ----------
    values
        Any.
    """
    return [value for value in values if value is not None and isfinite(value)]


def range_text(values: Sequence[float]) -> str:
    """Return smallest to largest, in two places.

    Parameters
    ----------
    values
        At least one.

    Examples
    --------
    >>> range_text([0.912, 0.5]), range_text([1.0])
    ('0.50 to 0.91', '1.00')
    """
    low, high = f"{min(values):.2f}", f"{max(values):.2f}"
    return low if low == high else f"{low} to {high}"


def share_text(some: int, of: int) -> str:
    """Return so many of all in words.

    Parameters
    ----------
    some, of
        How many, and of how many.

    Examples
    --------
    >>> share_text(0, 4), share_text(3, 4), share_text(4, 4), share_text(1, 1)
    ('none of 4', '3 of 4', 'all 4', 'the only one')
    """
    if some == of:
        return "the only one" if of == 1 else f"all {of}"
    return f"{some or 'none'} of {of}"


def verdict(ratios: Sequence[float], words: tuple[str, str, str]) -> str:
    """Return the word for ratios below, at and above 1, as they read in two places; two where they differ.

    Parameters
    ----------
    ratios
        At least one.
    words
        As `MESSAGES`.

    Examples
    --------
    >>> verdict([0.9, 0.8], MESSAGES), verdict([1.01], MESSAGES), verdict([0.9, 1.2], MESSAGES)
    ('fewer messages than', 'about as many messages as', 'fewer or more messages than')
    """
    shown = [round(ratio, 2) for ratio in ratios]
    less, same, more = words
    first, last = less.split(" ")[0], more.split(" ")[0]
    rest = less.removeprefix(first)
    low, high = min(shown), max(shown)
    if round(max(high - 1.0, 1.0 - low), 2) <= _ALIKE:
        return same if low == high == 1.0 else f"about {same}"
    if high <= 1.0:
        return less if high < 1.0 else f"no {last}{rest}"
    if low >= 1.0:
        return more if low > 1.0 else f"no {first}{rest}"
    return f"{first} or {last}{rest}"


def counted(count: int, noun: str) -> str:
    """Return how many of something there are.

    Parameters
    ----------
    count
        How many.
    noun
        Of one.

    Examples
    --------
    >>> counted(1, "trip"), counted(2, "trip")
    ('1 trip', '2 trips')
    """
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
