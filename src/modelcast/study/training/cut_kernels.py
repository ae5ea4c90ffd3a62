"""Compiled cutting of training rows: inputs of many windows of one trip."""

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntVector
from modelcast.models.learned.learned_kernels import window_features

__all__ = ["trip_features"]


@kernel
def trip_features(
    samples: FloatMatrix, rows: IntVector, window: int, constants: FloatVector, out: FloatMatrix
) -> int:
    """Write inputs (B, I) of the windows that end at these rows of a trip's samples (T, 9).

    Returns the first row whose window does not reach back far enough, -1 where all do.
    """
    for at in range(rows.size):
        i = rows[at]
        if i < window - 1 or not window_features(samples[i - window + 1 : i + 1], constants, out[at]):
            return i
    return -1
