"""Whether docstrings of public names say what the site shows: sections that parse, parameters as they are."""

import enum
import inspect
from collections.abc import Iterator, Mapping
from typing import Any, cast

from numpydoc.validate import validate  # pyright: ignore[reportUnknownVariableType] - it has no types

import modelcast

__all__ = ["docstring_faults"]

_FAULTS = {"GL06", "GL07", "GL08", "PR01", "PR02", "PR03"}
"""Of numpydoc: sections unknown or out of order, no text; parameters missing, unknown or out of order."""

_UNDESCRIBED = "PR01"


def docstring_faults() -> list[str]:
    """Return what is wrong with the docstrings of public names and of their methods, a line each.

    A method that a class above describes need not describe its parameters again; an enumeration has none.
    """
    return [
        f"{address}: {told}"
        for address, elsewhere in _described(modelcast.__dict__["_HOMES"])
        for code, told in cast("list[tuple[str, str]]", validate(address)["errors"])
        if code in _FAULTS and not (elsewhere and code == _UNDESCRIBED)
    ]


def _described(names: Mapping[str, str]) -> Iterator[tuple[str, bool]]:
    """Public names and methods, each with whether its parameters are described elsewhere, or are none."""
    for name in names:
        thing: Any = getattr(modelcast, name)
        if inspect.isclass(thing):
            yield f"modelcast.{name}", issubclass(thing, enum.Enum)
            for own, member in vars(thing).items():
                described = isinstance(member, property | classmethod | staticmethod) or inspect.isroutine(
                    member
                )
                if described and not own.startswith("_"):
                    above = any(own in vars(base) for base in thing.__mro__[1:])
                    yield f"modelcast.{name}.{own}", above
        elif inspect.isroutine(thing):
            yield f"modelcast.{name}", False
