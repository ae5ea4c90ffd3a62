"""The rule of a field that names one of an open group, with its settings."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from modelcast.core.exceptions import ConfigError
from modelcast.core.open_group import OpenGroup
from modelcast.core.rules import AbstractRule, FieldError, Text

__all__ = ["NamedIn"]

_WORD = Text(400)


@dataclass(frozen=True, slots=True)
class NamedIn(AbstractRule):
    """A word that stands for something in an open group, ours or another package's.

    Parameters
    ----------
    group
        The group.
    check
        Refuses a word by a ConfigError; None where what it names is made, to see that it can be.
    """

    group: OpenGroup[Any]
    check: Callable[[str], object] | None = None

    @property
    def expected(self) -> str:
        """The names."""
        return f"one of {', '.join(map(repr, self.group.names()))}, or NAME:KEY=VALUE with its settings"

    def fault(self, value: object) -> FieldError | None:
        """Refuse other types, and what cannot be made, with the reason."""
        found = _WORD.fault(value)
        if found is not None:
            return found
        try:
            (self.group.made_from if self.check is None else self.check)(str(value))
        except ConfigError as error:
            known = str(value).partition(":")[0] in self.group.names()
            reason = f"a {self.group.called} that can be made ({error})"
            return FieldError("", value, reason if known else self.expected)
        return None
