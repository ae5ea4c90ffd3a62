"""Compiled survival of predicted paths."""

from math import hypot

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import BoolMatrix, FloatCube, FloatMatrix, FloatVector
from modelcast.models.trusted_kernels import predict_trusted

__all__ = ["holds_each"]


@kernel
def holds_each(
    predict: int,
    parameters: FloatMatrix,
    horizons_s: FloatVector,
    constants: FloatVector,
    trusted_s: float,
    turn_s: float,
    paths_m: FloatCube,
    known: BoolMatrix,
    thresholds_m: FloatVector,
    out: FloatMatrix,
) -> None:
    """Write for how many horizons each of B paths stays under each of T rising thresholds, (B, T).

    ``paths_m`` (B, H, 2) are the true positions at the horizons (H,), ``known`` (B, H) whether the truth goes
    on so long. A path is not followed beyond the horizon at which it breaks the last threshold.
    """
    point = parameters[0, :2].copy()
    for row in range(parameters.shape[0]):
        broken = 0
        for level in range(thresholds_m.size):
            out[row, level] = 0.0
        for at in range(horizons_s.size):
            if not known[row, at] or broken == thresholds_m.size:
                break
            predict_trusted(predict, parameters[row], horizons_s[at], constants, trusted_s, turn_s, point)
            off = hypot(point[0] - paths_m[row, at, 0], point[1] - paths_m[row, at, 1])
            while broken < thresholds_m.size and off >= thresholds_m[broken]:
                broken += 1
            for level in range(broken, thresholds_m.size):
                out[row, level] += 1.0
