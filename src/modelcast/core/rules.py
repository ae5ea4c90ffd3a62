"""What a value from outside must be: rules that say where it is wrong, what it is and what was expected.

A frozen dataclass states the rule of a field beside its type, ``samples: Annotated[int, Whole(3, 60)]``, and
calls `check_fields` once. So the same sentence holds for a caller in Python and for a file: a reader builds
the dataclass and puts the place of it before the field that `FieldError` names. Documents without a class of
their own have a rule for the whole (`Keys`, `Table`).

A boolean is no number, a text is no number, and a number is finite unless the rule says otherwise.
"""

import functools
import math
import re
import reprlib
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, fields
from typing import Annotated, Any, cast, get_origin, get_type_hints

import numpy as np

__all__ = [
    "AbstractRule",
    "Anything",
    "Each",
    "FieldError",
    "Fixed",
    "Flag",
    "Grid",
    "Keys",
    "Maybe",
    "Number",
    "Numbers",
    "One",
    "Table",
    "Text",
    "Whole",
    "check",
    "check_fields",
    "is_clean",
    "shown",
]

_SHOWN_CHARACTERS = 60
_WIDEST_INTEGER_BITS = 256
_LONGEST_KEY = 4096
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
class Each(AbstractRule):
    """A list of `least` to `most` items, each as a rule says.

    Parameters
    ----------
    of
        The rule.
    least, most
        Bounds of the length.
    """

    of: AbstractRule
    least: int
    most: int

    @property
    def expected(self) -> str:
        """The length."""
        return f"a list of {self.least} to {self.most} items"

    def fault(self, value: object) -> FieldError | None:
        """Refuse other types and lengths, then the first item that is wrong."""
        if not isinstance(value, tuple | list):
            return self._refused(value)
        items = cast("Sequence[object]", value)
        if not self.least <= len(items) <= self.most:
            return FieldError("", items, f"{self.expected} (here {len(items)})")
        for at, item in enumerate(items):
            found = self.of.fault(item)
            if found is not None:
                return found.below(f"[{at}]")
        return None


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
class Numbers(AbstractRule):
    """An array of floats, every one in a range.

    Parameters
    ----------
    dimensions
        How many.
    of
        The range.
    most
        Largest size of any dimension; the least is 1.
    least
        Smallest size of any dimension.
    """

    dimensions: int
    of: Number
    most: int
    least: int = 1

    @property
    def expected(self) -> str:
        """Dimensions and sizes."""
        return f"an array of {self.dimensions} dimensions with {self.least} to {self.most} items each"

    def fault(self, value: object) -> FieldError | None:
        """Refuse other types and shapes, then the first number that is wrong."""
        if not isinstance(value, np.ndarray):
            return self._refused(value)
        array = cast("np.ndarray[Any, Any]", value)
        if array.dtype != np.float64 or array.ndim != self.dimensions:
            return self._refused(array)
        if not all(self.least <= size <= self.most for size in array.shape):
            return self._refused(array)
        above = array > self.of.low if self.of.over else array >= self.of.low
        good = above & (array <= self.of.high)
        if good.all():
            return None
        at = tuple(int(place) for place in np.argwhere(~good)[0])
        return FieldError("".join(f"[{place}]" for place in at), float(array[at]), self.of.expected)


