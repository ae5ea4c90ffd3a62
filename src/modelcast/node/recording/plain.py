"""Numbers and octets as plain values of JSON and back, to the bit.

A number is written so that it is read as the same 64 bits; one that is not finite is null, "inf" or "-inf".
Octets are base64.
"""

import base64
import binascii
import math
from collections.abc import Sequence
from typing import cast

from modelcast.core.rules import FieldError, Number, Whole

__all__ = ["ID", "TIME", "number_of", "octets_of", "plain_of", "text_of", "word_of", "words_of"]

TIME = Number(-1e9, 1e10)
"""Rule of times on the node's clock [s]."""

ID = Whole(0, 2**32 - 1)
"""Rule of temporary ids."""


def word_of(value: float) -> float | str | None:
    """A number as JSON can say it."""
    if math.isfinite(value):
        return float(value)
    return None if math.isnan(value) else ("inf" if value > 0.0 else "-inf")


def words_of(values: Sequence[float]) -> list[float | str | None]:
    """Numbers as JSON can say them."""
    return [word_of(value) for value in values]


def plain_of(value: object) -> object:
    """A number, pair of numbers, text or nothing as JSON can say it."""
    if isinstance(value, float):
        return word_of(value)
    if isinstance(value, tuple):
        return words_of(cast("tuple[float, ...]", value))
    return value


def number_of(value: object, place: str) -> float:
    """The number that `word_of` made a word of.

    Parameters
    ----------
    value
        Anything.
    place
        How errors name it.

    Raises
    ------
    FieldError
        Where it is none.
    """
    if value is None:
        return math.nan
    if value in ("inf", "-inf"):
        return float(str(value))
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise FieldError(place, value, "a number, null, 'inf' or '-inf'")
    return float(value)


def text_of(octets: bytes) -> str:
    """Octets as base64."""
    return base64.b64encode(octets).decode()


def octets_of(text: str, place: str) -> bytes:
    """The octets that `text_of` made a text of.

    Parameters
    ----------
    text
        Any text.
    place
        How errors name it.

    Raises
    ------
    FieldError
        Where it is no base64.
    """
    try:
        return base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError) as error:
        raise FieldError(place, text, "base64") from error
