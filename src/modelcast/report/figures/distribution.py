"""Distribution of the tracking error at one packet error ratio."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator

from modelcast.report.figures.panels import (
    READINGS,
    empty_figure,
    legend_of_all,
    policy_labels,
    reading_panels,
)
from modelcast.report.headline import rate_basis, role_of
from modelcast.report.style import INK, POLICY_COLOURS, POLICY_LINES, style
from modelcast.study.loss_ratios import nearest_ratio
from modelcast.study.result import Ecdf, EvaluationResult

__all__ = ["plot_distribution"]

_SMALLEST_M = 0.01
_TICKS_M = [0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0]


def plot_distribution(result: EvaluationResult) -> Figure:
    """Return the distribution of the tracking error at the packet error ratio nearest to 40 %.

    A row for each threshold: on the left everybody runs at it, on the right everybody sends as often as MBC.

    Parameters
    ----------
    result
        The evaluation.
    """
    ratio = nearest_ratio(sorted({curve.packet_error_ratio for curve in result.ecdfs}))
    basis = rate_basis(result)
    labels = policy_labels(result)
    curves = [
        replace(curve, policy=role_of(result, curve.policy))
        for curve in result.ecdfs
        if curve.packet_error_ratio == ratio
        and role_of(result, curve.policy) in labels
        and curve.rate_basis in {None, basis}
        and np.isfinite(curve.tracking_error_m).any()
    ]
    with style():
        if ratio is None or not curves:
            return empty_figure("No distribution of the tracking error was evaluated.")
        figure, panels = reading_panels(sorted({curve.threshold_m for curve in curves}))
        for (threshold_m, reading), axes in panels.items():
            own = [item for item in curves if item.threshold_m == threshold_m]
            _draw_curves(axes, threshold_m, own, {role: labels[role] for role in READINGS[reading]})
        _scale(next(iter(panels.values())), curves)
        across = f"Position tracking error at a packet error ratio of {100 * ratio:.4g} % [m]"
        figure.supxlabel(across, fontsize=7.5)
        figure.supylabel("Share of samples", fontsize=7.5)
        legend_of_all(figure)
        return figure


def _draw_curves(axes: Axes, threshold_m: float, curves: Sequence[Ecdf], labels: Mapping[str, str]) -> None:
    for policy in labels:
        for curve in curves:
            if curve.policy == policy:
                axes.plot(
                    curve.tracking_error_m,
                    curve.probability,
                    POLICY_LINES[policy],
                    color=POLICY_COLOURS[policy],
                    label=labels[policy],
                )
    axes.axvline(threshold_m, color=INK, linewidth=0.7, linestyle=(0, (1, 2)), label="Threshold")


def _scale(axes: Axes, curves: Sequence[Ecdf]) -> None:
    """Set the shared axes; errors under 1 cm, many of them 0, lie to the left of the logarithmic one."""
    largest_m = max(float(np.nanmax(curve.tracking_error_m)) for curve in curves)
    axes.set_xscale("log")
    axes.set_xlim(_SMALLEST_M, max(1.2 * largest_m, 10 * _SMALLEST_M))
    # Fixed ticks: the logarithmic locator's minor ticks would take a third of the drawing time.
    axes.xaxis.set_major_locator(FixedLocator(_TICKS_M))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_ylim(0.0, 1.02)
    axes.set_yticks([0.0, 0.25, 0.5, 0.75, 0.9, 1.0])
    axes.yaxis.set_major_formatter("{x:g}")
