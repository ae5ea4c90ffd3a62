"""Periodic kernel."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models.gp.kernel_codes import PERIODIC
from modelcast.models.gp.kernels.base import AbstractLeaf, Hyperparameter
from modelcast.models.gp.kernels.gaps import gap_s

__all__ = ["Periodic"]

_PERIOD = Hyperparameter("period_s", 0.5, 10.0)
_WIDTH = Hyperparameter("width", 0.1, 10.0)


@dataclass(frozen=True, slots=True)
class Periodic(AbstractLeaf):
    """``s²·exp(-2·sin²(pi·gap/period)/w²)``.

    Parameters
    ----------
    period_s
        Period [s].
    width
        w, a lengthscale on the circle.
    variance
        s² [m²].
    """

    name: ClassVar[str] = "periodic"
    code: ClassVar[int] = PERIODIC
    shape: ClassVar[tuple[Hyperparameter, ...]] = (_PERIOD, _WIDTH)
    period_s: float = 1.0
    width: float = 1.0
    variance: float = 1.0

    @staticmethod
    def correlation(t_s: FloatArray, u_s: FloatArray, *shape: FloatArray) -> FloatArray:
        """Equation (4.31) of Rasmussen and Williams 2006."""
        period_s, width = shape
        return np.exp(-2.0 * np.square(np.sin(np.pi * gap_s(t_s, u_s) / period_s) / width))
