"""Compiled point functions of the stop-and-go switch: two filters, and a bounded change of pace."""

from math import hypot

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector
from modelcast.models.point_kernels import (
    POSITION_NOISE,
    REPORTS,
    REPORTS_HEADING,
    REPORTS_SPEED,
)
from modelcast.models.velocity_filter_kernels import FILTER, begin, see_velocity, step

__all__ = [
    "AT_COLUMN",
    "CONSTANTS",
    "STATE",
    "fit",
    "observe",
    "predict",
]

(
    AT_COLUMN,
    _INTERVAL,
    _STEADY,
    _QUICK,
    _NOISE,
    _PRIOR,
    _GAIN,
    _LEAST,
    _PHASE,
    _PACE,
    _VELOCITY_NOISE,
) = range(11)
CONSTANTS = 11
"""Column of a sample at which the state stands, 0 where samples hold none; sampling interval [s]; roots of
the spectral densities of the acceleration of the steady and of the quick filter [m/s² over √Hz]; least noise
of a position [m]; spread of the first velocity [m/s]; gain [1/s]; least change of pace [m/s²]; how long it
lasts [s]; the pace at which speeding up ends [m/s]; noise of a reported velocity, of an axis [m/s]."""

STATE = 2 * FILTER
"""The steady filter, then the quick one."""

_MOTION = int(REPORTS_SPEED) | int(REPORTS_HEADING)

_STANDING_MPS = 0.1
"""A slower person has no course to change the pace along."""


@kernel
def _follow(state: FloatVector, sample: FloatVector, constants: FloatVector, out: FloatVector) -> None:
    """Both filters after a sample; ``state`` (`STATE`,) is that before, or empty at a start."""
    noise = max(sample[POSITION_NOISE], constants[_NOISE])
    noise2 = noise * noise
    velocity2 = constants[_VELOCITY_NOISE] * constants[_VELOCITY_NOISE]
    moves = int(sample[REPORTS]) & _MOTION == _MOTION
    for one in range(2):
        own = out[one * FILTER : (one + 1) * FILTER]
        if state.size == 0:
            begin(sample, noise2, constants[_PRIOR], own)
        else:
            held = state[one * FILTER : (one + 1) * FILTER]
            step(held, sample, noise2, constants[_STEADY + one], constants[_INTERVAL], own)
        if moves:
            see_velocity(sample, velocity2, own)


@kernel
def observe(before: FloatVector, sample: FloatVector, constants: FloatVector, out: FloatVector) -> None:
    """Write the state (`STATE`,) after a sample; ``before`` is the sample before with its state, or empty."""
    if before.size == 0:
        _follow(before, sample, constants, out)
    else:
        column = int(constants[AT_COLUMN])
        _follow(before[column : column + STATE], sample, constants, out)


@kernel(inlined=True)
def _state_motion(state: FloatVector, constants: FloatVector, out: FloatVector) -> None:
    """Velocity of the steady filter, and the change of pace that the quick one has seen beyond it."""
    east, north = state[2], state[3]
    out[0], out[1], out[2] = east, north, 0.0
    speed = hypot(east, north)
    if speed <= _STANDING_MPS:
        return
    ahead = (state[FILTER + 2] - east) * east + (state[FILTER + 3] - north) * north
    change = constants[_GAIN] * ahead / speed
    if abs(change) > constants[_LEAST]:
        out[2] = change


@kernel
def fit(window: FloatMatrix, constants: FloatVector, out: FloatVector) -> None:
    """Write velocity and change of pace; where samples hold no state, the filters run over the window."""
    column = int(constants[AT_COLUMN])
    if 0 < column <= window.shape[1] - STATE:
        _state_motion(window[-1, column : column + STATE], constants, out)
        return
    state, after = np.empty(STATE), np.empty(STATE)
    _follow(state[:0], window[0], constants, state)
    for i in range(1, window.shape[0]):
        _follow(state, window[i], constants, after)
        for j in range(STATE):
            state[j] = after[j]
    _state_motion(state, constants, out)


@kernel
def predict(parameters: FloatVector, horizon_s: float, constants: FloatVector, out: FloatVector) -> None:
    """Walk straight on; a change of pace ends at a stand, at the pace, or after its time."""
    east, north, change = parameters[0], parameters[1], parameters[2]
    speed = hypot(east, north)
    if speed <= _STANDING_MPS or change == 0.0:
        out[0], out[1] = east * horizon_s, north * horizon_s
        return
    to_go = -speed if change < 0.0 else max(constants[_PACE] - speed, 0.0)
    changing_s = min(to_go / change, constants[_PHASE])
    within_s = min(horizon_s, changing_s)
    way = within_s * (speed + 0.5 * change * within_s)
    way += (horizon_s - within_s) * (speed + change * changing_s)
    out[0], out[1] = way * east / speed, way * north / speed
