"""How often 95 % intervals over a few seeds hold what they say, and what fresh seeds may be held to.

Student's interval over n seeds holds the mean of the distribution in 95 % of cases where runs are normal. The
mean of m fresh seeds errs itself, and lies within the interval less often: as often as a number of Student's
distribution with n - 1 degrees of freedom has a size below t / sqrt(1 + n / m), t being its 97.5 % point. A
table that is checked with new seeds should be held to that.
"""

from typing import NamedTuple

import numpy as np
from scipy import special, stats

from modelcast.core.arrays import FloatArray
from modelcast.study.metrics import confidence_limits

__all__ = ["Coverage", "coverage", "expected_ratio"]

_DRAWS = 4000


class Coverage(NamedTuple):
    """Of intervals over n seeds: how often they held the mean of the other seeds, and of n fresh ones.

    ``others_ratio`` and ``fresh_ratio`` are measured, ``narrowest_ratio`` is the 5 % quantile of their half
    width over its mean: how narrow an interval over so few seeds may come out.
    """

    others_ratio: float
    fresh_ratio: float
    narrowest_ratio: float


def expected_ratio(seeds: int, fresh: int) -> float:
    """Share of Student's 95 % intervals over n seeds that hold the mean of m fresh ones, of normal runs.

    Examples
    --------
    >>> [round(expected_ratio(n, n), 3) for n in (3, 10)]
    [0.907, 0.856]
    >>> round(expected_ratio(3, 1), 3), round(expected_ratio(3, 10**9), 3)
    (0.836, 0.95)
    """
    point: float = stats.t.ppf(0.975, seeds - 1)
    beyond = np.zeros(1)
    special.stdtr(seeds - 1, -point / (1.0 + seeds / fresh) ** 0.5, out=beyond)
    return 1.0 - 2.0 * float(beyond[0])


def coverage(values: FloatArray, seeds: int, *, draws: int = _DRAWS) -> Coverage:
    """Draw n of the kept runs for an interval, and set the others against it, again and again.

    Parameters
    ----------
    values
        One figure of all runs of a setting, at least 2 n of them, (R,).
    seeds
        n, at least 2.
    draws
        How often.

    Raises
    ------
    ValueError
        Where there are fewer runs.

    Notes
    -----
    All draws are of the same R runs, so that the figure errs as R runs do, however many draws there are.
    """
    if seeds < 2 or values.size < 2 * seeds:
        raise ValueError(
            f"intervals over {seeds} seeds need at least {max(2 * seeds, 4)} runs, got {values.size}"
        )
    rng = np.random.default_rng(0)
    held = np.zeros((draws, 2), dtype=np.bool_)
    widths = np.zeros(draws)
    for draw in range(draws):
        mixed = rng.permutation(values)
        low, high = confidence_limits(mixed[:seeds])
        assert low is not None
        assert high is not None
        widths[draw] = high - low
        for column, fresh in enumerate((mixed[seeds:], mixed[seeds : 2 * seeds])):
            held[draw, column] = low <= fresh.mean() <= high
    narrowest = float(np.quantile(widths, 0.05) / widths.mean()) if widths.mean() else 1.0
    return Coverage(float(held[:, 0].mean()), float(held[:, 1].mean()), narrowest)
