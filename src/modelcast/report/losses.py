"""How the losses of a safety evaluation are called, and which of its loss ratios is shown where one is."""

from collections.abc import Sequence

from modelcast.study.safety.result import SafetyKind, kind_of
from modelcast.study.table import Row

__all__ = ["burst_words", "loss_words", "shown_ratios"]

_SHOWN_RATIO = 0.4
"""Of many loss ratios the nearest to it is shown, heavy loss that still lets something through."""


def burst_words(kind: SafetyKind) -> str:
    """Return how losses follow each other.

    Parameters
    ----------
    kind
        Sensor and kind of loss.

    Examples
    --------
    >>> burst_words(SafetyKind("ins", 0.5)), burst_words(SafetyKind("ins", None))
    ('bursts of 0.5 s', 'one by one')
    >>> burst_words(SafetyKind("ins", 0.3127, "a.csv"))
    'mean burst 0.31 s'
    """
    if kind.loss_log:
        return "no loss" if kind.mean_burst_s is None else f"mean burst {kind.mean_burst_s:.2g} s"
    return "one by one" if kind.mean_burst_s is None else f"bursts of {kind.mean_burst_s:g} s"


def loss_words(kind: SafetyKind) -> str:
    """Return where losses are from and how they follow each other.

    Parameters
    ----------
    kind
        Sensor and kind of loss.

    Examples
    --------
    >>> loss_words(SafetyKind("ins", 0.5))
    'bursts of 0.5 s'
    >>> loss_words(SafetyKind("ins", 0.3127, "a.csv"))
    'recorded: a.csv, mean burst 0.31 s'
    """
    return f"recorded: {kind.loss_log}, {burst_words(kind)}" if kind.loss_log else burst_words(kind)


def shown_ratios(rows: Sequence[Row]) -> dict[SafetyKind, float]:
    """Return the packet error ratio that is shown of each kind: a log has its own.

    Parameters
    ----------
    rows
        All of an evaluation.
    """
    found: dict[SafetyKind, float] = {}
    for row in rows:
        best = found.setdefault(kind_of(row), row.packet_error_ratio)
        if abs(row.packet_error_ratio - _SHOWN_RATIO) < abs(best - _SHOWN_RATIO):
            found[kind_of(row)] = row.packet_error_ratio
    return found
