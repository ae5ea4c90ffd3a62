"""Rational quadratic kernel: RBF kernels of many lengthscales in one."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models.gp.kernel_codes import RATIONAL_QUADRATIC
from modelcast.models.gp.kernels.base import AbstractLeaf, Hyperparameter
from modelcast.models.gp.kernels.gaps import LENGTHSCALE, gap_s

__all__ = ["RationalQuadratic"]

_EXPONENT = Hyperparameter("exponent", 0.1, 10.0)


@dataclass(frozen=True, slots=True)
class RationalQuadratic(AbstractLeaf):
    """``s²·(1 + r²/(2·a))^-a`` with r the gap over the lengthscale; an RBF kernel where a is large.

    Parameters
    ----------
    lengthscale_s
        Lengthscale [s].
    exponent
        a.
    variance
        s² [m²].
    """

    name: ClassVar[str] = "rq"
    code: ClassVar[int] = RATIONAL_QUADRATIC
    shape: ClassVar[tuple[Hyperparameter, ...]] = (LENGTHSCALE, _EXPONENT)
    lengthscale_s: float = 1.0
    exponent: float = 1.0
    variance: float = 1.0

    @staticmethod
    def correlation(t_s: FloatArray, u_s: FloatArray, *shape: FloatArray) -> FloatArray:
        """Equation (4.19) of Rasmussen and Williams 2006."""
        lengthscale_s, exponent = shape
        return (1.0 + np.square(gap_s(t_s, u_s) / lengthscale_s) / (2.0 * exponent)) ** -exponent
