"""Which of the evaluated loss ratios stands for all where one is shown."""

from collections.abc import Sequence

__all__ = ["HEADLINE_RATIO", "nearest_ratio"]

HEADLINE_RATIO = 0.4
"""The packet error ratio that the paper's distribution is drawn at."""


def nearest_ratio(ratios: Sequence[float], target: float = HEADLINE_RATIO) -> float | None:
    """Return the ratio nearest to the target, the smaller of two; None for an empty sequence.

    Parameters
    ----------
    ratios
        Packet error ratios.
    target
        The one wanted.

    Examples
    --------
    >>> nearest_ratio([0.0, 0.3, 0.5])
    0.3
    """
    # Rounding makes 0.3 and 0.5 equally near to 0.4, which they are not in binary.
    return min(ratios, key=lambda ratio: (round(abs(ratio - target), 9), ratio), default=None)
