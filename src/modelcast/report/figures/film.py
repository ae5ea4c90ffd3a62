"""One warning as a film strip: the road from above at five instants, and the margin over time."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelcast.apps.motions import LENGTH_M, WIDTH_M
from modelcast.core.arrays import FloatArray
from modelcast.report.figures.boxes import draw_box
from modelcast.report.figures.panels import drawable
from modelcast.report.style import INK, PAGE_IN, model_colours, new_figure
from modelcast.study.safety.film import EventFilm

__all__ = ["plot_film"]

_FRAMES_S = (-2.0, -0.5, 0.0, 0.5, 1.5)
_AROUND_M, _BESIDE_M = 6.0, 4.5
_CAR_M = (LENGTH_M, WIDTH_M)
_GAP_S = 0.25
_HEIGHT_IN = 5.2


def plot_film(film: EventFilm) -> Figure:
    """Return the film strip: the host at the left of each picture, driving right; below, margins over time.

    Parameters
    ----------
    film
        One true warning.
    """
    names = [one.candidate for one in film.believers]
    colours = model_colours(names)
    figure = new_figure(PAGE_IN, _HEIGHT_IN)
    rows = figure.add_gridspec(3, 1, height_ratios=(1.5, 1.7, 0.5))
    strip = rows[0].subgridspec(len(_FRAMES_S), 1)
    longest_m = 0.0
    pictures: list[Axes] = []
    for number, wanted_s in enumerate(_FRAMES_S):
        at = int(np.argmin(np.abs(film.t_s - wanted_s)))
        axes = figure.add_subplot(strip[number])
        longest_m = max(longest_m, _draw_frame(axes, film, at, colours))
        axes.set_ylabel(f"{film.t_s[at]:+.1f} s", rotation=0, ha="right", va="center")
        pictures.append(axes)
    for axes in pictures:
        axes.set_xlim(-_AROUND_M, longest_m + _AROUND_M)
        axes.set_ylim(-_BESIDE_M, _BESIDE_M)
        axes.set_yticks([])
        axes.set_xticks([])
        axes.grid(visible=False)
    pictures[-1].set_xticks(np.arange(0.0, longest_m + 10.0, 10.0))
    pictures[-1].set_xlabel("Ahead of the host [m]; filled: the leader, outlined: where it is believed")
    _draw_margins(figure.add_subplot(rows[1]), film, colours)
    _draw_messages(figure.add_subplot(rows[2]), film, colours)
    pictures[0].set_title(
        f"{drawable(film.follower, 40)} behind {drawable(film.leader, 40)}: "
        f"{100 * film.packet_error_ratio:.4g} % lost, equal {film.basis}, sensor {drawable(film.sensor, 20)}"
    )
    return figure


def _ahead(film: EventFilm, at: int, place_m: FloatArray) -> FloatArray:
    """A place as the host sees it: ahead and to the left, (2,) [m]."""
    course = film.host.heading_rad[at]
    east, north = place_m - film.host.position_m[at]
    return np.array(
        [east * np.sin(course) + north * np.cos(course), north * np.sin(course) - east * np.cos(course)]
    )


def _draw_frame(axes: Axes, film: EventFilm, at: int, colours: dict[str, str]) -> float:
    """Draw one instant from above; returns how far ahead the farthest vehicle is [m]."""
    course = film.host.heading_rad[at]
    draw_box(axes, np.zeros(2), 0.0, size_m=_CAR_M, colour="#cc3311" if film.warned[at] else INK, filled=True)
    leader = _ahead(film, at, film.leader_motion.position_m[at])
    turned_rad = course - film.leader_motion.heading_rad[at]
    draw_box(axes, leader, turned_rad, size_m=_CAR_M, colour="#777777", filled=True)
    farthest = float(leader[0])
    for one in film.believers:
        if np.isnan(one.motion[at, 0]):
            continue
        middle = _ahead(film, at, one.motion[at, :2])
        farthest = max(farthest, float(middle[0]))
        turned_rad = course - one.motion[at, 5]
        draw_box(axes, middle, turned_rad, size_m=_CAR_M, colour=colours[one.candidate], filled=False)
    return farthest


def _draw_margins(axes: Axes, film: EventFilm, colours: dict[str, str]) -> None:
    gaps = np.flatnonzero(np.diff(film.t_s) > _GAP_S) + 1
    t_s = np.insert(film.t_s, gaps, np.nan)

    def whole(margin_m: FloatArray) -> FloatArray:
        """Margins with a break where the recording has a gap."""
        return np.insert(margin_m, gaps, np.nan)

    axes.plot(t_s, whole(film.margin_m), color=INK, linewidth=1.6, label="perfect knowledge")
    for one in film.believers:
        axes.plot(t_s, whole(one.margin_m), color=colours[one.candidate], label=drawable(one.candidate, 30))
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.set_xlim(film.t_s[0], film.t_s[-1])
    axes.set_ylabel("Margin [m]\nwarned below 0")
    axes.tick_params(labelbottom=False)
    axes.legend(ncols=4, loc="lower left")


def _draw_messages(axes: Axes, film: EventFilm, colours: dict[str, str]) -> None:
    for number, one in enumerate(film.believers):
        for shown, marker in ((one.sent & ~one.lost, "|"), (one.lost, "x")):
            axes.plot(
                film.t_s[shown], np.full(int(shown.sum()), -number), marker, color=colours[one.candidate],
                markersize=5,
            )  # fmt: skip
    axes.set_yticks(
        [-number for number in range(len(film.believers))],
        [drawable(one.candidate, 20) for one in film.believers],
    )
    axes.set_ylim(-len(film.believers) + 0.4, 0.6)
    axes.set_xlim(film.t_s[0], film.t_s[-1])
    axes.grid(visible=False, axis="y")
    axes.set_xlabel("Time from where perfect knowledge warns [s]; bars: messages received, crosses: lost")
