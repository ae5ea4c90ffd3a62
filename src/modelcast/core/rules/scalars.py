"""Rules of single values, and of one of several."""

import math
import re
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import cast

import numpy as np

from modelcast.core.rules.base import AbstractRule, FieldError, is_clean

__all__ = ["Anything", "Fixed", "Flag", "Maybe", "Number", "One", "Text", "Whole"]


@dataclass(frozen=True, slots=True)
class Number(AbstractRule):
    """A real number in a range.

    Parameters
    ----------
    low, high
        The range, both ends inside.
    over, under
        Whether the lower or the upper end is outside.
    infinite
        Whether plus infinity is allowed too.

    Examples
    --------
    >>> Number(0.0, 5.0, over=True).fault(0)
    FieldError(' must be a number over 0 and up to 5, got 0')
    """

    low: float
    high: float
    _: KW_ONLY
    over: bool = False
    under: bool = False
    infinite: bool = False

    @property
    def expected(self) -> str:
        """The range."""
        if not self.over and not self.under:
            text = f"a number from {self.low:.15g} to {self.high:.15g}"
        else:
            low = f"over {self.low:.15g}" if self.over else f"from {self.low:.15g}"
            high = f"under {self.high:.15g}" if self.under else f"up to {self.high:.15g}"
            text = f"a number {low} and {high}"
        return f"{text}, or infinite" if self.infinite else text

    def fault(self, value: object) -> FieldError | None:
        """Refuse other types, NaN and what is out of the range."""
        if isinstance(value, bool | np.bool_) or not isinstance(
            value, int | float | np.integer | np.floating
        ):
            return self._refused(cast("object", value))
        number = cast("float", value)
        if number == math.inf and self.infinite:
            return None
        above = number > self.low if self.over else number >= self.low
        below = number < self.high if self.under else number <= self.high
        return None if above and below else self._refused(number)


@dataclass(frozen=True, slots=True)
class Whole(AbstractRule):
    """A whole number from `low` to `high`.

    Parameters
    ----------
    low, high
        The range, both ends inside.
    """

    low: int
    high: int

    @property
    def expected(self) -> str:
        """The range."""
        return f"a whole number from {self.low} to {self.high}"

    def fault(self, value: object) -> FieldError | None:
        """Refuse other types, floats among them, and what is out of the range."""
        if isinstance(value, bool) or not isinstance(value, int | np.integer):
            return self._refused(value)
        number = cast("int", value)
        return None if self.low <= number <= self.high else self._refused(number)


@dataclass(frozen=True, slots=True)
class Flag(AbstractRule):
    """True or false."""

    @property
    def expected(self) -> str:
        """The two."""
        return "true or false"

    def fault(self, value: object) -> FieldError | None:
        """Refuse anything else, numbers among it."""
        return None if isinstance(value, bool) else self._refused(value)


@dataclass(frozen=True, slots=True)
class Text(AbstractRule):
    """A text without control characters.

    Parameters
    ----------
    most
        Characters at most.
    empty
        Whether the empty text is allowed.
    choices
        The only texts that are; any where empty.
    pattern
        A regular expression for the whole; none where empty.
    """

    most: int = 200
    _: KW_ONLY
    empty: bool = False
    choices: tuple[str, ...] = ()
    pattern: str = ""

    @property
    def expected(self) -> str:
        """The choices, the pattern or the length."""
        if self.choices:
            return "one of " + ", ".join(repr(choice) for choice in self.choices)
        if self.pattern:
            return f"a text like {self.pattern}"
        return f"a text without control characters of {0 if self.empty else 1} to {self.most} characters"

    def fault(self, value: object) -> FieldError | None:
        """Refuse other types, other texts, long ones and control characters."""
        if not isinstance(value, str) or (self.choices and value not in self.choices):
            return self._refused(value)
        if len(value) > self.most or not is_clean(value) or not (value or self.empty):
            return self._refused(value)
        if self.pattern and not re.fullmatch(self.pattern, value):
            return self._refused(value)
        return None


@dataclass(frozen=True, slots=True)
class Maybe(AbstractRule):
    """None, or what another rule says.

    Parameters
    ----------
    of
        The other rule.
    """

    of: AbstractRule

    @property
    def expected(self) -> str:
        """Both."""
        return f"null or {self.of.expected}"

    def fault(self, value: object) -> FieldError | None:
        """As the other rule; what is wrong with the value itself, and not inside, names null too."""
        found = None if value is None else self.of.fault(value)
        return self._refused(value) if found is not None and not found.place else found


@dataclass(frozen=True, slots=True)
class Fixed(AbstractRule):
    """A list of as many items as there are rules.

    Parameters
    ----------
    rules
        One an item.
    """

    rules: tuple[AbstractRule, ...]

    @property
    def expected(self) -> str:
        """The length."""
        return f"a list of {len(self.rules)} items"

    def fault(self, value: object) -> FieldError | None:
        """Refuse other types and lengths, then the first item that is wrong."""
        if not isinstance(value, tuple | list):
            return self._refused(value)
        items = cast("Sequence[object]", value)
        if len(items) != len(self.rules):
            return FieldError("", items, f"{self.expected} (here {len(items)})")
        for at, (item, rule) in enumerate(zip(items, self.rules, strict=True)):
            found = rule.fault(item)
            if found is not None:
                return found.below(f"[{at}]")
        return None


@dataclass(frozen=True, slots=True)
class One(AbstractRule):
    """An instance of one of some classes.

    Parameters
    ----------
    kinds
        The classes.
    words
        What they are, for the error.
    but
        Classes derived from these that are refused.
    """

    kinds: tuple[type, ...]
    words: str
    _: KW_ONLY
    but: tuple[type, ...] = ()

    @property
    def expected(self) -> str:
        """In words."""
        return self.words

    def fault(self, value: object) -> FieldError | None:
        """Refuse instances of other classes."""
        good = isinstance(value, self.kinds) and not isinstance(value, self.but)
        return None if good else self._refused(value)


@dataclass(frozen=True, slots=True)
class Anything(AbstractRule):
    """Any plain value: what is only shown or kept."""

    @property
    def expected(self) -> str:
        """No more than that."""
        return "a plain value"

    def fault(self, value: object) -> FieldError | None:  # noqa: ARG002 - anything
        """Refuse nothing."""
        return None
