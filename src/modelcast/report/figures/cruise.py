"""Platoons: growth of the spacing error and least gap against loss, and against the message rate."""

from collections.abc import Callable, Sequence
from itertools import groupby
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, StrMethodFormatter

from modelcast.report.cruise import sender_label
from modelcast.report.figures.panels import empty_figure
from modelcast.report.figures.scales import legend_above
from modelcast.report.figures.senders import sender_look
from modelcast.report.style import INK, PAGE_IN, new_figure, style
from modelcast.study.cruise.run import PERFECT, CruiseResult
from modelcast.study.table import Row

__all__ = ["plot_cruise"]

_LINES = ("-", "--", ":", "-.")

_GAPS_M = (-100.0, -50.0, -20.0, -10.0, -5.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0)
"""Marks of the axis of gaps."""

_Value = Callable[[Row], float]


def plot_cruise(result: CruiseResult) -> Figure:
    """Return four panels: growth and least gap, against loss and against messages a second.

    On the right filled markers are those of the least loss, hollow ones those of the middle one. Bursts of
    different lengths have curves of their own.

    Parameters
    ----------
    result
        What was found.
    """
    rows = [row for row in result.rows if row.sender != PERFECT]
    with style():
        if not rows:
            return empty_figure("No sender was driven by.")
        figure = new_figure(PAGE_IN, 4.6)
        grid = figure.subplots(2, 2, sharex="col", sharey="row")
        ratios = sorted({row.loss_ratio for row in rows})
        middle = ratios[len(ratios) // 2]
        for axes, value, label in (
            (grid[0], _growth, "Growth of the spacing error"),
            (grid[1], _least_gap, "Least gap [m]"),
        ):
            _against_loss(axes[0], rows, value)
            _against_rate(axes[1], [row for row in rows if row.loss_ratio == ratios[0]], value, hollow=False)
            if middle != ratios[0]:
                _against_rate(axes[1], [row for row in rows if row.loss_ratio == middle], value, hollow=True)
            axes[0].set_ylabel(label)
        for axes in grid[0]:
            axes.axhline(1.0, color=INK, linewidth=0.6)
        for axes in grid[1]:
            axes.axhline(0.0, color=INK, linewidth=0.6)
            axes.set_yscale("symlog", linthresh=1.0)
            axes.yaxis.set_major_locator(FixedLocator(_GAPS_M))
            axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        grid[1][0].set_xlabel("Messages lost [%]")
        grid[1][1].set_xlabel("Messages of a vehicle a second")
        also = "" if middle == ratios[0] else f", hollow: {100 * middle:g} %"
        grid[0][1].set_title(f"filled: {100 * ratios[0]:g} % lost{also}")
        legend_above(figure, grid[0][0])
        return figure


def _growth(row: Row) -> float:
    return row.spacing_amplification


def _least_gap(row: Row) -> float:
    return row.gap_min_m


def _curve(row: Row) -> tuple[str, float]:
    return sender_label(row), row.burst_s


def _against_loss(axes: Axes, rows: Sequence[Row], value: _Value) -> None:
    seen: dict[str, int] = {}
    for (label, burst_s), group in groupby(sorted(rows, key=_curve), key=_curve):
        shown = sorted(group, key=lambda row: row.loss_ratio)
        colour, marker = sender_look(shown[0].sender)
        place = seen[shown[0].sender] = seen.get(shown[0].sender, -1) + 1
        look: dict[str, Any] = {"color": colour, "marker": marker, "linestyle": _LINES[place % len(_LINES)]}
        name = f"{label}, bursts {burst_s:g} s" if burst_s else label
        losses = [100 * row.loss_ratio for row in shown]
        axes.plot(losses, [value(row) for row in shown], label=name, clip_on=False, **look)


def _against_rate(axes: Axes, rows: Sequence[Row], value: _Value, *, hollow: bool) -> None:
    for row in rows:
        colour, marker = sender_look(row.sender)
        face = "none" if hollow else colour
        look: dict[str, Any] = {"color": colour, "marker": marker, "markerfacecolor": face}
        axes.plot(row.rate_hz, value(row), linestyle="", clip_on=False, **look)
