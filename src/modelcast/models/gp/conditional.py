"""Prediction weights of a Gaussian process on one axis from positions and, where wanted, velocities.

Everything here is plain NumPy on matrices of some twenty rows, made once for given hyper-parameters; a window
only enters through the weights, by a product.
"""

from dataclasses import KW_ONLY, dataclass
from typing import Annotated

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.rules import Number, check_fields

__all__ = ["AxisKernel", "Conditional", "condition_on", "log_likelihood"]


@dataclass(frozen=True, slots=True)
class AxisKernel:
    """Prior of the motion along one axis: a line of unknown slope plus an RBF part.

    Parameters
    ----------
    lengthscale_s
        Lengthscale of the RBF part [s].
    deviation_m
        Standard deviation of the RBF part [m]; 0 for a line alone.
    slope_deviation_mps
        Standard deviation of the slope about zero [m/s].
    velocity_noise_mps
        Standard deviation of the white noise of the measured velocity [m/s]; used where velocities are.

    Raises
    ------
    ValueError
        Where a value is out of its range: ten times what a search may find, either way.
    """

    lengthscale_s: Annotated[float, Number(0.05, 1000.0)] = 3.0
    deviation_m: Annotated[float, Number(0.0, 10_000.0)] = 10.0
    _: KW_ONLY
    slope_deviation_mps: Annotated[float, Number(1e-3, 1000.0)] = 30.0
    velocity_noise_mps: Annotated[float, Number(1e-4, 100.0)] = 0.1

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True)
class Conditional:
    """A process given its measurements, for one noise level.

    Parameters
    ----------
    weights
        What each measurement adds to the prediction at each horizon, (H, m): the positions first, each
        relative to any common origin, then the velocities, where there are any.
    variance_m2
        Variance of the noise-free position at each horizon, (H,) [m²].
    """

    weights: FloatArray
    variance_m2: FloatArray


def condition_on(
    kernel: AxisKernel,
    times_s: FloatArray,
    horizons_s: FloatArray,
    *,
    position_noise_m: float,
    velocities: bool,
) -> Conditional:
    """Condition a line with a free constant plus an RBF part on positions and velocities at the same times.

    Parameters
    ----------
    kernel
        The prior.
    times_s
        When it was measured, (n,) [s].
    horizons_s
        When to predict, (H,) [s].
    position_noise_m
        Standard deviation of the positions' white noise [m].
    velocities
        Whether velocities were measured too, at all of the times.

    Notes
    -----
    With C the covariance of the measurements y, o the direction of the free constant (1 for a position, 0 for
    a velocity) and c the covariance of y with the value at a horizon, the prediction is ``wᵀy`` with
    ``w = C⁻¹·(c + o·(1 - oᵀC⁻¹c)/(oᵀC⁻¹o))``. A velocity is a derivative of the process: its covariances are
    the kernel's derivatives.
    """
    cross = _covariance(kernel, times_s, horizons_s, velocities=velocities)[:, : horizons_s.size]
    whitener, constant = _measured(kernel, times_s, position_noise_m, velocities=velocities)
    white_cross = np.linalg.solve(whitener, cross)
    white_constant = np.linalg.solve(whitener, constant)
    precision = white_constant @ white_constant
    missing = 1.0 - white_constant @ white_cross
    white = white_cross + np.outer(white_constant, missing / precision)
    prior = kernel.deviation_m**2 + np.square(kernel.slope_deviation_mps * horizons_s)
    variance = prior - (white_cross**2).sum(axis=0) + np.square(missing) / precision
    weights = np.linalg.solve(whitener.T, white).T
    return Conditional(np.asarray(weights, dtype=np.float64), np.maximum(variance, 0.0))


def log_likelihood(
    kernel: AxisKernel, times_s: FloatArray, measured: FloatArray, *, position_noise_m: float
) -> FloatArray:
    """Logarithm of the restricted likelihood of windows, with the free constant integrated out, (B,).

    Parameters
    ----------
    kernel
        The prior.
    times_s
        When it was measured, (n,) [s].
    measured
        Positions, or positions then velocities, of B windows, (B, n) or (B, 2n) [m, m/s].
    position_noise_m
        Standard deviation of the positions' white noise [m].
    """
    velocities = measured.shape[1] > times_s.size
    whitener, constant = _measured(kernel, times_s, position_noise_m, velocities=velocities)
    white = np.linalg.solve(whitener, measured.T)
    direction = np.linalg.solve(whitener, constant)
    precision = direction @ direction
    squares = (white**2).sum(axis=0) - np.square(direction @ white) / precision
    log_determinant = 2.0 * np.log(np.diag(whitener)).sum() + np.log(precision)
    return -0.5 * (squares + log_determinant + (measured.shape[1] - 1) * np.log(2.0 * np.pi))


def _measured(
    kernel: AxisKernel, times_s: FloatArray, position_noise_m: float, *, velocities: bool
) -> tuple[FloatArray, FloatArray]:
    """Cholesky factor of the measurements' covariance, and the direction of the free constant."""
    covariance = _covariance(kernel, times_s, times_s, velocities=velocities)
    noise = np.full(times_s.size, position_noise_m**2)
    constant = np.ones(times_s.size)
    if velocities:
        noise = np.append(noise, np.full(times_s.size, kernel.velocity_noise_mps**2))
        constant = np.append(constant, np.zeros(times_s.size))
    return np.asarray(np.linalg.cholesky(covariance + np.diag(noise)), dtype=np.float64), constant


def _covariance(
    kernel: AxisKernel, one_s: FloatArray, other_s: FloatArray, *, velocities: bool
) -> FloatArray:
    """Covariance of values [and derivatives] at one set of times with those at another."""
    gap = (one_s[:, None] - other_s) / kernel.lengthscale_s
    rbf = kernel.deviation_m**2 * np.exp(-0.5 * gap**2)
    slope = kernel.slope_deviation_mps**2
    values = rbf + slope * np.outer(one_s, other_s)
    if not velocities:
        return values
    to_other = rbf * gap / kernel.lengthscale_s + slope * one_s[:, None]
    to_one = -rbf * gap / kernel.lengthscale_s + slope * other_s
    both = rbf * (1.0 - gap**2) / kernel.lengthscale_s**2 + slope
    return np.block([[values, to_other], [to_one, both]])
