"""Compiled point functions of a switching model: the forward filter, and the path of its mean."""

from math import cos, exp, hypot, sin

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector
from modelcast.models.kinematic_kernels import SLOWEST_MPS, move
from modelcast.models.point_kernels import ACCELERATION, VELOCITY_EAST, VELOCITY_NORTH, YAW_RATE

__all__ = [
    "AT_COLUMN",
    "AT_MODES",
    "AT_STEP",
    "AT_STEPS",
    "EMISSION",
    "HEADER",
    "TABLE",
    "fit",
    "observe",
    "predict",
]

AT_COLUMN, AT_MODES, AT_STEPS, AT_STEP = range(4)
HEADER = 4
"""The constants: column of a sample at which the belief stands, 0 where samples hold none; modes M; steps K
of the tables; how long each lasts [s]. Then the belief at a start (M); the chain (M, M) over one sample; of
each mode `EMISSION` numbers; and `TABLE` numbers for each of K + 1 steps and M modes."""

EMISSION = 10
"""Dynamics over one sample, row by row (4), offset (2), inverse of the covariance: first, mixed and second
entry (3), and minus half the logarithm of its determinant."""

TABLE = 6
"""Mean acceleration, then mean yaw rate: each as coefficients of 1, of the first acceleration and of the
first yaw rate."""

CORE = 4
"""Parameters before the belief: velocity, acceleration along the course, yaw rate."""


@kernel(inlined=True)
def _likelihood(j: int, before: FloatVector, sample: FloatVector, constants: FloatVector) -> float:
    """Logarithm of the density of a sample after the one before, in mode j, up to what all modes share."""
    modes = int(constants[AT_MODES])
    at = HEADER + modes + modes * modes + EMISSION * j
    along, turn = before[ACCELERATION], before[YAW_RATE]
    off_along = sample[ACCELERATION] - (constants[at] * along + constants[at + 1] * turn + constants[at + 4])
    off_turn = sample[YAW_RATE] - (constants[at + 2] * along + constants[at + 3] * turn + constants[at + 5])
    square = off_along * (constants[at + 6] * off_along + 2.0 * constants[at + 7] * off_turn)
    return constants[at + 9] - 0.5 * (square + constants[at + 8] * off_turn * off_turn)


@kernel
def _follow(
    belief: FloatVector, before: FloatVector, sample: FloatVector, constants: FloatVector, out: FloatVector
) -> None:
    """One step of the forward filter: the belief (M,) after a sample, from that after the one before."""
    modes = int(constants[AT_MODES])
    chain = HEADER + modes
    best = -np.inf
    for j in range(modes):
        out[j] = 0.0
        for i in range(modes):
            out[j] += belief[i] * constants[chain + i * modes + j]
        if out[j] > 0.0:
            best = max(best, _likelihood(j, before, sample, constants))
    total = 0.0
    for j in range(modes):
        total += out[j] * exp(_likelihood(j, before, sample, constants) - best)
    if not 0.0 < total < np.inf:  # a sample that no mode explains tells nothing
        return
    for j in range(modes):
        out[j] *= exp(_likelihood(j, before, sample, constants) - best) / total


@kernel
def observe(before: FloatVector, sample: FloatVector, constants: FloatVector, out: FloatVector) -> None:
    """Write the belief (M,) after a sample; ``before`` is the sample before with its belief, or empty."""
    modes, column = int(constants[AT_MODES]), int(constants[AT_COLUMN])
    if before.size == 0:
        for j in range(modes):
            out[j] = constants[HEADER + j]
    else:
        _follow(before[column : column + modes], before, sample, constants, out)


@kernel
def fit(window: FloatMatrix, constants: FloatVector, out: FloatVector) -> None:
    """Keep the newest velocity, acceleration and yaw rate, and the belief in all modes but the last.

    Where samples hold no belief, the filter runs over the window.
    """
    modes, column = int(constants[AT_MODES]), int(constants[AT_COLUMN])
    newest = window[window.shape[0] - 1]
    out[0], out[1] = newest[VELOCITY_EAST], newest[VELOCITY_NORTH]
    out[2], out[3] = newest[ACCELERATION], newest[YAW_RATE]
    if 0 < column <= window.shape[1] - modes:
        for j in range(modes - 1):
            out[CORE + j] = newest[column + j]
        return
    belief, after = np.empty(modes), np.empty(modes)
    for j in range(modes):
        belief[j] = constants[HEADER + j]
    for i in range(1, window.shape[0]):
        _follow(belief, window[i - 1], window[i], constants, after)
        for j in range(modes):
            belief[j] = after[j]
    for j in range(modes - 1):
        out[CORE + j] = belief[j]


@kernel
def _mean(parameters: FloatVector, step: int, constants: FloatVector) -> tuple[float, float]:
    """Mean acceleration and yaw rate after so many steps."""
    modes = int(constants[AT_MODES])
    at = HEADER + modes + modes * modes + EMISSION * modes + TABLE * modes * step
    along, turn = parameters[2], parameters[3]
    mean_along, mean_turn, total = 0.0, 0.0, 0.0
    for j in range(modes):
        # Rounded chances may sum to more than one; the last mode has what the others leave.
        chance = parameters[CORE + j] if j < modes - 1 else max(1.0 - total, 0.0)
        total += chance
        mean_along += chance * (constants[at] + constants[at + 1] * along + constants[at + 2] * turn)
        mean_turn += chance * (constants[at + 3] + constants[at + 4] * along + constants[at + 5] * turn)
        at += TABLE
    return mean_along / total, mean_turn / total


@kernel
def predict(parameters: FloatVector, horizon_s: float, constants: FloatVector, out: FloatVector) -> None:
    """Integrate mean acceleration and yaw rate, linear between steps; a car that stops stays.

    Beyond the tables it goes straight on at its last velocity.
    """
    step_s, steps = constants[AT_STEP], int(constants[AT_STEPS])
    out[0], out[1] = 0.0, 0.0
    velocity_east, velocity_north = parameters[0], parameters[1]
    moved_east, moved_north = 0.0, 0.0
    along, turn = _mean(parameters, 0, constants)
    left_s = horizon_s
    for step in range(steps):
        if left_s <= 0.0:
            break
        next_along, next_turn = _mean(parameters, step + 1, constants)
        share = min(left_s / step_s, 1.0)
        time_s = min(left_s, step_s)
        mean_along = along + 0.5 * share * (next_along - along)
        mean_turn = turn + 0.5 * share * (next_turn - turn)
        move(velocity_east, velocity_north, mean_along, mean_turn, time_s, out)
        moved_east += out[0]
        moved_north += out[1]
        speed = hypot(velocity_east, velocity_north)
        after = speed + mean_along * time_s
        left_s -= step_s
        if speed <= SLOWEST_MPS or after <= 0.0:
            velocity_east, velocity_north = 0.0, 0.0
            break
        c, s = cos(mean_turn * time_s), sin(mean_turn * time_s)
        ratio = after / speed
        velocity_east, velocity_north = (
            ratio * (velocity_east * c + velocity_north * s),
            ratio * (velocity_north * c - velocity_east * s),
        )
        along, turn = next_along, next_turn
    beyond_s = max(left_s, 0.0)
    out[0] = moved_east + velocity_east * beyond_s
    out[1] = moved_north + velocity_north * beyond_s
