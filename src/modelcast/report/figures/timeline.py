"""When each sub-model holds, and which one is in use."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EventCollection
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.report.figures.panels import drawable, empty_figure
from modelcast.report.style import (
    FAINT,
    IDENTIFICATION_COLOUR,
    INK,
    PAGE_IN,
    POLICY_COLOURS,
    model_colours,
    new_figure,
    style,
)
from modelcast.study.result import EvaluationResult, Timeline
from modelcast.study.wording import centimetres

__all__ = ["plot_timeline"]

_MOST_COLUMNS = 1000
_SHOWN_THRESHOLDS = 2.5
_MODEL_LINES = ("-", "--", "-.", ":")


def plot_timeline(result: EvaluationResult) -> Figure:
    """Return every sub-model's error against the threshold, and below it who holds and who is in use.

    Parameters
    ----------
    result
        The evaluation.
    """
    with style():
        if result.timeline is None or result.timeline.t_s.size == 0:
            return empty_figure("No trip holds a stretch for the timeline.")
        timeline = _thinned(result.timeline)
        figure = new_figure(PAGE_IN, 2.95 + 0.17 * len(timeline.members))
        heights = [2.0, 0.55 + 0.17 * len(timeline.members)]
        errors, strips = figure.subplots(2, 1, sharex=True, height_ratios=heights)
        _draw_errors(errors, timeline)
        _draw_strips(strips, timeline)
        title = f"{drawable(timeline.trip)}, threshold {centimetres(timeline.threshold_m)}"
        errors.set_title(title, loc="left")
        handles, labels = errors.get_legend_handles_labels()
        handles.append(Patch(color=FAINT))
        # Apart from the title: names of trips are long.
        figure.legend(
            handles, [*labels, "Sub-model fails"], loc="outside lower center", ncols=min(len(handles), 6)
        )
        return figure


def _thinned(timeline: Timeline) -> Timeline:
    """Return the timeline in at most `_MOST_COLUMNS` steps; the largest error of a step stands for it."""
    count = timeline.t_s.size
    if count <= _MOST_COLUMNS:
        return timeline
    starts = np.linspace(0, count, _MOST_COLUMNS, endpoint=False).astype(np.int64)
    # fmax passes over NaN, which marks samples without a window.
    largest_m = np.fmax.reduceat(timeline.tracking_error_m, starts, axis=0)
    return Timeline(
        timeline.trip,
        timeline.threshold_m,
        timeline.members,
        timeline.t_s[starts],
        largest_m,
        timeline.in_use[starts],
        timeline.update_s,
        timeline.identification_s,
    )


def _draw_errors(axes: Axes, timeline: Timeline) -> None:
    threshold_m = timeline.threshold_m
    colours = model_colours(timeline.members)
    for at, name in enumerate(timeline.members):
        axes.plot(
            timeline.t_s,
            timeline.tracking_error_m[:, at],
            _MODEL_LINES[at % len(_MODEL_LINES)],
            color=colours[name],
            linewidth=1.0,
            label=drawable(name, 24),
        )
    axes.axhline(threshold_m, color=INK, linewidth=0.7, linestyle=(0, (1, 2)), label="Threshold")
    axes.set_ylim(0.0, _SHOWN_THRESHOLDS * threshold_m)
    axes.set_ylabel("Tracking error [m]")


def _draw_strips(axes: Axes, timeline: Timeline) -> None:
    """Draw one strip a sub-model, one for the sub-model in use, and ticks for the messages."""
    colours = model_colours(timeline.members)
    for at, name in enumerate(timeline.members):
        errors_m = timeline.tracking_error_m[:, at]
        holds = errors_m < timeline.threshold_m
        _strip(axes, at, timeline.t_s, holds, colours[name])
        _strip(axes, at, timeline.t_s, ~holds & np.isfinite(errors_m), FAINT)
        _strip(axes, len(timeline.members), timeline.t_s, timeline.in_use == at, colours[name])
    row = len(timeline.members) + 1
    ticks = [("Updates", timeline.update_s, POLICY_COLOURS["mbc"])]
    if timeline.identification_s.size:
        ticks.append(("Identifications", timeline.identification_s, IDENTIFICATION_COLOUR))
    for below, (_, times_s, colour) in enumerate(ticks):
        axes.add_collection(
            EventCollection(times_s, lineoffset=row + below, linelength=0.8, linewidth=0.9, color=colour)
        )
    names = [*(drawable(name, 24) for name in timeline.members), "In use", *(name for name, _, _ in ticks)]
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.set_xlim(timeline.t_s[0], timeline.t_s[-1] + _step_s(timeline.t_s))
    axes.grid(visible=False, axis="y")
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel("Time [s]")


def _strip(axes: Axes, row: int, t_s: FloatArray, shown: BoolArray, colour: str) -> None:
    edges_s = np.append(t_s, t_s[-1] + _step_s(t_s))
    starts, ends = _runs(shown)
    spans = [
        (float(edges_s[start]), float(edges_s[end] - edges_s[start]))
        for start, end in zip(starts, ends, strict=True)
    ]
    axes.broken_barh(spans, (row - 0.4, 0.8), facecolors=colour, linewidth=0)


def _runs(shown: BoolArray) -> tuple[IntArray, IntArray]:
    """Return where runs of True start, and where they end (exclusive)."""
    steps = np.diff(shown.astype(np.int8), prepend=0, append=0)
    return np.flatnonzero(steps > 0), np.flatnonzero(steps < 0)


def _step_s(t_s: FloatArray) -> float:
    return float(np.median(np.diff(t_s))) if t_s.size > 1 else 0.1
