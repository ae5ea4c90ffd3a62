"""What no data can change about a kernel expression, packed once per window length and sampling interval."""

import functools

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import ConfigError
from modelcast.models.gp import expression_layout as at
from modelcast.models.gp.kernel_codes import LINEAR
from modelcast.models.gp.kernels.base import VARIANCE, AbstractKernel
from modelcast.models.gp.kernels.text import kernel_from_text
from modelcast.models.gp.tables import NOISE_CEILING_M
from modelcast.models.gp.time_grid import TimeGrid

__all__ = ["log_bounds", "pack_expression"]

_STARTS = 256
_SCALE_SPAN = (1.0, 1e10)
"""Variances of the starts relative to the white noise."""
_RATIO_SPAN = (1e-3, 1e3)
_MOST_OVER_NOISE = 1e12
"""Greatest variance of a start relative to the white noise, at any sample: more is left to rounding."""
_MOST_TRACE = 1e13
"""Trace of a covariance relative to the white noise, up to which doubles surely have its Cholesky factor."""
_AT_ONCE = 32
"""Starts worked out together: few enough for little memory."""
_DIFFERENCE = 1e-4
"""Step of a logarithm for the derivatives of the covariance, which only guide a search."""


def log_bounds(kernel: AbstractKernel, noise_floor_m: float) -> FloatArray:
    """Logarithms of the least and greatest hyper-parameters, white noise variance last, (2, P).

    Parameters
    ----------
    kernel
        The kernel.
    noise_floor_m
        Least standard deviation of the white noise [m].
    """
    pairs = [(one.low, one.high) for one in kernel.hyperparameters]
    return np.log(np.array([*pairs, (noise_floor_m**2, NOISE_CEILING_M**2)])).T


@functools.lru_cache(maxsize=32)
def pack_expression(expression: str, grid: TimeGrid, noise_floor_m: float) -> FloatArray:
    """Return the constants in the order of `modelcast.models.gp.expression_layout`, (K,).

    Parameters
    ----------
    expression
        Canonical text of the kernel.
    grid
        The window's times.
    noise_floor_m
        Least standard deviation of the white noise [m].

    Raises
    ------
    ConfigError
        Where the kernel grows over the window beyond what doubles hold.
    """
    kernel = kernel_from_text(expression)
    bounds = log_bounds(kernel, noise_floor_m)
    scales = [float(one.name.endswith(VARIANCE.name)) for one in kernel.hyperparameters] + [1.0]
    leaves, terms = _leaf_rows(kernel), _term_rows(kernel)
    points = _sound(kernel, grid, bounds, _points(kernel))
    if not len(points):
        raise ConfigError(
            f"the kernel {expression} grows too much over {grid.samples} samples every {grid.dt_s:g} s; "
            "take a shorter window, a shorter interval or fewer factors 'linear'"
        )
    inverses, determinants, curvatures = _tabled(kernel, grid, points)
    parts = [leaves, terms, np.concatenate([bounds, [scales]]), inverses, determinants, points, curvatures]
    header = np.zeros(at.HEADER)
    header[at.AT_SAMPLES] = grid.samples
    header[at.AT_DT] = grid.dt_s
    header[at.AT_LEAVES] = len(leaves)
    header[at.AT_TERMS] = len(terms)
    header[at.AT_PARAMETERS] = points.shape[1]
    header[at.AT_DEGREES] = terms[:, at.TERM_DEGREE].max() + 1
    header[at.AT_STARTS] = len(points)
    ends = np.cumsum([at.HEADER, *(part.size for part in parts)])
    header[at.AT_LEAF_ROWS : at.AT_CURVATURES + 1] = ends[:-1]
    # Writeable, because the signature of a point function takes no read-only array.
    return np.concatenate([header, *(part.ravel() for part in parts)])


def _leaf_rows(kernel: AbstractKernel) -> FloatArray:
    rows: list[tuple[float, float, float]] = []
    index = 0
    for place in kernel.places():
        own = len(place.hyperparameters)
        rows.append((place.leaf.code, index if place.free else -1, index + int(place.free)))
        index += own
    return np.array(rows, dtype=np.float64)


