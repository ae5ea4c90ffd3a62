"""Compiled prediction of a model with a trusted horizon: beyond it, its speed holds and its turn ends."""

from math import atan2, cos, hypot, sin

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector
from modelcast.models.address_kernels import predict_at

__all__ = ["FASTEST_TURN_RADPS", "SLOWEST_TURN_MPS", "STEP_S", "predict_trusted"]

STEP_S = 0.05
"""Velocity and turn at the trusted horizon come from the model's last three positions, this far apart [s]."""

SLOWEST_TURN_MPS = 0.1
"""A model that is slower at its trusted horizon goes straight on [m/s]: it has no curve to follow."""

FASTEST_TURN_RADPS = 1.0
"""A model that turns faster there goes straight on [rad/s]: no car on a road does."""


@kernel(inlined=True)
def _continue(
    predict: int,
    parameters: FloatVector,
    beyond_s: float,
    constants: FloatVector,
    trusted_s: float,
    turn_s: float,
    out: FloatVector,
) -> None:
    """Predict a time ``beyond_s`` after the trusted horizon, from the model's last three positions there."""
    predict_at(predict, parameters, trusted_s - 2.0 * STEP_S, constants, out)
    east, north = out[0], out[1]
    predict_at(predict, parameters, trusted_s - STEP_S, constants, out)
    early_east, early_north = out[0] - east, out[1] - north
    east, north = out[0], out[1]
    predict_at(predict, parameters, trusted_s, constants, out)
    late_east, late_north = out[0] - east, out[1] - north
    early, late = hypot(early_east, early_north), hypot(late_east, late_north)
    # Chords are half a step old: speed and direction are carried on to the horizon itself.
    speed = max(1.5 * late - 0.5 * early, 0.0) / STEP_S
    if late <= 0.0 or speed <= 0.0:
        return
    yaw = atan2(
        early_east * late_north - early_north * late_east, early_east * late_east + early_north * late_north
    )
    if min(early, late) < SLOWEST_TURN_MPS * STEP_S or abs(yaw) > FASTEST_TURN_RADPS * STEP_S:
        yaw = 0.0
    c, s = cos(0.5 * yaw), sin(0.5 * yaw)
    ratio = 0.5 * yaw / s if s != 0.0 else 1.0  # of an arc to its chord
    ahead_east = ratio * speed * (late_east * c - late_north * s) / late
    ahead_north = ratio * speed * (late_east * s + late_north * c) / late
    turning_s = min(beyond_s, turn_s)
    angle = yaw / STEP_S * turning_s
    if angle == 0.0:
        along, left = turning_s, 0.0
    else:
        half = sin(0.5 * angle)
        along = turning_s * sin(angle) / angle
        left = turning_s * 2.0 * half * half / angle
    along += (beyond_s - turning_s) * cos(angle)
    left += (beyond_s - turning_s) * sin(angle)
    out[0] += along * ahead_east - left * ahead_north
    out[1] += along * ahead_north + left * ahead_east


@kernel(inlined=True)
def predict_trusted(
    predict: int,
    parameters: FloatVector,
    horizon_s: float,
    constants: FloatVector,
    trusted_s: float,
    turn_s: float,
    out: FloatVector,
) -> None:
    """Predict with a model up to ``trusted_s``; from there along its circle for ``turn_s``, then straight.

    ``predict`` is the address of a point function; ``parameters`` (P,), ``constants`` and ``out`` (2,) are as
    `PREDICT_TYPES` has them. It is inlined: an infinite ``trusted_s`` costs one comparison.
    """
    if horizon_s <= trusted_s:
        predict_at(predict, parameters, horizon_s, constants, out)
    else:
        _continue(predict, parameters, horizon_s - trusted_s, constants, trusted_s, turn_s, out)
