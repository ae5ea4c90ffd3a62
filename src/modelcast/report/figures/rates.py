"""Message rate and airtime against threshold: MBC, the free receiver and the baseline, and references."""

from collections.abc import Iterable

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
from modelcast.study.rules import FREE_RECEIVER, MODEL_SENDER
from modelcast.study.table import Row

__all__ = ["plot_rates"]

_WIDTH = 0.27
_REACH = 0.45
_MOST_IN_COLUMN = 4
_REFERENCE_LINES: dict[str, LineStyleType] = {
    "clairvoyant-1": "-",
    "clairvoyant-2": (0, (3.5, 1.0)),
    "clairvoyant-3": (0, (1.0, 0.8)),
    "cam": (0, (5.0, 1.2, 1.0, 1.2)),
}
_TALLEST_RATIO = 1.4
"""A line this much higher than the tallest bar would squeeze the bars."""


def plot_rates(result: EvaluationResult) -> Figure:
    """Return bars of the pooled message rate and, below, airtime at each threshold: MBC beside its rivals.

    Message rates of MBC are stacked by kind.

    The references are thin lines across the bars of a threshold, or across all where they know none.

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
        off_hz = _off_the_scale(result, lines)
        _draw_references(axes, result, lines, cam=off_hz is None)
        if off_hz is not None:
            note = f"{REFERENCE_LABELS['cam']}: {off_hz:.2f}/s, off the scale"
            axes.set_title(note, loc="right", fontsize=6.0, color=INK)
        axes.set_xticks(range(len(lines)), [f"{100 * line.threshold_m:.4g}" for line in lines])
        axes.set_xlim(-0.6, len(lines) - 0.4)
        _draw_airtime(below, lines)
        axes.set_ylabel("Message rate [1/s]")
        axes.grid(visible=False, axis="x")
        axes.margins(y=0.09)
        _legend(figure, axes, wide=wide)
        return figure


def _rows(lines: list[Headline]) -> dict[str, list[Row | None]]:
    """The rows of each bar from the left, by role; nobody of whom there is none."""
    found: dict[str, list[Row | None]] = {
        MODEL_SENDER: [line.mbc for line in lines],
        FREE_RECEIVER: [line.free for line in lines],
        "baseline": [line.baseline for line in lines],
    }
    return {role: rows for role, rows in found.items() if any(row is not None for row in rows)}


def _places(roles: Iterable[str], count: int) -> dict[str, list[float]]:
    """Where the bars of each role stand."""
    shown = list(roles)
    step = _WIDTH + 0.02
    first = -step * (len(shown) - 1) / 2
    return {role: [at + first + step * nth for at in range(count)] for nth, role in enumerate(shown)}


def _draw_bars(axes: Axes, lines: list[Headline], sender: str) -> None:
    rows = _rows(lines)
    for role, places in _places(rows, len(lines)).items():
        colour, own = POLICY_COLOURS[role], rows[role]
        totals_hz = [None if row is None else row.total_rate_hz for row in own]
        if role != MODEL_SENDER:
            name = {FREE_RECEIVER: "Free receiver", "baseline": "Baseline"}[role]
            bars = axes.bar(places, [rate or 0.0 for rate in totals_hz], _WIDTH, color=colour, label=name)
            _label_tops(axes, bars, totals_hz)
            continue
        updates = [0.0 if row is None else row.update_rate_hz for row in own]
        named = [0.0 if row is None else row.identification_rate_hz for row in own]
        label = f"{sender} identifications" if any(named) else ""
        axes.bar(places, updates, _WIDTH, color=colour, label=f"{sender} updates" if any(named) else sender)
        bars = axes.bar(places, named, _WIDTH, bottom=updates, color=IDENTIFICATION_COLOUR, label=label)
        _label_tops(axes, bars, totals_hz)


def _draw_airtime(axes: Axes, lines: list[Headline]) -> None:
    rows = _rows(lines)
    for role, places in _places(rows, len(lines)).items():
        airtime_ms = [None if row is None else 1000.0 * row.airtime_per_s for row in rows[role]]
        heights = [height or 0.0 for height in airtime_ms]
        bars = axes.bar(places, heights, _WIDTH, color=POLICY_COLOURS[role])
        _label_tops(axes, bars, airtime_ms)
    axes.set_ylabel("Airtime [ms/s]")
    axes.set_xlabel("Tracking-error threshold [cm]")
    axes.grid(visible=False, axis="x")
    axes.margins(y=0.25)


def _draw_references(axes: Axes, result: EvaluationResult, lines: list[Headline], *, cam: bool) -> None:
    """Draw a line a threshold for each degree, on white to stand out from the bars, and one for all CAM."""
    for name, dashes in _REFERENCE_LINES.items():
        rows = [pooled_reference(result, name, line.threshold_m) for line in lines]
        found = [(at, row.rate_hz) for at, row in enumerate(rows) if row is not None]
        if not found or (name == "cam" and not cam):
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


def _off_the_scale(result: EvaluationResult, lines: list[Headline]) -> float | None:
    """How high the CAM rate is where it is so high that its line would squeeze the bars; else None."""
    cam = pooled_reference(result, "cam", lines[0].threshold_m)
    tallest_hz = _tallest_hz(lines)
    if cam is None or tallest_hz == 0.0 or cam.rate_hz <= _TALLEST_RATIO * tallest_hz:
        return None
    return cam.rate_hz


def _tallest_hz(lines: list[Headline]) -> float:
    rows = [row for line in lines for row in (line.mbc, line.baseline, line.free) if row is not None]
    return max(row.total_rate_hz for row in rows)


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
    """Write each total on white above its bar: no line goes through it."""
    labels = ["" if total is None else f"{total:.2f}" for total in totals_hz]
    for text in axes.bar_label(bars, labels, padding=1.5, fontsize=5.5, zorder=5):
        text.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 0.4})
