"""The local dynamic map: where a host believes its remotes to be, how sure it is, where they go."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from modelcast.core.arrays import FloatArray
from modelcast.report.figures.panels import empty_figure
from modelcast.report.style import COLUMN_IN, INK, POLICY_COLOURS, new_figure, style
from modelcast.station.receiver.local_dynamic_map import Beliefs

__all__ = ["plot_remotes"]

_CHI2_95 = 5.991
"""95 % point of the chi-squared distribution with two degrees of freedom."""

_AHEAD_S = 1.0
_COLOUR = POLICY_COLOURS["mbc"]
_TRUE_COLOUR = POLICY_COLOURS["baseline-matched"]


def plot_remotes(
    beliefs: Beliefs,
    *,
    host_m: tuple[float, float] | None = None,
    path_m: FloatArray | None = None,
    truth_m: FloatArray | None = None,
) -> Figure:
    """Return a map of what a host believes at one time.

    A dot is a remote, the ellipse around it holds it with a chance of 95 % by the belief's covariance, the
    line is its way in the next second, the number its temporary id.

    Parameters
    ----------
    beliefs
        As `modelcast.Station.believe` gives them; N remotes.
    host_m
        Where the host is [m].
    path_m
        Where one remote was believed to be before, (T, 2) [m].
    truth_m
        Where the remotes truly are, (N, 2), in the order of the beliefs [m].

    Raises
    ------
    ValueError
        Where there is not one true place a remote.

    Examples
    --------
    >>> import modelcast
    >>> one, other = modelcast.Station(temporary_id=1), modelcast.Station(temporary_id=2)
    >>> for message in one.sense(0.0, (0.0, 0.0), speed_mps=10.0, heading_rad=0.0):
    ...     receipts = other.hear([message.octets], received_s=[message.send_s])
    >>> len(plot_remotes(other.believe(0.5), host_m=(0.0, -20.0)).axes)
    1
    """
    count = beliefs.vehicle.size
    if truth_m is not None and truth_m.shape != (count, 2):
        raise ValueError(f"truth_m must be ({count}, 2), one place a remote, got {truth_m.shape}")
    with style():
        if not count and host_m is None:
            return empty_figure("The map holds no remote.")
        figure = new_figure(COLUMN_IN, COLUMN_IN)
        axes = figure.subplots()
        if path_m is not None:
            axes.plot(*path_m.T, "-", color=_COLOUR, linewidth=0.8, alpha=0.5, label="Believed before")
        if truth_m is not None:
            axes.plot(*truth_m.T, "x", color=_TRUE_COLOUR, markersize=6.0, label="True place")
        if count:
            _draw(axes, beliefs)
        if host_m is not None:
            axes.plot(*host_m, "s", color=INK, markersize=4.5, label="Host")
        axes.set_aspect("equal", adjustable="datalim")
        axes.margins(0.15)
        axes.set_xlabel("East [m]")
        axes.set_ylabel("North [m]")
        figure.legend(loc="outside lower center", ncols=2)
        return figure


def _draw(axes: Axes, beliefs: Beliefs) -> None:
    for row in range(beliefs.vehicle.size):
        place, ahead = beliefs.position_m[row], beliefs.velocity_mps[row] * _AHEAD_S
        axes.add_patch(_ellipse(place, beliefs.covariance_m2[row]))
        axes.plot(*np.stack([place, place + ahead]).T, "-", color=_COLOUR, linewidth=1.2)
        axes.annotate(
            str(beliefs.vehicle[row]), place, xytext=(4, 4), textcoords="offset points", fontsize=6.5
        )
    axes.plot(*beliefs.position_m.T, "o", color=_COLOUR, markersize=4.0, label="Believed, and 1 s on")


def _ellipse(place: FloatArray, covariance_m2: FloatArray) -> Ellipse:
    """Return the ellipse that holds a remote with a chance of 95 %."""
    squares, axes = np.linalg.eigh(covariance_m2)
    radii = np.sqrt(_CHI2_95 * np.maximum(squares, 0.0))
    turned = np.degrees(np.arctan2(axes[1, 1], axes[0, 1]))
    return Ellipse(
        (float(place[0]), float(place[1])),
        2.0 * float(radii[1]),
        2.0 * float(radii[0]),
        angle=float(turned),
        facecolor=_COLOUR,
        alpha=0.2,
        edgecolor=_COLOUR,
        linewidth=0.6,
    )
