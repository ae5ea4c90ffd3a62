"""Figures of the hybrid against the error-driven baseline in traffic: load, delivery, tracking.

A colour and a marker are a policy, as in `modelcast.report.figures.senders`; the line is the threshold. What
is drawn by range is drawn of the lowest and the highest threshold, at one density.
"""

from collections.abc import Callable, Sequence
from math import isfinite, nan
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelcast.report.figures.panels import empty_figure, radio_panels
from modelcast.report.figures.scales import density_scale, end_below, from_zero, legend_above, log_scale
from modelcast.report.figures.senders import Curve, threshold_text
from modelcast.report.style import INK
from modelcast.study.network.pairs import BASELINE, HYBRID
from modelcast.study.table import Row

__all__ = [
    "TRAFFIC_FIGURES",
    "one_density",
    "plot_by_density",
    "plot_by_range",
    "plot_load",
    "plot_reception",
]

_ACROSS = "vehicles a kilometre"
_SPREAD = 0.03
_NEAR_PER_KM = 400.0
"""Where one density is drawn it is that of the runs next to this one [1/km]."""
_FARTHEST_M = 300.0
_BENEATH: dict[str, Any] = {"linewidth": 2.2, "markersize": 6.0}
"""Look of the baseline, which is drawn first: it must show where the hybrid lies on it."""

Panel = tuple[str, str, float]
"""Figure of `PAIRED`, what the axis says, factor to what it shows."""


def one_density(rows: Sequence[Row]) -> float:
    """Return the density that is drawn where there is room for one: the one nearest to 400/km.

    Traffic that has a density of its own has that one alone, NaN.

    Parameters
    ----------
    rows
        At least one.
    """
    every = {row.density_per_km for row in rows if isfinite(row.density_per_km)}
    return min(every, key=lambda density: (abs(density - _NEAR_PER_KM), density), default=nan)


def _thresholds(rows: Sequence[Row]) -> list[float]:
    return sorted({row.threshold_m for row in rows})


def _ends(rows: Sequence[Row]) -> list[float]:
    every = _thresholds(rows)
    return every if len(every) < 3 else [every[0], every[-1]]


def _radios(rows: Sequence[Row]) -> list[str]:
    return sorted({row.radio for row in rows})


def _curve(policy: str, place: int, threshold_m: float) -> Curve:
    return Curve(policy, "", threshold_m, f"{policy}, {threshold_text(threshold_m)}", place)


def _panels(radios: Sequence[str], columns: int, across: str) -> tuple[Figure, list[list[Axes]]]:
    return radio_panels(radios, columns, across=across, height_in=2.2, head_in=0.45)


def _draw(
    axes: Axes,
    rows: Sequence[Row],
    factor: float,
    thresholds_m: Sequence[float],
    place_of: Callable[[Row], float],
    *,
    spread: float = 0.0,
) -> None:
    """Draw both policies at each threshold, with their intervals."""
    count = 2 * len(thresholds_m)
    for policy in (BASELINE, HYBRID):
        for at, threshold_m in enumerate(thresholds_m):
            curve = _curve(policy, at, threshold_m)
            own = sorted((row for row in rows if row.threshold_m == threshold_m), key=place_of)
            if not own:
                continue
            name = "hybrid" if policy == HYBRID else "baseline"
            aside = 1.0 + spread * (2 * at + (policy == HYBRID) - 0.5 * (count - 1))
            place = np.array([place_of(row) for row in own]) * aside
            look = {**curve.marked, **_BENEATH} if policy == BASELINE else curve.marked
            axes.plot(place, [factor * getattr(row, name) for row in own], **look)
            bounds = [(getattr(row, f"{name}_low"), getattr(row, f"{name}_high")) for row in own]
            _bars(axes, place, bounds, factor, curve.colour)


def _bars(
    axes: Axes,
    place: np.ndarray[tuple[int], np.dtype[np.float64]],
    bounds: Sequence[tuple[float | None, float | None]],
    factor: float,
    colour: str,
) -> None:
    low, high = factor * np.array(bounds, dtype=np.float64).T
    axes.vlines(place, low, high, color=colour, linewidth=0.8)


def _drawn(rows: Sequence[Row], thresholds_m: Sequence[float]) -> list[float]:
    return [value for row in rows if row.threshold_m in thresholds_m for value in (row.hybrid, row.baseline)]


def _of_runs(rows: Sequence[Row], radio: str, figure: str) -> list[Row]:
    return [row for row in rows if (row.radio, row.figure, row.by_range) == (radio, figure, False)]


