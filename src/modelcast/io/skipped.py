"""What gave no trip, by name: files in a folder, vehicles in a file; two that share a name are both kept."""

from collections.abc import Iterable, Mapping

__all__ = ["free_name", "merge_skipped"]


def free_name(taken: Mapping[str, str], name: str) -> str:
    """Return the name, or with ``#2``, ``#3``, ... behind it where it is taken.

    Parameters
    ----------
    taken
        Holds the names that are taken.
    name
        The one asked for.

    Examples
    --------
    >>> free_name({"a": "", "a#2": ""}, "a"), free_name({}, "a")
    ('a#3', 'a')
    """
    if name not in taken:
        return name
    copy = 2
    while f"{name}#{copy}" in taken:
        copy += 1
    return f"{name}#{copy}"


def merge_skipped(several: Iterable[Mapping[str, str]]) -> dict[str, str]:
    """Return what several sources skipped, in order, as one; nothing is lost to a name that two share.

    Parameters
    ----------
    several
        Names with reasons, a mapping a source.

    Examples
    --------
    >>> merge_skipped([{"a": "too short"}, {"a": "no position"}])
    {'a': 'too short', 'a#2': 'no position'}
    """
    merged: dict[str, str] = {}
    for one in several:
        for name, reason in one.items():
            merged[free_name(merged, name)] = reason
    return merged
