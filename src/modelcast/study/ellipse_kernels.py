"""Compiled filter of a sender of ellipses, and which samples it sends at."""

from math import hypot, sqrt

import numpy as np

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatCube, FloatMatrix, FloatVector, IntVector

__all__ = ["follow", "greater_variance", "send"]

_STANDING_MPS = 0.1


@kernel(inlined=True)
def _product(one: FloatMatrix, other: FloatMatrix, out: FloatMatrix) -> None:
    """Write the product of two matrices (2, 2)."""
    for i in range(2):
        for j in range(2):
            out[i, j] = one[i, 0] * other[0, j] + one[i, 1] * other[1, j]


@kernel(inlined=True)
def _density(velocity: FloatVector, along2: float, across2: float, out: FloatMatrix) -> None:
    """Write the spectral density of the acceleration at a velocity; who stands takes the greater one."""
    speed = hypot(velocity[0], velocity[1])
    most = max(along2, across2)
    out[0, 0], out[0, 1], out[1, 0], out[1, 1] = most, 0.0, 0.0, most
    if speed >= _STANDING_MPS:
        for i in range(2):
            for j in range(2):
                out[i, j] = (along2 - across2) * velocity[i] * velocity[j] / (speed * speed)
            out[i, i] += across2


@kernel
def follow(
    t_s: FloatVector,
    position: FloatMatrix,
    segments: IntVector,
    numbers: FloatVector,
    place: FloatMatrix,
    velocity: FloatMatrix,
    place2: FloatCube,
    velocity2: FloatCube,
) -> None:
    """Filter positions (T, 2) into places, velocities (T, 2) and their covariances (T, 2, 2).

    ``numbers`` are the roots of the densities along and across the course, the noise of a position and the
    spread of the first velocity.
    """
    along2, across2 = numbers[0] ** 2, numbers[1] ** 2
    noise2, prior2 = numbers[2] ** 2, numbers[3] ** 2
    moved, own, weight = np.empty((2, 2)), np.empty((2, 2)), np.empty((2, 2))
    mixed, before, gain, turned = np.empty((2, 2)), np.empty((2, 2)), np.empty((2, 2)), np.empty((2, 2))
    product, off = np.empty((2, 2)), np.empty(2)
    for part in range(segments.size - 1):
        for k in range(segments[part], segments[part + 1]):
            if k == segments[part]:
                for i in range(2):
                    place[k, i], velocity[k, i] = position[k, i], 0.0
                    for j in range(2):
                        place2[k, i, j] = noise2 if i == j else 0.0
                        velocity2[k, i, j] = prior2 if i == j else 0.0
                        before[i, j] = 0.0
                continue
            dt = t_s[k] - t_s[k - 1]
            _density(velocity[k - 1], along2, across2, moved)
            for i in range(2):
                off[i] = position[k, i] - place[k - 1, i] - dt * velocity[k - 1, i]
                for j in range(2):
                    held = velocity2[k - 1, i, j]
                    own[i, j] = place2[k - 1, i, j] + dt * (before[i, j] + before[j, i])
                    own[i, j] += dt * dt * held + dt**3 / 3.0 * moved[i, j]
                    mixed[i, j] = before[i, j] + dt * held + 0.5 * dt * dt * moved[i, j]
            first, second = own[0, 0] + noise2, own[1, 1] + noise2
            size = first * second - own[0, 1] * own[1, 0]
            weight[0, 0], weight[1, 1] = second / size, first / size
            weight[0, 1], weight[1, 0] = -own[0, 1] / size, -own[1, 0] / size
            _product(own, weight, gain)
            for i in range(2):
                for j in range(2):
                    turned[i, j] = mixed[0, i] * weight[0, j] + mixed[1, i] * weight[1, j]
            for i in range(2):
                expected = position[k, i] - off[i]
                place[k, i] = expected + gain[i, 0] * off[0] + gain[i, 1] * off[1]
                velocity[k, i] = velocity[k - 1, i] + turned[i, 0] * off[0] + turned[i, 1] * off[1]
            _product(gain, own, product)
            for i in range(2):
                for j in range(2):
                    place2[k, i, j] = own[i, j] - 0.5 * (product[i, j] + product[j, i])
            _product(turned, mixed, product)
            for i in range(2):
                for j in range(2):
                    taken = 0.5 * (product[i, j] + product[j, i])
                    velocity2[k, i, j] = velocity2[k - 1, i, j] + dt * moved[i, j] - taken
            _product(gain, mixed, product)
            for i in range(2):
                for j in range(2):
                    before[i, j] = mixed[i, j] - product[i, j]


@kernel
def greater_variance(covariance: FloatMatrix) -> float:
    """Variance along the greater axis of a covariance (2, 2)."""
    half = 0.5 * (covariance[0, 0] + covariance[1, 1])
    return half + hypot(0.5 * (covariance[0, 0] - covariance[1, 1]), covariance[0, 1])


@kernel(inlined=True)
def _distance2(covariance: FloatMatrix, off: FloatVector) -> float:
    """Square of the Mahalanobis distance (2,) by a covariance (2, 2)."""
    size = covariance[0, 0] * covariance[1, 1] - covariance[0, 1] * covariance[1, 0]
    first = covariance[1, 1] * off[0] * off[0] + covariance[0, 0] * off[1] * off[1]
    return (first - 2.0 * covariance[0, 1] * off[0] * off[1]) / size


@kernel
def send(
    t_s: FloatVector,
    position: FloatMatrix,
    segments: IntVector,
    place: FloatMatrix,
    velocity: FloatMatrix,
    told2: FloatCube,
    velocity2: FloatCube,
    numbers: FloatVector,
    by_ellipse: bool,
    sent: IntVector,
    error: FloatVector,
    inside: IntVector,
) -> None:
    """Mark samples (T,) at which a message is sent, how far off receivers were, and whether inside (T,).

    ``numbers`` are the roots of the densities, the threshold, and the square of the distance that 95 % lie
    within. At a sample that is sent, error and inside are those before the message.
    """
    along2, across2 = numbers[0] ** 2, numbers[1] ** 2
    threshold, reach2 = numbers[2], numbers[3]
    grown, moved, off, at = np.empty((2, 2)), np.zeros((2, 2)), np.empty(2), 0
    for part in range(segments.size - 1):
        for k in range(segments[part], segments[part + 1]):
            due = k == segments[part]
            inside[k] = 1
            if not due:
                age = t_s[k] - t_s[at]
                for i in range(2):
                    off[i] = position[k, i] - place[at, i] - age * velocity[at, i]
                    for j in range(2):
                        grown[i, j] = told2[at, i, j] + age * age * velocity2[at, i, j]
                        grown[i, j] += age**3 / 3.0 * moved[i, j]
                error[k] = hypot(off[0], off[1])
                inside[k] = 1 if _distance2(grown, off) <= reach2 else 0
                wide = sqrt(reach2 * greater_variance(grown)) >= threshold
                due = (inside[k] == 0 or wide) if by_ellipse else error[k] >= threshold
            if due:
                sent[k] = 1
                at = k
                _density(velocity[k], along2, across2, moved)
