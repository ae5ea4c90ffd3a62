"""Road users from above."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from modelcast.core.arrays import FloatArray

__all__ = ["draw_box"]


def draw_box(
    axes: Axes,
    middle_m: FloatArray,
    turned_rad: float,
    *,
    size_m: tuple[float, float],
    colour: str,
    filled: bool,
) -> None:
    """Draw somebody as a box.

    Parameters
    ----------
    axes
        Where to, in metres.
    middle_m
        Where the middle is, (2,) [m].
    turned_rad
        Direction of its front, anticlockwise from the first axis [rad].
    size_m
        Length and width [m].
    colour
        Of its edge, and where filled of its area.
    filled
        Or outlined.
    """
    corners = 0.5 * np.array(size_m) * np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]])
    turn = np.array([[np.cos(turned_rad), -np.sin(turned_rad)], [np.sin(turned_rad), np.cos(turned_rad)]])
    axes.add_patch(
        Polygon(
            middle_m + corners @ turn.T,
            closed=True,
            facecolor=colour if filled else "none",
            edgecolor=colour,
            linewidth=0.8,
            alpha=0.6 if filled else 1.0,
        )
    )
