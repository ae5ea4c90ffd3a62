"""Figures of a network evaluation: load, delivery, tracking, settling."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelcast.report.figures.panels import empty_figure, radio_panels
from modelcast.report.figures.scales import density_scale, end_below, from_zero, legend_above, log_scale
from modelcast.report.figures.senders import Curve, sender_curves
from modelcast.report.style import style
from modelcast.study.network.rows import NetworkResult
from modelcast.study.table import Row

__all__ = [
    "NETWORK_FIGURES",
    "plot_delivery",
    "plot_distance",
    "plot_load",
    "plot_settling",
    "plot_tracking",
]

_MOST_DENSITIES = 4
_SPREAD = 0.02

Panel = tuple[str, str, float]
"""Field of `RUNS`, what the axis says, factor to what it shows."""

_LOAD: tuple[Panel, ...] = (
    ("message_rate_hz", "messages a vehicle [1/s]", 1.0),
    ("bytes_per_s", "bytes a vehicle [kB/s]", 1e-3),
    ("busy_ratio", "channel busy ratio [%]", 100.0),
)
_DELIVERY: tuple[Panel, ...] = (
    ("delivery_ratio", "received, 50-150 m [%]", 100.0),
    ("hidden_ratio", "lost to hidden frames [%]", 100.0),
    ("concurrent_ratio", "lost to concurrent ones [%]", 100.0),
)
_TRACKING: tuple[Panel, ...] = (
    ("pte_p50_m", "PTE p50, 50-150 m [m]", 1.0),
    ("pte_p90_m", "PTE p90, 50-150 m [m]", 1.0),
    ("pte_p99_m", "PTE p99, 50-150 m [m]", 1.0),
)


def _radios(result: NetworkResult) -> list[str]:
    return sorted({row.radio for row in result.runs})


def _panels(
    radios: Sequence[str], columns: int, across: str, *, sharey: bool = False
) -> tuple[Figure, list[list[Axes]]]:
    return radio_panels(radios, columns, across=across, height_in=2.0, head_in=0.35, sharey=sharey)


def _against_density(result: NetworkResult, panels: Sequence[Panel], *, log: bool) -> Figure:
    """Draw a row of panels a radio, with the interval over seeds."""
    rows = [row for row in result.pooled if np.isfinite(row.density_per_km)]
    radios = sorted({row.radio for row in rows})
    if not rows:
        return empty_figure("no density was varied")
    figure, grid = _panels(radios, len(panels), "vehicles a kilometre")
    for line, radio in zip(grid, radios, strict=True):
        for axes, (name, label, factor) in zip(line, panels, strict=True):
            own = [row for row in rows if row.radio == radio and row.figure == name]
            if log:
                log_scale(axes)
            _draw_densities(axes, own, factor, sender_curves(result))
            axes.set_ylabel(label)
            if log:
                end_below(axes, [factor * row.value for row in own])
            else:
                from_zero(axes)
    legend_above(figure, grid[0][0])
    return figure


def _draw_densities(axes: Axes, rows: Sequence[Row], factor: float, curves: Sequence[Curve]) -> None:
    axes.set_xscale("log")
    for at, curve in enumerate(curves):
        own = sorted(filter(curve.drew, rows), key=lambda row: row.density_per_km)
        if not own:
            continue
        # Side by side, so that intervals do not hide each other.
        aside = 1.0 + _SPREAD * (at - 0.5 * (len(curves) - 1))
        place = np.array([row.density_per_km for row in own]) * aside
        axes.plot(place, [factor * row.value for row in own], **curve.marked)
        bounds = [(np.nan, np.nan) if row.low is None else (row.low, row.high) for row in own]
        low, high = factor * np.array(bounds, dtype=np.float64).T
        axes.vlines(place, np.maximum(low, 1e-6), high, color=curve.colour, linewidth=0.8)
    density_scale(axes, (row.density_per_km for row in rows))


@style()
def plot_load(result: NetworkResult) -> Figure:
    """Messages, bytes and channel busy ratio against density.

    Parameters
    ----------
    result
        All runs.
    """
    return _against_density(result, _LOAD, log=False)


@style()
def plot_delivery(result: NetworkResult) -> Figure:
    """Delivery and collisions against density.

    Parameters
    ----------
    result
        All runs.
    """
    return _against_density(result, _DELIVERY, log=False)


@style()
def plot_tracking(result: NetworkResult) -> Figure:
    """Tracking error at 50 m to 150 m against density.

    Parameters
    ----------
    result
        All runs.
    """
    return _against_density(result, _TRACKING, log=True)


@style()
def plot_distance(result: NetworkResult) -> Figure:
    """90th percentile of the tracking error against distance, one panel a density.

    Parameters
    ----------
    result
        All runs.
    """
    densities = _some(sorted({row.density_per_km for row in result.runs}))
    radios = _radios(result)
    figure, grid = _panels(radios, len(densities), "distance [m]", sharey=True)
    for line, radio in zip(grid, radios, strict=True):
        for axes, density in zip(line, densities, strict=True):
            here = [
                row for row in result.distances if row.radio == radio and _same(row.density_per_km, density)
            ]
            for curve in sender_curves(result):
                place, values = _mean_by_distance([row for row in here if curve.drew(row)])
                axes.plot(place, values, **curve.marked)
            log_scale(axes)
            title = f"{density:g}/km" if np.isfinite(density) else "own density"
            axes.set_title(f"{radio}, {title}", loc="left")
        line[0].set_ylabel("tracking error p90 [m]")
    legend_above(figure, grid[0][0])
    return figure


def _some(densities: list[float]) -> list[float]:
    """The densities, or some of them where there are too many for panels."""
    if len(densities) <= _MOST_DENSITIES:
        return densities
    chosen = np.linspace(0, len(densities) - 1, _MOST_DENSITIES).round().astype(int)
    return [densities[at] for at in chosen]


def _same(one: float, other: float) -> bool:
    return one == other or (np.isnan(one) and np.isnan(other))


def _mean_by_distance(rows: Sequence[Row]) -> tuple[list[float], list[float]]:
    """Middle of every bin and the mean over seeds of its 90th percentile."""
    groups: dict[float, list[float]] = {}
    for row in rows:
        if np.isfinite(row.pte_p90_m):
            groups.setdefault(0.5 * (row.low_m + row.high_m), []).append(row.pte_p90_m)
    places = sorted(groups)
    return places, [float(np.mean(groups[place])) for place in places]


_SETTLING: tuple[Panel, ...] = (
    ("message_rate_hz", "messages [1/s]", 1.0),
    ("busy_ratio", "CBR [%]", 100.0),
    ("inter_transmit_time_s", "MaxITT [s]", 1.0),
    ("pte_p90_m", "PTE p90 [m]", 1.0),
)


@style()
def plot_settling(result: NetworkResult) -> Figure:
    """How the loop settles: the first seed at the highest density, second by second.

    Parameters
    ----------
    result
        All runs.
    """
    radios = _radios(result)
    highest = max(
        (row.density_per_km for row in result.runs), key=lambda density: (np.isfinite(density), density)
    )
    figure, grid = _panels(radios, len(_SETTLING), "time [s]")
    for line, radio in zip(grid, radios, strict=True):
        here = [
            row
            for row in result.seconds
            if (row.radio, row.run) == (radio, 0) and _same(row.density_per_km, highest)
        ]
        log_scale(line[-1])
        for axes, (name, label, factor) in zip(line, _SETTLING, strict=True):
            for curve in sender_curves(result):
                own = [row for row in here if curve.drew(row)]
                axes.plot(
                    [row.t_s for row in own], [factor * getattr(row, name) for row in own], **curve.plain
                )
            axes.set_ylabel(label)
        for axes in line[:-1]:
            from_zero(axes)
    legend_above(figure, grid[0][0])
    return figure


NETWORK_FIGURES: dict[str, tuple[str, Callable[[NetworkResult], Figure]]] = {
    "load": ("Load against density. Bars are 95 % intervals over seeds.", plot_load),
    "delivery": (
        "What became of frames at vehicles 50 m to 150 m away; the rest was too weak or met a sender.",
        plot_delivery,
    ),
    "tracking_density": ("Tracking error of all live tracks 50 m to 150 m away.", plot_tracking),
    "tracking_distance": ("Tracking error against distance, mean over seeds.", plot_distance),
    "settling": ("How the loop settles at the highest density, first seed, warm-up included.", plot_settling),
}
"""Captions and figures in the order of the report, by the stem of their files."""