def _term_rows(kernel: AbstractKernel) -> FloatArray:
    codes = [place.leaf.code for place in kernel.places()]
    terms = kernel.terms()
    rows = np.zeros((len(terms), at.TERM_ROW))
    for row, term in zip(rows, terms, strict=True):
        row[at.TERM_DEGREE] = sum(codes[leaf] == LINEAR for leaf in term)
        row[at.TERM_COUNT] = len(term)
        row[at.TERM_FIRST : at.TERM_FIRST + len(term)] = term
    return rows


def _points(kernel: AbstractKernel) -> FloatArray:
    """Logarithms of the starts' hyper-parameters at a white noise of 1 m², evenly spread, (G, P).

    Notes
    -----
    The additive recurrence of Roberts 2018, whose steps are powers of the root of ``x^(d+1) = x + 1``.
    """
    spans: list[tuple[float, float]] = []
    for place in kernel.places():
        if place.free:
            spans.append(_SCALE_SPAN if place.scales else _RATIO_SPAN)
        spans += [(one.low, one.high) for one in place.leaf.shape]
    low, high = np.log(np.array(spans)).T
    root = 2.0
    for _ in range(50):
        root = (1.0 + root) ** (1.0 / (low.size + 1))
    steps = root ** -np.arange(1.0, low.size + 1)
    share = (0.5 + np.arange(1, _STARTS + 1)[:, None] * steps) % 1.0
    return np.concatenate([low + (high - low) * share, np.zeros((_STARTS, 1))], axis=1)


def _sound(kernel: AbstractKernel, grid: TimeGrid, bounds: FloatArray, points: FloatArray) -> FloatArray:
    """Starts whose covariance has an inverse, (S, P); none where the kernel grows too much over the window.

    Notes
    -----
    A covariance is linear in the variances that scale it. A start is left out where the least that the bounds
    allow of these is too much beside the most white noise. Of the others each such variance is lowered to
    what doubles can invert: ``linear*linear`` is 1e7 times its variance after a minute.
    """
    scales = [one.name.endswith(VARIANCE.name) for one in kernel.hyperparameters]
    columns = np.flatnonzero(scales)
    least = points.copy()
    least[:, columns] = bounds[0, columns]
    with np.errstate(over="ignore", invalid="ignore"):
        traces = _diagonals(kernel, grid, np.exp(least[:, :-1])).sum(axis=1)
    sound = points[traces <= _MOST_TRACE * np.exp(bounds[1, -1])]
    for column in columns:
        alone = np.exp(sound[:, :-1])
        alone[:, columns[columns != column]] = 0.0
        peaks = _diagonals(kernel, grid, alone).max(axis=1)
        sound[:, column] -= np.log(np.maximum(peaks / _MOST_OVER_NOISE, 1.0))
    return sound


def _diagonals(kernel: AbstractKernel, grid: TimeGrid, values: FloatArray) -> FloatArray:
    """Variances at the window's times, (G, n)."""
    return kernel.at(values[:, None, :], grid.times_s, grid.times_s)


def _tabled(
    kernel: AbstractKernel, grid: TimeGrid, points: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Packed inverses, log determinants and expected curvatures of -2·log L at the starts."""
    times = grid.times_s
    rows, columns = np.tril_indices(grid.samples)
    double = np.where(rows == columns, 1.0, 2.0)
    inverses: list[FloatArray] = []
    determinants: list[FloatArray] = []
    curvatures: list[FloatArray] = []
    for first in range(0, len(points), _AT_ONCE):
        some = points[first : first + _AT_ONCE]
        inverse = np.linalg.inv(_covariances(kernel, times, some)).astype(np.float64)
        inverses.append(inverse[:, rows, columns] * double)
        determinants.append(-np.linalg.slogdet(inverse)[1].astype(np.float64))
        steps = _DIFFERENCE * np.eye(points.shape[1])
        whitened = [
            inverse @ (_covariances(kernel, times, some + step) - _covariances(kernel, times, some - step))
            for step in steps
        ]
        changes = np.stack(whitened, axis=1) / (2.0 * _DIFFERENCE)
        curvatures.append(np.einsum("gpij,gqji->gpq", changes, changes, optimize=True))
    return np.concatenate(inverses), np.concatenate(determinants), np.concatenate(curvatures)


def _covariances(kernel: AbstractKernel, times_s: FloatArray, logarithms: FloatArray) -> FloatArray:
    """With white noise, (G, n, n)."""
    values = np.exp(logarithms)[:, None, None]
    return kernel.at(values[..., :-1], times_s[:, None], times_s) + values[..., -1] * np.eye(times_s.size)