@dataclass(frozen=True, slots=True)
class Grid(AbstractRule):
    """Lists in lists, all of one length at each level: what becomes an array.

    Parameters
    ----------
    dimensions
        How many.
    of
        What every number must be.
    most
        Largest length at any level; the least is 1.
    """

    dimensions: int
    of: Number
    most: int

    @property
    def expected(self) -> str:
        """Dimensions and sizes."""
        return f"lists {self.dimensions} deep, 1 to {self.most} items each, of one length at each level"

    def fault(self, value: object) -> FieldError | None:
        """Refuse other types and lengths, then the first number that is wrong."""
        return self._fault(value, self._lengths(value))

    def _lengths(self, value: object) -> list[int]:
        """Lengths along the first items: those that all others must have."""
        found: list[int] = []
        while isinstance(value, list) and value and len(found) < self.dimensions:
            items = cast("list[object]", value)
            found.append(len(items))
            value = items[0]
        return found

    def _fault(self, value: object, lengths: list[int], level: int = 0) -> FieldError | None:
        if level == self.dimensions:
            return self.of.fault(value)
        items = cast("list[object]", value if isinstance(value, list) else [])
        if not items or level >= len(lengths) or len(items) != lengths[level] or len(items) > self.most:
            return self._refused(cast("object", value))
        for at, item in enumerate(items):
            found = self._fault(item, lengths, level + 1)
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
class Keys(AbstractRule):
    """A mapping with these keys and no others.

    Parameters
    ----------
    needed
        Rules of the keys that must be there.
    others
        Rules of those that may.
    """

    needed: Mapping[str, AbstractRule]
    others: Mapping[str, AbstractRule] = field(default_factory=dict[str, AbstractRule])

    @property
    def expected(self) -> str:
        """The keys."""
        return f"a mapping with {', '.join(self.needed)}"

    def fault(self, value: object) -> FieldError | None:
        """Refuse other types, missing and unknown keys, then the first value that is wrong."""
        if not isinstance(value, Mapping):
            return self._refused(value)
        given = cast("Mapping[object, object]", value)
        missing = [key for key in self.needed if key not in given]
        if missing:
            return FieldError("", sorted(map(str, given)), f"{self.expected}; {', '.join(missing)} missing")
        for key, item in given.items():
            rule = self.needed.get(cast("str", key)) or self.others.get(cast("str", key))
            if rule is None:
                known = ", ".join((*self.needed, *self.others))
                return FieldError("", key, f"a mapping without unknown fields; known are {known}")
            found = rule.fault(item)
            if found is not None:
                return found.below(str(key))
        return None


@dataclass(frozen=True, slots=True)
class Table(AbstractRule):
    """A mapping from any clean texts to what a rule says.

    Parameters
    ----------
    of
        The rule.
    most
        Keys at most.
    """

    of: AbstractRule
    most: int

    @property
    def expected(self) -> str:
        """How many keys."""
        return f"a mapping of at most {self.most} keys"

    def fault(self, value: object) -> FieldError | None:
        """Refuse other types, too many or odd keys, then the first value that is wrong."""
        if not isinstance(value, Mapping):
            return self._refused(value)
        given = cast("Mapping[object, object]", value)
        if len(given) > self.most:
            return FieldError("", len(given), f"{self.expected} keys")
        for key, item in given.items():
            if not (isinstance(key, str) and is_clean(key) and len(key) <= _LONGEST_KEY):
                return FieldError(
                    "",
                    key,
                    f"a mapping whose keys are texts without control characters, of {_LONGEST_KEY} at most",
                )
            found = self.of.fault(item)
            if found is not None:
                return found.below(f"[{shown(key)}]")
        return None


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


def check(value: object, rule: AbstractRule, path: str = "$") -> None:
    """Refuse a value that is not what a rule says.

    Parameters
    ----------
    value
        Anything.
    rule
        What it must be.
    path
        Where it stands, for the error.

    Raises
    ------
    FieldError
        Where it is not.
    """
    found = rule.fault(value)
    if found is not None:
        raise found.below(path)


def check_fields(instance: Any) -> None:
    """Refuse a dataclass whose fields are not what their annotations say.

    Parameters
    ----------
    instance
        The dataclass; of its fields those whose type is `Annotated` with a rule are looked at.

    Raises
    ------
    FieldError
        Where one is not; it names the field.
    """
    for name, rule in _rules(instance.__class__):
        found = rule.fault(getattr(instance, name))
        if found is not None:
            raise found.below(name)


@functools.cache
def _rules(kind: Any) -> tuple[tuple[str, AbstractRule], ...]:
    hints = get_type_hints(kind, include_extras=True)
    return tuple(
        (item.name, rule)
        for item in fields(kind)
        if get_origin(hints[item.name]) is Annotated
        for rule in hints[item.name].__metadata__
        if isinstance(rule, AbstractRule)
    )
