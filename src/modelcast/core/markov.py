"""A first-order Markov chain of a few states."""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray

__all__ = ["MarkovChain"]

_SUM_SLACK = 1e-3
"""Printed chances are rounded; rows are scaled to a sum of 1."""


@dataclass(frozen=True, slots=True)
class MarkovChain:
    """Chances of the next state by the last one.

    Parameters
    ----------
    steps
        A row for each state, (K, K): the chance of each next state.

    Raises
    ------
    ValueError
        Where it is not square, or a row is not chances that add up to 1 within a thousandth.

    Examples
    --------
    >>> MarkovChain(((0.9, 0.1), (0.3, 0.7))).stationary.round(3).tolist()
    [0.75, 0.25]
    """

    steps: tuple[tuple[float, ...], ...]

    def __post_init__(self) -> None:
        states = len(self.steps)
        if states == 0 or any(len(row) != states for row in self.steps):
            raise ValueError(f"steps must be square, got rows of {[len(row) for row in self.steps]}")
        for row in self.steps:
            if not (min(row) >= 0.0 and abs(sum(row) - 1.0) <= _SUM_SLACK):
                raise ValueError(f"each row of steps must be chances that add up to 1, got {row}")

    @property
    def matrix(self) -> FloatArray:
        """Chances, rows of sum 1, (K, K)."""
        given = np.array(self.steps, dtype=np.float64)
        return given / given.sum(axis=1, keepdims=True)

    @property
    def stationary(self) -> FloatArray:
        """Chance of each state in the long run, (K,)."""
        matrix = self.matrix
        states = len(matrix)
        conditions = np.vstack([matrix.T - np.eye(states), np.ones(states)])
        found = np.linalg.lstsq(conditions, np.append(np.zeros(states), 1.0), rcond=None)[0]
        return np.asarray(found, dtype=np.float64)

    def up_to(self) -> FloatArray:
        """Cumulative chances by the last state, (K + 1, K); the last row is of the first state."""
        rows = np.vstack([self.matrix, self.stationary])
        return np.ascontiguousarray(np.cumsum(rows, axis=1))
