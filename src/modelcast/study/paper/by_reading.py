"""Claims whose ratios every reading has, and the ratios as verdicts and tables take them."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from modelcast.study.paper.choices import Reading
from modelcast.study.paper.readings import ReadingRows
from modelcast.study.paper.verdict import Estimate
from modelcast.study.table import Row
from modelcast.study.wording import centimetres

__all__ = [
    "ByReading",
    "message_estimate",
    "message_estimates",
    "shown_estimates",
    "tracking_estimates",
    "worst_messages",
    "worst_tracking",
]


@dataclass(frozen=True, slots=True)
class ByReading:
    """A claim whose ratios every reading has.

    Parameters
    ----------
    name, place, sentence, measure, shown_in
        As in `ClaimRow`.
    estimates
        The ratios that are to lie below 1, and what each is of.
    worst
        The trip that speaks against it most.
    """

    name: str
    place: str
    sentence: str
    measure: str
    shown_in: str
    estimates: Callable[[ReadingRows, Reading], list[tuple[str, Estimate]]]
    worst: Callable[[ReadingRows, Reading], str]


def message_estimate(row: Row) -> Estimate:
    """Messages over the rival's, with their interval.

    Parameters
    ----------
    row
        Of one threshold.
    """
    return Estimate(row.message_ratio, row.message_low, row.message_high)


def message_estimates(rows: Iterable[Row]) -> list[tuple[str, Estimate]]:
    """Messages over the rival's, and at which threshold.

    Parameters
    ----------
    rows
        One a threshold.
    """
    return [(centimetres(row.threshold_m), message_estimate(row)) for row in rows]


def tracking_estimates(rows: Iterable[Row], quantile: str) -> list[tuple[str, Estimate]]:
    """A quantile of the error over the rival's, and at which threshold.

    Parameters
    ----------
    rows
        One a threshold.
    quantile
        ``p90`` or ``p99``.
    """
    return [
        (
            f"{quantile} {centimetres(row.threshold_m)}",
            Estimate(*(getattr(row, f"{quantile}_{what}") for what in ("ratio", "low", "high"))),
        )
        for row in rows
    ]


def worst_messages(rows: Sequence[Row]) -> str:
    """The trip that speaks against fewer messages most, as text; empty where there is but one.

    Parameters
    ----------
    rows
        One a threshold.
    """
    every: list[Row] = [*rows]
    worst = max(every, key=lambda row: row.worst_ratio, default=None)
    if worst is None or worst.trips < 2:
        return ""
    return f"{worst.worst_trip} {worst.worst_ratio:.2f} at {centimetres(worst.threshold_m)}"


def worst_tracking(rows: Sequence[Row], quantile: str) -> str:
    """The trip that speaks against a smaller error most, as text; empty where there is but one.

    Parameters
    ----------
    rows
        One a trip and threshold.
    quantile
        ``p90`` or ``p99``.
    """
    usable = [row for row in rows if np.isfinite(getattr(row, f"{quantile}_ratio"))]
    if len({row.trip for row in rows}) < 2 or not usable:
        return ""
    worst = max(usable, key=lambda row: getattr(row, f"{quantile}_ratio"))
    return f"{worst.trip} {getattr(worst, f'{quantile}_ratio'):.2f} at {centimetres(worst.threshold_m)}"


def shown_estimates(estimates: Sequence[tuple[str, Estimate]]) -> str:
    """Ratios with their intervals, as text.

    Parameters
    ----------
    estimates
        Each with what it is of.
    """
    return ", ".join(
        f"{name}: {one.value:.2f}" + ("" if one.low is None else f" ({one.low:.2f} to {one.high:.2f})")
        for name, one in estimates
    )
