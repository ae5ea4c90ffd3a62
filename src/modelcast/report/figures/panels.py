"""Small multiples, legends and labels that several figures share."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelcast.report.headline import policy_label, rate_basis, sender_label
from modelcast.report.style import COLUMN_IN, PAGE_IN, new_figure
from modelcast.study.result import EvaluationResult
from modelcast.study.rules import BASELINES, MODEL_SENDER
from modelcast.study.wording import centimetres

__all__ = [
    "LONGEST_NAME",
    "MOST_PANELS",
    "drawable",
    "empty_figure",
    "panel_grid",
    "policy_labels",
    "radio_panels",
    "top_legend",
]

MOST_PANELS = 9
"""More thresholds than this are thinned out evenly: panels must stay readable."""

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
    return {role: policy_label(role, basis, sender=sender) for role in (MODEL_SENDER, *BASELINES)}


def empty_figure(reason: str) -> Figure:
    """Return a small figure that says why there is nothing to draw."""
    # No layout engine: with no axes to arrange, it warns.
    figure = Figure(figsize=(COLUMN_IN, 0.8))
    figure.text(0.5, 0.5, reason, ha="center", va="center", color="#666666")
    return figure


def panel_grid(thresholds_m: Sequence[float], *, also: str = "") -> tuple[Figure, dict[float, Axes]]:
    """Return a figure with one panel for each threshold, axes shared, by threshold.

    Parameters
    ----------
    thresholds_m
        At least one threshold, rising [m].
    also
        What the title of each panel says besides its threshold.
    """
    if len(thresholds_m) > MOST_PANELS:
        last = len(thresholds_m) - 1
        thresholds_m = [thresholds_m[round(at * last / (MOST_PANELS - 1))] for at in range(MOST_PANELS)]
    count = len(thresholds_m)
    columns = 1 if count == 1 else 2 if count <= 4 else 3
    rows = -(-count // columns)
    width_in = COLUMN_IN if columns == 1 else PAGE_IN
    figure = new_figure(width_in, 0.55 + (2.3 if columns == 1 else 1.75) * rows)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    panels: dict[float, Axes] = {}
    for at, axes in enumerate(grid.flat):
        if at >= count:
            axes.set_axis_off()
            continue
        axes.set_title(f"Threshold {centimetres(thresholds_m[at])}{also}")
        panels[thresholds_m[at]] = axes
        if at + columns >= count:
            # An incomplete last row leaves the panels above its gap at the bottom of their column.
            axes.tick_params(labelbottom=True)
    return figure, panels


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
