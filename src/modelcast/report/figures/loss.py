"""90th percentile of the tracking error against the packet error ratio, in both readings."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelcast.core.arrays import FloatArray
from modelcast.report.figures.panels import (
    READINGS,
    empty_figure,
    legend_of_all,
    policy_labels,
    reading_panels,
)
from modelcast.report.figures.scales import end_below, log_scale
from modelcast.report.headline import (
    SAME_THRESHOLD,
    Headline,
    evaluated_ratios,
    headlines,
    sender_label,
)
from modelcast.report.style import INK, POLICY_COLOURS, POLICY_LINES, POLICY_MARKERS, style
from modelcast.study.loss_ratios import nearest_ratio
from modelcast.study.result import EvaluationResult
from modelcast.study.rules import FREE_RECEIVER, MODEL_SENDER
from modelcast.study.table import Row

__all__ = ["plot_loss"]

_MOST_TICKS = 8


def plot_loss(result: EvaluationResult) -> Figure:
    """Return the 90th percentile of the tracking error against the packet error ratio, a row a threshold.

    On the left everybody runs at that threshold, with the messages each sends; on the right everybody sends
    as often as MBC. Thin bars are confidence limits over the seeds; the axis and they are logarithmic.

    Parameters
    ----------
    result
        The evaluation.
    """
    labels = policy_labels(result)
    lines = {line.threshold_m: line for line in headlines(result) if line.tracking}
    ratios = evaluated_ratios(result)
    ratio = nearest_ratio(ratios)
    with style():
        if not lines or ratio is None:
            return empty_figure("No tracking under packet loss was evaluated.")
        figure, panels = reading_panels(sorted(lines))
        first = next(iter(panels.values()))
        values = [
            row.pte_p90_m for line in lines.values() for row in line.tracking.values() if row.pte_p90_m > 0.0
        ]
        if values:
            log_scale(first)
        for (threshold_m, reading), axes in panels.items():
            line = lines[threshold_m]
            for role in READINGS[reading]:
                rows = [line.tracking[at, role] for at in ratios if (at, role) in line.tracking]
                if rows:
                    _draw_policy(axes, role, rows, labels[role])
            axes.axhline(threshold_m, color=INK, linewidth=0.7, linestyle=(0, (1, 2)), label="Threshold")
            if reading == "same threshold":
                _say_messages(axes, line, ratio, sender_label(result))
        end_below(first, [*values, *lines])
        if len(ratios) <= _MOST_TICKS:
            first.set_xticks([100 * ratio for ratio in ratios], [f"{100 * ratio:.4g}" for ratio in ratios])
        figure.supxlabel("Packet error ratio [%]", fontsize=7.5)
        figure.supylabel("90th percentile of the PTE [m]", fontsize=7.5)
        legend_of_all(figure)
        return figure


def _say_messages(axes: Axes, line: Headline, ratio: float, sender: str) -> None:
    """Say under the title what the errors of this reading cost."""
    names = {MODEL_SENDER: sender, FREE_RECEIVER: "free", "baseline": "baseline"}
    rates_hz = {names[role]: line.rate_hz(ratio, role) for role in SAME_THRESHOLD}
    said = ", ".join(f"{name} {rate_hz:.2f}" for name, rate_hz in rates_hz.items() if rate_hz is not None)
    title = axes.get_title()
    axes.set_title(f"{title}\nmessages/s at {100 * ratio:.4g} %: {said}")


def _draw_policy(axes: Axes, role: str, rows: list[Row], label: str) -> None:
    percent = 100 * np.array([row.packet_error_ratio for row in rows])
    p90_m = np.array([row.pte_p90_m for row in rows])
    low_m, high_m = _limits(rows)
    colour = POLICY_COLOURS[role]
    axes.plot(
        percent,
        p90_m,
        linestyle=POLICY_LINES[role],
        marker=POLICY_MARKERS[role],
        color=colour,
        label=label,
    )
    if not np.isfinite(low_m).any():
        return
    axes.vlines(percent, low_m, high_m, color=colour, linewidth=0.8, alpha=0.7)


def _limits(rows: list[Row]) -> tuple[FloatArray, FloatArray]:
    """Return limits on the logarithm, from those on the percentile, (N,) each [m].

    The reach is divided by the mean over seeds: the first order of a logarithm's spread (the delta method).
    """
    high_m = np.array([row.pte_p90_high_m for row in rows], dtype=np.float64)
    low_m = np.array([row.pte_p90_low_m for row in rows], dtype=np.float64)
    middle_m = 0.5 * (low_m + high_m)
    factor = np.exp((high_m - low_m) / (2.0 * np.where(middle_m > 0.0, middle_m, np.nan)))
    return middle_m / factor, middle_m * factor
