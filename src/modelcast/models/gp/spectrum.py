"""Eigenvalues of the RBF kernel on an equally spaced grid, accurate down to the smallest.

The kernel matrix of n equally spaced times is centrosymmetric, so it splits into an even and an odd half of
about n/2 each. Long lengthscales leave most eigenvalues far below ``1e-16``, where an ordinary
eigen-solver returns rounding noise, while a fitted relative noise may be ``1e-12``: the small ones matter.
Each half has a Cholesky factor in closed form, without a single subtraction of nearly equal numbers, because
``cosh(i·θ)`` and ``sinh(i·θ)`` are polynomials in ``cosh θ`` (Chebyshev) and the difference of two nodes is
a product of two ``sinh``. One-sided Jacobi rotations of that factor then give every eigenvalue to a small
*relative* error.

References
----------
Demmel and Veselić, "Jacobi's method is more accurate than QR", SIAM J. Matrix Anal. Appl. 13 (1992),
doi:10.1137/0613074.
"""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models.gp.time_grid import TimeGrid

__all__ = ["HalfSpectrum", "fold", "spectrum"]

_LOG_TWO = float(np.log(2.0))
_LOG_SMALLEST = -130.0
"""Factors are raised to this at least: eigenvalues of 1e-113 are zero beside any noise."""
_SWEEPS = 30
_ORTHOGONAL = 4e-16


@dataclass(frozen=True, slots=True)
class HalfSpectrum:
    """Eigen-decomposition of one half of the kernel matrix for L lengthscales.

    Parameters
    ----------
    values
        Eigenvalues, not increasing, (L, h).
    vectors
        Eigenvectors of the half as columns, in the basis of `fold`, (L, h, h).
    """

    values: FloatArray
    vectors: FloatArray


def fold(columns: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the even and the odd half of vectors over the window, from the middle outwards.

    Parameters
    ----------
    columns
        Vectors over the window, (..., n).

    Examples
    --------
    >>> even, odd = fold(np.array([1.0, 5.0, 3.0]))
    >>> round(float((even**2).sum() + (odd**2).sum()), 12)
    35.0
    """
    samples = columns.shape[-1]
    later = columns[..., samples // 2 :]
    earlier = columns[..., ::-1][..., samples // 2 :]
    even = (later + earlier) * np.sqrt(0.5)
    odd = (later - earlier) * np.sqrt(0.5)
    if samples % 2:
        even[..., 0] *= np.sqrt(0.5)
        odd = odd[..., 1:]
    return even, odd


def spectrum(grid: TimeGrid, lengthscales_s: FloatArray) -> tuple[HalfSpectrum, HalfSpectrum]:
    """Return the even and the odd half of the RBF kernel's spectrum.

    Parameters
    ----------
    grid
        The window's times.
    lengthscales_s
        Lengthscales, (L,) [s].

    Examples
    --------
    >>> even, odd = spectrum(TimeGrid(10, 0.1), np.array([0.3]))
    >>> round(float(even.values.sum() + odd.values.sum()), 12)
    10.0
    """
    even = _decompose(_factor(grid, lengthscales_s, odd=False))
    odd = _decompose(_factor(grid, lengthscales_s, odd=True))
    return even, odd


def _log_sinh(x: FloatArray) -> FloatArray:
    return x + np.log(-np.expm1(-2.0 * x)) - _LOG_TWO


def _log_cosh(x: FloatArray) -> FloatArray:
    return x + np.log1p(np.exp(-2.0 * x)) - _LOG_TWO


def _factor(grid: TimeGrid, lengthscales_s: FloatArray, *, odd: bool) -> FloatArray:
    """Cholesky factor of one half, (L, h, h), lower triangular.

    With ``x = (dt/lengthscale)²``, ``θ_i = i·x`` and ``c_i = cosh θ_i``, entry (i, j) of the half is
    ``N_i·E_i·h_i·p_j(c_i)·E_j·N_j`` with p_j a Chebyshev polynomial of leading coefficient 2^e_j, so that the
    factor is Newton's basis on the nodes c.
    """
    middle = bool(grid.samples % 2)
    index = grid.half_steps
    if odd and middle:
        index = index[1:]
    size = index.size
    x = np.square(grid.dt_s / lengthscales_s)[:, None]
    theta = index * x
    if middle:
        row = _log_sinh(theta) if odd else np.zeros_like(theta)
        power = np.arange(size) if odd else np.maximum(np.arange(size) - 1, 0)
    else:
        row = (_log_sinh if odd else _log_cosh)(theta / 2.0)
        power = np.arange(size)
    weight = np.full(size, 0.5 * _LOG_TWO)
    if middle and not odd:
        weight[0] = 0.0
    left = weight - 0.5 * index**2 * x + row
    log_factor = np.full((x.shape[0], size, size), -np.inf)
    nodes = np.zeros((x.shape[0], size))
    for k in range(size):
        pivot = nodes[:, k]
        scale = 0.5 * (power[k] * _LOG_TWO + pivot - row[:, k]) - pivot
        log_factor[:, k:, k] = left[:, k:] + nodes[:, k:] + np.maximum(scale, _LOG_SMALLEST - pivot)[:, None]
        later = slice(k + 1, size)
        nodes[:, later] += (
            _LOG_TWO
            + _log_sinh((index[later] + index[k]) * x / 2.0)
            + _log_sinh((index[later] - index[k]) * x / 2.0)
        )
    return np.exp(log_factor)


def _decompose(factor: FloatArray) -> HalfSpectrum:
    """Eigen-decomposition of ``factor @ factorᵀ`` by one-sided Jacobi rotations, all L at once."""
    columns = np.ascontiguousarray(np.moveaxis(factor, 2, 0))
    size = columns.shape[0]
    for _ in range(_SWEEPS):
        worst = 0.0
        for p in range(size - 1):
            for q in range(p + 1, size):
                worst = max(worst, _rotate(columns, p, q))
        if worst < _ORTHOGONAL * size:
            break
    norms = np.sqrt(np.square(columns).sum(axis=2))
    order = np.argsort(-norms, axis=0, kind="stable")
    vectors = np.take_along_axis(columns / norms[:, :, None], order[:, :, None], axis=0)
    values = np.take_along_axis(np.square(norms), order, axis=0)
    return HalfSpectrum(np.ascontiguousarray(values.T), np.ascontiguousarray(np.moveaxis(vectors, 0, 2)))


def _rotate(columns: FloatArray, p: int, q: int) -> float:
    """Make columns p and q orthogonal in place; return the largest cosine between them before."""
    first, second = columns[p], columns[q]
    alpha = np.square(first).sum(axis=1)
    beta = np.square(second).sum(axis=1)
    gamma = (first * second).sum(axis=1)
    cosine = np.abs(gamma) / np.sqrt(alpha * beta)
    safe = np.where(cosine < _ORTHOGONAL, 1.0, gamma)
    zeta = (beta - alpha) / (2.0 * safe)
    tangent = np.copysign(1.0, zeta) / (np.abs(zeta) + np.hypot(1.0, zeta))
    tangent = np.where(cosine < _ORTHOGONAL, 0.0, tangent)
    c = 1.0 / np.sqrt(1.0 + tangent**2)
    s = c * tangent
    columns[p], columns[q] = (
        c[:, None] * first - s[:, None] * second,
        s[:, None] * first + c[:, None] * second,
    )
    return float(cosine.max(initial=0.0))
