"""Compiled point functions of the constant-velocity model."""

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector
from modelcast.models.point_kernels import (
    VELOCITY_EAST,
    VELOCITY_NORTH,
)

__all__ = ["fit", "predict"]


@kernel
def fit(window: FloatMatrix, _constants: FloatVector, out: FloatVector) -> None:
    """Keep the newest velocity."""
    out[0] = window[-1, VELOCITY_EAST]
    out[1] = window[-1, VELOCITY_NORTH]


@kernel
def predict(parameters: FloatVector, horizon_s: float, _constants: FloatVector, out: FloatVector) -> None:
    """Coast along the velocity."""
    out[0] = parameters[0] * horizon_s
    out[1] = parameters[1] * horizon_s
