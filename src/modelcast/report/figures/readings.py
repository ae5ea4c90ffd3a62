"""What every open choice of the paper does: messages and tracking, one row a reading."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator

from modelcast.report.figures.panels import drawable
from modelcast.report.style import INK, PAGE_IN, POLICY_COLOURS, new_figure, style
from modelcast.study.paper.result import PaperResult
from modelcast.study.wording import centimetres

__all__ = ["plot_readings"]

_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*", "<", ">")
_SPREAD = 0.5
_TICKS = [0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0]

_OVER_BASELINE, _OVER_FREE = "one threshold", "one threshold, over free"

_Ratio = tuple[float, float | None, float | None]


def plot_readings(result: PaperResult) -> Figure:
    """Return two panels with a row a reading: all messages, and the 90th percentile, over the baseline's.

    Hollow markers are over the free receiver's (`modelcast.study.paper.beside_free`), without intervals.

    Parameters
    ----------
    result
        The reproduction.
    """
    with style():
        figure = new_figure(PAGE_IN, 1.0 + 0.22 * len(result.readings))
        messages, tracking = figure.subplots(1, 2, sharey=True)
        for at, one in enumerate(result.readings):
            rows = one.rows.messages
            _draw_beside(messages, at, [row.message_ratio for row in one.rows.beside_free])
            _draw(messages, at, [(row.message_ratio, row.message_low, row.message_high) for row in rows])
            pooled = one.rows.pooled(one.labelled.reading)
            beside = one.rows.beside_free_pooled(one.labelled.reading)
            _draw_beside(tracking, at, [row.p90_ratio for row in beside])
            _draw(tracking, at, [(row.p90_ratio, row.p90_low, row.p90_high) for row in pooled])
        ratio = f"{100 * result.plan.headline_ratio:g} %"
        _scale(messages, "All messages over the baseline's")
        _scale(tracking, f"p90 at PER {ratio} over the baseline's of equal rate")
        labels = [drawable(one.labelled.label, 44) for one in result.readings]
        messages.set_yticks(range(len(labels)), labels)
        messages.set_ylim(len(labels) - 0.4, -0.6)
        handles, _ = messages.get_legend_handles_labels()
        solid = [line for line in handles if line.get_label() == _OVER_BASELINE]
        hollow = [line for line in handles if line.get_label() == _OVER_FREE]
        names = [centimetres(threshold_m) for threshold_m in result.plan.thresholds_m]
        shown = [*solid[: len(names)], *hollow[:1]]
        names.append("hollow: over a free receiver's")
        figure.legend(shown, names, loc="outside upper center", ncols=len(names))
        return figure


def _place(row: int, at: int, count: int) -> float:
    """Height of a threshold's marker in the row of its reading."""
    return row + _SPREAD * ((at + 0.5) / count - 0.5)


def _draw_beside(axes: Axes, row: int, ratios: Sequence[float]) -> None:
    """Draw a reading's ratios to the free receiver, one hollow marker a threshold."""
    for at, value in enumerate(ratios):
        marker = _MARKERS[at % len(_MARKERS)]
        axes.plot(
            [value],
            [_place(row, at, len(ratios))],
            marker,
            color=POLICY_COLOURS["mbc"],
            markerfacecolor="none",
            markersize=3.0,
            markeredgewidth=0.6,
            label=_OVER_FREE,
        )


def _draw(axes: Axes, row: int, ratios: Sequence[_Ratio]) -> None:
    """Draw a reading's ratios, one marker a threshold from top to bottom, with their intervals."""
    for at, (value, low, high) in enumerate(ratios):
        place = _place(row, at, len(ratios))
        colour = POLICY_COLOURS["mbc"]
        if low is not None and high is not None:
            axes.plot([low, high], [place, place], color=colour, linewidth=0.8)
        marker = _MARKERS[at % len(_MARKERS)]
        axes.plot([value], [place], marker, color=colour, markersize=3.0, label=_OVER_BASELINE)


def _scale(axes: Axes, label: str) -> None:
    axes.axvline(1.0, color=INK, linewidth=0.7, linestyle=(0, (1, 2)))
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(FixedLocator(_TICKS))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter("{x:g}")
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel(label)
