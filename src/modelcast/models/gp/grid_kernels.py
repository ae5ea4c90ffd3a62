"""Compiled objective over the coarse grid and along one fine row, vectorised over the noise ratios."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector
from modelcast.models.gp.layout import (
    AT_COARSE_START,
    AT_COARSE_STRIDE,
    AT_FLAT,
    AT_NOISE_HIGH,
    AT_NOISE_LOW,
    AT_VARIANCE_HIGH,
    AT_VARIANCE_LOW,
    COARSE_LENGTHSCALES,
    COARSE_NOISES,
    LANES,
    POINTS,
)
from modelcast.models.gp.log_kernels import rough_log

__all__ = ["PROFILE", "coarse_grid", "coarse_scratch", "profile", "rotate"]

_TINY = 1e-290

NB, NC = COARSE_NOISES, COARSE_LENGTHSCALES
_B, _PRODUCT, _DETERMINANT, _Q, _TAU, _C0, _C1, _A0, _A1, _ONE, _W = range(POINTS, 12 * POINTS, POINTS)
PROFILE = 12 * POINTS
"""Length of the vector that `profile` works in."""


@kernel(fast=True)
def coarse_scratch(n: int) -> int:
    """Length of the scratch vector of `coarse_grid`."""
    return 2 * NC * n + 4 * n + NB


@kernel(fast=True)
def objective(
    rest: float,
    explained: float,
    D: int,
    over_D: float,
    m: float,
    low: float,
    high: float,
    log_determinant: float,
) -> float:
    """-2·log-likelihood up to a constant, variance and slope profiled inside their bounds."""
    s = rest * (over_D / (m - 1.0))
    s = s if s <= explained * over_D else (rest + explained) * (over_D / m)
    s = min(high, max(s, low))
    return (
        D * ((m - 1.0) * rough_log(s) + rough_log(max(s, explained * over_D)) + log_determinant)
        + (rest + min(explained, D * s)) / s
    )


@kernel(fast=True, copied=True)
def _coarse_grid(
    folded: FloatVector,
    gamma: FloatVector,
    D: int,
    n: int,
    he: int,
    ho: int,
    tab: FloatVector,
    constants: FloatVector,
    z: FloatVector,
    table: FloatVector,
) -> None:
    flat = constants[AT_FLAT] > 0.0
    m = n - constants[AT_FLAT]
    over_D = 1.0 / D
    g0 = gamma[0]
    g1 = gamma[1]
    even = 0
    odd = NC * he
    axis = NC * n
    for d in range(D):
        for c in range(NC * he):
            z[d * axis + c] = folded[d * n] * tab[c]
        for j in range(1, he):
            f = folded[d * n + j]
            for c in range(NC * he):
                z[d * axis + c] += f * tab[j * NC * he + c]
        o = he * he * NC
        for c in range(NC * ho):
            z[d * axis + odd + c] = folded[d * n + he] * tab[o + c]
        for j in range(1, ho):
            f = folded[d * n + he + j]
            for c in range(NC * ho):
                z[d * axis + odd + c] += f * tab[o + j * NC * ho + c]
    square = z[2 * axis : 2 * axis + n]
    line0 = z[2 * axis + n : 2 * axis + 2 * n]
    line1 = z[2 * axis + 2 * n : 2 * axis + 3 * n]
    over_b = z[2 * axis + 4 * n : 2 * axis + 4 * n + NB]
    value = np.exp(-constants[AT_COARSE_START])
    ratio = np.exp(-constants[AT_COARSE_STRIDE])
    for b in range(NB):
        over_b[b] = value
        value *= ratio
    noise_low, noise_high = constants[AT_NOISE_LOW], constants[AT_NOISE_HIGH]
    variance_low, variance_high = constants[AT_VARIANCE_LOW], constants[AT_VARIANCE_HIGH]
    stride = 2 * n + n * NB + 4 * NB
    at = (he * he + ho * ho) * NC
    for i in range(NC):
        for k in range(n):
            source = even + i * he + k if k < he else odd + i * ho + k - he
            v = z[source]
            square[k] = v * v
            line0[k] = v * tab[at + k]
        if D == 2:
            for k in range(n):
                source = even + i * he + k if k < he else odd + i * ho + k - he
                v = z[axis + source]
                square[k] += v * v
                line1[k] = v * tab[at + k]
        e = at + 2 * n + n * NB
        for b in range(NB):
            q = 0.0
            c0 = 0.0
            for k in range(n):
                w = tab[at + 2 * n + k * NB + b]
                q += square[k] * w
                c0 += line0[k] * w
            over_tau = tab[e + NB + b]
            # The slope removed beforehand keeps this difference harmless on a coarse grid.
            rest = q - c0 * c0 * over_tau
            t0 = c0 + g0 * tab[e + b]
            explained = t0 * t0 * over_tau + _TINY
            if D == 2:
                c1 = 0.0
                for k in range(n):
                    c1 += line1[k] * tab[at + 2 * n + k * NB + b]
                rest -= c1 * c1 * over_tau
                t1 = c1 + g1 * tab[e + b]
                explained += t1 * t1 * over_tau
            if flat:
                a0 = 0.0
                a1 = 0.0
                for k in range(he):
                    w = tab[at + 2 * n + k * NB + b] * tab[at + n + k]
                    a0 += z[even + i * he + k] * w
                    if D == 2:
                        a1 += z[axis + even + i * he + k] * w
                rest -= (a0 * a0 + a1 * a1) * tab[e + 2 * NB + b]
            rest = max(rest, 1e-12 * q + _TINY)
            low = max(noise_low * over_b[b], variance_low)
            high = min(noise_high * over_b[b], variance_high)
            table[i * NB + b] = objective(rest, explained, D, over_D, m, low, high, tab[e + 3 * NB + b])
        at += stride


@kernel(fast=True)
def coarse_grid(
    folded: FloatVector,
    gamma: FloatVector,
    D: int,
    n: int,
    tab: FloatVector,
    constants: FloatVector,
    z: FloatVector,
    table: FloatVector,
) -> None:
    """Objective at every point of the coarse grid, to about 1e-4, into ``table`` (NC·NB,)."""
    # A constant length lets the compiler unroll and vectorise: the paper's window gets a copy of its own.
    if n == 10 and D == 1:
        _coarse_grid(folded, gamma, 1, 10, 5, 5, tab, constants, z, table)
    elif n == 10:
        _coarse_grid(folded, gamma, 2, 10, 5, 5, tab, constants, z, table)
    else:
        _coarse_grid(folded, gamma, D, n, (n + 1) // 2, n // 2, tab, constants, z, table)


@kernel(fast=True, copied=True)
def _rotate(
    folded: FloatVector, D: int, n: int, he: int, ho: int, hp: int, row: FloatVector, z: FloatVector
) -> None:
    for d in range(D):
        for start in range(0, hp, LANES):
            at = 2 * d * hp + start
            for k in range(LANES):
                z[at + k] = folded[d * n] * row[start + k]
                z[at + hp + k] = folded[d * n + he] * row[he * hp + start + k]
            for j in range(1, he):
                for k in range(LANES):
                    z[at + k] += folded[d * n + j] * row[j * hp + start + k]
            for j in range(1, ho):
                for k in range(LANES):
                    z[at + hp + k] += folded[d * n + he + j] * row[(he + j) * hp + start + k]


@kernel(fast=True)
def rotate(folded: FloatVector, D: int, n: int, row: FloatVector, z: FloatVector) -> None:
    """Rotate D folded axes into a fine row's eigen-basis, each half padded to hp, into ``z`` (D·2·hp,)."""
    he = (n + 1) // 2
    hp = (he + LANES - 1) // LANES * LANES
    if n == 10:
        _rotate(folded, D, 10, 5, 5, 8, row, z)
    else:
        _rotate(folded, D, n, he, n // 2, hp, row, z)


@kernel(fast=True, copied=True)
def _profile(
    D: int,
    n: int,
    he: int,
    hp: int,
    row: FloatVector,
    gamma: FloatVector,
    constants: FloatVector,
    first: float,
    step: float,
    z: FloatVector,
    out: FloatVector,
) -> None:
    flat = constants[AT_FLAT] > 0.0
    m = n - constants[AT_FLAT]
    over_D = 1.0 / D
    o = n * hp
    g0 = gamma[0]
    g1 = gamma[1]
    value = np.exp(first)
    ratio = np.exp(step)
    for lane in range(POINTS):
        out[_B + lane] = value
        value *= ratio
        out[_PRODUCT + lane] = 1.0
        out[_DETERMINANT + lane] = 0.0
        out[_Q + lane] = 0.0
        out[_TAU + lane] = 0.0
        out[_C0 + lane] = 0.0
        out[_C1 + lane] = 0.0
        out[_A0 + lane] = 0.0
        out[_A1 + lane] = 0.0
        out[_ONE + lane] = 0.0
    # One simple loop over the lanes at a time, all in one array at fixed places: that is what vectorises.
    for k in range(n):
        at = k if k < he else k - he + hp
        eigenvalue = row[o + k]
        t = row[o + n + k]
        square = z[at] * z[at]
        line = z[at] * t
        tt = t * t
        line1 = 0.0
        if D == 2:
            other = z[2 * hp + at]
            square += other * other
            line1 = other * t
        for lane in range(POINTS):
            v = eigenvalue + out[_B + lane]
            w = 1.0 / v
            if D == 2 or flat:
                out[_W + lane] = w
            out[_PRODUCT + lane] *= v
            out[_Q + lane] += square * w
            out[_C0 + lane] += line * w
            out[_TAU + lane] += tt * w
        if D == 2:
            for lane in range(POINTS):
                out[_C1 + lane] += line1 * out[_W + lane]
        if flat and k < he:
            i = row[o + 2 * n + k]
            level = z[at] * i
            level1 = z[2 * hp + at] * i if D == 2 else 0.0
            for lane in range(POINTS):
                out[_A0 + lane] += level * out[_W + lane]
                out[_A1 + lane] += level1 * out[_W + lane]
                out[_ONE + lane] += i * i * out[_W + lane]
        if k % 16 == 15:
            for lane in range(POINTS):
                out[_DETERMINANT + lane] += rough_log(out[_PRODUCT + lane])
                out[_PRODUCT + lane] = 1.0
    noise_low, noise_high = constants[AT_NOISE_LOW], constants[AT_NOISE_HIGH]
    variance_low, variance_high = constants[AT_VARIANCE_LOW], constants[AT_VARIANCE_HIGH]
    if not flat:
        for lane in range(POINTS):
            out[_ONE + lane] = 1.0
    for lane in range(POINTS):
        tau = out[_TAU + lane]
        over_tau = 1.0 / tau
        one = out[_ONE + lane]
        c0 = out[_C0 + lane]
        c1 = out[_C1 + lane]
        a0 = out[_A0 + lane]
        a1 = out[_A1 + lane]
        q = out[_Q + lane]
        rest = max(q - (c0 * c0 + c1 * c1) * over_tau - (a0 * a0 + a1 * a1) / one, 1e-12 * q + _TINY)
        t0 = c0 + g0 * tau
        t1 = c1 + g1 * tau
        explained = (t0 * t0 + t1 * t1) * over_tau + _TINY
        over_b = 1.0 / out[_B + lane]
        low = max(noise_low * over_b, variance_low)
        high = min(noise_high * over_b, variance_high)
        log_determinant = out[_DETERMINANT + lane] + rough_log(out[_PRODUCT + lane] * one)
        out[lane] = objective(rest, explained, D, over_D, m, low, high, log_determinant)


@kernel(fast=True)
def profile(
    D: int,
    n: int,
    row: FloatVector,
    gamma: FloatVector,
    constants: FloatVector,
    first: float,
    step: float,
    z: FloatVector,
    out: FloatVector,
) -> None:
    """Objective for `POINTS` noise ratios, log b from ``first`` by ``step``, into ``out`` (`PROFILE`,)."""
    he = (n + 1) // 2
    hp = (he + LANES - 1) // LANES * LANES
    if n == 10 and D == 1:
        _profile(1, 10, 5, 8, row, gamma, constants, first, step, z, out)
    elif n == 10:
        _profile(2, 10, 5, 8, row, gamma, constants, first, step, z, out)
    else:
        _profile(D, n, he, hp, row, gamma, constants, first, step, z, out)
