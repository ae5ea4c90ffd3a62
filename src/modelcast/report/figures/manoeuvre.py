"""The map of a manoeuvre: the true path and the one each sub-model predicts."""

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelcast.core.arrays import FloatArray
from modelcast.report.figures.panels import drawable, empty_figure, legend_of_all
from modelcast.report.style import INK, PAGE_IN, model_colours, new_figure, style
from modelcast.study.result import EvaluationResult, Manoeuvre
from modelcast.study.wording import centimetres

__all__ = ["plot_manoeuvre"]

_SHOWN_THRESHOLDS = 4.0
_MARGIN = 0.08
_CROSS: dict[str, Any] = {"markersize": 7.0, "markeredgecolor": "white", "markeredgewidth": 0.6}
_MODEL_LINES = ("-", "--", "-.", ":")


def plot_manoeuvre(result: EvaluationResult) -> Figure:
    """Return a map of history, truth and predicted paths, and beside it the error of each prediction.

    Parameters
    ----------
    result
        The evaluation.
    """
    with style():
        manoeuvre = result.manoeuvre
        if manoeuvre is None or manoeuvre.truth_m.shape[0] == 0:
            return empty_figure("No trip holds a manoeuvre to map.")
        figure = new_figure(PAGE_IN, 3.3)
        chart, growth = figure.subplots(1, 2, width_ratios=[1.55, 1.0])
        _draw_map(chart, manoeuvre)
        _draw_growth(growth, manoeuvre)
        title = f"{drawable(manoeuvre.trip)}, predicted at {manoeuvre.start_s:.1f} s"
        chart.set_title(title, loc="left")
        growth.set_title("Error of each prediction", loc="left")
        legend_of_all(figure, place="lower")
        return figure


def _draw_map(axes: Axes, manoeuvre: Manoeuvre) -> None:
    """Draw the paths in metres from the start; a cross marks where an error reaches the threshold."""
    start_m = manoeuvre.history_m[-1] if manoeuvre.history_m.size else manoeuvre.truth_m[0]
    history_m, truth_m = manoeuvre.history_m - start_m, manoeuvre.truth_m - start_m
    axes.plot(*truth_m.T, color=INK, linewidth=2.6, alpha=0.25, solid_capstyle="butt", label="True path")
    axes.plot(*history_m.T, ".", color=INK, markersize=3.0, label="Samples fitted")
    colours = model_colours(list(manoeuvre.predicted_m))
    for at, (name, path_m) in enumerate(manoeuvre.predicted_m.items()):
        shown_m = path_m - start_m
        axes.plot(
            *shown_m.T,
            _MODEL_LINES[at % len(_MODEL_LINES)],
            color=colours[name],
            linewidth=1.1,
            label=_label(manoeuvre, name),
        )
        lost_s = _survival_s(manoeuvre, name)
        if lost_s is not None:
            # The short line joins the prediction to the truth at that instant: it is one threshold long.
            pair_m = np.stack([_at(manoeuvre, path, lost_s) for path in (shown_m, truth_m)])
            axes.plot(*pair_m.T, color=colours[name], linewidth=0.8)
            _cross(axes, pair_m[0], colours[name])
    axes.plot([], [], "X", color="#777777", **_CROSS, label="Error reaches the threshold")
    axes.plot(0.0, 0.0, "o", color=INK, markerfacecolor="white", markersize=4.5, label="Start")
    _crop(axes, np.concatenate([history_m, truth_m]))
    axes.set_xlabel("East of the start [m]")
    axes.set_ylabel("North of the start [m]")


def _crop(axes: Axes, path_m: FloatArray) -> None:
    """Show the path that was driven, to scale and with a margin; a prediction that leaves it is cut off.

    The shorter side has at least half of the longer one, so that a straight path makes no sliver.
    """
    low_m, high_m = path_m.min(axis=0), path_m.max(axis=0)
    longest_m = max(float((high_m - low_m).max()), 1.0)
    half_m = 0.5 * np.maximum(high_m - low_m, 0.5 * longest_m) + _MARGIN * longest_m
    middle_m = 0.5 * (low_m + high_m)
    axes.set_xlim(float(middle_m[0] - half_m[0]), float(middle_m[0] + half_m[0]))
    axes.set_ylim(float(middle_m[1] - half_m[1]), float(middle_m[1] + half_m[1]))
    axes.set_aspect("equal", adjustable="box")


def _draw_growth(axes: Axes, manoeuvre: Manoeuvre) -> None:
    colours = model_colours(list(manoeuvre.predicted_m))
    for at, (name, path_m) in enumerate(manoeuvre.predicted_m.items()):
        error_m = np.hypot(*(path_m - manoeuvre.truth_m).T)
        axes.plot(manoeuvre.horizons_s, error_m, _MODEL_LINES[at % len(_MODEL_LINES)], color=colours[name])
        lost_s = _survival_s(manoeuvre, name)
        if lost_s is not None:
            _cross(axes, np.array([lost_s, manoeuvre.threshold_m]), colours[name])
    label = f"Threshold {centimetres(manoeuvre.threshold_m)}"
    axes.axhline(manoeuvre.threshold_m, color=INK, linewidth=0.7, linestyle=(0, (1, 2)), label=label)
    axes.set_xlabel("Time after the start [s]")
    axes.set_ylabel("Tracking error [m]")
    # Errors grow to many thresholds; where they cross it must stay in sight.
    axes.set_ylim(0.0, _SHOWN_THRESHOLDS * manoeuvre.threshold_m)
    axes.set_xlim(left=0.0)


def _cross(axes: Axes, place: FloatArray, colour: str) -> None:
    axes.plot(*place, "X", color=colour, **_CROSS)


def _survival_s(manoeuvre: Manoeuvre, name: str) -> float | None:
    """Return when the sub-model's error reaches the threshold; None where it does not on the map."""
    lost_s = manoeuvre.survival_s.get(name, math.inf)
    return lost_s if lost_s <= float(manoeuvre.horizons_s[-1]) else None


def _label(manoeuvre: Manoeuvre, name: str) -> str:
    lost_s = _survival_s(manoeuvre, name)
    fate = "holds throughout" if lost_s is None else f"holds {lost_s:.1f} s"
    return f"{drawable(name, 24)} ({fate})"


def _at(manoeuvre: Manoeuvre, path_m: FloatArray, time_s: float) -> FloatArray:
    return np.array([np.interp(time_s, manoeuvre.horizons_s, path_m[:, axis]) for axis in (0, 1)])
