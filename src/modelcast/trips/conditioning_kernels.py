"""Compiled Kalman filter, Rauch-Tung-Striebel smoother and parameter search of `conditioning`.

East and north are filtered apart, since every measurement has the same noise in both directions but for
the grid of the positions. The state of an axis is (position, velocity, acceleration); the jerk is white.
Missing measurements are marked by a negative variance, so that no kernel ever sees a NaN.
"""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatCube, FloatMatrix, FloatVector, IntVector

__all__ = ["negative_log_likelihood", "search", "smooth"]

_GATE = 4.0


@kernel(fast=True)
def _predict(x: FloatVector, P: FloatMatrix, dt: float, q: float) -> None:
    """Move a state and its covariance (upper triangle) over one step of white jerk of density q."""
    h = 0.5 * dt * dt
    x[0] += dt * x[1] + h * x[2]
    x[1] += dt * x[2]
    a, b, c, d, e, f = P[0, 0], P[0, 1], P[0, 2], P[1, 1], P[1, 2], P[2, 2]
    pc = c + dt * e + h * f
    pe = e + dt * f
    pb = b + dt * d + h * e + dt * pc
    P[0, 0] = a + dt * b + h * c + dt * (b + dt * d + h * e) + h * pc + q * dt**5 / 20.0
    P[0, 1] = pb + q * dt**4 / 8.0
    P[0, 2] = pc + q * dt**3 / 6.0
    P[1, 1] = d + dt * e + dt * pe + q * dt**3 / 3.0
    P[1, 2] = pe + q * dt * dt / 2.0
    P[2, 2] = f + q * dt


@kernel(fast=True)
def _update(x: FloatVector, P: FloatMatrix, k: int, z: float, r: float) -> tuple[float, float]:
    """Weigh in a measurement of state component k; return its squared innovation and its variance.

    A velocity beyond `_GATE` standard deviations is given the variance that puts it there: a speed column
    that is wrong for a while then pulls no harder than its distance allows. Positions are the anchor and
    always count in full.
    """
    c0 = P[0, k]
    c1 = P[1, k] if k >= 1 else P[0, 1]
    c2 = P[k, 2]
    innovation = z - x[k]
    s = P[k, k] + r
    if k == 1:
        s = max(s, innovation * innovation / _GATE**2)
    g0, g1, g2 = c0 / s, c1 / s, c2 / s
    x[0] += g0 * innovation
    x[1] += g1 * innovation
    x[2] += g2 * innovation
    P[0, 0] -= g0 * c0
    P[0, 1] -= g0 * c1
    P[0, 2] -= g0 * c2
    P[1, 1] -= g1 * c1
    P[1, 2] -= g1 * c2
    P[2, 2] -= g2 * c2
    return innovation * innovation, s


@kernel(fast=True)
def _start(x: FloatVector, P: FloatMatrix, start: FloatVector) -> None:
    """Begin a part with an unknown state: mean zero about the part's first position."""
    for i in range(3):
        x[i] = 0.0
        for j in range(3):
            P[i, j] = 0.0
        P[i, i] = start[i] * start[i]


@kernel(fast=True)
def negative_log_likelihood(
    t: FloatVector,
    bounds: IntVector,
    z: FloatCube,
    r: FloatCube,
    start: FloatVector,
    log_parameters: FloatVector,
    sums: FloatMatrix,
) -> float:
    """Return minus the log-likelihood of all innovations, both axes.

    Parameters
    ----------
    t
        Times, (T,) [s].
    bounds
        Bounds of the parts, (S + 1,).
    z, r
        Measured position, velocity and velocity at rest of each axis, (T, 2 axes, 3), positions relative to
        the part's start, and their known variances; negative where there is no measurement. The noises of
        `log_parameters` are added to the first two. Samples at rest are weighed in but not counted.
    start
        Standard deviation of the unknown first state, (3,).
    log_parameters
        Natural logarithms of jerk density, added position noise and velocity noise, (3,).
    sums
        Receives, for position and velocity, the normalised innovations squared and their count, (2, 2).
    """
    q = np.exp(log_parameters[0])
    added = (np.exp(2.0 * log_parameters[1]), np.exp(2.0 * log_parameters[2]))
    x, P = np.empty(3), np.empty((3, 3))
    sums[:] = 0.0
    total = 0.0
    for axis in range(2):
        for part in range(bounds.size - 1):
            _start(x, P, start)
            for i in range(bounds[part], bounds[part + 1]):
                if i > bounds[part]:
                    _predict(x, P, t[i] - t[i - 1], q)
                for k in range(2):
                    known = r[i, axis, k]
                    if known >= 0.0:
                        squared, s = _update(x, P, k, z[i, axis, k], known + added[k])
                        # A stopped car's samples repeat one another: counted, they would hide the drive.
                        if r[i, axis, 2] < 0.0:
                            total += squared / s + np.log(s)
                            sums[k, 0] += squared / s
                            sums[k, 1] += 1.0
                if r[i, axis, 2] >= 0.0:
                    _update(x, P, 1, z[i, axis, 2], r[i, axis, 2])
    return 0.5 * (total + (sums[0, 1] + sums[1, 1]) * np.log(2.0 * np.pi))


