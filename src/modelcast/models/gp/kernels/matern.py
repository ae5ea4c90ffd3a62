"""Matérn kernels of smoothness 1/2, 3/2 and 5/2: equations (4.17) of Rasmussen and Williams 2006."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models.gp.kernel_codes import MATERN12, MATERN32, MATERN52
from modelcast.models.gp.kernels.base import AbstractLeaf, Hyperparameter
from modelcast.models.gp.kernels.gaps import LENGTHSCALE, gap_s

__all__ = ["Matern12", "Matern32", "Matern52"]


@dataclass(frozen=True, slots=True)
class Matern12(AbstractLeaf):
    """``s²·exp(-r)`` with r the gap over the lengthscale: continuous, nowhere smooth.

    Parameters
    ----------
    lengthscale_s
        Lengthscale [s].
    variance
        s² [m²].
    """

    name: ClassVar[str] = "matern12"
    code: ClassVar[int] = MATERN12
    shape: ClassVar[tuple[Hyperparameter, ...]] = (LENGTHSCALE,)
    lengthscale_s: float = 1.0
    variance: float = 1.0

    @staticmethod
    def correlation(t_s: FloatArray, u_s: FloatArray, *shape: FloatArray) -> FloatArray:
        """Exponential of the scaled gap."""
        return np.exp(-gap_s(t_s, u_s) / shape[0])


@dataclass(frozen=True, slots=True)
class Matern32(AbstractLeaf):
    """``s²·(1 + q)·exp(-q)`` with q = sqrt(3)·r: it has a velocity.

    Parameters
    ----------
    lengthscale_s
        Lengthscale [s].
    variance
        s² [m²].
    """

    name: ClassVar[str] = "matern32"
    code: ClassVar[int] = MATERN32
    shape: ClassVar[tuple[Hyperparameter, ...]] = (LENGTHSCALE,)
    lengthscale_s: float = 1.0
    variance: float = 1.0

    @staticmethod
    def correlation(t_s: FloatArray, u_s: FloatArray, *shape: FloatArray) -> FloatArray:
        """Polynomial of degree 1 times exponential."""
        q = np.sqrt(3.0) * gap_s(t_s, u_s) / shape[0]
        return (1.0 + q) * np.exp(-q)


@dataclass(frozen=True, slots=True)
class Matern52(AbstractLeaf):
    """``s²·(1 + q + q²/3)·exp(-q)`` with q = sqrt(5)·r: it has an acceleration.

    Parameters
    ----------
    lengthscale_s
        Lengthscale [s].
    variance
        s² [m²].
    """

    name: ClassVar[str] = "matern52"
    code: ClassVar[int] = MATERN52
    shape: ClassVar[tuple[Hyperparameter, ...]] = (LENGTHSCALE,)
    lengthscale_s: float = 1.0
    variance: float = 1.0

    @staticmethod
    def correlation(t_s: FloatArray, u_s: FloatArray, *shape: FloatArray) -> FloatArray:
        """Polynomial of degree 2 times exponential."""
        q = np.sqrt(5.0) * gap_s(t_s, u_s) / shape[0]
        return (1.0 + q + np.square(q) / 3.0) * np.exp(-q)
