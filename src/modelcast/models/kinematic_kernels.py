"""Compiled point functions of the kinematic models: constant acceleration, turn rate, or both.

All three are one integral along the course. With the turned angle θ = ω·t, speed v and acceleration a, the
vehicle moves ``v·t·A + a·t²·C`` along its first course and ``v·t·B + a·t²·D`` to the right of it.
"""

from math import cos, hypot, sin

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector
from modelcast.models.point_kernels import (
    ACCELERATION,
    VELOCITY_EAST,
    VELOCITY_NORTH,
    YAW_RATE,
)

__all__ = [
    "SERIES_BELOW_RAD",
    "SLOWEST_MPS",
    "fit_acceleration",
    "fit_acceleration_and_turn",
    "fit_turn",
    "move",
    "predict_acceleration",
    "predict_acceleration_and_turn",
    "predict_turn",
    "turned",
]

SERIES_BELOW_RAD = 0.1
"""Turned angle under which `turned` sums series.

The first terms left out are under 3e-16 there, and just above it the closed forms lose at most a rounding
error divided by the angle, about 2e-15.
"""

SLOWEST_MPS = 1e-9
"""A slower velocity has no direction to accelerate along."""


@kernel
def turned(angle_rad: float) -> tuple[float, float, float, float]:
    """Shares A, B, C, D of a turned angle θ; 1, 0, ½, 0 at θ = 0.

    ``A = sin θ/θ``, ``B = (1 - cos θ)/θ``, ``C = A - B/θ``, ``D = (sin θ - θ·cos θ)/θ²``.
    """
    if abs(angle_rad) < SERIES_BELOW_RAD:
        s = angle_rad * angle_rad
        along = 1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0)))
        half = 0.5 - s / 24.0 * (1.0 - s / 30.0 * (1.0 - s / 56.0 * (1.0 - s / 90.0)))
        late = 1.0 / 3.0 - s / 30.0 * (1.0 - s / 28.0 * (1.0 - s / 54.0))
        return along, angle_rad * half, along - half, angle_rad * late
    along = sin(angle_rad) / angle_rad
    half_sine = sin(0.5 * angle_rad)
    across = 2.0 * half_sine * half_sine / angle_rad
    return along, across, along - across / angle_rad, (along - cos(angle_rad)) / angle_rad


@kernel
def move(
    east: float, north: float, acceleration: float, yaw_rate: float, time_s: float, out: FloatVector
) -> None:
    """Displacement from a velocity, an acceleration along it that ends in a stop, and a clockwise turn."""
    speed = hypot(east, north)
    gain = acceleration / speed if speed > SLOWEST_MPS else 0.0
    if gain < 0.0:
        time_s = min(time_s, -1.0 / gain)
    a, b, c, d = turned(yaw_rate * time_s)
    along = time_s * (a + gain * time_s * c)
    right = time_s * (b + gain * time_s * d)
    out[0] = along * east + right * north
    out[1] = along * north - right * east


@kernel
def fit_acceleration(window: FloatMatrix, _constants: FloatVector, out: FloatVector) -> None:
    """Keep the newest velocity and acceleration."""
    out[0] = window[-1, VELOCITY_EAST]
    out[1] = window[-1, VELOCITY_NORTH]
    out[2] = window[-1, ACCELERATION]


@kernel
def fit_turn(window: FloatMatrix, _constants: FloatVector, out: FloatVector) -> None:
    """Keep the newest velocity and yaw rate."""
    out[0] = window[-1, VELOCITY_EAST]
    out[1] = window[-1, VELOCITY_NORTH]
    out[2] = window[-1, YAW_RATE]


@kernel
def fit_acceleration_and_turn(window: FloatMatrix, _constants: FloatVector, out: FloatVector) -> None:
    """Keep the newest velocity, acceleration and yaw rate."""
    out[0] = window[-1, VELOCITY_EAST]
    out[1] = window[-1, VELOCITY_NORTH]
    out[2] = window[-1, ACCELERATION]
    out[3] = window[-1, YAW_RATE]


@kernel
def predict_acceleration(
    parameters: FloatVector, horizon_s: float, _constants: FloatVector, out: FloatVector
) -> None:
    """Accelerate straight ahead."""
    move(parameters[0], parameters[1], parameters[2], 0.0, horizon_s, out)


@kernel
def predict_turn(
    parameters: FloatVector, horizon_s: float, _constants: FloatVector, out: FloatVector
) -> None:
    """Follow a circle at constant speed."""
    move(parameters[0], parameters[1], 0.0, parameters[2], horizon_s, out)


@kernel
def predict_acceleration_and_turn(
    parameters: FloatVector, horizon_s: float, _constants: FloatVector, out: FloatVector
) -> None:
    """Accelerate along a turn."""
    move(parameters[0], parameters[1], parameters[2], parameters[3], horizon_s, out)
