"""The compiled point function of the selector: how long each sub-model would last."""

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector
from modelcast.models.learned.learned_kernels import HEADER, run_network, window_features

__all__ = ["score"]


@kernel
def score(window: FloatMatrix, constants: FloatVector, out: FloatVector) -> None:
    """Write the mean of all networks' scores (M,), NaN where the window does not reach back far enough."""
    lags, inputs, networks = int(constants[1]), int(constants[4]), int(constants[7])
    features = np.empty(inputs)
    if not window_features(window, constants, features):
        out[:] = np.nan
        return
    out[:] = 0.0
    squashed, one = np.empty(inputs), np.empty(out.size)
    at = HEADER + (int(constants[2]) + int(constants[3]) + int(constants[8])) * (lags + 1)
    for _ in range(networks):
        first, second = int(constants[at + 1]), int(constants[at + 2])
        size = 2 * inputs + first * (inputs + 1) + second * (first + 1) + out.size * (second + 1)
        for i in range(inputs):
            squashed[i] = features[i]
        run_network(constants[at + 3 : at + 3 + size], first, second, squashed, one)
        for m in range(out.size):
            out[m] += one[m] / networks
        at += 3 + size
