"""Message rate and airtime against threshold: MBC beside the baseline, and the references across both."""

from matplotlib.axes import Axes
from matplotlib.container import BarContainer
from matplotlib.figure import Figure
from matplotlib.typing import LineStyleType

from modelcast.report.figures.panels import LONGEST_NAME, drawable, empty_figure
from modelcast.report.headline import REFERENCE_LABELS, Headline, headlines, pooled_reference, sender_label
from modelcast.report.style import (
    COLUMN_IN,
    IDENTIFICATION_COLOUR,
    INK,
    PAGE_IN,
    POLICY_COLOURS,
    new_figure,
    style,
)
from modelcast.study.result import EvaluationResult

__all__ = ["plot_rates"]

_WIDTH = 0.38
_REACH = 0.46
_MOST_IN_COLUMN = 6
_REFERENCE_LINES: dict[str, LineStyleType] = {
    "clairvoyant-1": "-",
    "clairvoyant-2": (0, (3.5, 1.0)),
    "clairvoyant-3": (0, (1.0, 0.8)),
    "cam": (0, (5.0, 1.2, 1.0, 1.2)),
}
_TALLEST_RATIO = 1.4
"""A line this much higher than the tallest bar would squeeze the bars."""

_HEADROOM = 1.25


def plot_rates(result: EvaluationResult) -> Figure:
    """Return bars of the pooled message rate and, below, airtime at each threshold: MBC and the baseline.

    Message rates of MBC are stacked by kind.

    The references are thin lines across both bars of a threshold, or across all where they know none.

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
        figure = new_figure(PAGE_IN if wide else COLUMN_IN, 4.0 if result.references else 3.6)
        axes, below = figure.subplots(2, 1, sharex=True, height_ratios=(2.6, 1.0))
        _draw_bars(axes, lines, drawable(sender_label(result), LONGEST_NAME))
        _draw_references(axes, result, lines)
        axes.set_xticks(range(len(lines)), [f"{100 * line.threshold_m:.4g}" for line in lines])
        axes.set_xlim(-0.6, len(lines) - 0.4)
        _draw_airtime(below, lines)
        axes.set_ylabel("Message rate [1/s]")
        axes.grid(visible=False, axis="x")
        axes.margins(y=0.09)
        _keep_bars_large(axes, result, lines)
        _legend(figure, axes, wide=wide)
        return figure


def _draw_bars(axes: Axes, lines: list[Headline], sender: str) -> None:
    places = range(len(lines))
    left, right = [at - _WIDTH / 2 - 0.01 for at in places], [at + _WIDTH / 2 + 0.01 for at in places]
    updates = [0.0 if line.mbc is None else line.mbc.update_rate_hz for line in lines]
    identifications = [0.0 if line.mbc is None else line.mbc.identification_rate_hz for line in lines]
    baseline = [0.0 if line.baseline is None else line.baseline.total_rate_hz for line in lines]
    axes.bar(left, updates, _WIDTH, color=POLICY_COLOURS["mbc"], label=f"{sender} updates")
    tops = axes.bar(
        left,
        identifications,
        _WIDTH,
        bottom=updates,
        color=IDENTIFICATION_COLOUR,
        label=f"{sender} identifications",
    )
    beside = axes.bar(right, baseline, _WIDTH, color=POLICY_COLOURS["baseline"], label="Baseline")
    _label_tops(axes, tops, [None if line.mbc is None else line.mbc.total_rate_hz for line in lines])
    _label_tops(
        axes, beside, [None if line.baseline is None else line.baseline.total_rate_hz for line in lines]
    )


def _draw_airtime(axes: Axes, lines: list[Headline]) -> None:
    for policy, shift in (("mbc", -1), ("baseline", 1)):
        rows = [line.mbc if policy == "mbc" else line.baseline for line in lines]
        places = [at + shift * (_WIDTH / 2 + 0.01) for at in range(len(lines))]
        heights = [0.0 if row is None else 1000.0 * row.airtime_per_s for row in rows]
        bars = axes.bar(places, heights, _WIDTH, color=POLICY_COLOURS[policy])
        _label_tops(axes, bars, [None if row is None else 1000.0 * row.airtime_per_s for row in rows])
    axes.set_ylabel("Airtime [ms/s]")
    axes.set_xlabel("Tracking-error threshold [cm]")
    axes.grid(visible=False, axis="x")
    axes.margins(y=0.25)


def _draw_references(axes: Axes, result: EvaluationResult, lines: list[Headline]) -> None:
    """Draw a line a threshold for each degree, on white to stand out from the bars, and one for all CAM."""
    for name, dashes in _REFERENCE_LINES.items():
        rows = [pooled_reference(result, name, line.threshold_m) for line in lines]
        found = [(at, row.rate_hz) for at, row in enumerate(rows) if row is not None]
        if not found:
            continue
        rates_hz = [rate_hz for _, rate_hz in found]
        if name == "cam":
            axes.axhline(
                rates_hz[0], color=INK, linestyle=dashes, linewidth=0.9, label=REFERENCE_LABELS[name]
            )
            continue
        left, right = [at - _REACH for at, _ in found], [at + _REACH for at, _ in found]
        axes.hlines(rates_hz, left, right, colors="white", linewidths=1.9)
        axes.hlines(
            rates_hz, left, right, colors=INK, linestyles=dashes, linewidths=0.9, label=REFERENCE_LABELS[name]
        )


def _keep_bars_large(axes: Axes, result: EvaluationResult, lines: list[Headline]) -> None:
    """Leave a far higher CAM rate off the scale, and say how high it is."""
    cam = pooled_reference(result, "cam", lines[0].threshold_m)
    rows = [row for line in lines for row in (line.mbc, line.baseline) if row is not None]
    tallest_hz = max(row.total_rate_hz for row in rows)
    if cam is None or tallest_hz == 0.0 or cam.rate_hz <= _TALLEST_RATIO * tallest_hz:
        return
    axes.set_ylim(0.0, _HEADROOM * tallest_hz)
    note = f"{REFERENCE_LABELS['cam']}: {cam.rate_hz:.2f}, off the scale"
    axes.text(0.99, 0.985, note, transform=axes.transAxes, ha="right", va="top", fontsize=6.0, color=INK)


def _legend(figure: Figure, axes: Axes, *, wide: bool) -> None:
    """Name the bars first, then the line for all thresholds, then the lines of each."""
    handles, labels = axes.get_legend_handles_labels()
    named = dict(zip(labels, handles, strict=True))
    bars = [label for label in labels if label not in REFERENCE_LABELS.values()]
    references = sorted(set(labels) - set(bars))
    shown = [*bars, *references]
    columns = 3 if not references else 4 if wide else 2
    figure.legend(
        [named[label] for label in shown],
        shown,
        loc="outside upper center",
        ncols=columns,
        columnspacing=1.2,
    )


def _label_tops(axes: Axes, bars: BarContainer, totals_hz: list[float | None]) -> None:
    labels = ["" if total is None else f"{total:.2f}" for total in totals_hz]
    axes.bar_label(bars, labels, padding=1.5, fontsize=6.0)
