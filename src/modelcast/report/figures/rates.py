"""Message rate against threshold, MBC beside the baseline."""

from matplotlib.axes import Axes
from matplotlib.container import BarContainer
from matplotlib.figure import Figure

from modelcast.evaluation.result import EvaluationResult
from modelcast.report.figures.panels import empty_figure
from modelcast.report.headline import Headline, headlines
from modelcast.report.style import (
    COLUMN_IN,
    IDENTIFICATION_COLOUR,
    PAGE_IN,
    POLICY_COLOURS,
    new_figure,
    style,
)

__all__ = ["plot_rates"]

_WIDTH = 0.38
_MOST_IN_COLUMN = 6


def plot_rates(result: EvaluationResult) -> Figure:
    """Return bars of the pooled message rate at each threshold: MBC, stacked by kind, and the baseline.

    Parameters
    ----------
    result
        The evaluation.
    """
    with style():
        lines = [line for line in headlines(result) if line.mbc is not None or line.baseline is not None]
        if not lines:
            return empty_figure("No message rates were evaluated.")
        wide = len(lines) > _MOST_IN_COLUMN
        figure = new_figure(PAGE_IN if wide else COLUMN_IN, 2.7)
        axes = figure.subplots()
        _draw_bars(axes, lines)
        axes.set_xticks(range(len(lines)), [f"{100 * line.threshold_m:.4g}" for line in lines])
        axes.set_xlim(-0.6, len(lines) - 0.4)
        axes.set_xlabel("Tracking-error threshold [cm]")
        axes.set_ylabel("Message rate [1/s]")
        axes.grid(visible=False, axis="x")
        axes.margins(y=0.09)
        figure.legend(
            *axes.get_legend_handles_labels(), loc="outside upper center", ncols=3, columnspacing=1.2
        )
        return figure


def _draw_bars(axes: Axes, lines: list[Headline]) -> None:
    places = range(len(lines))
    left, right = [at - _WIDTH / 2 - 0.01 for at in places], [at + _WIDTH / 2 + 0.01 for at in places]
    updates = [0.0 if line.mbc is None else line.mbc.update_rate_hz for line in lines]
    identifications = [0.0 if line.mbc is None else line.mbc.identification_rate_hz for line in lines]
    baseline = [0.0 if line.baseline is None else line.baseline.total_rate_hz for line in lines]
    axes.bar(left, updates, _WIDTH, color=POLICY_COLOURS["mbc"], label="MBC updates")
    tops = axes.bar(
        left,
        identifications,
        _WIDTH,
        bottom=updates,
        color=IDENTIFICATION_COLOUR,
        label="MBC identifications",
    )
    beside = axes.bar(right, baseline, _WIDTH, color=POLICY_COLOURS["baseline"], label="Baseline")
    _label_tops(axes, tops, [None if line.mbc is None else line.mbc.total_rate_hz for line in lines])
    _label_tops(
        axes, beside, [None if line.baseline is None else line.baseline.total_rate_hz for line in lines]
    )


def _label_tops(axes: Axes, bars: BarContainer, totals_hz: list[float | None]) -> None:
    labels = ["" if total is None else f"{total:.2f}" for total in totals_hz]
    axes.bar_label(bars, labels, padding=1.5, fontsize=6.0)
