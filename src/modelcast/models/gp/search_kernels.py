"""Compiled maximum-likelihood search of the exact Gaussian process on an equally spaced window.

Variance and slope are profiled in closed form, so that two hyper-parameters are left. A coarse grid over both
finds the basins; each of the best two is followed along the fine lengthscales, where the best noise ratio of
a row comes from `POINTS` of them at once; Newton steps finish the noise ratio.
"""

from typing import Any

import numba
import numpy as np

from modelcast.models.gp.grid_kernels import PROFILE, coarse_grid, coarse_scratch, profile, rotate
from modelcast.models.gp.layout import (
    AT_COARSE_START,
    AT_COARSE_STRIDE,
    AT_FLAT,
    AT_LOG_LENGTHSCALE_START,
    AT_LOG_LENGTHSCALE_STRIDE,
    AT_LOG_RATIO_HIGH,
    AT_LOG_RATIO_LOW,
    AT_NOISE_HIGH,
    AT_NOISE_LOW,
    AT_SAMPLES,
    AT_VARIANCE_HIGH,
    AT_VARIANCE_LOW,
    COARSE_LENGTHSCALES,
    COARSE_NOISES,
    COARSE_STEP,
    FINE_LENGTHSCALES,
    HEADER,
    LANES,
    OUT_CONSTANT,
    OUT_FLOORED,
    OUT_LENGTHSCALE,
    OUT_LINEAR_RATIO,
    OUT_LOG_LIKELIHOOD,
    OUT_NOISE_RATIO,
    OUT_SLOPE,
    OUT_VARIANCE,
    OUT_WEIGHTS,
    POINTS,
)
from modelcast.models.gp.log_kernels import FAST

__all__ = ["scratch_size", "search"]

_jit: Any = numba.njit(cache=True, nogil=True, fastmath=FAST, error_model="numpy")
NB, NC = COARSE_NOISES, COARSE_LENGTHSCALES
_LOG_TWO_PI = float(np.log(2.0 * np.pi))
_FIRST_STEP = 0.5
_STEP = 0.1
_MARGIN = 2.0
"""A second basin is followed unless the coarse grid puts it this far above the first's optimum."""
_TOLERANCE = 1e-6


@_jit
def scratch_size(n: int) -> int:
    """Length of the scratch vector of `search`."""
    return 4 * (n + LANES) + coarse_scratch(n) + NC * NB + 2 * NC + PROFILE


