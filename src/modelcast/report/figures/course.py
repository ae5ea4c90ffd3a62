"""The course of a trip with its manoeuvres marked by kind."""

from collections.abc import Iterable, Iterator
from itertools import groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelcast.core.arrays import FloatArray
from modelcast.report.figures.files import Drawing, drawn
from modelcast.report.figures.panels import drawable
from modelcast.report.style import FAINT, INK, PAGE_IN, new_figure, style
from modelcast.trips.manoeuvres.base import KINDS, FoundManoeuvre, ManoeuvreCounts, ManoeuvreKind
from modelcast.trips.recorder import parts
from modelcast.trips.trajectory import Trajectory

__all__ = ["KIND_COLOURS", "course_drawings", "plot_course"]

KIND_COLOURS = {
    ManoeuvreKind.LANE_CHANGE: "#0072b2",
    ManoeuvreKind.TURN: "#e69f00",
    ManoeuvreKind.U_TURN: "#cc79a7",
    ManoeuvreKind.ROUNDABOUT: "#009e73",
    ManoeuvreKind.STOP: INK,
    ManoeuvreKind.HARD_BRAKE: "#d55e00",
}
"""One colour a kind, from Okabe and Ito."""

_MARKERS = {
    ManoeuvreKind.LANE_CHANGE: "o",
    ManoeuvreKind.TURN: "^",
    ManoeuvreKind.U_TURN: "v",
    ManoeuvreKind.ROUNDABOUT: "D",
    ManoeuvreKind.STOP: "s",
    ManoeuvreKind.HARD_BRAKE: "X",
}
_MAX_HEIGHT_IN = 7.0


def plot_course(trip: Trajectory, counts: ManoeuvreCounts) -> Figure:
    """Return a map of the trip, each manoeuvre drawn over it where it was driven.

    Parameters
    ----------
    trip
        The trip.
    counts
        Its manoeuvres (`modelcast.trips.manoeuvres.rank.count_manoeuvres`).

    Raises
    ------
    ValueError
        Where the two are of different trips.
    """
    if trip.trip_id != counts.trip_id:
        raise ValueError(f"the trip is {trip.trip_id}, the manoeuvres are those of {counts.trip_id}")
    with style():
        position = trip.position_m - trip.position_m[0]
        width_m, height_m = np.maximum(np.ptp(position, axis=0), 1.0)
        height_in = float(np.clip(PAGE_IN * height_m / width_m, 2.4, _MAX_HEIGHT_IN)) + 0.9
        figure = new_figure(PAGE_IN, height_in)
        axes = figure.subplots()
        for at, part in enumerate(parts(trip)):
            axes.plot(*position[part].T, color=FAINT, linewidth=1.6, label="Course" if at == 0 else None)
        axes.plot(0.0, 0.0, ">", color=INK, markerfacecolor="white", markersize=5.0, label="Start")
        ordered = sorted(counts.manoeuvres, key=lambda one: KINDS.index(one.kind))
        for kind, found in groupby(ordered, key=lambda one: one.kind):
            _draw(axes, kind, list(found), trip, position)
        minutes = f"{counts.duration_s / 60.0:.1f} min, {counts.distance_m / 1000.0:.1f} km"
        axes.set_title(f"{drawable(trip.trip_id)}: {counts.total} manoeuvres in {minutes}", loc="left")
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_xlabel("East of the start [m]")
        axes.set_ylabel("North of the start [m]")
        figure.legend(loc="outside lower center", ncols=4)
        return figure


def course_drawings(trips: Iterable[tuple[Trajectory, ManoeuvreCounts]]) -> Iterator[Drawing]:
    """Yield the courses, drawn, named ``course_001``, ``course_002``, ... in the order given.

    Parameters
    ----------
    trips
        Trips with their manoeuvres.
    """
    for at, (trip, counts) in enumerate(trips, start=1):
        with style():
            yield drawn(f"course_{at:03d}", plot_course(trip, counts))


def _draw(
    axes: Axes,
    kind: ManoeuvreKind,
    found: Iterable[FoundManoeuvre],
    trip: Trajectory,
    position: FloatArray,
) -> None:
    """Draw the stretches of one kind, and a marker in the middle of each."""
    colour, middles = KIND_COLOURS[kind], list[FloatArray]()
    for one in found:
        first, last = np.searchsorted(trip.t_s, [one.start_s - 1e-9, one.end_s + 1e-9])
        stretch = position[first : max(last, first + 1)]
        axes.plot(*stretch.T, color=colour, linewidth=2.2, solid_capstyle="butt")
        middles.append(stretch[stretch.shape[0] // 2])
    axes.plot(
        *np.stack(middles, axis=1),
        _MARKERS[kind],
        color=colour,
        markeredgecolor="white",
        markeredgewidth=0.5,
        markersize=5.5,
        label=f"{kind.value.capitalize() if kind.value[0].islower() else kind.value} ({len(middles)})",
    )
