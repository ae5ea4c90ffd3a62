"""Compiled end of the search: the noise ratio to full precision, and the parameters that follow from it."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector
from modelcast.models.gp.layout import (
    AT_FLAT,
    AT_LOG_RATIO_HIGH,
    AT_LOG_RATIO_LOW,
    AT_NOISE_HIGH,
    AT_NOISE_LOW,
    AT_VARIANCE_HIGH,
    AT_VARIANCE_LOW,
    HEADER,
    LANES,
    OUT_CONSTANT,
    OUT_FLOORED,
    OUT_LINEAR_RATIO,
    OUT_NOISE_RATIO,
    OUT_SLOPE,
    OUT_VARIANCE,
    OUT_WEIGHTS,
)

__all__ = ["conclude", "fine_row", "finish", "slope_at"]

_TOLERANCE = 1e-6
"""Newton steps stop where the next would lower the objective by less."""


@kernel(fast=True)
def fine_row(index: int, n: int, constants: FloatVector) -> FloatVector:
    """Fine row of a lengthscale."""
    he = (n + 1) // 2
    size = n * ((he + LANES - 1) // LANES * LANES) + 3 * n
    return constants[HEADER + index * size : HEADER + (index + 1) * size]


@kernel(fast=True)
def slope_at(
    z: FloatVector, gamma: FloatVector, D: int, n: int, row: FloatVector, constants: FloatVector, x: float
) -> tuple[float, float]:
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


@kernel(fast=True)
def finish(
    z: FloatVector, gamma: FloatVector, D: int, n: int, row: FloatVector, constants: FloatVector, x: float
) -> tuple[float, float]:
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


@kernel(fast=True)
def conclude(
    gamma: FloatVector,
    D: int,
    n: int,
    row: FloatVector,
    constants: FloatVector,
    z: FloatVector,
    out: FloatVector,
) -> None:
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
