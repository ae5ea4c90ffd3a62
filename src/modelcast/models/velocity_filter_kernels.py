"""A compiled Kalman filter of constant velocity and white acceleration, with one covariance for both axes."""

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatVector
from modelcast.models.point_kernels import EAST, NORTH, VELOCITY_EAST, VELOCITY_NORTH

__all__ = ["FILTER", "begin", "see_velocity", "step"]

FILTER = 7
"""Place and velocity east and north, then the variance of the place, their covariance and the variance of the
velocity, alike on both axes."""


@kernel(inlined=True)
def begin(sample: FloatVector, noise2: float, prior_mps: float, out: FloatVector) -> None:
    """A filter (`FILTER`,) at its first sample."""
    out[0], out[1] = sample[EAST], sample[NORTH]
    out[2], out[3] = sample[VELOCITY_EAST], sample[VELOCITY_NORTH]
    out[4], out[5], out[6] = noise2, 0.0, prior_mps * prior_mps


@kernel(inlined=True)
def step(
    before: FloatVector, sample: FloatVector, noise2: float, density: float, dt_s: float, out: FloatVector
) -> None:
    """A filter (`FILTER`,) of constant velocity and white acceleration after one more position."""
    square = density * density
    place = before[4] + dt_s * (2.0 * before[5] + dt_s * before[6]) + square * dt_s**3 / 3.0
    mixed = before[5] + dt_s * before[6] + square * dt_s * dt_s / 2.0
    velocity = before[6] + square * dt_s
    first, second = place / (place + noise2), mixed / (place + noise2)
    for axis in range(2):
        expected = before[axis] + dt_s * before[2 + axis]
        off = sample[EAST + axis] - expected
        out[axis] = expected + first * off
        out[2 + axis] = before[2 + axis] + second * off
    out[4], out[5], out[6] = (1.0 - first) * place, (1.0 - first) * mixed, velocity - second * mixed


@kernel(inlined=True)
def see_velocity(sample: FloatVector, noise2: float, out: FloatVector) -> None:
    """A filter (`FILTER`,) after a reported velocity."""
    first, second = out[5] / (out[6] + noise2), out[6] / (out[6] + noise2)
    for axis in range(2):
        off = sample[VELOCITY_EAST + axis] - out[2 + axis]
        out[axis] += first * off
        out[2 + axis] += second * off
    out[4] -= first * out[5]
    out[5] *= 1.0 - second
    out[6] *= 1.0 - second
