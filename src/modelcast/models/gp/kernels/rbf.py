"""Squared-exponential kernel."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models.gp.kernel_codes import RBF
from modelcast.models.gp.kernels.base import AbstractLeaf, Hyperparameter
from modelcast.models.gp.kernels.gaps import LENGTHSCALE, gap_s

__all__ = ["Rbf"]


@dataclass(frozen=True, slots=True)
class Rbf(AbstractLeaf):
    """``s²·exp(-r²/2)`` with r the gap over the lengthscale.

    Parameters
    ----------
    lengthscale_s
        Lengthscale [s].
    variance
        s² [m²].
    """

    name: ClassVar[str] = "rbf"
    code: ClassVar[int] = RBF
    shape: ClassVar[tuple[Hyperparameter, ...]] = (LENGTHSCALE,)
    lengthscale_s: float = 1.0
    variance: float = 1.0

    @staticmethod
    def correlation(t_s: FloatArray, u_s: FloatArray, *shape: FloatArray) -> FloatArray:
        """Equation (4.9) of Rasmussen and Williams 2006."""
        return np.exp(-0.5 * np.square(gap_s(t_s, u_s) / shape[0]))
