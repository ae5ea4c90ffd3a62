"""What every rule is, and the error that says where a value is wrong."""

import re
import reprlib
from abc import ABC, abstractmethod
from typing import Any, cast

import numpy as np

__all__ = ["AbstractRule", "FieldError", "is_clean", "shown"]

_SHOWN_CHARACTERS = 60
_WIDEST_INTEGER_BITS = 256
_UNCLEAN = re.compile(
    "[\x00-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"  # C0, C1, bidirectional, half
)


def is_clean(text: str) -> bool:
    """Whether a text may go to a terminal: no control characters, half code points or turns of direction.

    Parameters
    ----------
    text
        Any text.

    Examples
    --------
    >>> is_clean("Opel Corsa"), is_clean("a" + chr(27)), is_clean(chr(0xD800))
    (True, False, False)
    """
    return _UNCLEAN.search(text) is None


class FieldError(ValueError):
    """A value is not what a rule says.

    Parameters
    ----------
    place
        Where: a field's name, or a path such as ``$.members[2].samples``.
    value
        What stands there; the text shows it shortened.
    expected
        What should.
    """

    def __init__(self, place: str, value: object, expected: str) -> None:
        self.place = place
        self.value = value
        self.expected = expected
        super().__init__(f"{place} must be {expected}, got {shown(value)}")

    def below(self, path: str) -> "FieldError":
        """The same, seen from outside.

        Parameters
        ----------
        path
            Path of what holds the place.
        """
        join = "" if self.place.startswith("[") or not self.place else "."
        return FieldError(f"{path}{join}{self.place}", self.value, self.expected)


def shown(value: object) -> str:
    """A value in one short line without control characters.

    Parameters
    ----------
    value
        Anything.

    Examples
    --------
    >>> shown("a" * 100), shown([1, [2, [3, [4]]]]), shown(10**100)
    ("'aaaaaaaaaaaaaaaaaaaaaaaa...aaaaaaaaaaaaaaaaaaaaaaaaa'", '[1, [2, [...]]]', 'an integer of 333 bits')
    """
    if isinstance(value, int) and value.bit_length() > _WIDEST_INTEGER_BITS:
        return f"an integer of {value.bit_length()} bits"
    if isinstance(value, np.ndarray):
        array = cast("np.ndarray[Any, Any]", value)
        return f"an array of shape {array.shape}" if array.size > 4 else f"{array.tolist()}"
    writer = reprlib.Repr()
    writer.maxstring = writer.maxother = writer.maxlong = _SHOWN_CHARACTERS - 5
    writer.maxlevel = 2
    writer.maxlist = writer.maxtuple = writer.maxdict = 3
    try:
        return " ".join(_UNCLEAN.sub(" ", writer.repr(value)).split())
    except ValueError:  # an integer inside has more digits than Python writes
        return f"a {type(value).__name__}"


class AbstractRule(ABC):
    """What a value must be."""

    @property
    @abstractmethod
    def expected(self) -> str:
        """In words, to go after "must be"."""

    @abstractmethod
    def fault(self, value: object) -> FieldError | None:
        """What is wrong with the value, or None.

        Parameters
        ----------
        value
            Anything.
        """

    def _refused(self, value: object) -> FieldError:
        return FieldError("", value, self.expected)
