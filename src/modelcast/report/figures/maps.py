"""A map of values over the shares of vehicles that send and that read models."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from modelcast.core.arrays import FloatArray

__all__ = ["draw_map"]

_DARK_RATIO = 0.55
"""Of the colour scale, from where on its text is white."""


def draw_map(axes: Axes, cells: FloatArray, senders: Sequence[float], receivers: Sequence[float]) -> None:
    """Draw a map whose cells say their values.

    Parameters
    ----------
    axes
        Where.
    cells
        Values, (R, S).
    senders, receivers
        Shares of new senders and of model receivers, 0..1, (S,) and (R,).
    """
    axes.imshow(cells, origin="lower", aspect="auto", cmap="Blues", vmin=0.0)
    axes.grid(visible=False)
    top = np.nanmax(cells)
    for (row, column), value in np.ndenumerate(cells):
        colour = "white" if value > _DARK_RATIO * top else "black"
        axes.text(column, row, f"{value:.2f}", ha="center", va="center", color=colour)
    axes.set_xticks(range(len(senders)), [f"{100.0 * one:g}" for one in senders])
    axes.set_yticks(range(len(receivers)), [f"{100.0 * one:g}" for one in receivers])
