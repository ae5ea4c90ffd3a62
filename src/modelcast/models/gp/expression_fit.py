"""Maximum-likelihood fits of any kernel on one axis, in batch: for studies and for comparison."""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models.gp import expression_kernels as kernels
from modelcast.models.gp.expression_tables import pack_expression
from modelcast.models.gp.kernels import kernel_from_text
from modelcast.models.gp.time_grid import TimeGrid, check_window

__all__ = ["KernelFits", "fit_kernel", "likelihood_of_kernel"]


@dataclass(frozen=True, slots=True)
class KernelFits:
    """What the search finds for each of B windows.

    Parameters
    ----------
    hyperparameters
        In the order of the kernel's `hyperparameters`, then the white noise's variance, (B, P).
    weights_per_m
        Dual coefficients, (B, n) [1/m].
    log_likelihood
        Logarithm of the likelihood, (B,).
    """

    hyperparameters: FloatArray
    weights_per_m: FloatArray
    log_likelihood: FloatArray


def fit_kernel(
    expression: str, displacements_m: FloatArray, *, dt_s: float, noise_floor_m: float = 0.001
) -> KernelFits:
    """Fit one axis of every window by maximum likelihood.

    Parameters
    ----------
    expression
        The kernel, as `modelcast.models.gp.kernels.kernel_from_text` reads it.
    displacements_m
        Positions, oldest first; only differences to the last one count, (B, n) [m].
    dt_s
        Sampling interval [s].
    noise_floor_m
        Least standard deviation of the white noise [m].

    Raises
    ------
    ValueError
        Where the expression is no kernel, or the windows are too short, too long or not finite.

    Examples
    --------
    >>> fits = fit_kernel("linear", np.linspace(-9.0, 0.0, 10)[None], dt_s=0.1)
    >>> fits.hyperparameters.round(6)[:, 1]
    array([1.e-06])
    """
    windows, constants = _ready(expression, displacements_m, dt_s, noise_floor_m)
    samples = windows.shape[1]
    count = len(kernel_from_text(expression).hyperparameters) + 1
    out = np.empty((windows.shape[0], count + samples + 1))
    kernels.fit_axes(windows, constants, out)
    return KernelFits(
        hyperparameters=out[:, :count],
        weights_per_m=out[:, count:-1],
        log_likelihood=_logarithm(out[:, -1], samples),
    )


def likelihood_of_kernel(
    expression: str, displacements_m: FloatArray, hyperparameters: FloatArray, *, dt_s: float
) -> tuple[FloatArray, FloatArray]:
    """Logarithm of the likelihood, (B,), and its derivatives by the hyper-parameters' logarithms, (B, P).

    Parameters
    ----------
    expression
        The kernel.
    displacements_m
        Positions, oldest first; only differences to the last one count, (B, n) [m].
    hyperparameters
        In the order of the kernel's `hyperparameters`, then the white noise's variance, (B, P).
    dt_s
        Sampling interval [s].

    Raises
    ------
    ValueError
        Where the expression is no kernel, or an array is another shape or not finite.
    """
    windows, constants = _ready(expression, displacements_m, dt_s, 0.001)
    wanted = (windows.shape[0], len(kernel_from_text(expression).hyperparameters) + 1)
    if hyperparameters.shape != wanted:
        raise ValueError(f"hyperparameters must be {wanted}, got {hyperparameters.shape}")
    out = np.empty((wanted[0], 1 + wanted[1]))
    kernels.costs_and_slopes(windows, np.log(hyperparameters), constants, out)
    return _logarithm(out[:, 0], windows.shape[1]), -0.5 * out[:, 1:]


def _ready(
    expression: str, displacements_m: FloatArray, dt_s: float, noise_floor_m: float
) -> tuple[FloatArray, FloatArray]:
    """Windows and constants as the kernels take them."""
    check_window(displacements_m.shape[1])
    if not np.isfinite(displacements_m).all():
        raise ValueError("displacements_m must be finite: skip a vehicle without a full window")
    grid = TimeGrid(displacements_m.shape[1], round(dt_s, 6))
    windows = np.ascontiguousarray(displacements_m - displacements_m[:, -1:], dtype=np.float64)
    return windows, pack_expression(str(kernel_from_text(expression)), grid, noise_floor_m)


def _logarithm(costs: FloatArray, samples: int) -> FloatArray:
    """Log-likelihood of a cost."""
    return -0.5 * (costs + samples * np.log(2.0 * np.pi))
