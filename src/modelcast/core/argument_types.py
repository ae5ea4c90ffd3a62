"""What a caller gave in place of what a function takes, told by the argument's name and a remedy."""

from collections.abc import Iterable
from typing import Any, TypeVar, cast

__all__ = ["require_several", "require_type"]

Item = TypeVar("Item")


def require_type(name: str, given: object, kind: type[Any], *, remedy: str = "") -> None:
    """Refuse an argument of another type; a text is no sequence of numbers.

    Parameters
    ----------
    name
        The argument's.
    given
        Its value.
    kind
        The type asked for.
    remedy
        What to do; empty where the type's name says it.

    Raises
    ------
    TypeError
        Where it is none.

    Examples
    --------
    >>> require_type("seeds", 0.5, int, remedy="give a whole number")
    Traceback (most recent call last):
    TypeError: seeds must be of int, not float: give a whole number
    """
    if not isinstance(given, kind) or (kind is not str and isinstance(given, str)):
        told = f": {remedy}" if remedy else ""
        raise TypeError(f"{name} must be of {kind.__name__}, not {type(given).__name__}{told}")


def require_several(name: str, given: object, kind: type[Item], *, remedy: str = "") -> list[Item]:
    """Return several of a type as a list.

    Parameters
    ----------
    name, kind, remedy
        As for `require_type`.
    given
        One of them, or any number after one another.

    Raises
    ------
    TypeError
        Where it is neither, or one of them is of another type.

    Examples
    --------
    >>> require_several("seeds", 3, int), require_several("seeds", (3, 4), int)
    ([3], [3, 4])
    """
    if isinstance(given, kind):
        return [given]
    if isinstance(given, str) or not isinstance(given, Iterable):
        require_type(name, given, kind, remedy=remedy)
    found = list(cast("Iterable[Any]", given))
    for place, one in enumerate(found):
        require_type(f"{name}[{place}]", one, kind, remedy=remedy)
    return found
