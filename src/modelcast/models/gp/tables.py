"""Everything about the kernel that no data can change, packed once per window length and sampling interval.

One flat vector, because a compiled point function receives one: a header of settings, then one *row* for
every lengthscale of the fine grid (the kernel's eigen-basis), then one *coarse row* for every lengthscale
of the coarse grid (the same basis, and everything about M = K + b·I for every relative noise of the coarse
grid). All vectors are in the folded basis of `modelcast.models.gp.spectrum`: even half first, then odd.
"""

import functools
from dataclasses import dataclass
from typing import Literal

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.models.gp import layout as at
from modelcast.models.gp.layout import COARSE_NOISES, COARSE_STEP, FINE_LENGTHSCALES
from modelcast.models.gp.spectrum import HalfSpectrum, fold, spectrum
from modelcast.models.gp.time_grid import TimeGrid

__all__ = ["NOISE_CEILING_M", "Bounds", "Form", "lengthscale_grid", "pack"]

Form = Literal["anchored", "intercept"]

LENGTHSCALE_BOUNDS_S = (0.1, 10.0)
"""Bounds of the lengthscale [s]."""
NOISE_CEILING_M = 1000.0
"""Upper bound of the white noise's standard deviation [m]."""
VARIANCE_BOUNDS_M2 = (1e-14, 1e8)
"""Bounds of the RBF part's variance [m²]; the lower is as good as none: a line can be just a line."""
NOISE_RATIO_BOUNDS = (1e-14, 1e8)
"""Bounds of the relative noise: what the bounds above leave possible at a floor of 1 mm."""
COARSE_NOISE_RATIO_BOUNDS = (1e-13, 1e2)
"""Span of the coarse grid; beyond it the likelihood has no further optimum, only slopes."""


@dataclass(frozen=True, slots=True)
class Bounds:
    """Bounds of the search, equal to those that a general optimiser is given in the comparison.

    Parameters
    ----------
    noise_floor_m, noise_ceiling_m
        Least and greatest standard deviation of the white noise [m].
    lengthscale_s
        Least and greatest lengthscale [s].
    variance_m2
        Least and greatest variance of the RBF part [m²].
    """

    noise_floor_m: float = 0.001
    noise_ceiling_m: float = NOISE_CEILING_M
    lengthscale_s: tuple[float, float] = LENGTHSCALE_BOUNDS_S
    variance_m2: tuple[float, float] = VARIANCE_BOUNDS_M2


def lengthscale_grid(bounds_s: tuple[float, float] = LENGTHSCALE_BOUNDS_S) -> FloatArray:
    """Return the fine grid of lengthscales, evenly spaced in the logarithm [s]."""
    return np.geomspace(*bounds_s, FINE_LENGTHSCALES)


@functools.lru_cache(maxsize=32)
def pack(grid: TimeGrid, form: Form, bounds: Bounds) -> FloatArray:
    """Return the constants of the maximum-likelihood fit, (K,).

    Parameters
    ----------
    grid
        The window's times.
    form
        Form of the linear part.
    bounds
        Bounds of the hyper-parameters.
    """
    lengthscales = lengthscale_grid(bounds.lengthscale_s)
    halves = spectrum(grid, lengthscales)
    columns = _rows(grid, form, halves)
    width = -(-((grid.samples + 1) // 2) // at.LANES) * at.LANES
    rows = np.concatenate([*(_padded(half.vectors, width) for half in halves), *columns], axis=1)
    thin = slice(None, None, COARSE_STEP)
    coarse_halves = tuple(HalfSpectrum(half.values[thin], half.vectors[thin]) for half in halves)
    coarse = _coarse(form, (coarse_halves[0], coarse_halves[1]), *(column[thin] for column in columns))
    header = np.zeros(at.HEADER)
    header[at.AT_SAMPLES] = grid.samples
    header[at.AT_DT] = grid.dt_s
    header[at.AT_FLAT] = form == "intercept"
    header[at.AT_NOISE_LOW] = bounds.noise_floor_m**2
    header[at.AT_NOISE_HIGH] = bounds.noise_ceiling_m**2
    header[at.AT_VARIANCE_LOW], header[at.AT_VARIANCE_HIGH] = bounds.variance_m2
    header[at.AT_LOG_RATIO_LOW], header[at.AT_LOG_RATIO_HIGH] = np.log(NOISE_RATIO_BOUNDS)
    low, high = np.log(COARSE_NOISE_RATIO_BOUNDS)
    header[at.AT_COARSE_START] = low
    header[at.AT_COARSE_STRIDE] = (high - low) / (COARSE_NOISES - 1)
    header[at.AT_LOG_LENGTHSCALE_START] = np.log(lengthscales[0])
    header[at.AT_LOG_LENGTHSCALE_STRIDE] = np.log(lengthscales[-1] / lengthscales[0]) / (
        FINE_LENGTHSCALES - 1
    )
    # Writeable, because the signature of a point function takes no read-only array.
    return np.concatenate([header, rows.ravel(), coarse])


def _rows(
    grid: TimeGrid, form: Form, halves: tuple[HalfSpectrum, HalfSpectrum]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Eigenvalues, linear and constant direction in every lengthscale's eigen-basis, (L, n) each."""
    values = np.concatenate([half.values for half in halves], axis=1)
    times_s = grid.times_s
    centred = times_s - times_s.mean() if form == "intercept" else times_s
    constant = np.full(grid.samples, float(form == "intercept"))
    linear, flat = (
        np.concatenate(
            [
                np.einsum("j,ljk->lk", part, half.vectors)
                for part, half in zip(fold(column), halves, strict=True)
            ],
            axis=1,
        )
        for column in (centred, constant)
    )
    return values, linear, flat


def _padded(vectors: FloatArray, width: int) -> FloatArray:
    """Eigenvectors of one half with zero columns up to a width, (L, h·width)."""
    count, size, _ = vectors.shape
    out = np.zeros((count, size, width))
    out[:, :, :size] = vectors
    return out.reshape(count, -1)


def _coarse(
    form: Form,
    halves: tuple[HalfSpectrum, HalfSpectrum],
    values: FloatArray,
    linear: FloatArray,
    flat: FloatArray,
) -> FloatArray:
    """Coarse grid: all eigenvectors side by side, then for each lengthscale what `layout` says."""
    ratios = np.geomspace(*COARSE_NOISE_RATIO_BOUNDS, COARSE_NOISES)
    inverse = 1.0 / (values[:, :, None] + ratios)
    tau = np.einsum("lk,lkb->lb", linear**2, inverse)
    log_determinant = -np.log(inverse).sum(axis=1)
    over = np.zeros_like(tau)
    if form == "intercept":
        precision = np.einsum("lk,lkb->lb", flat**2, inverse)
        log_determinant += np.log(precision)
        over = 1.0 / precision
    count = values.shape[0]
    rows = np.concatenate(
        [linear, flat, inverse.reshape(count, -1), tau, 1.0 / tau, over, log_determinant], axis=1
    )
    vectors = [np.moveaxis(half.vectors, 0, 1).ravel() for half in halves]
    return np.concatenate([*vectors, rows.ravel()])
