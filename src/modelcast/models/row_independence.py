"""Whether the rows of a batch stand alone: a function of many rows says of each what it says of it alone."""

from collections.abc import Callable

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.models.base import Windows

__all__ = ["ROWS", "made_up_windows", "rows_stand_alone"]

ROWS = 67
"""Rows that are looked at: more than any vector unit takes at once, and no multiple of what one takes."""


def rows_stand_alone(function: Callable[[IntArray], FloatArray], rows: int = ROWS) -> bool:
    """Whether a function gives the same bits for a row, whichever others stand beside it and in what order.

    Parameters
    ----------
    function
        From indices of rows, (n,), to what it says of these, (n, ...).
    rows
        How many rows there are.

    Examples
    --------
    >>> values = np.arange(5.0)
    >>> rows_stand_alone(lambda chosen: values[chosen] ** 2, 5)
    True
    >>> rows_stand_alone(lambda chosen: values[chosen] - values[chosen].mean(), 5)
    False
    """
    whole = np.arange(rows)
    together = function(whole)
    shuffled = np.random.default_rng(0).permutation(rows)
    groups = (shuffled, shuffled[: rows // 2], *whole[:, None])
    return all(np.array_equal(function(chosen), together[chosen]) for chosen in groups)


def made_up_windows(samples: int, *, dt_s: float, rows: int = ROWS) -> Windows:
    """Vehicles that turn and brake, in the same way each time; the first stands still.

    Parameters
    ----------
    samples
        Window length.
    dt_s
        Sampling interval [s].
    rows
        How many.

    Examples
    --------
    >>> made_up_windows(5, dt_s=0.1).samples.shape
    (67, 5, 9)
    """
    rng = np.random.default_rng(1)
    t = np.arange(1 - samples, 1) * dt_s
    speed, heading, along, turn = (
        rng.uniform(low, high, (rows, 1))
        for low, high in ((0.0, 40.0), (-np.pi, np.pi), (-3.0, 3.0), (-0.4, 0.4))
    )
    speed[0] = along[0] = turn[0] = 0.0
    speeds, headings = np.maximum(speed + along * t, 0.0), heading + turn * t
    velocity = speeds[..., None] * np.stack([np.sin(headings), np.cos(headings)], axis=-1)
    position = rng.uniform(-1e3, 1e3, (rows, 1, 2)) + np.cumsum(velocity, axis=1) * dt_s
    rest = [np.broadcast_to(one, speeds.shape) for one in (along, turn, np.full((rows, 1), 0.01))]
    return Windows(np.concatenate([position, velocity, np.stack(rest, axis=-1)], axis=-1), dt_s=dt_s)
