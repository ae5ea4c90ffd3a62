"""What gave no trip, by name: files in a folder, vehicles in a file; two that share a name are both kept."""

from collections.abc import Iterable, Mapping

from modelcast.io.free_names import free_name

__all__ = ["merge_skipped"]


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
