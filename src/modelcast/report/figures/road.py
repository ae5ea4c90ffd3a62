"""The roads of a road file as a map, coloured by how much they turn."""

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import Origin, geodetic_to_local
from modelcast.report.style import PAGE_IN, new_figure, style
from modelcast.station.context.road_kernels import CELL_M
from modelcast.station.context.survey import RoadSurvey

__all__ = ["plot_roads"]

_MAX_HEIGHT_IN = 7.0
_SHARPEST_PER_KM = 20.0
"""Curvature at the end of the colours: a radius of 50 m [1/km]."""


def plot_roads(survey: RoadSurvey) -> Figure:
    """Return a map of all passes, coloured by curvature.

    Parameters
    ----------
    survey
        The roads; at least one cell.

    Raises
    ------
    ValueError
        Where there is none.
    """
    if not len(survey):
        raise ValueError("there are no roads to draw")
    with style():
        position = _on_plane(survey)
        width_m, height_m = np.maximum(np.ptp(position, axis=0), 1.0)
        height_in = float(np.clip(PAGE_IN * height_m / width_m, 2.4, _MAX_HEIGHT_IN)) + 0.9
        figure = new_figure(PAGE_IN, height_in)
        axes = figure.subplots()
        joined = np.flatnonzero(np.diff(survey.passes) == 0)
        turn_per_km = np.diff(survey.heading_rad)[joined] * 1e3 / CELL_M
        lines = LineCollection(
            list(np.stack([position[joined], position[joined + 1]], axis=1)),
            array=turn_per_km,
            cmap="coolwarm",
            clim=(-_SHARPEST_PER_KM, _SHARPEST_PER_KM),
            linewidths=1.6,
            capstyle="round",
        )
        axes.add_collection(lines)
        axes.autoscale_view()
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_title(
            f"{survey.length_m / 1e3:.1f} km in {np.unique(survey.passes).size} passes of "
            f"{len(survey.fingerprints)} trips",
            loc="left",
        )
        axes.set_xlabel("East [m]")
        axes.set_ylabel("North [m]")
        bar = figure.colorbar(lines, ax=axes, shrink=0.8, extend="both")
        bar.set_label("Curvature, clockwise [1/km]")
        return figure


def _on_plane(survey: RoadSurvey) -> FloatArray:
    """East and north of all cells, about the first where places are on Earth, (K, 2) [m]."""
    if not survey.geodetic:
        return survey.places - survey.places[0]
    latitude_deg, longitude_deg = survey.places[0].tolist()
    return geodetic_to_local(survey.places, Origin(latitude_deg, longitude_deg))
