"""What a window's samples hold, and batch loops over point functions (`address_kernels`)."""

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatCube, FloatMatrix, FloatVector
from modelcast.models.address_kernels import fit_at
from modelcast.models.trusted_kernels import predict_trusted

__all__ = [
    "ACCELERATION",
    "EAST",
    "NORTH",
    "POSITION_NOISE",
    "REPORTS",
    "REPORTS_ACCELERATION",
    "REPORTS_HEADING",
    "REPORTS_SPEED",
    "REPORTS_YAW_RATE",
    "SAMPLE_COLUMNS",
    "SPEED",
    "VELOCITY_EAST",
    "VELOCITY_NORTH",
    "YAW_RATE",
    "fit_batch",
    "predict_batch",
    "predict_each",
]

EAST, NORTH, VELOCITY_EAST, VELOCITY_NORTH, ACCELERATION, YAW_RATE, POSITION_NOISE, SPEED, REPORTS = range(9)
"""Columns of a window's samples: [m], [m/s], along the course [m/s²], clockwise [rad/s], an axis [m]; the
speed that the vehicle reports, that of its velocity where it reports none [m/s]; and what it reports beside
positions, the sum of `REPORTS_SPEED` and so on."""

REPORTS_SPEED, REPORTS_HEADING, REPORTS_ACCELERATION, REPORTS_YAW_RATE = 1.0, 2.0, 4.0, 8.0

SAMPLE_COLUMNS = 9
"""How many columns a window's samples have."""


@kernel
def fit_batch(fit: int, samples: FloatCube, constants: FloatVector, out: FloatMatrix) -> None:
    """Fit (B, n, 9) windows one by one into ``out`` (B, P)."""
    for row in range(samples.shape[0]):
        fit_at(fit, samples[row], constants, out[row])


@kernel
def predict_batch(
    predict: int,
    parameters: FloatMatrix,
    horizons_s: FloatVector,
    constants: FloatVector,
    trusted_s: float,
    turn_s: float,
    out: FloatCube,
) -> None:
    """Predict (B, P) parameters at every one of (H,) horizons into ``out`` (B, H, 2)."""
    for row in range(parameters.shape[0]):
        for at in range(horizons_s.size):
            predict_trusted(
                predict, parameters[row], horizons_s[at], constants, trusted_s, turn_s, out[row, at]
            )


@kernel
def predict_each(
    predict: int,
    parameters: FloatMatrix,
    ages_s: FloatVector,
    constants: FloatVector,
    trusted_s: float,
    turn_s: float,
    out: FloatMatrix,
) -> None:
    """Predict (B, P) parameters, each at its own age, into ``out`` (B, 2)."""
    for row in range(parameters.shape[0]):
        predict_trusted(predict, parameters[row], ages_s[row], constants, trusted_s, turn_s, out[row])