def plot_load(rows: Sequence[Row]) -> Figure:
    """Channel busy ratio, collisions and their paired difference against density.

    Parameters
    ----------
    rows
        Of one bank, as `modelcast.study.network.pairs.traffic_rows` gives them.
    """
    rows = [row for row in rows if isfinite(row.density_per_km)]
    if not rows:
        return empty_figure("no density was varied")
    radios, thresholds = _radios(rows), _thresholds(rows)
    figure, grid = _panels(radios, 3, _ACROSS)
    for line, radio in zip(grid, radios, strict=True):
        for axes, name, label in (
            (line[0], "busy_ratio", "channel busy ratio [%]"),
            (line[1], "collision_ratio", "collided, 50-150 m [%]"),
        ):
            own = _of_runs(rows, radio, name)
            density_scale(axes, (row.density_per_km for row in own))
            _draw(axes, own, 100.0, thresholds, _density, spread=_SPREAD)
            from_zero(axes)
            axes.set_ylabel(label)
        own = _of_runs(rows, radio, "collision_ratio")
        density_scale(line[2], (row.density_per_km for row in own))
        line[2].axhline(0.0, color=INK, linewidth=0.8)
        for at, threshold_m in enumerate(thresholds):
            curve = _curve(HYBRID, at, threshold_m)
            here = sorted((row for row in own if row.threshold_m == threshold_m), key=_density)
            place = np.array([row.density_per_km for row in here])
            place *= 1.0 + _SPREAD * (at - 0.5 * (len(thresholds) - 1))
            line[2].plot(place, [100.0 * row.difference for row in here], **curve.marked)
            bounds = [(row.difference_low, row.difference_high) for row in here]
            _bars(line[2], place, bounds, 100.0, curve.colour)
        line[2].set_ylabel("more collided by mbc [points]")
    legend_above(figure, grid[0][0], columns=4)
    return figure


def _density(row: Row) -> float:
    return row.density_per_km


def _distance(row: Row) -> float:
    return 0.5 * (row.low_m + row.high_m)


def _by_range(rows: Sequence[Row], panels: Sequence[Panel], *, log: bool) -> Figure:
    density = one_density(rows)
    radios, thresholds = _radios(rows), _ends(rows)
    figure, grid = _panels(radios, len(panels), "distance [m]")
    for line, radio in zip(grid, radios, strict=True):
        place = f"{density:g}/km" if isfinite(density) else "own density"
        line[0].set_title(f"{radio}, {place}", loc="left")
        for axes, (name, label, factor) in zip(line, panels, strict=True):
            own = [
                row
                for row in rows
                if (row.radio, row.figure, row.by_range) == (radio, name, True)
                and repr(row.density_per_km) == repr(density)
                and row.high_m <= _FARTHEST_M
            ]
            if log:
                log_scale(axes)
            _draw(axes, own, factor, thresholds, _distance)
            if log:
                end_below(axes, _drawn(own, thresholds))
            else:
                from_zero(axes)
            axes.set_ylabel(label)
    legend_above(figure, grid[0][0], columns=4)
    return figure


def plot_reception(rows: Sequence[Row]) -> Figure:
    """Delivery, collisions and the inter-packet gap by range, at one density.

    Parameters
    ----------
    rows
        As for `plot_load`.
    """
    panels = (
        ("delivery_ratio", "received [%]", 100.0),
        ("collision_ratio", "collided [%]", 100.0),
        ("gap_p90_s", "inter-packet gap p90 [s]", 1.0),
    )
    return _by_range(rows, panels, log=False)


_TRACKING = (("pte_p90_m", "PTE p90 [m]", 1.0), ("pte_p99_m", "PTE p99 [m]", 1.0))


def plot_by_range(rows: Sequence[Row]) -> Figure:
    """Tracking error by range, at one density.

    Parameters
    ----------
    rows
        As for `plot_load`.
    """
    return _by_range(rows, _TRACKING, log=True)


def plot_by_density(rows: Sequence[Row]) -> Figure:
    """Tracking error against density, at one range.

    Parameters
    ----------
    rows
        As for `plot_load`.
    """
    rows = [row for row in rows if isfinite(row.density_per_km)]
    if not rows:
        return empty_figure("no density was varied")
    radios, thresholds = _radios(rows), _thresholds(rows)
    figure, grid = _panels(radios, len(_TRACKING), _ACROSS)
    for line, radio in zip(grid, radios, strict=True):
        for axes, (name, label, factor) in zip(line, _TRACKING, strict=True):
            own = _of_runs(rows, radio, name)
            log_scale(axes)
            density_scale(axes, (row.density_per_km for row in own))
            _draw(axes, own, factor, thresholds, _density, spread=_SPREAD)
            end_below(axes, _drawn(own, thresholds))
            axes.set_ylabel(f"{label[:-4]}, 50-150 m [m]")
    legend_above(figure, grid[0][0], columns=4)
    return figure


TRAFFIC_FIGURES: dict[str, tuple[str, Callable[[Sequence[Row]], Figure]]] = {
    "traffic_load": (
        (
            "Load, collisions, and their difference within seeds: below zero the hybrid has fewer. "
            "Bars are 95 % intervals over seeds."
        ),
        plot_load,
    ),
    "traffic_reception": (
        "What is received by range, at one density, for the lowest and the highest threshold.",
        plot_reception,
    ),
    "traffic_range": (
        "Tracking error by range, at one density, for the lowest and the highest threshold.",
        plot_by_range,
    ),
    "traffic_density": ("Tracking error of remotes 50 m to 150 m away, by density.", plot_by_density),
}
"""Captions and figures, by the stem of their files."""
