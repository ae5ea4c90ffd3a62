"""The fixed signatures of a model's compiled functions, and the batch loops over them."""

from typing import Any

import numba
from numba import types

from modelcast.models.trusted_kernels import predict_trusted

__all__ = [
    "ACCELERATION",
    "EAST",
    "FIT_SIGNATURE",
    "NORTH",
    "POSITION_NOISE",
    "PREDICT_SIGNATURE",
    "SAMPLE_COLUMNS",
    "VELOCITY_EAST",
    "VELOCITY_NORTH",
    "YAW_RATE",
    "fit_batch",
    "predict_batch",
    "predict_each",
]

EAST, NORTH, VELOCITY_EAST, VELOCITY_NORTH, ACCELERATION, YAW_RATE, POSITION_NOISE = range(7)
"""Columns of a window's samples: [m], [m/s], along the course [m/s²], clockwise [rad/s], an axis [m]."""

SAMPLE_COLUMNS = 7
"""How many columns a window's samples have."""

_vector = types.float64[::1]
_matrix = types.float64[:, ::1]

FIT_SIGNATURE = types.void(_matrix, _vector, _vector)
"""``fit(window (n, 7), constants (K,), out_parameters (P,))``."""

PREDICT_SIGNATURE = types.void(_vector, types.float64, _vector, _vector)
"""``predict(parameters (P,), horizon_s, constants (K,), out_displacement (2,))``."""

# Numba's decorators are typed since 0.68, but not the function types they make: hence Any.
_jit: Any = numba.njit(cache=True, nogil=True)


@_jit
def fit_batch(fit: Any, samples: Any, constants: Any, out: Any) -> None:
    """Fit (B, n, 7) windows one by one into ``out`` (B, P)."""
    for row in range(samples.shape[0]):
        fit(samples[row], constants, out[row])


@_jit
def predict_batch(
    predict: Any,
    parameters: Any,
    horizons_s: Any,
    constants: Any,
    trusted_s: float,
    turn_s: float,
    out: Any,
) -> None:
    """Predict (B, P) parameters at every one of (H,) horizons into ``out`` (B, H, 2)."""
    for row in range(parameters.shape[0]):
        for at in range(horizons_s.size):
            predict_trusted(
                predict, parameters[row], horizons_s[at], constants, trusted_s, turn_s, out[row, at]
            )


@_jit
def predict_each(
    predict: Any,
    parameters: Any,
    ages_s: Any,
    constants: Any,
    trusted_s: float,
    turn_s: float,
    out: Any,
) -> None:
    """Predict (B, P) parameters, each at its own age, into ``out`` (B, 2)."""
    for row in range(parameters.shape[0]):
        predict_trusted(predict, parameters[row], ages_s[row], constants, trusted_s, turn_s, out[row])
