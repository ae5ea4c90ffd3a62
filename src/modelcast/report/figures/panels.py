"""Small multiples, legends and labels that several figures share."""

from collections.abc import Sequence
from typing import Literal

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelcast.report.headline import SAME_RATE, SAME_THRESHOLD, policy_label, rate_basis, sender_label
from modelcast.report.style import COLUMN_IN, PAGE_IN, new_figure
from modelcast.study.result import EvaluationResult
from modelcast.study.rules import MODEL_SENDER, RIVALS
from modelcast.study.wording import centimetres

__all__ = [
    "LONGEST_NAME",
    "MOST_READINGS",
    "READINGS",
    "drawable",
    "empty_figure",
    "legend_of_all",
    "policy_labels",
    "radio_panels",
    "reading_panels",
    "top_legend",
]

MOST_READINGS = 4
"""More thresholds than this are thinned out evenly: panels must stay readable, and the figure on its page."""

READINGS = {"same threshold": SAME_THRESHOLD, "same rate": SAME_RATE}
"""Who is drawn in which column: a comparison has two readings, and neither may stand without the other."""

_LAST_IN_FONT = "\u024f"

LONGEST_NAME = 30
"""Letters of another package's name in a legend."""


def drawable(text: str, most: int = 60) -> str:
    """Return the text in letters that the figure's font has, shortened in its middle.

    Examples
    --------
    >>> drawable("a-long-file-name.csv/17", 12)
    'a-lon…csv/17'
    """
    shown = "".join(letter if letter <= _LAST_IN_FONT and letter.isprintable() else "?" for letter in text)
    if len(shown) <= most:
        return shown
    tail = most // 2
    return f"{shown[: most - 1 - tail]}…{shown[-tail:]}"


def policy_labels(result: EvaluationResult) -> dict[str, str]:
    """Return what legends call the policies of an evaluation, by role.

    Parameters
    ----------
    result
        The evaluation.
    """
    basis, sender = rate_basis(result), drawable(sender_label(result), LONGEST_NAME)
    return {role: policy_label(role, basis, sender=sender) for role in (MODEL_SENDER, *RIVALS)}


def empty_figure(reason: str) -> Figure:
    """Return a small figure that says why there is nothing to draw."""
    # No layout engine: with no axes to arrange, it warns.
    figure = Figure(figsize=(COLUMN_IN, 0.8))
    figure.text(0.5, 0.5, reason, ha="center", va="center", color="#666666")
    return figure


def reading_panels(
    thresholds_m: Sequence[float], *, height_in: float = 1.65
) -> tuple[Figure, dict[tuple[float, str], Axes]]:
    """Return a figure with a row a threshold and a column a reading, axes shared, by threshold and reading.

    Parameters
    ----------
    thresholds_m
        At least one threshold, rising [m].
    height_in
        Of a row [in].
    """
    if len(thresholds_m) > MOST_READINGS:
        last = len(thresholds_m) - 1
        thresholds_m = [thresholds_m[round(at * last / (MOST_READINGS - 1))] for at in range(MOST_READINGS)]
    figure = new_figure(PAGE_IN, 1.1 + height_in * len(thresholds_m))
    grid = figure.subplots(len(thresholds_m), len(READINGS), sharex=True, sharey=True, squeeze=False)
    panels: dict[tuple[float, str], Axes] = {}
    for line, threshold_m in zip(grid, thresholds_m, strict=True):
        for axes, reading in zip(line, READINGS, strict=True):
            axes.set_title(f"{reading.capitalize()}, {centimetres(threshold_m)}")
            panels[threshold_m, reading] = axes
    return figure, panels


def legend_of_all(figure: Figure, *, columns: int = 3, place: Literal["upper", "lower"] = "upper") -> None:
    """Put one legend above or below all panels, each name once, those of all panels behind the others.

    Parameters
    ----------
    figure
        With its curves drawn.
    columns
        At most so many names side by side.
    place
        Above or below.
    """
    named = {
        label: handle
        for axes in figure.axes
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    shared = {name: handle for name, handle in named.items() if name.startswith("Threshold")}
    named = {name: handle for name, handle in named.items() if name not in shared} | shared
    if named:
        figure.legend(
            list(named.values()),
            list(named),
            loc="outside upper center" if place == "upper" else "outside lower center",
            ncols=min(columns, len(named)),
        )


def radio_panels(
    radios: Sequence[str],
    columns: int,
    *,
    across: str,
    height_in: float,
    head_in: float,
    sharey: bool = False,
) -> tuple[Figure, list[list[Axes]]]:
    """Return a figure with a row of panels a radio, named above its first one, and the rows.

    Parameters
    ----------
    radios
        Names, at least one.
    columns
        Panels of a row.
    across
        What the horizontal axis, which all share, says.
    height_in, head_in
        Height of a row, and of the room above all [in].
    sharey
        Whether all share the vertical axis too.
    """
    figure = new_figure(PAGE_IN, head_in + height_in * len(radios))
    grid = figure.subplots(len(radios), columns, squeeze=False, sharex=True, sharey=sharey)
    for line, radio in zip(grid, radios, strict=True):
        line[0].set_title(radio, loc="left")
    for axes in grid[-1]:
        axes.set_xlabel(across)
    return figure, [list(line) for line in grid]


def top_legend(figure: Figure, axes: Axes, *, columns: int = 4) -> None:
    """Put the legend of one panel above all of them."""
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        if figure.get_figwidth() <= COLUMN_IN:
            columns = 1
        figure.legend(handles, labels, loc="outside upper center", ncols=min(columns, len(handles)))