@kernel(fast=True)
def search(
    t: FloatVector,
    bounds: IntVector,
    z: FloatCube,
    r: FloatCube,
    start: FloatVector,
    best: FloatVector,
    low: FloatVector,
    high: FloatVector,
    sums: FloatMatrix,
) -> tuple[float, int]:
    """Lower the negative log-likelihood by a compass search in place; return it and the evaluations.

    One parameter is moved at a time, its step grows while it pays and halves where it does not, until all
    steps are under `2 %`: no gradient, no randomness, a few dozen evaluations.
    """
    value = negative_log_likelihood(t, bounds, z, r, start, best, sums)
    evaluations = 1
    step = np.full(best.size, 1.5)
    trial = best.copy()
    while step.max() > 0.02 and evaluations < 400:
        for k in range(best.size):
            moved = False
            for sign in (1.0, -1.0):
                trial[:] = best
                trial[k] = min(max(best[k] + sign * step[k], low[k]), high[k])
                if trial[k] != best[k]:
                    found = negative_log_likelihood(t, bounds, z, r, start, trial, sums)
                    evaluations += 1
                    if found < value:
                        value, moved = found, True
                        best[k] = trial[k]
                        break
            step[k] = min(1.3 * step[k], 3.0) if moved else 0.4 * step[k]
    negative_log_likelihood(t, bounds, z, r, start, best, sums)
    return value, evaluations + 1


@kernel(fast=True)
def _solve_into(P: FloatMatrix, rhs: FloatVector, out: FloatVector) -> None:
    """Solve P out = rhs for a symmetric positive 3 x 3 matrix given by its upper triangle (Cholesky)."""
    l00 = np.sqrt(P[0, 0])
    l10, l20 = P[0, 1] / l00, P[0, 2] / l00
    l11 = np.sqrt(P[1, 1] - l10 * l10)
    l21 = (P[1, 2] - l20 * l10) / l11
    l22 = np.sqrt(P[2, 2] - l20 * l20 - l21 * l21)
    y0 = rhs[0] / l00
    y1 = (rhs[1] - l10 * y0) / l11
    y2 = (rhs[2] - l20 * y0 - l21 * y1) / l22
    out[2] = y2 / l22
    out[1] = (y1 - l21 * out[2]) / l11
    out[0] = (y0 - l10 * out[1] - l20 * out[2]) / l00


@kernel(fast=True)
def smooth(
    t: FloatVector,
    bounds: IntVector,
    z: FloatCube,
    r: FloatCube,
    start: FloatVector,
    log_parameters: FloatVector,
    out: FloatCube,
) -> None:
    """Write the smoothed means of both axes, (T, 2 axes, 3), by a forward filter and a backward pass.

    The backward pass moves only means: with the filtered mean x, covariance P, prediction x', P' of the
    next sample and its smoothed mean s', the smoothed mean is x + P Fᵀ P'⁻¹ (s' - x').
    """
    q = np.exp(log_parameters[0])
    added = (np.exp(2.0 * log_parameters[1]), np.exp(2.0 * log_parameters[2]))
    count = t.size
    filtered, predicted = np.empty((count, 3)), np.empty((count, 3))
    P_filtered, P_predicted = np.empty((count, 3, 3)), np.empty((count, 3, 3))
    x, P, weight = np.empty(3), np.empty((3, 3)), np.empty(3)
    for axis in range(2):
        for part in range(bounds.size - 1):
            first, end = bounds[part], bounds[part + 1]
            _start(x, P, start)
            for i in range(first, end):
                if i > first:
                    _predict(x, P, t[i] - t[i - 1], q)
                predicted[i] = x
                P_predicted[i] = P
                for k in range(2):
                    if r[i, axis, k] >= 0.0:
                        _update(x, P, k, z[i, axis, k], r[i, axis, k] + added[k])
                if r[i, axis, 2] >= 0.0:
                    _update(x, P, 1, z[i, axis, 2], r[i, axis, 2])
                filtered[i] = x
                P_filtered[i] = P
            out[end - 1, axis] = filtered[end - 1]
            for i in range(end - 2, first - 1, -1):
                dt = t[i + 1] - t[i]
                _solve_into(P_predicted[i + 1], out[i + 1, axis] - predicted[i + 1], weight)
                # Fᵀ P'⁻¹ (s' - x')
                w0 = weight[0]
                w1 = dt * weight[0] + weight[1]
                w2 = 0.5 * dt * dt * weight[0] + dt * weight[1] + weight[2]
                M = P_filtered[i]
                out[i, axis, 0] = filtered[i, 0] + M[0, 0] * w0 + M[0, 1] * w1 + M[0, 2] * w2
                out[i, axis, 1] = filtered[i, 1] + M[0, 1] * w0 + M[1, 1] * w1 + M[1, 2] * w2
                out[i, axis, 2] = filtered[i, 2] + M[0, 2] * w0 + M[1, 2] * w1 + M[2, 2] * w2
