"""Kernels of modelcast as scikit-learn's, with the same bounds; and predictions in extended precision."""

from collections.abc import Callable
from functools import reduce
from operator import add, mul
from typing import Any

import numpy as np
import numpy.typing as npt
from sklearn.gaussian_process import kernels as peers

from modelcast.models.gp.kernels import AbstractKernel, Product, Sum, kernel_from_text

__all__ = ["extended_prediction", "peer_of"]

Array = npt.NDArray[np.float64]

MATERN: dict[str, float] = {"matern12": 0.5, "matern32": 1.5, "matern52": 2.5}


def peer_of(expression: str, values: Array | None = None, *, noise_bounds_m2: Any = "fixed") -> Any:
    """Return scikit-learn's kernel with white noise.

    Parameters
    ----------
    expression
        The kernel.
    values
        Hyper-parameters, then the white noise's variance, (P,); where None, 1 each, a linear part of 100 and
        a noise of 1e-3, from which a fit starts.
    noise_bounds_m2
        Bounds of the white noise's variance; ``fixed``: nothing is fitted.
    """
    kernel = kernel_from_text(expression)
    names = [one.name for one in kernel.hyperparameters]
    if values is None:
        linear = [name.startswith("linear") and name.endswith("variance_m2") for name in names]
        values = np.where([*linear, False], 100.0, 1.0)
        values[-1] = 1e-3
    fitted = noise_bounds_m2 != "fixed"
    bounds = iter([(one.low, one.high) if fitted else "fixed" for one in kernel.hyperparameters])
    leaves = iter([(place.free, place.leaf) for place in kernel.with_values(list(values[:-1])).places()])
    tree = _converted(kernel, lambda: _leaf(*next(leaves), bounds))
    return tree + peers.WhiteKernel(values[-1], noise_bounds_m2)


def extended_prediction(expression: str, y: Array, values: Array, dt_s: float, horizons_s: Array) -> Array:
    """Return predictions by dense algebra in extended precision, (B, H).

    Parameters
    ----------
    expression
        The kernel.
    y
        Windows of one axis less their last sample, (B, n) [m].
    values
        Hyper-parameters, then the white noise's variance, (B, P).
    dt_s
        Sampling interval [s].
    horizons_s
        Times after the last sample, (H,) [s].
    """
    kernel = kernel_from_text(expression)
    count, n = y.shape
    t = (np.arange(n, dtype=np.longdouble) - n + 1) * np.longdouble(dt_s)
    long = values.astype(np.longdouble)[:, None, None]
    covariance = kernel.at(long[..., :-1], t[:, None], t) + long[..., -1] * np.eye(n)
    lower = np.zeros_like(covariance)
    z = y.astype(np.longdouble)
    for i in range(n):
        for j in range(i + 1):
            rest = covariance[:, i, j] - (lower[:, i, :j] * lower[:, j, :j]).sum(axis=1)
            lower[:, i, j] = np.sqrt(rest) if i == j else rest / lower[:, j, j]
        z[:, i] = (z[:, i] - (lower[:, i, :i] * z[:, :i]).sum(axis=1)) / lower[:, i, i]
    for i in range(n - 1, -1, -1):
        z[:, i] = (z[:, i] - (lower[:, i + 1 :, i] * z[:, i + 1 :]).sum(axis=1)) / lower[:, i, i]
    cross = kernel.at(long[..., :-1], horizons_s.astype(np.longdouble)[:, None], t)
    return (cross * z[:, None]).sum(axis=2).astype(np.float64).reshape(count, horizons_s.size)


def _converted(kernel: AbstractKernel, leaf: Callable[[], Any]) -> Any:
    """The same tree, whose leaves come in order."""
    if isinstance(kernel, Sum | Product):
        return reduce(
            add if isinstance(kernel, Sum) else mul, [_converted(one, leaf) for one in kernel.parts]
        )
    return leaf()


def _leaf(free: bool, leaf: Any, bounds: Any) -> Any:
    """One leaf, with its variance where that is free; takes its bounds from the front."""
    variance = peers.ConstantKernel(leaf.variance, next(bounds)) if free else None
    own = [next(bounds) for _ in leaf.shape]
    if leaf.name == "linear":
        made: Any = peers.DotProduct(0.0, "fixed")
    elif leaf.name == "rbf":
        made = peers.RBF(leaf.lengthscale_s, *own)
    elif leaf.name in MATERN:
        made = peers.Matern(leaf.lengthscale_s, *own, nu=MATERN[leaf.name])
    elif leaf.name == "rq":
        made = peers.RationalQuadratic(leaf.lengthscale_s, leaf.exponent, *own)
    else:
        # Its width is scikit-learn's length_scale.
        made = peers.ExpSineSquared(leaf.width, leaf.period_s, own[1], own[0])
    return made if variance is None else variance * made
