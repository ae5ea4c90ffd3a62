"""Compiled maximum-likelihood search of the exact Gaussian process on an equally spaced window.

Variance and slope are profiled in closed form, so that two hyper-parameters are left. A coarse grid over both
finds the basins; each of the best two is followed along the fine lengthscales, where the best noise ratio of
a row comes from `POINTS` of them at once; Newton steps finish the noise ratio.
"""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector
from modelcast.models.gp.grid_kernels import PROFILE, coarse_grid, coarse_scratch, profile, rotate
from modelcast.models.gp.layout import (
    AT_COARSE_START,
    AT_COARSE_STRIDE,
    AT_FLAT,
    AT_LOG_LENGTHSCALE_START,
    AT_LOG_LENGTHSCALE_STRIDE,
    AT_LOG_RATIO_HIGH,
    AT_LOG_RATIO_LOW,
    AT_SAMPLES,
    COARSE_LENGTHSCALES,
    COARSE_NOISES,
    COARSE_STEP,
    FINE_LENGTHSCALES,
    HEADER,
    LANES,
    OUT_LENGTHSCALE,
    OUT_LOG_LIKELIHOOD,
    OUT_NOISE_RATIO,
    POINTS,
)
from modelcast.models.gp.optimum_kernels import conclude, fine_row, finish

__all__ = ["scratch_size", "search"]

NB, NC = COARSE_NOISES, COARSE_LENGTHSCALES
_LOG_TWO_PI = float(np.log(2.0 * np.pi))
_STEP = 0.1
"""Spacing of log b along a fine row: at 0.1 a parabola finds the least objective to 1e-5."""
_WIDE, _NARROW = 10, 3
"""Spacings of the rows that a parabola along the lengthscales is drawn through, in fine steps."""
_MARGIN = 2.0
"""A second basin is followed unless the coarse grid puts it this far above the first's optimum."""


@kernel(fast=True)
def scratch_size(n: int) -> int:
    """Length of the scratch vector of `search`."""
    return 4 * (n + LANES) + coarse_scratch(n) + NC * NB + 2 * NC + PROFILE


@kernel(fast=True)
def row_optimum(
    index: int,
    x: float,
    step: float,
    folded: FloatVector,
    gamma: FloatVector,
    D: int,
    n: int,
    constants: FloatVector,
    z: FloatVector,
    lanes: FloatVector,
) -> tuple[float, float]:
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


@kernel(fast=True)
def descend(
    mid: int,
    x: float,
    tilt: float,
    folded: FloatVector,
    gamma: FloatVector,
    D: int,
    n: int,
    constants: FloatVector,
    z: FloatVector,
    lanes: FloatVector,
) -> tuple[float, float, int]:
    """Best lengthscale of the fine grid near ``mid``: (objective, log b, index)."""
    last = FINE_LENGTHSCALES - 1
    costm, xm = row_optimum(mid, x, _STEP, folded, gamma, D, n, constants, z, lanes)
    h = _WIDE
    for _ in range(30):
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
        shift = 0
        curved = False
        if lo < mid < hi:
            left = (costl - costm) / (mid - lo)
            right = (costh - costm) / (hi - mid)
            curved = left + right > 0.0
            if curved:
                vertex = 0.5 * (left * (hi - mid) - right * (mid - lo)) / (left + right)
                shift = round(min(4.0 * h, max(-4.0 * h, vertex)))
        if not curved:
            shift = -2 * h if costl < min(costm, costh) else 2 * h if costh < costm else 0
        shift = min(last - mid, max(-mid, shift))
        if h <= _NARROW and abs(shift) <= h:
            # The parabola through the closest rows is trusted without another look.
            return min(costl, costm, costh), xm + tilt * shift, mid + shift
        centre = mid
        if costl < costm and costl <= costh:
            centre, costm, xm = lo, costl, xl
        elif costh < costm:
            centre, costm, xm = hi, costh, xh
        vertex_index = mid + shift
        if vertex_index != centre:
            found, place = row_optimum(
                vertex_index,
                xm + tilt * (vertex_index - centre),
                _STEP,
                folded,
                gamma,
                D,
                n,
                constants,
                z,
                lanes,
            )
            if found < costm:
                centre, costm, xm = vertex_index, found, place
        if abs(shift) <= 2 * h:
            h = _NARROW
        mid = centre
    return costm, xm, mid


@kernel(fast=True)
def row_minima(table: FloatVector, constants: FloatVector, best: FloatVector, location: FloatVector) -> None:
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


@kernel(fast=True)
def two_basins(best: FloatVector) -> tuple[int, int]:
    """Coarse lengthscales of the two least local minima, -1 where there is only one."""
    first, second = -1, -1
    for i in range(NC):
        if (i == 0 or best[i] <= best[i - 1]) and (i == NC - 1 or best[i] < best[i + 1]):
            if first < 0 or best[i] < best[first]:
                first, second = i, first
            elif second < 0 or best[i] < best[second]:
                second = i
    return first, second


@kernel(fast=True)
def search(
    folded: FloatVector,
    gamma: FloatVector,
    D: int,
    constants: FloatVector,
    scratch: FloatVector,
    out: FloatVector,
) -> None:
    """Maximum likelihood of D folded, detrended axes.

    `modelcast.models.gp.layout` says where ``out`` has what; ``gamma`` (2,) holds the slopes taken out
    beforehand.
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
