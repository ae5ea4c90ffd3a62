"""Shares, delays and ratios of warnings as cells of a table."""

from math import inf, isfinite

from modelcast.study.compare.bootstrap import Limits
from modelcast.study.table import Row

__all__ = ["ENOUGH", "late_text", "over_text", "percent_text", "plain_text", "ratio_text"]

ENOUGH = 50
"""With fewer true warnings a ratio is an anecdote."""


def plain_text(value: float, form: str) -> str:
    """Return a value in a form; a dash where there is none."""
    return form.format(value) if isfinite(value) else "-"


def percent_text(value: float) -> str:
    """Return a share in percent.

    Examples
    --------
    >>> percent_text(0.1234), percent_text(float("nan"))
    ('12.34 %', '-')
    """
    return plain_text(100 * value, "{:.2f} %")


def late_text(value_s: float) -> str:
    """Return a delay; one without end never came.

    Examples
    --------
    >>> late_text(0.25), late_text(float("inf")), late_text(float("nan"))
    ('0.25 s', 'never', '-')
    """
    return "never" if value_s == inf else plain_text(value_s, "{:.2f} s")


def over_text(row: Row, what: str) -> str:
    """Return missed or false instants over someone else's, with the interval.

    Parameters
    ----------
    row
        With the columns of `modelcast.study.safety.result.over_columns`.
    what
        ``missed`` or ``false``.
    """
    value, low, high = row.picked(f"{what}_over{end}" for end in ("", "_low", "_high")).values()
    return ratio_text(value, (low, high))


def ratio_text(value: float, ends: Limits) -> str:
    """Return a ratio with the ends of its interval, where it has one.

    Examples
    --------
    >>> ratio_text(0.7, (0.65, 0.75)), ratio_text(1.0, (None, None))
    ('0.70 (0.65-0.75)', '1.00')
    """
    low, high = ends
    if not isfinite(value):
        return "-"
    return f"{value:.2f}" if low is None or high is None else f"{value:.2f} ({low:.2f}-{high:.2f})"
