"""What hosts miss, warn of wrongly, and how late they are, against losses."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelcast.core.arrays import FloatArray
from modelcast.report.figures.panels import drawable, empty_figure, top_legend
from modelcast.report.losses import burst_words, shown_ratios
from modelcast.report.style import PAGE_IN, model_colours, new_figure, style
from modelcast.study.safety.result import RecordingScores, SafetyKind, SafetyResult, kind_of
from modelcast.study.table import Row

__all__ = ["SAFETY_FIGURES", "plot_accuracy", "plot_delays"]

_MARKERS = "osD^v<>PX*"
_ROW_IN, _HEAD_IN = 1.9, 0.6
_LONGEST_S = 2.0


def _basis(result: SafetyResult) -> str:
    """The basis drawn: airtime where it was asked for."""
    bases = [row.basis for row in result.pooled]
    return "airtime" if "airtime" in bases else bases[0]


def _cases(result: SafetyResult) -> list[SafetyKind]:
    return list(dict.fromkeys(kind_of(row) for row in result.pooled))


def _title(kind: SafetyKind) -> str:
    recorded = f"\nrecorded: {drawable(kind.loss_log, 20)}" if kind.loss_log else ""
    sensor = f"{drawable(kind.sensor, 20)}, " if kind.sensor else ""
    return f"{sensor}{burst_words(kind)}{recorded}"


@style()
def plot_accuracy(result: SafetyResult) -> Figure:
    """Return the shares missed and false against the packet error ratio, a row a sensor and kind of loss.

    Parameters
    ----------
    result
        The evaluation.
    """
    if not result.pooled:
        return empty_figure("Nothing was scored.")
    cases, basis = _cases(result), _basis(result)
    names = list(dict.fromkeys(row.candidate for row in result.pooled))
    colours = model_colours(names)
    figure = new_figure(PAGE_IN, _HEAD_IN + _ROW_IN * len(cases))
    panels = figure.subplots(len(cases), 3, squeeze=False, sharex=True)
    for row, case in zip(panels, cases, strict=True):
        own = [one for one in result.pooled if (kind_of(one), one.basis) == (case, basis)]
        for number, name in enumerate(names):
            _draw(row, [one for one in own if one.candidate == name], name, number, colours[name])
        row[0].set_ylabel(f"{_title(case)}\nMissed [%]")
        row[1].set_ylabel("Never warned [%]")
        row[2].set_ylabel("False [%]")
        for axes in row:
            axes.set_ylim(bottom=0.0)
    figure.supxlabel("Packet error ratio [%]", fontsize=7.5)
    top_legend(figure, panels[0, 0])
    return figure


def _draw(row: Sequence[Axes], own: Sequence[Row], name: str, number: int, colour: str) -> None:
    ratios = 100 * np.array([one.packet_error_ratio for one in own])
    for axes, field in zip(row, ("missed_ratio", "missed_events", "false_ratio"), strict=True):
        values = 100 * np.array([getattr(one, field) for one in own])
        marker = _MARKERS[number % len(_MARKERS)]
        axes.plot(ratios, values, marker=marker, color=colour, label=drawable(name, 30))


@style()
def plot_delays(result: SafetyResult) -> Figure:
    """Return the distribution of how late warnings come at the loss ratio nearest to 40 %, or a log's own.

    Parameters
    ----------
    result
        The evaluation.
    """
    if result.events == 0:
        return empty_figure("There was no true warning.")
    cases, basis = _cases(result), _basis(result)
    names = list(dict.fromkeys(row.candidate for row in result.pooled))
    colours = model_colours(names)
    shown_at = shown_ratios(result.pooled)
    same = f", {100 * shown_at[cases[0]]:.4g} % lost" if len(set(shown_at.values())) == 1 else ""
    columns = min(3, len(cases))
    rows = -(-len(cases) // columns)
    figure = new_figure(PAGE_IN, _HEAD_IN + _ROW_IN * rows)
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    for axes in panels.flat[len(cases) :]:
        axes.set_visible(False)
    for axes, case in zip(panels.flat, cases, strict=False):
        own = [one for one in result.recordings if one.kind == case]
        at = shown_at[case]
        for name in names:
            late_s = _delays(own, name, basis, at)
            level = 100 * np.arange(1, late_s.size + 1) / late_s.size
            shown = late_s <= _LONGEST_S
            axes.step(
                np.concatenate([[0.0], late_s[shown], [_LONGEST_S]]),
                np.concatenate([[0.0], level[shown], [level[shown][-1] if shown.any() else 0.0]]),
                where="post",
                color=colours[name],
                label=drawable(name, 30),
            )
        axes.set_title(_title(case) + ("" if same else f"\n{100 * at:.4g} % lost"))
        axes.set_ylim(0.0, 101.0)
    figure.supxlabel(f"Later than perfect knowledge [s]{same}", fontsize=7.5)
    figure.supylabel("True warnings given [%]", fontsize=7.5)
    top_legend(figure, panels.flat[0])
    return figure


def _delays(own: Sequence[RecordingScores], name: str, basis: str, ratio: float) -> FloatArray:
    found = [
        one.delay_s.ravel()
        for scores in own
        for one in scores.conditions
        if (one.candidate, one.basis, one.packet_error_ratio) == (name, basis, ratio)
    ]
    return np.sort(np.concatenate(found))


SAFETY_FIGURES: dict[str, tuple[str, Callable[[SafetyResult], Figure]]] = {
    "accuracy": (
        (
            "Instants near the decision at which the host did not warn and perfect knowledge does, whole "
            "warnings that never came, and instants at which it warned without reason, against losses."
        ),
        plot_accuracy,
    ),
    "delays": (
        (
            "How late warnings come, as a share of all true warnings: where a curve ends below 100 %, the "
            "rest never came."
        ),
        plot_delays,
    ),
}
"""Figures of the report in order: caption and what draws it, by the stem of their files."""
