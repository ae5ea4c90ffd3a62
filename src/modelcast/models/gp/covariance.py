"""Predictive covariance and the constant matrices of a Gaussian process with given hyper-parameters.

Plain NumPy in the eigen-basis of the kernel, for reports and for fixed hyper-parameters; the search for
hyper-parameters is in `modelcast.models.gp.search_kernels`.
"""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models.gp.spectrum import fold, spectrum
from modelcast.models.gp.tables import Form
from modelcast.models.gp.time_grid import TimeGrid

__all__ = ["Inverse", "inverse", "predictive_variance_m2", "projection"]


@dataclass(frozen=True, slots=True)
class Inverse:
    """Inverse of M = K + b·I for L pairs of lengthscale and relative noise, by its eigen-basis.

    Parameters
    ----------
    basis
        Orthonormal eigenvectors as columns, (L, n, n).
    weights
        Inverse eigenvalues 1/(λ + b), (L, n).
    """

    basis: FloatArray
    weights: FloatArray

    def rotate(self, columns: FloatArray) -> FloatArray:
        """Return vectors over the window, (..., n) or (L, ..., n), in the eigen-basis, (L, ..., n)."""
        return np.einsum("l...j,ljk->l...k", np.broadcast_to(columns, self._like(columns)), self.basis)

    def _like(self, columns: FloatArray) -> tuple[int, ...]:
        count = self.basis.shape[0]
        return (count, *columns.shape) if columns.ndim == 1 else columns.shape


def inverse(grid: TimeGrid, lengthscales_s: FloatArray, noise_ratios: FloatArray) -> Inverse:
    """Return M⁻¹ for each pair of lengthscale and relative noise.

    Parameters
    ----------
    grid
        The window's times.
    lengthscales_s
        Lengthscales, (L,) [s].
    noise_ratios
        White noise relative to the RBF part's variance, (L,).
    """
    distinct, which = np.unique(lengthscales_s, return_inverse=True)
    even, odd = spectrum(grid, distinct)
    fold_even, fold_odd = fold(np.eye(grid.samples))
    basis = np.concatenate(
        [np.einsum("nj,ljk->lnk", fold_even, even.vectors), np.einsum("nj,ljk->lnk", fold_odd, odd.vectors)],
        axis=2,
    )
    values = np.concatenate([even.values, odd.values], axis=1)
    return Inverse(basis[which], 1.0 / (values[which] + noise_ratios[:, None]))


def predictive_variance_m2(
    grid: TimeGrid,
    form: Form,
    horizons_s: FloatArray,
    *,
    lengthscales_s: FloatArray,
    noise_ratios: FloatArray,
    linear_ratios_per_s2: FloatArray,
    variances_m2: FloatArray,
) -> FloatArray:
    """Return the variance of the noise-free displacement on one axis, (L, H) [m²].

    Parameters
    ----------
    grid
        The window's times.
    form
        Form of the linear part; "intercept" adds the variance of the constant.
    horizons_s
        Times after the last sample, (H,) [s].
    lengthscales_s, noise_ratios, linear_ratios_per_s2, variances_m2
        Hyper-parameters, (L,) each.

    Notes
    -----
    The variance is ``s²·(1 - k*ᵀM⁻¹k* + (h - tᵀM⁻¹k*)²/(tau + 1/a))`` with t the line's direction, and
    for the intercept ``s²·(1 - 1ᵀM⁻¹k*)²/o`` more. There, time is measured from the window's middle, which
    makes t and 1 orthogonal in M⁻¹.
    """
    solved = inverse(grid, lengthscales_s, noise_ratios)
    times = grid.times_s
    shift = times.mean() if form == "intercept" else 0.0
    gaps = horizons_s[:, None] - times
    cross = solved.rotate(np.exp(-0.5 * np.square(gaps / lengthscales_s[:, None, None])))
    linear = solved.rotate(times - shift)[:, None]
    weights = solved.weights[:, None]
    tau = (linear**2 * weights).sum(axis=2)
    left = horizons_s - shift - (linear * cross * weights).sum(axis=2)
    ratio = linear_ratios_per_s2[:, None]
    variance = 1.0 - (cross**2 * weights).sum(axis=2) + np.square(left) * ratio / (1.0 + ratio * tau)
    if form == "intercept":
        constant = solved.rotate(np.ones(grid.samples))[:, None]
        missing = 1.0 - (constant * cross * weights).sum(axis=2)
        variance += np.square(missing) / (constant**2 * weights).sum(axis=2)
    return variances_m2[:, None] * np.maximum(variance, 0.0)


def projection(
    grid: TimeGrid,
    form: Form,
    *,
    lengthscale_s: float,
    noise_ratio: float,
    linear_ratio_per_s2: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the matrices that turn displacements into [intercept,] slope and weights.

    Lines are ``(1 or 2, n) @ displacements`` and weights ``(n, n) @ (n, n) @ displacements``.

    Parameters
    ----------
    grid
        The window's times.
    form
        Form of the linear part.
    lengthscale_s, noise_ratio, linear_ratio_per_s2
        Hyper-parameters.

    Notes
    -----
    The two matrices of the weights are not multiplied out. The first gives the dual coefficients in the
    eigen-basis, where rounding errors, as large as ``1e-16/b``, stay along the eigenvectors of the
    smallest eigenvalues, which no prediction sees. The product would spread them over all weights: a
    centimetre where b is ``1e-12``.
    """
    solved = inverse(grid, np.array([lengthscale_s]), np.array([noise_ratio]))
    basis, weights = solved.basis[0], solved.weights[0]
    times = grid.times_s
    shift = times.mean() if form == "intercept" else 0.0
    linear = (times - shift) @ basis
    tau = (linear**2 * weights).sum()
    slope = linear_ratio_per_s2 / (1.0 + linear_ratio_per_s2 * tau) * (linear * weights)
    residual = np.eye(grid.samples) - np.outer(linear, slope)
    lines = [slope]
    if form == "intercept":
        constant = np.ones(grid.samples) @ basis
        level = constant * weights / (constant**2 * weights).sum()
        residual -= np.outer(constant, level)
        lines = [level - shift * slope, slope]
    decay = np.exp(-0.5 * np.square(times / lengthscale_s))
    return np.array(lines) @ basis.T, weights[:, None] * residual @ basis.T, decay[:, None] * basis
