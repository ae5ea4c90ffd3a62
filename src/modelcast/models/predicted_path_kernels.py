"""Compiled point functions of a sub-model that is sent as its predicted path."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector
from modelcast.models.address_kernels import fit_at, predict_at
from modelcast.models.point_kernels import VELOCITY_EAST, VELOCITY_NORTH

__all__ = [
    "AT_COEFFICIENTS",
    "AT_COUNT",
    "AT_FIT",
    "AT_NODES",
    "AT_PREDICT",
    "AT_SPAN",
    "HEADER",
    "fit",
    "predict",
]

AT_FIT, AT_PREDICT, AT_COUNT, AT_COEFFICIENTS, AT_NODES, AT_SPAN = range(6)
HEADER = 6
"""The constants: addresses of the model's two functions; how many parameters it has; coefficients k an axis;
instants m at which its path is looked at; time from the first to the last of them [s]. Then the matrix (k, m)
from positions at the instants to coefficients; then the model's own constants."""


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
    moved = np.empty(2)
    for j in range(m):
        horizon_s = constants[AT_SPAN] * j / (m - 1)
        predict_at(np.int64(constants[AT_PREDICT]), inner, horizon_s, own, moved)
        for axis in range(2):
            off = moved[axis] - out[axis] * horizon_s
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
