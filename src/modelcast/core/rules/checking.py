"""Checking: one value by a rule, or a dataclass by the rules beside its fields."""

import functools
from dataclasses import fields
from typing import Annotated, Any, get_origin, get_type_hints

from modelcast.core.rules.base import AbstractRule

__all__ = ["check", "check_fields"]


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
