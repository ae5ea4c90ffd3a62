"""A meeting as a film strip: a crossing from above at six instants, a row of pictures for each run."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from modelcast.apps.motions import WIDTH_M
from modelcast.channel.propagation import StreetGrid
from modelcast.core.arrays import FloatArray
from modelcast.report.figures.boxes import draw_box
from modelcast.report.figures.panels import drawable
from modelcast.report.style import INK, PAGE_IN, new_figure
from modelcast.study.network.meeting import Meeting, Seen

__all__ = ["FRAMES_S", "at_instants", "plot_meeting"]

FRAMES_S = (-6.0, -4.0, -3.0, -2.0, -1.0, 0.0)
"""Instants of the pictures, from where both are nearest [s]."""

_BELIEVED, _PERSON, _BUILDING = "#0072b2", "#d55e00", "#e4e0d8"
_LARGER = 2.0
"""A person is drawn this much larger than life, to be seen."""

_ROW_IN = 1.3


def at_instants(seen: Seen) -> list[int]:
    """Rows of a run at the instants of the pictures.

    Parameters
    ----------
    seen
        The run.
    """
    return [int(np.argmin(np.abs(seen.t_s - wanted_s))) for wanted_s in FRAMES_S]


def plot_meeting(meeting: Meeting, runs: Mapping[str, Seen], streets: StreetGrid) -> Figure:
    """Return the film strip; north is up.

    Parameters
    ----------
    meeting
        Who meets.
    runs
        What is believed, by the words of each run, at least one.
    streets
        Where buildings are.
    """
    figure = new_figure(PAGE_IN, 0.7 + _ROW_IN * len(runs))
    panels = figure.subplots(len(runs), len(FRAMES_S), sharex=True, sharey=True, squeeze=False)
    window = _window(next(iter(runs.values())), streets)
    for row, (words, seen) in zip(panels, runs.items(), strict=True):
        for axes, at in zip(row, at_instants(seen), strict=True):
            _draw(axes, seen, at, streets, window)
        row[0].set_ylabel(drawable(words, 30))
    for axes, at in zip(panels[0], at_instants(next(iter(runs.values()))), strict=True):
        seen = next(iter(runs.values()))
        axes.set_title(f"{seen.t_s[at]:+.0f} s, {'in sight' if seen.in_sight[at] else 'hidden'}", fontsize=7)
    figure.supxlabel(
        f"grey: buildings; black: the vehicle; orange: the {meeting.kind.name.lower().replace('_', ' ')}, "
        f"{_LARGER:g} times as large; ring: where the vehicle believes it, and how old that is; "
        f"{2.0 * window[1]:.0f} m a side",
        fontsize=6.5,
    )
    return figure


def _window(seen: Seen, streets: StreetGrid) -> tuple[FloatArray, float]:
    """Middle and half side of the pictures: the crossing, and all of both ways [m]."""
    rows = at_instants(seen)
    middle_m = np.round(seen.person[rows[-1], :2] / streets.block_m) * streets.block_m
    places_m = np.concatenate([seen.vehicle[rows, :2], seen.person[rows, :2]]) - middle_m
    return middle_m, min(float(np.abs(places_m).max()) + 12.0, 0.5 * streets.block_m)


def _draw(axes: Axes, seen: Seen, at: int, streets: StreetGrid, window: tuple[FloatArray, float]) -> None:
    """Draw one instant in a window, given by its middle and half side."""
    middle_m, half_m = window
    street_m = 0.5 * streets.street_m
    for east, north in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        corner = np.array([east, north]) * street_m
        far = np.array([east, north]) * half_m
        low, size = np.minimum(corner, far), np.abs(far - corner)
        axes.add_patch(
            Rectangle((float(low[0]), float(low[1])), size[0], size[1], facecolor=_BUILDING, edgecolor="none")
        )
    for place, size_m, colour in (
        (seen.vehicle[at], _known(seen.sizes_m[0]), INK),
        (seen.person[at], _known(_LARGER * seen.sizes_m[1]), _PERSON),
    ):
        turned_rad = 0.5 * np.pi - place[2]
        draw_box(axes, place[:2] - middle_m, turned_rad, size_m=size_m, colour=colour, filled=True)
    if np.isfinite(seen.believed[at, 0]):
        believed = seen.believed[at] - middle_m
        axes.plot(*believed, "o", markersize=6, markerfacecolor="none", markeredgecolor=_BELIEVED)
        told = f"{seen.age_s[at]:.1f} s old, {seen.error_m[at]:.1f} m off"
    else:
        told = "not known"
    axes.text(0.03, 0.03, told, transform=axes.transAxes, fontsize=5.5, color=_BELIEVED)
    axes.set_xlim(-half_m, half_m)
    axes.set_ylim(-half_m, half_m)
    axes.set_aspect("equal")
    axes.set_xticks([])
    axes.set_yticks([])
    axes.grid(visible=False)
    for side in axes.spines.values():
        side.set_visible(False)


def _known(size_m: FloatArray) -> tuple[float, float]:
    """Length and width, a car's where a width is not said [m]."""
    return float(size_m[0]), float(size_m[1]) if np.isfinite(size_m[1]) else WIDTH_M