@_jit
def fine_row(index: int, n: int, constants: Any) -> Any:
    """Fine row of a lengthscale."""
    he = (n + 1) // 2
    size = n * ((he + LANES - 1) // LANES * LANES) + 3 * n
    return constants[HEADER + index * size : HEADER + (index + 1) * size]


@_jit
def slope_at(z: Any, gamma: Any, D: int, n: int, row: Any, constants: Any, x: float) -> Any:
    """Objective at log b = x and its derivative there, by sums of squares."""
    he = (n + 1) // 2
    hp = (he + LANES - 1) // LANES * LANES
    o = n * hp
    b = np.exp(x)
    flat = constants[AT_FLAT]
    tau = 0.0
    tau2 = 0.0
    one = 0.0
    one2 = 0.0
    trace = 0.0
    product = 1.0
    log_determinant = 0.0
    for k in range(n):
        v = row[o + k] + b
        product *= v
        if k % 16 == 15:
            log_determinant += np.log(product)
            product = 1.0
        w = 1.0 / v
        t = row[o + n + k]
        i = row[o + 2 * n + k]
        trace += w
        tau += t * t * w
        tau2 += t * t * w * w
        one += i * i * w
        one2 += i * i * w * w
    over = 0.0
    if flat > 0.0:
        over = 1.0 / one
        product *= one
        trace -= one2 * over
    log_determinant += np.log(product)
    m = n - flat
    rest = 0.0
    d_rest = 0.0
    explained = 0.0
    d_explained = 0.0
    for d in range(D):
        c = 0.0
        a = 0.0
        for k in range(n):
            at = 2 * d * hp + (k if k < he else k - he + hp)
            w = 1.0 / (row[o + k] + b)
            c += z[at] * row[o + n + k] * w
            a += z[at] * row[o + 2 * n + k] * w
        beta = c / tau
        delta = a * over
        bend = 0.0
        for k in range(n):
            at = 2 * d * hp + (k if k < he else k - he + hp)
            w = 1.0 / (row[o + k] + b)
            r = z[at] - beta * row[o + n + k] - delta * row[o + 2 * n + k]
            rw = r * w
            rest += r * rw
            d_rest -= rw * rw
            bend += rw * w * row[o + n + k]
        beta += gamma[d]
        explained += beta * beta * tau
        d_explained -= 2.0 * beta * bend + beta * beta * tau2
    s = rest / ((m - 1.0) * D)
    if s * D > explained:
        s = (rest + explained) / (m * D)
    bound = s * b < constants[AT_NOISE_LOW] or s * b > constants[AT_NOISE_HIGH]
    s = min(max(s, constants[AT_NOISE_LOW] / b), constants[AT_NOISE_HIGH] / b)
    if s < constants[AT_VARIANCE_LOW] or s > constants[AT_VARIANCE_HIGH]:
        s = min(max(s, constants[AT_VARIANCE_LOW]), constants[AT_VARIANCE_HIGH])
        bound = False
    if explained > D * s:
        cost = D * ((m - 1.0) * np.log(s) + np.log(explained / D) + log_determinant) + rest / s + D
        d_cost = d_rest / s + D * d_explained / explained + D * trace
        d_variance = (m - 1.0) * D - rest / s
    else:
        cost = D * (m * np.log(s) + log_determinant) + (rest + explained) / s
        d_cost = (d_rest + d_explained) / s + D * trace
        d_variance = m * D - (rest + explained) / s
    # On the floor the variance is the floor over b, so it falls as b rises.
    return cost, d_cost * b - (d_variance if bound else 0.0)


@_jit
def finish(z: Any, gamma: Any, D: int, n: int, row: Any, constants: Any, x: float) -> Any:
    """Best relative noise at one lengthscale by safeguarded Newton steps: (objective, log b)."""
    low = constants[AT_LOG_RATIO_LOW]
    high = constants[AT_LOG_RATIO_HIGH]
    curvature = 1.0
    cost, g = slope_at(z, gamma, D, n, row, constants, x)
    for _ in range(12):
        if g * g <= 2.0 * _TOLERANCE * curvature:
            break
        step = min(1.0, max(-1.0, -g / curvature))
        xn = min(high, max(low, x + step))
        if xn == x:
            break
        costn, gn = slope_at(z, gamma, D, n, row, constants, xn)
        secant = (gn - g) / (xn - x)
        if secant > 1e-3:
            curvature = secant
        if costn <= cost:
            x, cost, g = xn, costn, gn
        elif secant <= 1e-3:
            curvature = max(4.0 * curvature, 4.0 * abs(g))
    return cost, x


@_jit
def row_optimum(
    index: int,
    x: float,
    step: float,
    folded: Any,
    gamma: Any,
    D: int,
    n: int,
    constants: Any,
    z: Any,
    lanes: Any,
) -> Any:
    """Best relative noise at one lengthscale, near ``x``: (objective, log b)."""
    row = fine_row(index, n, constants)
    rotate(folded, D, n, row, z)
    low = constants[AT_LOG_RATIO_LOW]
    high = constants[AT_LOG_RATIO_HIGH] - (POINTS - 1) * step
    best, where, first = np.inf, 0, x
    for _ in range(6):
        first = min(high, max(low, x - 0.5 * (POINTS - 1) * step))
        profile(D, n, row, gamma, constants, first, step, z, lanes)
        best = lanes[0]
        where = 0
        for lane in range(1, POINTS):
            if lanes[lane] < best:
                best = lanes[lane]
                where = lane
        if (where == 0 and first > low) or (where == POINTS - 1 and first < high):
            x = first + step * where
        else:
            break
    if 0 < where < POINTS - 1:
        left = lanes[where - 1]
        right = lanes[where + 1]
        curve = left - 2.0 * best + right
        if curve > 0.0:
            shift = 0.5 * (left - right) / curve
            return best - 0.25 * (left - right) * shift, first + step * (where + shift)
    return best, first + step * where


@_jit
def descend(
    mid: int,
    x: float,
    tilt: float,
    folded: Any,
    gamma: Any,
    D: int,
    n: int,
    constants: Any,
    z: Any,
    lanes: Any,
) -> Any:
    """Best lengthscale of the fine grid near ``mid``: (objective, log b, index)."""
    last = FINE_LENGTHSCALES - 1
    costm, xm = row_optimum(mid, x, _FIRST_STEP, folded, gamma, D, n, constants, z, lanes)
    costm, xm = row_optimum(mid, xm, _STEP, folded, gamma, D, n, constants, z, lanes)
    h = 8
    for _ in range(40):
        lo = max(mid - h, 0)
        hi = min(mid + h, last)
        costl, xl, costh, xh = costm, xm, costm, xm
        if lo < mid:
            costl, xl = row_optimum(
                lo, xm + tilt * (lo - mid), _STEP, folded, gamma, D, n, constants, z, lanes
            )
        if hi > mid:
            costh, xh = row_optimum(
                hi, xm + tilt * (hi - mid), _STEP, folded, gamma, D, n, constants, z, lanes
            )
        tilt = (xh - xl) / (hi - lo)
        if costl < costm and costl <= costh:
            mid, costm, xm = lo, costl, xl
            h = min(2 * h, 64)
            continue
        if costh < costm:
            mid, costm, xm = hi, costh, xh
            h = min(2 * h, 64)
            continue
        vertex = mid
        if lo < mid < hi:
            left = (costl - costm) / (mid - lo)
            right = (costh - costm) / (hi - mid)
            if left + right > 0.0:
                shift = 0.5 * (left * (hi - mid) - right * (mid - lo)) / (left + right)
                vertex = min(hi, max(lo, mid + round(shift)))
        if h <= 2:
            # The parabola of the last, closest rows is trusted without another look.
            return costm, xm + tilt * (vertex - mid), vertex
        if vertex != mid:
            costv, xv = row_optimum(
                vertex, xm + tilt * (vertex - mid), _STEP, folded, gamma, D, n, constants, z, lanes
            )
            if costv < costm:
                mid, costm, xm = vertex, costv, xv
        h = 2
    return costm, xm, mid


@_jit
def row_minima(table: Any, constants: Any, best: Any, location: Any) -> None:
    """Least objective of every coarse lengthscale and the log b where it lies, by parabolas."""
    start = constants[AT_COARSE_START]
    stride = constants[AT_COARSE_STRIDE]
    for i in range(NC):
        least = table[i * NB]
        where = 0
        for b in range(1, NB):
            if table[i * NB + b] < least:
                least = table[i * NB + b]
                where = b
        best[i] = least
        location[i] = start + stride * where
        if 0 < where < NB - 1:
            left = table[i * NB + where - 1]
            right = table[i * NB + where + 1]
            curve = left - 2.0 * least + right
            if curve > 0.0:
                shift = 0.5 * (left - right) / curve
                best[i] -= 0.25 * (left - right) * shift
                location[i] += stride * shift


@_jit
def two_basins(best: Any) -> tuple[int, int]:
    """Coarse lengthscales of the two least local minima, -1 where there is only one."""
    first, second = -1, -1
    for i in range(NC):
        if (i == 0 or best[i] <= best[i - 1]) and (i == NC - 1 or best[i] < best[i + 1]):
            if first < 0 or best[i] < best[first]:
                first, second = i, first
            elif second < 0 or best[i] < best[second]:
                second = i
    return first, second


@_jit
def search(folded: Any, gamma: Any, D: int, constants: Any, scratch: Any, out: Any) -> None:
    """Maximum likelihood of D folded, detrended axes.

    `modelcast.models.gp.layout` says where ``out`` has what; ``gamma`` (2,) holds the slopes taken out beforehand.
    """
    n = int(constants[AT_SAMPLES])
    he = (n + 1) // 2
    hp = (he + LANES - 1) // LANES * LANES
    z = scratch[0 : 4 * hp]
    at = 4 * hp
    lanes = scratch[at : at + PROFILE]
    at += PROFILE
    best = scratch[at : at + NC]
    location = scratch[at + NC : at + 2 * NC]
    at += 2 * NC
    table = scratch[at : at + NC * NB]
    at += NC * NB
    coarse_grid(
        folded,
        gamma,
        D,
        n,
        constants[HEADER + FINE_LENGTHSCALES * (n * hp + 3 * n) :],
        constants,
        scratch[at : at + coarse_scratch(n)],
        table,
    )
    row_minima(table, constants, best, location)
    first, second = two_basins(best)
    top = constants[AT_COARSE_START] + constants[AT_COARSE_STRIDE] * (NB - 1)
    objective, x, index = np.inf, 0.0, 0
    for i in (first, second):
        if i < 0 or best[i] > objective + _MARGIN:
            continue
        if location[i] >= top:
            # No RBF part at all: from here the likelihood only creeps up with b, whatever the lengthscale.
            if best[i] < objective:
                objective, x, index = best[i], constants[AT_LOG_RATIO_HIGH], i * COARSE_STEP
            continue
        a = max(i - 1, 0)
        c = min(i + 1, NC - 1)
        tilt = (location[c] - location[a]) / ((c - a) * COARSE_STEP)
        shift = 0
        if a < i < c:
            curve = best[a] - 2.0 * best[i] + best[c]
            if curve > 0.0:
                shift = round(0.5 * COARSE_STEP * (best[a] - best[c]) / curve)
        found, place, row = descend(
            i * COARSE_STEP + shift,
            location[i] + tilt * shift,
            tilt,
            folded,
            gamma,
            D,
            n,
            constants,
            z,
            lanes,
        )
        if found < objective:
            objective, x, index = found, place, row
    row = fine_row(index, n, constants)
    rotate(folded, D, n, row, z)
    objective, x = finish(z, gamma, D, n, row, constants, x)
    out[OUT_LENGTHSCALE] = np.exp(
        constants[AT_LOG_LENGTHSCALE_START] + index * constants[AT_LOG_LENGTHSCALE_STRIDE]
    )
    out[OUT_NOISE_RATIO] = np.exp(x)
    out[OUT_LOG_LIKELIHOOD] = -0.5 * (objective + (n - constants[AT_FLAT]) * D * _LOG_TWO_PI)
    conclude(gamma, D, n, row, constants, z, out)


@_jit
def conclude(gamma: Any, D: int, n: int, row: Any, constants: Any, z: Any, out: Any) -> None:
    """Write variance, line and weights for the noise ratio that ``out`` already holds."""
    he = (n + 1) // 2
    ho = n // 2
    hp = (he + LANES - 1) // LANES * LANES
    o = n * hp
    b = out[OUT_NOISE_RATIO]
    flat = constants[AT_FLAT]
    m = n - flat
    tau = 0.0
    one = 0.0
    for k in range(n):
        w = 1.0 / (row[o + k] + b)
        tau += row[o + n + k] * row[o + n + k] * w
        one += row[o + 2 * n + k] * row[o + 2 * n + k] * w
    over = 1.0 / one if flat > 0.0 else 0.0
    rest = 0.0
    explained = 0.0
    for d in range(D):
        c = 0.0
        a = 0.0
        for k in range(n):
            at = 2 * d * hp + (k if k < he else k - he + hp)
            w = 1.0 / (row[o + k] + b)
            c += z[at] * row[o + n + k] * w
            a += z[at] * row[o + 2 * n + k] * w
        beta = c / tau
        delta = a * over
        for k in range(n):
            at = 2 * d * hp + (k if k < he else k - he + hp)
            z[at] -= beta * row[o + n + k] + delta * row[o + 2 * n + k]
            rest += z[at] * z[at] / (row[o + k] + b)
        beta += gamma[d]
        explained += beta * beta * tau
        out[OUT_SLOPE + d] = beta
        out[OUT_CONSTANT + d] = delta
    s = rest / ((m - 1.0) * D)
    if s * D > explained:
        s = (rest + explained) / (m * D)
    out[OUT_FLOORED] = 1.0 if s * b < constants[AT_NOISE_LOW] else 0.0
    s = min(max(s, constants[AT_NOISE_LOW] / b), constants[AT_NOISE_HIGH] / b)
    s = min(max(s, constants[AT_VARIANCE_LOW]), constants[AT_VARIANCE_HIGH])
    u = max(1.0, explained / (D * s))
    out[OUT_VARIANCE] = s
    out[OUT_LINEAR_RATIO] = (u - 1.0) / tau
    root = np.sqrt(0.5)
    for d in range(D):
        beta = out[OUT_SLOPE + d]
        out[OUT_SLOPE + d] = beta * (u - 1.0) / u
        for k in range(n):
            at = 2 * d * hp + (k if k < he else k - he + hp)
            z[at] = (z[at] + beta / u * row[o + n + k]) / (row[o + k] + b)
        to = OUT_WEIGHTS + d * n
        for j in range(he):
            even = 0.0
            for k in range(he):
                even += row[j * hp + k] * z[2 * d * hp + k]
            i = j - n % 2
            if i < 0:
                out[to + n // 2] = even
                continue
            odd = 0.0
            for k in range(ho):
                odd += row[(he + i) * hp + k] * z[2 * d * hp + hp + k]
            out[to + n // 2 + j] = (even + odd) * root
            out[to + n - 1 - n // 2 - j] = (even - odd) * root
