"""Between which two of several rising values another lies."""

from collections.abc import Sequence
from math import log

__all__ = ["log_bracket"]


def log_bracket(known: Sequence[float], value: float) -> tuple[int, int, float]:
    """Neighbours of a value, and how far it is from the first to the second, over logarithms.

    Parameters
    ----------
    known
        Rising and positive.
    value
        Positive; beyond the ends the nearest serves.

    Returns
    -------
    tuple of int, int and float
        Index below, index above, share of the one above, 0..1.

    Examples
    --------
    >>> log_bracket((0.1, 0.4), 0.2), log_bracket((0.1, 0.4), 9.0)
    ((0, 1, 0.5), (1, 1, 0.0))
    """
    below = max((at for at, one in enumerate(known) if one <= value), default=0)
    above = min(below + 1, len(known) - 1)
    if above == below or value <= known[below]:
        return below, below, 0.0
    return below, above, log(value / known[below]) / log(known[above] / known[below])
