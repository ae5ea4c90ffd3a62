"""Compiled point functions of a sub-model that is sent as its predicted path."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector
from modelcast.models.address_kernels import fit_at, predict_at, track_at
from modelcast.models.point_kernels import VELOCITY_EAST, VELOCITY_NORTH

__all__ = [
    "AT_COEFFICIENTS",
    "AT_COUNT",
    "AT_FIT",
    "AT_NODES",
    "AT_PREDICT",
    "AT_SPAN",
    "AT_TRACK",
    "HEADER",
    "NO_TRACK",
    "fit",
    "predict",
]

AT_FIT, AT_PREDICT, AT_COUNT, AT_COEFFICIENTS, AT_NODES, AT_SPAN, AT_TRACK = range(7)
HEADER = 7
"""The constants: addresses of the model's two functions; how many parameters it has; coefficients k an axis;
instants m at which its path is looked at; time from the first to the last of them [s]; address of what
predicts at all of them. Then the matrix (k, m) from positions at the instants to coefficients; then the
model's own constants."""

NO_TRACK = -1.0
"""In place of the address of what predicts at many instants, where one is predicted after the other."""


@kernel
def fit(window: FloatMatrix, constants: FloatVector, out: FloatVector) -> None:
    """Fit the model; keep the newest velocity, and by how much the model's path leaves the straight one."""
    k, m = int(constants[AT_COEFFICIENTS]), int(constants[AT_NODES])
    own = constants[HEADER + k * m :]
    inner = np.empty(int(constants[AT_COUNT]))
    fit_at(np.int64(constants[AT_FIT]), window, own, inner)
    newest = window[window.shape[0] - 1]
    out[:] = 0.0
    out[0], out[1] = newest[VELOCITY_EAST], newest[VELOCITY_NORTH]
    horizons_s, moved = np.empty(m), np.empty((m, 2))
    for j in range(m):
        horizons_s[j] = constants[AT_SPAN] * j / (m - 1)
    if constants[AT_TRACK] != NO_TRACK:
        track_at(np.int64(constants[AT_TRACK]), inner, horizons_s, own, moved)
    else:
        for j in range(m):
            predict_at(np.int64(constants[AT_PREDICT]), inner, horizons_s[j], own, moved[j])
    for j in range(m):
        for axis in range(2):
            off = moved[j, axis] - out[axis] * horizons_s[j]
            for i in range(k):
                out[2 + axis * k + i] += constants[HEADER + i * m + j] * off


@kernel
def predict(parameters: FloatVector, horizon_s: float, constants: FloatVector, out: FloatVector) -> None:
    """Follow the polynomial over its span, then go straight on at its last velocity."""
    k = int(constants[AT_COEFFICIENTS])
    share = horizon_s / constants[AT_SPAN]
    beyond = max(share - 1.0, 0.0)
    share = min(share, 1.0)
    for axis in range(2):
        value, slope = 0.0, 0.0
        for i in range(k - 1, -1, -1):
            slope = slope * share + value
            value = value * share + parameters[2 + axis * k + i]
        out[axis] = parameters[axis] * horizon_s + value + slope * beyond
