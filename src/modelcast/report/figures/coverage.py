"""Coverage of the ellipses of 50, 90 and 95 % against the age of the prediction, and times to a threshold."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelcast.models.calibration import LEVELS
from modelcast.report.figures.panels import drawable, empty_figure
from modelcast.report.style import INK, PAGE_IN, POLICY_COLOURS, new_figure, style
from modelcast.study.coverage import FORMS
from modelcast.study.table import Row

__all__ = ["plot_coverage", "plot_times"]

_MOST_COLUMNS = 3
_COLOURS = {
    "nominal": "#888888",
    "calibrated": POLICY_COLOURS["baseline"],
    "mapped": POLICY_COLOURS["mbc"],
}
_LINES = {"nominal": ":", "calibrated": "--", "mapped": "-"}
_MARKERS = dict(zip(LEVELS, ("v", "o", "^"), strict=True))


def plot_coverage(rows: Sequence[Row]) -> Figure:
    """Return the share of errors inside each kind of ellipse against the horizon, one panel a sub-model.

    A marker's shape is its level, and the level's own line is where it should lie.

    Parameters
    ----------
    rows
        Of `modelcast.study.coverage.measure_coverage`.
    """
    names = list(dict.fromkeys(row.sub_model for row in rows))
    with style():
        if not names:
            return empty_figure("No coverage was measured.")
        columns = len(names) if len(names) <= 2 else 2 if len(names) == 4 else _MOST_COLUMNS
        lines = -(-len(names) // columns)
        figure = new_figure(PAGE_IN * max(columns, 2) / _MOST_COLUMNS, 0.7 + 1.9 * lines)
        grid = figure.subplots(lines, columns, sharex=True, sharey=True, squeeze=False)
        for at, axes in enumerate(grid.flat):
            if at >= len(names):
                axes.set_axis_off()
                continue
            _draw(axes, names[at], [row for row in rows if row.sub_model == names[at]])
            if at + columns >= len(names):
                axes.tick_params(labelbottom=True)
        figure.supxlabel("Age of the prediction [s]", fontsize=7.5)
        figure.supylabel("Errors inside the ellipse [%]", fontsize=7.5)
        handles, labels = grid.flat[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(handles), columnspacing=1.2)
        return figure


def _draw(axes: Axes, name: str, rows: Sequence[Row]) -> None:
    axes.set_title(drawable(name, 30))
    axes.set_ylim(0.0, 102.0)
    axes.set_yticks([0.0, *(100 * level for level in LEVELS)], ["0", "50", "90", ""])
    axes.grid(visible=False)
    for level in LEVELS:
        axes.axhline(100 * level, color=INK, linewidth=0.5, zorder=0.5)
        for form in FORMS:
            shown = [row for row in rows if row.form == form and row.level == level]
            axes.plot(
                [row.horizon_s for row in shown],
                [100 * row.covered_ratio for row in shown],
                _LINES[form],
                marker=_MARKERS[level],
                color=_COLOURS[form],
                linewidth=1.0,
                markersize=2.8,
            )
    for form in FORMS:
        axes.plot([], [], _LINES[form], color=_COLOURS[form], label=form)
    for level in LEVELS:
        axes.plot([], [], marker=_MARKERS[level], color=INK, linestyle="", label=f"{100 * level:g} %")


def plot_times(rows: Sequence[Row]) -> Figure:
    """Return the expected times until a threshold is crossed beside the observed one, one panel a threshold.

    A bar is the mean of the observed times; a marker is the mean that the kind of ellipse lets expect.

    Parameters
    ----------
    rows
        Of `modelcast.study.coverage.measure_coverage`.
    """
    names = list(dict.fromkeys(row.sub_model for row in rows if row.instants))
    thresholds_m = sorted({row.threshold_m for row in rows})
    with style():
        if not names:
            return empty_figure("No time was measured.")
        figure = new_figure(PAGE_IN, 0.9 + 0.22 * len(names))
        grid = figure.subplots(1, len(thresholds_m), sharex=True, sharey=True, squeeze=False)
        for axes, threshold_m in zip(grid.flat, thresholds_m, strict=True):
            _draw_times(axes, names, [row for row in rows if row.threshold_m == threshold_m and row.instants])
            axes.set_title(f"until {100 * threshold_m:.4g} cm")
        grid.flat[0].set_yticks(range(len(names)), [drawable(name, 30) for name in names])
        grid.flat[0].invert_yaxis()
        figure.supxlabel("Mean time [s]", fontsize=7.5)
        handles, labels = grid.flat[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(handles), columnspacing=1.2)
        return figure


def _draw_times(axes: Axes, names: Sequence[str], rows: Sequence[Row]) -> None:
    axes.grid(visible=False)
    first = [row for row in rows if row.form == FORMS[0]]
    axes.barh(
        [names.index(row.sub_model) for row in first],
        [row.observed_s for row in first],
        height=0.6,
        color="#dddddd",
        label="observed",
    )
    for form, marker in zip(FORMS, ("x", "s", "o"), strict=True):
        shown = [row for row in rows if row.form == form]
        axes.plot(
            [row.expected_s for row in shown],
            [names.index(row.sub_model) for row in shown],
            marker,
            color=_COLOURS[form],
            markersize=3.2,
            label=f"expected, {form}",
        )
