"""Compiled point functions of the interacting multiple model: four kinematic modes and their chances."""

from math import atan2, cos, exp, hypot, log, sin

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector
from modelcast.models.kinematic_kernels import SLOWEST_MPS, fit_acceleration_and_turn, move

__all__ = ["CHANCE", "CONSTANTS", "MODES", "absorb", "fit", "move_by_mode", "predict"]

MODES = 4
"""Constant velocity, constant acceleration, constant turn rate, and both: bit 0 accelerates, bit 1 turns."""

CHANCE = 4
"""First of the chances among the parameters; velocity, acceleration and yaw rate stand before them."""

_PERSISTENCE, _NOISE, _ACCELERATION, _JERK, _YAW_ACCELERATION, _PRIOR = range(6)
CONSTANTS = _PRIOR + MODES
"""Persistence [s], noise of a place [m], spreads [m/s², m/s³, rad/s²], then the chances at a start."""


@kernel
def move_by_mode(parameters: FloatVector, mode: int, time_s: float, out: FloatVector) -> None:
    """Displacement by one mode, into ``out`` (2,)."""
    acceleration = parameters[2] if mode & 1 else 0.0
    yaw_rate = parameters[3] if mode & 2 else 0.0
    move(parameters[0], parameters[1], acceleration, yaw_rate, time_s, out)


@kernel(inlined=True)
def _chance(parameters: FloatVector, mode: int, time_s: float, constants: FloatVector) -> float:
    """Chance of a mode a time after the update: it goes to that at a start as the chain forgets."""
    start, known = constants[_PRIOR + mode], 0.0
    for one in range(MODES):
        known += parameters[CHANCE + one]
    if not known > 0.0:
        return start
    return start + (parameters[CHANCE + mode] - start) * exp(-max(time_s, 0.0) / constants[_PERSISTENCE])


@kernel
def fit(window: FloatMatrix, constants: FloatVector, out: FloatVector) -> None:
    """Keep the newest motion; chances are the receivers'."""
    fit_acceleration_and_turn(window, constants, out)
    for mode in range(MODES):
        out[CHANCE + mode] = 0.0


@kernel
def predict(parameters: FloatVector, horizon_s: float, constants: FloatVector, out: FloatVector) -> None:
    """Mean of the modes' displacements."""
    east, north = 0.0, 0.0
    for mode in range(MODES):
        chance = _chance(parameters, mode, horizon_s, constants)
        move_by_mode(parameters, mode, horizon_s, out)
        east += chance * out[0]
        north += chance * out[1]
    out[0], out[1] = east, north


@kernel(inlined=True)
def _log_likelihood(
    held: FloatVector, mode: int, moved: FloatVector, constants: FloatVector, way: FloatVector
) -> float:
    """Log of a mode's likelihood of the way that was moved, but for a constant; ``way`` (2,) is used."""
    time_s, speed = moved[0], hypot(held[0], held[1])
    move_by_mode(held, mode, time_s, way)
    east, north = moved[1] - way[0], moved[2] - way[1]
    straying_m = 0.5 * constants[_ACCELERATION] * time_s**2
    along_m = constants[_JERK] * time_s**3 / 6.0 if mode & 1 else straying_m
    across_m = speed * constants[_YAW_ACCELERATION] * time_s**3 / 6.0 if mode & 2 else straying_m
    noise2 = 2.0 * constants[_NOISE] ** 2  # of two places
    if speed <= SLOWEST_MPS:
        along_m = across_m = max(along_m, across_m)
    course = atan2(held[0], held[1]) + (0.5 * held[3] * time_s if mode & 2 else 0.0)
    along = east * sin(course) + north * cos(course)
    across = east * cos(course) - north * sin(course)
    first, second = along_m**2 + noise2, across_m**2 + noise2
    return -0.5 * (along * along / first + across * across / second + log(first * second))


@kernel
def absorb(new: FloatVector, moved: FloatVector, constants: FloatVector, held: FloatVector) -> None:
    """Weigh the modes by how each foresaw the way from the last update, then take the new motion."""
    way, weight, chance = np.empty(2), np.empty(MODES), np.empty(MODES)
    best, total = -np.inf, 0.0
    for mode in range(MODES):
        weight[mode] = _log_likelihood(held, mode, moved, constants, way)
        chance[mode] = _chance(held, mode, moved[0], constants)
        best = max(best, weight[mode])
    for mode in range(MODES):
        weight[mode] = chance[mode] * exp(weight[mode] - best)
        total += weight[mode]
    for mode in range(MODES):
        # What is no number or has no likelihood at all starts anew.
        held[CHANCE + mode] = weight[mode] / total if total > 0.0 else 0.0
    for i in range(CHANCE):
        held[i] = new[i]
