"""Kernels as values that add and multiply: ``Linear() + Rbf(2.0) * Periodic()``.

A kernel is a frozen value with one point-wise method; its NumPy form here is the reference that compiled code
is held to. `modelcast.models.gp.expression.KernelProcess` is the sub-model of a kernel.
"""

from modelcast.models.gp.kernels.base import AbstractKernel, Hyperparameter, Product, Sum
from modelcast.models.gp.kernels.linear import Linear
from modelcast.models.gp.kernels.matern import Matern12, Matern32, Matern52
from modelcast.models.gp.kernels.periodic import Periodic
from modelcast.models.gp.kernels.rational_quadratic import RationalQuadratic
from modelcast.models.gp.kernels.rbf import Rbf
from modelcast.models.gp.kernels.text import LEAVES, kernel_from_text

__all__ = [
    "LEAVES",
    "AbstractKernel",
    "Hyperparameter",
    "Linear",
    "Matern12",
    "Matern32",
    "Matern52",
    "Periodic",
    "Product",
    "RationalQuadratic",
    "Rbf",
    "Sum",
    "kernel_from_text",
]
