"""Compiled point functions of the constant-velocity model."""

from typing import Any

import numba

from modelcast.models.point_kernels import (
    FIT_SIGNATURE,
    PREDICT_SIGNATURE,
    VELOCITY_EAST,
    VELOCITY_NORTH,
)

__all__ = ["fit", "predict"]


@numba.njit(FIT_SIGNATURE, cache=True, nogil=True)
def fit(window: Any, _constants: Any, out: Any) -> None:
    """Keep the newest velocity."""
    out[0] = window[-1, VELOCITY_EAST]
    out[1] = window[-1, VELOCITY_NORTH]


@numba.njit(PREDICT_SIGNATURE, cache=True, nogil=True)
def predict(parameters: Any, horizon_s: float, _constants: Any, out: Any) -> None:
    """Coast along the velocity."""
    out[0] = parameters[0] * horizon_s
    out[1] = parameters[1] * horizon_s
