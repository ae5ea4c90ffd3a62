"""What stationary kernels share: the gap between two times, and a lengthscale."""

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models.gp.kernels.base import Hyperparameter
from modelcast.models.gp.tables import LENGTHSCALE_BOUNDS_S

__all__ = ["LENGTHSCALE", "gap_s"]

LENGTHSCALE = Hyperparameter("lengthscale_s", *LENGTHSCALE_BOUNDS_S)
"""A lengthscale, with the bounds that all Gaussian processes here have."""


def gap_s(t_s: FloatArray, u_s: FloatArray) -> FloatArray:
    """Return the gap between two times, which are broadcast [s].

    Parameters
    ----------
    t_s, u_s
        Times [s].
    """
    return np.abs(t_s - u_s)
