"""Exact moments of a Markov jump linear system, and of what acceleration and yaw rate add up to.

With ``y = (1, x, I, D)``, where I is the integral of ``x = (acceleration, yaw rate)`` and D that of I, and x
linear between steps, each mode maps y linearly: ``y' = F_j y + G w``. The second moments
``S_j = E[y yᵀ, mode = j]`` then follow exactly, without a path being drawn or left out:
``S_j' = F_j (Σ_i P_ij S_i) F_jᵀ + p_j' G Q_j Gᵀ``; the first moments stand in the row of the constant 1.

References
----------
O. L. V. Costa, M. D. Fragoso, R. P. Marques, "Discrete-Time Markov Jump Linear Systems", Springer, 2005,
chapter 3. https://doi.org/10.1007/b138575
"""

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models.switching.mode import ModeArrays

__all__ = ["SIZE", "mean_tables", "second_moments", "stationary"]

SIZE = 7
"""Of y: the constant, then acceleration and yaw rate, their integrals, and the integrals of those."""


def stationary(chain: FloatArray) -> FloatArray:
    """Share of time a chain spends in each mode, (M,); of several such, the mean over where it starts.

    Parameters
    ----------
    chain
        (M, M), from row to column.
    """
    lazy = 0.5 * (chain + np.eye(len(chain)))  # the same shares, and no chain that alternates for ever
    return np.linalg.matrix_power(lazy, 1 << 20).mean(axis=0)


def mean_tables(modes: ModeArrays, steps: int) -> FloatArray:
    """Mean acceleration and yaw rate after 0 to ``steps`` steps, by the mode it starts in, (K + 1, M, 2, 3).

    Parameters
    ----------
    modes
        M of them, over one step.
    steps
        K.

    Notes
    -----
    The mean is linear in the start: row r of a table times (1, acceleration, yaw rate).
    """
    count = len(modes.chain)
    affine = np.zeros((count, 3, 3))
    affine[:, 0, 0] = 1.0
    affine[:, 1:, 0], affine[:, 1:, 1:] = modes.offset, modes.dynamics
    held = np.zeros((count, count, 3, 3))  # by first mode and present one
    held[np.arange(count), np.arange(count)] = np.eye(3)
    out = np.empty((steps + 1, count, 2, 3))
    for step in range(steps + 1):
        out[step] = held.sum(axis=1)[:, 1:]
        mixed = np.einsum("ij,biuv->bjuv", modes.chain, held)
        held = np.einsum("juv,bjvw->bjuw", affine, mixed)
    return out


def second_moments(
    modes: ModeArrays, belief: FloatArray, start: FloatArray, *, steps: int, step_s: float
) -> FloatArray:
    """Moments ``E[y yᵀ]`` after 0 to ``steps`` steps, (B, K + 1, SIZE, SIZE).

    Parameters
    ----------
    modes
        M of them, over one step.
    belief
        Chance of each mode at the start, (B, M).
    start
        Acceleration and yaw rate there, (B, 2).
    steps, step_s
        K, and how long a step lasts [s].
    """
    linear, noise = _augmented(modes, step_s)
    first = np.zeros((len(start), SIZE))
    first[:, 0], first[:, 1:3] = 1.0, start
    held = belief[:, :, None, None] * (first[:, None, :, None] * first[:, None, None, :])
    out = np.empty((len(start), steps + 1, SIZE, SIZE))
    for step in range(steps + 1):
        out[:, step] = held.sum(axis=1)
        mixed = np.einsum("ij,biuv->bjuv", modes.chain, held)
        held = linear @ mixed @ np.swapaxes(linear, 1, 2) + mixed[:, :, :1, :1] * noise
    return out


def _augmented(modes: ModeArrays, step_s: float) -> tuple[FloatArray, FloatArray]:
    """Matrix F of y and covariance G Q Gᵀ of each mode, (M, SIZE, SIZE) both."""
    count = len(modes.chain)
    now, integral, twice = slice(1, 3), slice(3, 5), slice(5, 7)
    late, later = 0.5 * step_s, step_s * step_s / 6.0  # shares of the new x in I and in D
    linear = np.zeros((count, SIZE, SIZE))
    linear[:, 0, 0] = 1.0
    linear[:, now, 0], linear[:, now, now] = modes.offset, modes.dynamics
    unit = np.eye(2)
    linear[:, integral, 0] = late * modes.offset
    linear[:, integral, now] = late * (unit + modes.dynamics)
    linear[:, integral, integral] = unit
    linear[:, twice, 0] = later * modes.offset
    linear[:, twice, now] = later * (2.0 * unit + modes.dynamics)
    linear[:, twice, integral] = step_s * unit
    linear[:, twice, twice] = unit
    spread = np.zeros((SIZE, 2))
    spread[now], spread[integral], spread[twice] = unit, late * unit, later * unit
    return linear, spread @ modes.covariance @ spread.T
