"""Axes that several figures share: logarithmic with plain numbers, from zero, of densities."""

from collections.abc import Iterable, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

__all__ = ["density_scale", "end_below", "from_zero", "legend_above", "log_scale"]


def log_scale(axes: Axes) -> None:
    """Make the vertical axis logarithmic with plain numbers: the project's style reads no formulas.

    It comes before the curves, whose limits are else settled as those of a linear axis.

    Parameters
    ----------
    axes
        A panel.
    """
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.yaxis.set_minor_locator(NullLocator())


def end_below(axes: Axes, values: Sequence[float]) -> None:
    """End a logarithmic axis at half of the least value: what an interval has below runs out of it.

    Parameters
    ----------
    axes
        A panel.
    values
        What is drawn.
    """
    positive = [value for value in values if value > 0.0]
    if positive:
        axes.set_ylim(bottom=0.5 * min(positive))


def from_zero(axes: Axes) -> None:
    """Begin the vertical axis at zero, and leave room for markers at its end.

    Parameters
    ----------
    axes
        A panel.
    """
    axes.set_ylim(0.0, 1.04 * axes.get_ylim()[1])


def density_scale(axes: Axes, densities_per_km: Iterable[float]) -> None:
    """Make the horizontal axis logarithmic, with the densities as its marks.

    Parameters
    ----------
    axes
        A panel.
    densities_per_km
        Those run [1/km].
    """
    axes.set_xscale("log")
    densities = sorted(set(densities_per_km))
    axes.set_xticks(densities, [f"{density:g}" for density in densities])
    axes.xaxis.set_minor_locator(NullLocator())


def legend_above(figure: Figure, axes: Axes, columns: int = 5) -> None:
    """Put the legend of one panel above all of them.

    Parameters
    ----------
    figure
        The figure.
    axes
        The panel whose curves are named.
    columns
        At most so many names side by side.
    """
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=min(columns, max(1, len(labels))))
