"""Rules of whole documents: named keys, and tables of any."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import cast

from modelcast.core.rules.base import AbstractRule, FieldError, is_clean, shown

__all__ = ["Keys", "Table"]

_LONGEST_KEY = 4096


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
