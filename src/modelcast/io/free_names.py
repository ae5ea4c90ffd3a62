"""Names of which each is given once: where one is taken, the later gets ``#2``, ``#3``, ... behind it."""

from collections import Counter
from collections.abc import Container

__all__ = ["FreeNames", "free_name"]


def free_name(taken: Container[str], name: str, copy: int = 2) -> str:
    """Return the name, or with ``#2``, ``#3``, ... behind it where it is taken.

    Parameters
    ----------
    taken
        Holds the names that are taken.
    name
        The one asked for.
    copy
        The number to begin with.

    Examples
    --------
    >>> free_name({"a": "", "a#2": ""}, "a"), free_name({}, "a")
    ('a#3', 'a')
    """
    if name not in taken:
        return name
    while f"{name}#{copy}" in taken:
        copy += 1
    return f"{name}#{copy}"


class FreeNames:
    """Gives names out, each once; many that are the same take no longer than others.

    Examples
    --------
    >>> names = FreeNames()
    >>> [names.take(name) for name in ("a", "a#2", "a", "a#2", "a")]
    ['a', 'a#2', 'a#3', 'a#2#2', 'a#4']
    """

    def __init__(self) -> None:
        self._taken: set[str] = set()
        self._copies = Counter[str]()

    def take(self, name: str) -> str:
        """Return the name that is given where one is asked for.

        Parameters
        ----------
        name
            The one asked for.
        """
        given = free_name(self._taken, name, 2 + self._copies[name])
        if given != name:
            self._copies[name] += 1
        self._taken.add(given)
        return given
