"""The equally spaced times of a window, on which everything about a kernel depends."""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray

__all__ = ["WINDOW_BOUNDS", "TimeGrid", "check_window"]

WINDOW_BOUNDS = (3, 60)
"""Samples a window may hold: a line and a curvature need 3, the tables stay under 10 MB to 60."""


def check_window(samples: int) -> None:
    """Raise ``ValueError`` unless a window of this many samples is supported.

    Parameters
    ----------
    samples
        Window length n.
    """
    low, high = WINDOW_BOUNDS
    if not low <= samples <= high:
        raise ValueError(f"a window must hold {low} to {high} samples, got {samples}")


@dataclass(frozen=True, slots=True)
class TimeGrid:
    """Times of a window's samples.

    Parameters
    ----------
    samples
        Window length n.
    dt_s
        Sampling interval [s].

    Examples
    --------
    >>> TimeGrid(4, 0.5).times_s
    array([-1.5, -1. , -0.5,  0. ])
    >>> TimeGrid(4, 0.5).half_steps
    array([0.5, 1.5])
    """

    samples: int
    dt_s: float

    @property
    def times_s(self) -> FloatArray:
        """From the first sample to the last, which is at 0, (n,) [s]."""
        return (np.arange(self.samples, dtype=np.float64) - (self.samples - 1)) * self.dt_s

    @property
    def half_steps(self) -> FloatArray:
        """From the window's middle to its end in sampling intervals, ((n + 1) // 2,)."""
        return np.arange((self.samples + 1) // 2, dtype=np.float64) + (0.0 if self.samples % 2 else 0.5)
