"""The penetration map: tracking errors over the shares of vehicles that send and that read models."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelcast.core.arrays import FloatArray
from modelcast.report.figures.maps import draw_map
from modelcast.report.figures.panels import empty_figure
from modelcast.report.style import PAGE_IN, new_figure
from modelcast.study.network.rows import NetworkResult
from modelcast.study.table import Row

__all__ = ["plot_penetration"]

_ROW_IN = 2.4
_PANELS = (
    ("pte_p50_m", "PTE p50, 50-150 m [m]"),
    ("pte_p90_m", "PTE p90, 50-150 m [m]"),
    ("pte_p99_m", "PTE p99, 50-150 m [m]"),
)


def plot_penetration(result: NetworkResult) -> Figure:
    """A row of maps a radio and density: the median and two tails, means over seeds.

    Parameters
    ----------
    result
        Runs of mixed fleets.
    """
    places = list(dict.fromkeys((repr(row.density_per_km), row.radio) for row in result.penetration))
    if not places:
        return empty_figure("no share of receivers was asked for")
    figure = new_figure(PAGE_IN, 0.3 + _ROW_IN * len(places))
    grid = figure.subplots(len(places), len(_PANELS), squeeze=False)
    for line, place in zip(grid, places, strict=True):
        own = [row for row in result.penetration if (repr(row.density_per_km), row.radio) == place]
        for axes, (name, label) in zip(line, _PANELS, strict=True):
            _draw_map(axes, own, name)
            axes.set_title(label)
        density = own[0].density_per_km
        where = place[1] + (f", {density:g}/km" if np.isfinite(density) else "")
        line[0].set_ylabel(f"{where}\nread models [%]")
    for axes in grid[-1]:
        axes.set_xlabel("send by the last policy [%]")
    return figure


def _draw_map(axes: Axes, rows: Sequence[Row], name: str) -> None:
    """Draw one map; a cell says its mean over seeds."""
    senders = sorted({row.senders_ratio for row in rows})
    receivers = sorted({row.receivers_ratio for row in rows})
    values: dict[tuple[float, float], list[float]] = {}
    for row in rows:
        values.setdefault((row.receivers_ratio, row.senders_ratio), []).append(getattr(row, name))
    means = [[float(np.mean(values[r, s])) for s in senders] for r in receivers]
    cells: FloatArray = np.array(means, dtype=np.float64)
    draw_map(axes, cells, senders, receivers)
