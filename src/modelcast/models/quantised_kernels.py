"""Compiled point functions of a sub-model whose parameters are those a receiver decodes.

They go round the point functions of another model (`address_kernels`).
"""

from math import atan2, cos, hypot, sin

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector
from modelcast.models.address_kernels import fit_at, predict_at
from modelcast.models.point_kernels import EAST, NORTH

__all__ = [
    "AT_COUNT",
    "AT_FASTEST",
    "AT_FIT",
    "AT_HEADING",
    "AT_POSITION",
    "AT_PREDICT",
    "AT_SPEED",
    "AT_VELOCITY",
    "HEADER",
    "fit",
    "predict",
]

AT_FIT, AT_PREDICT, AT_COUNT, AT_VELOCITY, AT_SPEED, AT_FASTEST, AT_HEADING, AT_POSITION = range(8)
HEADER = 8
"""The constants: addresses of the model's two functions; how many parameters it has; where among them its
velocity is, or -1; step [m/s] and last code of speed, step of heading [rad], of position [m]. Then for each
parameter its step (0: as it is), lowest and highest code; then the model's own constants."""


@kernel
def fit(window: FloatMatrix, constants: FloatVector, out: FloatVector) -> None:
    """Fit the model; then put every parameter where its code puts it, and the position on its grid."""
    count = int(constants[AT_COUNT])
    own = constants[HEADER + 3 * count :]
    fit_at(np.int64(constants[AT_FIT]), window, own, out[:count])
    for i in range(count):
        at = HEADER + 3 * i
        step = constants[at]
        if step > 0.0:
            out[i] = min(max(np.rint(out[i] / step), constants[at + 1]), constants[at + 2]) * step
    velocity = int(constants[AT_VELOCITY])
    if velocity >= 0:
        east, north = out[velocity], out[velocity + 1]
        step = constants[AT_SPEED]
        speed = min(np.rint(hypot(east, north) / step), constants[AT_FASTEST]) * step
        heading = np.rint(atan2(east, north) / constants[AT_HEADING]) * constants[AT_HEADING]
        out[velocity], out[velocity + 1] = speed * sin(heading), speed * cos(heading)
    grid = constants[AT_POSITION]
    for axis, column in ((0, EAST), (1, NORTH)):
        at_m = window[window.shape[0] - 1, column]
        out[count + axis] = np.rint(at_m / grid) * grid - at_m if grid > 0.0 else 0.0


@kernel
def predict(parameters: FloatVector, horizon_s: float, constants: FloatVector, out: FloatVector) -> None:
    """Predict with the model, from the position that was sent."""
    count = int(constants[AT_COUNT])
    own = constants[HEADER + 3 * count :]
    predict_at(np.int64(constants[AT_PREDICT]), parameters[:count], horizon_s, own, out)
    out[0] += parameters[count]
    out[1] += parameters[count + 1]
