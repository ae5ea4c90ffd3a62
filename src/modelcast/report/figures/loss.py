"""90th percentile of the tracking error against the packet error ratio."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelcast.core.arrays import FloatArray
from modelcast.report.figures.panels import empty_figure, panel_grid, policy_labels, top_legend
from modelcast.report.headline import SHOWN_POLICIES, pooled_tracking
from modelcast.report.style import INK, POLICY_COLOURS, POLICY_LINES, POLICY_MARKERS, style
from modelcast.study.result import EvaluationResult
from modelcast.study.table import Row

__all__ = ["plot_loss"]

_MOST_TICKS = 8


def plot_loss(result: EvaluationResult) -> Figure:
    """Return the 90th percentile of the tracking error against the packet error ratio, for each threshold.

    MBC and both readings of the equal-rate baseline, with their confidence limits over the seeds.

    Parameters
    ----------
    result
        The evaluation.
    """
    labels = policy_labels(result)
    thresholds_m = sorted({row.threshold_m for row in result.tracking})
    rows = {
        (threshold_m, policy): pooled_tracking(result, policy, threshold_m)
        for threshold_m in thresholds_m
        for policy in SHOWN_POLICIES
    }
    drawn_m = [item for item in thresholds_m if any(rows[item, policy] for policy in SHOWN_POLICIES)]
    with style():
        if not drawn_m:
            return empty_figure("No tracking under packet loss was evaluated.")
        figure, panels = panel_grid(drawn_m)
        for threshold_m, axes in panels.items():
            for policy in SHOWN_POLICIES:
                if rows[threshold_m, policy]:
                    _draw_policy(axes, policy, rows[threshold_m, policy], labels[policy])
            axes.axhline(threshold_m, color=INK, linewidth=0.7, linestyle=(0, (1, 2)), label="Threshold")
        first = next(iter(panels.values()))
        first.set_ylim(bottom=0.0)
        ratios = sorted({row.packet_error_ratio for row in result.tracking})
        if len(ratios) <= _MOST_TICKS:
            first.set_xticks([100 * ratio for ratio in ratios], [f"{100 * ratio:.4g}" for ratio in ratios])
        figure.supxlabel("Packet error ratio [%]", fontsize=7.5)
        figure.supylabel("90th percentile of the PTE [m]", fontsize=7.5)
        top_legend(figure, first)
        return figure


def _draw_policy(axes: Axes, policy: str, rows: list[Row], label: str) -> None:
    percent = 100 * np.array([row.packet_error_ratio for row in rows])
    p90_m = np.array([row.pte_p90_m for row in rows])
    low_m, high_m = _limits(rows)
    colour = POLICY_COLOURS[policy]
    axes.plot(percent, p90_m, POLICY_LINES[policy], marker=POLICY_MARKERS[policy], color=colour, label=label)
    if not np.isfinite(low_m).any():
        return
    if len(rows) > 1:
        axes.fill_between(percent, low_m, high_m, color=colour, alpha=0.2, linewidth=0)
    else:
        # A band over one ratio would have no width.
        axes.vlines(percent, low_m, high_m, color=colour, linewidth=1.0)


def _limits(rows: list[Row]) -> tuple[FloatArray, FloatArray]:
    low_m = np.array([row.pte_p90_low_m for row in rows], dtype=np.float64)
    high_m = np.array([row.pte_p90_high_m for row in rows], dtype=np.float64)
    return np.maximum(low_m, 0.0), high_m
