"""What is to be known before any figure, gathered over trips: one line a kind, with the first trips named."""

from collections.abc import Iterable, Mapping

__all__ = ["warning_lines"]

_SHOWN_TRIPS = 3


def warning_lines(trips: Iterable[tuple[str, Mapping[str, str]]]) -> list[str]:
    """Return one line for each warning of the first trips of its kind, then how many more have it.

    Parameters
    ----------
    trips
        Identifier and warnings of every trip, by kind.

    Examples
    --------
    >>> warning_lines([("a/1", {"rate": "sampled at 5 Hz"}), ("a/2", {})])
    ['rate, a/1: sampled at 5 Hz']
    """
    by_kind: dict[str, list[str]] = {}
    for trip_id, warnings in trips:
        for kind, text in warnings.items():
            by_kind.setdefault(kind, []).append(f"{kind}, {trip_id}: {text}")
    lines: list[str] = []
    for kind, texts in by_kind.items():
        lines += texts[:_SHOWN_TRIPS]
        more = len(texts) - _SHOWN_TRIPS
        if more > 0:
            lines.append(f"{kind}: and {more} more {'trip' if more == 1 else 'trips'} (summary.json)")
    return lines
